//! Results as an MCAP that Foxglove, RViz and Nav2's tools open without configuration.

use std::path::{Path, PathBuf};

use self::diagnostics::Diagnostics;
use crate::base::{Error, Result};
use crate::config::{Config, SensorInfo};
use crate::map::Update;
use crate::message::RosMessage;
use crate::output::ros_file::RosFile;
use crate::output::topics::{TopicSink, Topics, transforms};
use crate::output::{End, Sink, StagedFile, abandon, encode_error};
use crate::sensor::Observation;

mod diagnostics;

/// Writes what updates hold:
///
/// | topic | type | stamp |
/// |---|---|---|
/// | `/limpid/costmap` | `nav_msgs/OccupancyGrid`, see [`occupancy_of_cost`](crate::output::occupancy_of_cost) | oldest data used |
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
    topics: Topics,
    diagnostics: Diagnostics,
}

/// The file, and the path that names it in errors.
struct Out {
    path: PathBuf,
    file: RosFile<StagedFile>,
}

impl Out {
    fn write<M: RosMessage>(&mut self, topic: &str, stamp_ns: u64, message: &M) -> Result<()> {
        self.file.write(topic, stamp_ns, message)
    }

    fn fault(&self, reason: impl ToString) -> Error {
        encode_error(&self.path, reason)
    }
}

impl TopicSink for Out {
    fn wants(&self, _: &str) -> bool {
        true
    }

    fn put<M: RosMessage>(&mut self, topic: &str, stamp_ns: u64, message: &M) -> Result<()> {
        self.write(&format!("/limpid/{topic}"), stamp_ns, message)
    }

    fn error(&self, reason: String) -> Error {
        self.fault(reason)
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
            topics: Topics::of(sensors),
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
            (Some(sensor), _) if sensor >= self.topics.sensors() => {
                let known = self.topics.sensors();
                Err(self.out.fault(format!("a result of sensor {sensor}, and there are {known} sensors")))
            }
            (Some(sensor), None) => {
                Err(self.out.fault(format!("a result of sensor {sensor} without its observation")))
            }
            (Some(sensor), Some(observation)) => Ok(Some((sensor, observation))),
        }
    }

    fn write_transforms(&mut self, stamp_ns: u64, frame: &str, update: &Update) -> Result<()> {
        match transforms(stamp_ns, &self.base_frame, frame, update) {
            Some(transforms) => self.out.write("/tf", stamp_ns, &transforms),
            None => Ok(()),
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
            Topics::write_map(&mut self.out, update.stamp_ns, &update.map_frame, map)?;
        }
        let frame = observed.and_then(|(sensor, observation)| self.topics.frame(sensor, observation));
        let diagnostics = self.diagnostics.of(update, frame.as_deref());
        self.out.write("/limpid/diagnostics", update.stamp_ns, &diagnostics)?;
        if let (Some((sensor, observation)), Some(frame)) = (observed, frame) {
            self.write_transforms(observation.stamp_ns(), &frame, update)?;
            if let Some(seen) = &update.seen {
                self.topics.write_seen(&mut self.out, sensor, seen, observation)?;
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
