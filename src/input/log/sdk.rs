//! Recordings of the RealSense SDK: topics such as `/device_0/sensor_0/Depth_0/image/data`, images
//! without frames, and for each stream a transform from a common reference.

use crate::base::Rigid;
use crate::input::event::TransformEvent;
use crate::input::log::topics::Topics;

/// One of the SDK's streams.
#[derive(Debug)]
struct Stream {
    /// Such as `/device_0/sensor_0/Depth_0`.
    prefix: String,
    /// Such as `depth_0_optical_frame`.
    frame_id: String,
    /// The name of the reference and the pose of it in this stream's frame.
    stream_from_reference: Option<(String, Rigid)>,
}

/// Whether a topic is an image of the RealSense SDK's own layout.
#[cfg(feature = "ros2")]
pub(crate) fn is_image_of_sdk(topic: &str) -> bool {
    Stream::of(topic).is_some()
}

impl Stream {
    fn of(image_topic: &str) -> Option<Self> {
        let prefix =
            image_topic.strip_suffix("/image/data").filter(|prefix| prefix.starts_with("/device_"))?;
        let (_, name) = prefix.rsplit_once('/')?;
        let frame_id = format!("{}_optical_frame", name.to_lowercase());
        Some(Self { prefix: prefix.into(), frame_id, stream_from_reference: None })
    }

    fn owns(&self, topic: &str) -> bool {
        topic.strip_prefix(&self.prefix).is_some_and(|rest| rest.starts_with('/'))
    }

    /// The name of the reference that a transform's topic refers to.
    fn reference<'a>(&self, topic: &'a str) -> Option<&'a str> {
        topic.strip_prefix(&self.prefix)?.strip_prefix("/tf/")
    }
}

/// The chosen streams of such a recording.
#[derive(Debug)]
pub(super) struct SdkStreams {
    depth: Stream,
    color: Option<Stream>,
}

impl SdkStreams {
    /// `None` for other recordings.
    pub(super) fn of(topics: &Topics) -> Option<Self> {
        let depth = Stream::of(&topics.depth)?;
        Some(Self { depth, color: topics.color.as_deref().and_then(Stream::of) })
    }

    fn streams(&mut self) -> impl Iterator<Item = &mut Stream> {
        [Some(&mut self.depth), self.color.as_mut()].into_iter().flatten()
    }

    /// The frame of a stream's image or calibration.
    pub(super) fn frame_id(&self, topic: &str) -> Option<&str> {
        let stream =
            [Some(&self.depth), self.color.as_ref()].into_iter().flatten().find(|s| s.owns(topic))?;
        Some(&stream.frame_id)
    }

    /// Whether a topic has the transform of one of the streams.
    pub(super) fn has_transform(&self, topic: &str) -> bool {
        let color = self.color.as_ref();
        self.depth.reference(topic).is_some() || color.is_some_and(|color| color.reference(topic).is_some())
    }

    /// Takes in a stream's transform; colour from depth once both have the same reference.
    pub(super) fn transform(&mut self, topic: &str, stream_from_reference: Rigid) -> Option<TransformEvent> {
        for stream in self.streams() {
            if let Some(reference) = stream.reference(topic) {
                stream.stream_from_reference = Some((reference.into(), stream_from_reference));
            }
        }
        let color = self.color.as_ref()?;
        let (color_reference, color_from_reference) = color.stream_from_reference.as_ref()?;
        let (depth_reference, depth_from_reference) = self.depth.stream_from_reference.as_ref()?;
        (color_reference == depth_reference).then(|| TransformEvent {
            parent: color.frame_id.clone(),
            child: self.depth.frame_id.clone(),
            stamp_ns: 0,
            fixed: true,
            parent_from_child: Some(color_from_reference.then(depth_from_reference.inverse())),
        })
    }

    /// Whether a topic says how many metres a count of depth is.
    pub(super) fn has_depth_unit(&self, topic: &str) -> bool {
        let sensor = self.depth.prefix.rsplit_once('/').map_or("", |(sensor, _)| sensor);
        topic.strip_prefix(sensor) == Some("/option/Depth Units/value")
    }

    /// One line for the report.
    pub(super) fn note(&self) -> String {
        let color = self.color.as_ref().map(|color| format!(" and `{}`", color.frame_id)).unwrap_or_default();
        format!(
            "recorded by the RealSense SDK, which does not name its frames: they are called `{}`{color}",
            self.depth.frame_id
        )
    }
}
