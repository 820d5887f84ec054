//! What limpid tells of its results as ROS 2 messages: one list of topics for MCAP files and for a ROS 2 graph.

use crate::base::{Error, Result};
use crate::config::SensorInfo;
use crate::map::{MapUpdate, Seen};
use crate::message::RosMessage;
use crate::output::grid_mismatch;
use crate::output::topics::camera::CameraTopics;
use crate::sensor::{Observation, SensorData, SensorKind};

mod camera;
mod lidar;
mod map;
mod transforms;

pub use map::occupancy_of_cost;
#[cfg(feature = "ros2")]
pub(crate) use map::{costmap, occupancy_grid};
pub(crate) use transforms::transforms;

/// Frame of images whose recording names none.
const NAMELESS_CAMERA_FRAME: &str = "camera_optical_frame";
/// Frame of scans whose recording names none.
const NAMELESS_LIDAR_FRAME: &str = "lidar";

/// Takes messages by the names of their topics, such as `front/reliability`; what stands before a name is the taker's own.
pub(crate) trait TopicSink {
    /// Whether somebody takes messages of a topic; others are not made.
    fn wants(&self, topic: &str) -> bool;

    /// Takes a message.
    ///
    /// # Errors
    /// The sink's own.
    fn put<M: RosMessage>(&mut self, topic: &str, stamp_ns: u64, message: &M) -> Result<()>;

    /// An error about a result that cannot be told.
    fn error(&self, reason: String) -> Error;
}

/// One of several topics of a sensor or of the map: its name after the sensor's prefix, and the type of its messages.
type Named = (&'static str, &'static str);

/// Names of a sensor's topics and frames.
struct SensorTopics {
    kind: SensorKind,
    /// What the names of its topics begin with: nothing, or its name and a slash.
    prefix: String,
    camera: CameraTopics,
    glass: bool,
    camera_frame: String,
    lidar_frame: String,
    nameless_camera_frame: String,
    nameless_lidar_frame: String,
}

impl SensorTopics {
    fn of(sensors: &[SensorInfo], sensor: &SensorInfo) -> Self {
        let (name, config) = (&sensor.name, &sensor.config);
        let (prefix, nameless_camera_frame, nameless_lidar_frame) =
            if crate::output::one_of_several(sensors, sensor) {
                (format!("{name}/"), format!("{name}_optical_frame"), name.clone())
            } else {
                (String::new(), NAMELESS_CAMERA_FRAME.into(), NAMELESS_LIDAR_FRAME.into())
            };
        Self {
            kind: sensor.model.kind(),
            camera: CameraTopics::new(&prefix, config),
            glass: config.glass,
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

    fn names(&self) -> impl Iterator<Item = (String, &'static str)> {
        let named: &[Named] = match self.kind {
            SensorKind::Camera if self.camera.has_cloud() => &camera::TOPICS,
            SensorKind::Camera => &camera::TOPICS[..camera::TOPICS.len() - 1],
            SensorKind::Lidar if self.glass => &lidar::TOPICS,
            SensorKind::Lidar => &[],
        };
        named.iter().map(|(name, kind)| (format!("{}{name}", self.prefix), *kind))
    }
}

/// See the module; [`McapSink`](crate::output::McapSink) has the table of the topics.
#[derive(Default)]
pub(crate) struct Topics(Vec<SensorTopics>);

impl Topics {
    /// Those of these sensors, as updates count them.
    pub(crate) fn of(sensors: &[SensorInfo]) -> Self {
        Self(sensors.iter().map(|sensor| SensorTopics::of(sensors, sensor)).collect())
    }

    /// How many sensors there are.
    pub(crate) fn sensors(&self) -> usize {
        self.0.len()
    }

    /// Names and types of all topics that there can be.
    #[cfg_attr(not(feature = "ros2"), expect(dead_code, reason = "the node alone asks for names"))]
    pub(crate) fn names(&self) -> Vec<(String, &'static str)> {
        let has_lidar = self.0.iter().any(|sensor| sensor.kind == SensorKind::Lidar);
        let of_map = map::TOPICS.iter().filter(|(name, _)| has_lidar || *name != map::CLASSES);
        let of_map = of_map.map(|(name, kind)| ((*name).to_owned(), *kind));
        of_map.chain(self.0.iter().flat_map(SensorTopics::names)).collect()
    }

    /// Frame of what a sensor observed; `None` where there is no such sensor.
    pub(crate) fn frame(&self, sensor: usize, observation: &Observation) -> Option<String> {
        self.0.get(sensor).map(|topics| topics.frame(observation))
    }

    /// Tells a published map.
    ///
    /// # Errors
    /// The sink's; one of its making where the map's parts do not fit.
    pub(crate) fn write_map(
        out: &mut impl TopicSink,
        stamp_ns: u64,
        map_frame: &str,
        map: &MapUpdate,
    ) -> Result<()> {
        match grid_mismatch(map) {
            Some(reason) => Err(out.error(reason)),
            None => map::write(out, stamp_ns, map_frame, map),
        }
    }

    /// Whether a sensor's images are wanted.
    #[cfg(feature = "ros2")]
    pub(crate) fn wants_images(&self, out: &impl TopicSink, sensor: usize) -> bool {
        let topics = self.0.get(sensor).filter(|topics| topics.kind == SensorKind::Camera);
        topics.is_some_and(|topics| topics.camera.wanted(out))
    }

    /// Tells what came of an observation.
    ///
    /// # Errors
    /// As [`Self::write_map`].
    pub(crate) fn write_seen(
        &mut self,
        out: &mut impl TopicSink,
        sensor: usize,
        seen: &Seen,
        observation: &Observation,
    ) -> Result<()> {
        let Some(topics) = self.0.get_mut(sensor) else { return Ok(()) };
        let frame = topics.frame(observation);
        match (seen, &observation.data) {
            (Seen::Camera(camera), SensorData::Frame(of)) => match &camera.images {
                Some(images) => topics.camera.write(out, &frame, &of.depth, images),
                None => Ok(()),
            },
            (Seen::Lidar(lidar), SensorData::Scan(scan)) => match &lidar.glass {
                Some(labelled) => lidar::write(out, &topics.prefix, &frame, scan, labelled),
                None => Ok(()),
            },
            _ => Err(out.error("a camera's result of a scan, or a lidar's of a frame".into())),
        }
    }
}
