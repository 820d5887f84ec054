//! Results as an MCAP that Foxglove, RViz and Nav2's tools open without configuration.

use std::path::{Path, PathBuf};

use self::camera::CameraTopics;
use self::diagnostics::Diagnostics;
use crate::base::{Error, Result, Rigid};
use crate::config::{Config, SensorInfo};
use crate::map::{Seen, Update};
use crate::message::RosMessage;
use crate::message::ros2::{Header, TFMessage, TransformStamped};
use crate::output::ros_file::RosFile;
use crate::output::{End, Sink, StagedFile, abandon, encode_error, one_of_several};
use crate::sensor::{Observation, SensorData};

mod camera;
mod diagnostics;
mod lidar;
mod map;

pub use map::occupancy_of_cost;
#[cfg(feature = "ros2")]
pub(crate) use map::{costmap, occupancy_grid};

/// Frame of images whose recording names none.
const NAMELESS_CAMERA_FRAME: &str = "camera_optical_frame";
/// Frame of scans whose recording names none.
const NAMELESS_LIDAR_FRAME: &str = "lidar";

/// Writes what updates hold:
///
/// | topic | type | stamp |
/// |---|---|---|
/// | `/limpid/costmap` | `nav_msgs/OccupancyGrid`, see [`occupancy_of_cost`] | oldest data used |
/// | `/limpid/costmap_raw` | `nav2_msgs/Costmap` | oldest data used |
/// | `/limpid/classes` | `nav_msgs/OccupancyGrid`, where a lidar takes part: 0 free, 25 passable, 50 inflated, 75 transparent, 100 solid, -1 unknown | oldest data used |
/// | `/limpid/verdicts` | `foxglove_msgs/Grid` of the rule's verdicts (spec 4 §4), where they were read back: `cost` before inflation, `reason` (row of the rule), `sensor` (counted from 1; 0: none), `age_s` | oldest data used |
/// | `/limpid/diagnostics` | `diagnostic_msgs/DiagnosticArray`: each sensor, and the map | oldest data used |
/// | `/tf` | map from base, base from sensor, where the map is not the sensor's own frame | depth image, or scan |
/// | `/limpid/reliability` | `mono8`, R * 255 | depth image |
/// | `/limpid/reliability_float` | `32FC1`, R | depth image |
/// | `/limpid/depth_filtered/image` | encoding of the recording, 0 where R is at most tau | depth image |
/// | `/limpid/depth_filtered/camera_info` | its calibration | depth image |
/// | `/limpid/points_trusted` | `sensor_msgs/PointCloud2` of x, y, z, reliability where R is above tau | depth image |
/// | `/limpid/glass/points` | `sensor_msgs/PointCloud2`: x, y, z, intensity, ring, return_type, class, plane_id (lidar frame), where glass is searched for | scan |
/// | `/limpid/glass/cleaned` | the same, for SLAM: inside, glass, outside and mirrored points | scan |
/// | `/limpid/glass/panes` | `visualization_msgs/MarkerArray`: panes as thin boxes (lidar frame) | scan |
///
/// There is one map, whatever sensors it has: the topics `/limpid/plan`, `/limpid/plan_raw` and `/limpid/plan_classes`, which
/// lidars had, are `/limpid/costmap`, `/limpid/costmap_raw` and `/limpid/classes`.
///
/// Of several cameras each has its own `/limpid/<name>/reliability` and so on; of several lidars each its own
/// `/limpid/<name>/glass/points` and so on.
///
/// What a camera sees needs the images to be read back; the cloud holds every `cloud_stride`-th pixel both ways, and is left
/// out where that is 0. Images, cloud and the last frame of `/tf` bear the depth image's
/// `frame_id`; where it has none, `camera_frame`; where that is empty too, `camera_optical_frame` (`<name>_optical_frame` of
/// several cameras). A lidar's bear `lidar_frame`; where it is empty, the scan's `frame_id`; where it has none, `lidar` (the
/// sensor's name of several lidars).
pub struct McapSink {
    out: Out,
    base_frame: String,
    sensors: Vec<SensorTopics>,
    diagnostics: Diagnostics,
}

/// The file, and the path that names it in errors.
struct Out {
    path: PathBuf,
    file: RosFile<StagedFile>,
}

impl Out {
    fn put<M: RosMessage>(&mut self, topic: &str, stamp_ns: u64, message: &M) -> Result<()> {
        self.file.write(topic, stamp_ns, message)
    }

    fn error(&self, reason: impl ToString) -> Error {
        encode_error(&self.path, reason)
    }
}

/// Names of a sensor's topics and frames.
struct SensorTopics {
    prefix: String,
    camera: CameraTopics,
    camera_frame: String,
    lidar_frame: String,
    nameless_camera_frame: String,
    nameless_lidar_frame: String,
}

impl SensorTopics {
    fn of(sensors: &[SensorInfo], sensor: &SensorInfo) -> Self {
        let (name, config) = (&sensor.name, &sensor.config);
        let (prefix, nameless_camera_frame, nameless_lidar_frame) = if one_of_several(sensors, sensor) {
            (format!("/limpid/{name}"), format!("{name}_optical_frame"), name.clone())
        } else {
            ("/limpid".into(), NAMELESS_CAMERA_FRAME.into(), NAMELESS_LIDAR_FRAME.into())
        };
        Self {
            camera: CameraTopics::new(&prefix, config),
            prefix,
            camera_frame: config.camera_frame.clone(),
            lidar_frame: config.lidar_frame.clone(),
            nameless_camera_frame,
            nameless_lidar_frame,
        }
    }

