//! One camera of a log.

use crate::base::{Result, duration_ns};
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::event::{Event, Streams, TransformEvent};
use crate::input::log::decode;
use crate::input::log::motion::Motion;
use crate::input::log::sdk::SdkStreams;
use crate::input::log::topics::{Channel, Kind, Topics};
use crate::input::sync::Synchronizer;
use crate::message::decode_error;
use crate::sensor::{Observation, RgbdFrame};

/// See the module.
pub(super) struct LogCamera {
    topics: Topics,
    sdk: Option<SdkStreams>,
    depth_unit_m: f64,
    map_frame: String,
    tolerance_ns: u64,
    pub(super) sync: Synchronizer,
    pub(super) report: ReadReport,
    /// Frames given.
    pub(super) frames: u64,
    /// Whether its stamps have jumped back since the transforms' did.
    jumped: bool,
}

impl LogCamera {
    /// `moves`: whether the recording says how the robot moved.
    pub(super) fn new(topics: Topics, config: &Config, moves: bool) -> Self {
        let mut report = ReadReport::default();
        report.note(topics.note());
        topics.unread.iter().for_each(|note| report.note(&**note));
        let sdk = SdkStreams::of(&topics);
        report.notes.extend(sdk.as_ref().map(SdkStreams::note));
        let streams = Streams {
            depth: topics.depth.clone(),
            color: topics.color.clone(),
            confidence: topics.confidence.clone(),
            depth_info: topics.depth_info.clone(),
            color_info: topics.color_info.clone(),
            has_transforms: moves || sdk.is_some(),
        };
        Self {
            sdk,
            depth_unit_m: config.depth_unit_m,
            map_frame: config.map_frame.clone(),
            tolerance_ns: duration_ns(config.transform_tolerance_s),
            sync: Synchronizer::new(config, streams),
            topics,
            report,
            frames: 0,
            jumped: false,
        }
    }

    pub(super) fn depth_topic(&self) -> &str {
        &self.topics.depth
    }

    /// Whether there is a topic with colour.
    pub(super) fn has_color(&self) -> bool {
        self.topics.color.is_some()
    }

    /// Whether a channel's messages are for this camera; calibrations are for all.
    pub(super) fn reads(&self, channel: &Channel) -> bool {
        let (Some(kind), topic) = (channel.kind, &channel.topic) else { return false };
        let Topics { depth, color, confidence, .. } = &self.topics;
        match kind {
            Kind::RosTransform(_) => self.sdk.as_ref().is_some_and(|sdk| sdk.has_transform(topic)),
            Kind::RosFloat(_) => self.sdk.as_ref().is_some_and(|sdk| sdk.has_depth_unit(topic)),
            _ => [Some(depth), color.as_ref(), confidence.as_ref()].contains(&Some(topic)),
        }
    }

    /// What a channel is used for, if it is.
    pub(super) fn role(&self, channel: &Channel) -> Option<&'static str> {
        let Topics { depth, depth_info, color, color_info, confidence, .. } = &self.topics;
        let roles = [
            (Some(depth), "depth"),
            (depth_info.as_ref(), "calibration of depth"),
            (color.as_ref(), "colour"),
            (color_info.as_ref(), "calibration of colour"),
            (confidence.as_ref(), "confidence"),
        ];
        let named = roles.into_iter().find(|(topic, _)| *topic == Some(&channel.topic));
        let by_frame = channel.kind.is_some_and(Kind::is_calibration)
            && (depth_info.is_none() || color.is_some() && color_info.is_none());
        named.map(|(_, role)| role).or(by_frame.then_some("calibration of its frame"))
    }

    /// The frame of a topic whose messages do not name it.
    pub(super) fn frame_id(&self, topic: &str) -> Option<&str> {
        self.sdk.as_ref().and_then(|sdk| sdk.frame_id(topic))
    }

    /// What a message says; a bad depth image has a number all the same.
    pub(super) fn event(
        &mut self,
        topic: &str,
        kind: Kind,
        log_time_ns: u64,
        payload: &[u8],
    ) -> Option<Event> {
        let image = decode::image(kind, self.frame_id(topic), payload);
        let is_depth = topic == self.topics.depth;
        match image {
            Ok(image) if is_depth => Some(Event::Depth(image)),
            Ok(image) if self.topics.color.as_deref() == Some(topic) => Some(Event::Color(image)),
            Ok(image) => Some(Event::Confidence(image)),
            Err(error) => {
                self.report.skip(topic, error.to_string(), log_time_ns);
                self.report.depth_images += u64::from(is_depth);
                None
            }
        }
    }

    /// What a message that only the RealSense SDK writes says.
    pub(super) fn sdk_transform(
        &mut self,
        topic: &str,
        kind: Kind,
        payload: &[u8],
    ) -> Result<Option<TransformEvent>> {
        match (kind, &mut self.sdk) {
            (Kind::RosTransform(wire), Some(sdk)) => {
                let stream_from_reference = decode::transform(wire, payload)?;
                Ok(sdk.transform(topic, stream_from_reference))
            }
            (Kind::RosFloat(wire), _) => {
                self.check_depth_unit(wire.decode("std_msgs/Float32", payload)?);
                Ok(None)
            }
            _ => Err(decode_error("stream", "the topic holds another type")),
        }
    }

    fn check_depth_unit(&mut self, recorded_m: f32) {
        #[expect(clippy::cast_possible_truncation, reason = "compared as the recording has it")]
        let configured_m = self.depth_unit_m as f32;
        if recorded_m != configured_m {
            self.report.note(format!(
                "the recording says that a count of depth is {recorded_m} m, but depth_unit_m is {configured_m} m: set it"
            ));
        }
    }

    /// Starts over where an image's stamp jumps back; what of it does.
    pub(super) fn restart_at(&mut self, event: &Event, motion: &Motion) -> Option<&'static str> {
        let what = self.sync.jump(event)?;
        self.sync.start_over(&motion.poses, &mut self.report);
        self.jumped = true;
        Some(what)
    }

    /// The transforms start over: so does what was seen before they did.
    pub(super) fn restart_with_transforms(&mut self, motion: &Motion) {
        if !std::mem::take(&mut self.jumped) {
            self.sync.start_over(&motion.poses, &mut self.report);
        }
    }

    /// The next frame that waits for nothing any more.
    pub(super) fn pop(&mut self, motion: &Motion) -> Option<Observation> {
        let frame: RgbdFrame = self.sync.pop()?;
        self.frames += 1;
        let goal_m = motion.goal(&self.map_frame, frame.depth.stamp_ns, self.tolerance_ns, &mut self.report);
        Some(Observation { goal_m, ..Observation::of_frame(0, &self.map_frame, frame) })
    }

    /// Why none of its depth images can be used, where that is so.
    pub(super) fn uncalibrated(&self) -> Option<String> {
        if self.report.depth_images == 0 || self.sync.calibrated() {
            return None;
        }
        Some(format!(
            "none of its {} depth images can be used: {}; `camera_matrix` (and `distortion`) can state one",
            self.report.depth_images,
            self.sync.uncalibrated(None)
        ))
    }
}