    /// Frame of what was observed.
    fn frame(&self, observation: &Observation) -> String {
        let (known, nameless) = match &observation.data {
            SensorData::Frame(frame) => {
                ([&frame.depth.frame_id, &self.camera_frame], &self.nameless_camera_frame)
            }
            SensorData::Scan(scan) => ([&self.lidar_frame, &scan.frame_id], &self.nameless_lidar_frame),
        };
        known.into_iter().find(|name| !name.is_empty()).unwrap_or(nameless).clone()
    }
}

impl McapSink {
    /// Starts the file `path`, which takes its name, or an older one's place, when it is finished; `sensors` as [`Update::sensor`] counts them.
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be created.
    pub fn create(path: &Path, config: &Config, sensors: &[SensorInfo]) -> Result<Self> {
        let file = RosFile::new(StagedFile::create(path)?, path)?;
        Ok(Self {
            out: Out { path: path.into(), file },
            base_frame: config.base_frame.clone(),
            sensors: sensors.iter().map(|sensor| SensorTopics::of(sensors, sensor)).collect(),
            diagnostics: Diagnostics::new(sensors),
        })
    }

    /// The sensor that an update came of, with what was observed; `None` for a published map.
    fn observed<'a>(
        &self,
        update: &Update,
        observation: Option<&'a Observation>,
    ) -> Result<Option<(usize, &'a Observation)>> {
        match (update.sensor, observation) {
            (None, _) => Ok(None),
            (Some(sensor), _) if sensor >= self.sensors.len() => {
                let known = self.sensors.len();
                Err(self.out.error(format!("a result of sensor {sensor}, and there are {known} sensors")))
            }
            (Some(sensor), None) => {
                Err(self.out.error(format!("a result of sensor {sensor} without its observation")))
            }
            (Some(sensor), Some(observation)) => Ok(Some((sensor, observation))),
        }
    }

    fn write_transforms(&mut self, stamp_ns: u64, frame: &str, update: &Update) -> Result<()> {
        let (map_frame, base_frame) = (update.map_frame.as_str(), self.base_frame.as_str());
        if map_frame == frame {
            return Ok(());
        }
        let edge = |parent: &str, child: &str, pose: Rigid| TransformStamped {
            header: Header::new(stamp_ns, parent),
            child_frame_id: child.to_owned(),
            transform: pose.into(),
        };
        let mut transforms = vec![edge(map_frame, base_frame, update.map_from_base)];
        // A robot whose base is the sensor itself has one edge only.
        if frame != base_frame {
            transforms.push(edge(base_frame, frame, update.base_from_sensor));
        }
        self.out.put("/tf", stamp_ns, &TFMessage { transforms })
    }

    fn write_seen(&mut self, sensor: usize, seen: &Seen, observation: &Observation) -> Result<()> {
        let topics = &mut self.sensors[sensor];
        let frame = topics.frame(observation);
        match (seen, &observation.data) {
            (Seen::Camera(camera), SensorData::Frame(of)) => match &camera.images {
                Some(images) => topics.camera.write(&mut self.out, &frame, &of.depth, images),
                None => Ok(()),
            },
            (Seen::Lidar(lidar), SensorData::Scan(scan)) => match &lidar.glass {
                Some(labelled) => lidar::write(&mut self.out, &topics.prefix, &frame, scan, labelled),
                None => Ok(()),
            },
            _ => Err(self.out.error("a camera's result of a scan, or a lidar's of a frame")),
        }
    }
}

/// Completes what was written by a sink that was neither finished nor abandoned; an older file stays.
impl Drop for McapSink {
    fn drop(&mut self) {
        // There is nobody to tell.
        let _ = self.abandon(End::Stopped);
    }
}

impl Sink for McapSink {
    fn write(&mut self, update: &Update, observation: Option<&Observation>) -> Result<()> {
        let observed = self.observed(update, observation)?;
        if let Some(map) = &update.map {
            map::write(&mut self.out, update.stamp_ns, &update.map_frame, map)?;
        }
        let frame = observed.map(|(sensor, observation)| self.sensors[sensor].frame(observation));
        let diagnostics = self.diagnostics.of(update, frame.as_deref());
        self.out.put("/limpid/diagnostics", update.stamp_ns, &diagnostics)?;
        if let (Some((sensor, observation)), Some(frame)) = (observed, frame) {
            self.write_transforms(observation.stamp_ns(), &frame, update)?;
            if let Some(seen) = &update.seen {
                self.write_seen(sensor, seen, observation)?;
            }
        }
        self.out.file.end_result()
    }

    fn finish(&mut self) -> Result<()> {
        self.out.file.finish()?.map_or(Ok(()), StagedFile::commit)
    }

    fn abandon(&mut self, end: End) -> Result<Option<PathBuf>> {
        abandon(&mut self.out.file, end)
    }
}
