//! How the robot moved and where it was sent, as a log says: transforms, odometry, `geometry_msgs/PoseStamped`.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec2;

use crate::base::Result;
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::event::TransformEvent;
use crate::input::frames::Posing;
use crate::input::log::decode;
use crate::input::log::odometry::Odometry;
use crate::input::log::topics::{Channel, Channels, Kind};
use crate::input::pose::PoseResolver;
use crate::message::{bare_frame, ros2};
use crate::sensor::SensorKind;

/// Most goals kept: only the newest can still count, a bound against hostile files.
const MAX_GOALS: usize = 1024;

/// A goal as it came.
#[derive(Debug, Clone, PartialEq)]
struct Goal {
    stamp_ns: u64,
    frame_id: String,
    place_m: DVec2,
}

/// See the module.
pub(super) struct Motion {
    /// Everything known so far, the stated transforms included.
    pub(super) poses: PoseResolver,
    /// Whether the log has topics with transforms.
    has_transforms: bool,
    reads_transforms: bool,
    odometry_topic: Option<String>,
    odometry: Option<Odometry>,
    goal_topic: Option<String>,
    goals: Vec<Goal>,
    /// Odometry that is not configured, for messages: topic, frame and child frame, once a message has told them.
    unread_odometry: BTreeMap<String, Option<[String; 2]>>,
}

impl Motion {
    /// # Errors
    /// [`crate::Error::Config`] for a configured topic that is absent or of another type, and for a stated transform that
    /// is not a transform.
    pub(super) fn choose(channels: &Channels, config: &Config, path: &Path) -> Result<Self> {
        let is_odometry = |kind| matches!(kind, Kind::RosOdometry(_));
        let is_goal = |kind| matches!(kind, Kind::RosPoseStamped(_));
        let odometry_topic =
            channels.configured(path, "odometry_topic", &config.odometry_topic, is_odometry)?;
        Ok(Self {
            poses: PoseResolver::new(config)?,
            has_transforms: channels.has_transforms(),
            reads_transforms: true,
            odometry: odometry_topic.as_ref().map(|_| Odometry::new(config)),
            odometry_topic,
            goal_topic: channels.configured(path, "goal_topic", &config.goal_topic, is_goal)?,
            goals: Vec::new(),
            unread_odometry: channels
                .of_kind(is_odometry)
                .map(|channel| (channel.topic.clone(), None))
                .filter(|(topic, _)| *topic != config.odometry_topic)
                .collect(),
        })
    }

    /// Of a log that is read without poses.
    pub(super) fn unread(path: &Path) -> Result<Self> {
        let motion = Self::choose(&Channels::default(), &Config::default(), path)?;
        Ok(Self { reads_transforms: false, ..motion })
    }

    /// Whether the recording or the configuration says anything of poses.
    pub(super) fn posed(&self) -> bool {
        self.is_recorded() || self.poses.has_stated()
    }

    /// Whether the recording does.
    pub(super) fn is_recorded(&self) -> bool {
        self.has_transforms || self.odometry_topic.is_some()
    }

    /// Why a sensor has no poses, and which keys to set.
    pub(super) fn explain(&self, posing: &Posing, kind: SensorKind) -> Option<String> {
        let odometry = self.unread_odometry.iter().next().map(|(topic, frames)| match frames {
            Some([parent, child]) => format!(
                "odometry of `{child}` in `{parent}` on {topic}: set odometry_topic: {topic}, map_frame: {parent} and base_frame: \
                 {child}"
            ),
            None => format!("odometry on {topic}: set odometry_topic: {topic}"),
        });
        let odometry = odometry.unwrap_or_default();
        let without = match odometry.as_str() {
            "" if self.has_transforms => "the topics with transforms hold none that can be used".into(),
            "" => "the recording has no transforms (no /tf, no /tf_static, no odometry)".into(),
            odometry => format!("the recording has no transforms (/tf), but {odometry}"),
        };
        self.poses.explain(posing, kind, &without, &odometry)
    }

    /// Takes in that the channels have become more.
    pub(super) fn learn(&mut self, channels: &Channels) {
        self.has_transforms |= channels.has_transforms();
    }

    /// Whether a channel's messages are read here.
    pub(super) fn reads(&self, channel: &Channel) -> bool {
        let chosen = [&self.odometry_topic, &self.goal_topic];
        let is_chosen = chosen.into_iter().any(|topic| topic.as_ref() == Some(&channel.topic));
        // One message tells the frames.
        let is_told = self.reads_transforms && self.unread_odometry.get(&channel.topic) == Some(&None);
        is_chosen || is_told || self.reads_transforms && channel.kind.is_some_and(Kind::is_transforms)
    }

    /// What a channel that is read here is used for.
    pub(super) fn role(&self, channel: &Channel) -> &'static str {
        match channel.kind {
            _ if self.unread_odometry.contains_key(&channel.topic) => "poses only with odometry_topic",
            Some(Kind::RosPoseStamped(_)) => "goal",
            _ => "poses",
        }
    }

    /// The transforms of a message, none for a goal, which is kept.
    pub(super) fn take(
        &mut self,
        topic: &str,
        kind: Kind,
        log_time_ns: u64,
        payload: &[u8],
        report: &mut ReadReport,
    ) -> Result<Vec<TransformEvent>> {
        if let Kind::RosPoseStamped(wire) = kind {
            self.take_goal(wire.decode("geometry_msgs/PoseStamped", payload)?, log_time_ns)?;
            return Ok(Vec::new());
        }
        if let (Kind::RosOdometry(_), Some(odometry)) = (kind, &mut self.odometry) {
            return Ok(odometry.take(decode::odometry(kind, payload)?, report));
        }
        if let Some(frames) = self.unread_odometry.get_mut(topic) {
            let TransformEvent { parent, child, .. } = decode::odometry(kind, payload)?;
            *frames = Some([parent, child]);
            return Ok(Vec::new());
        }
        let mut transforms = decode::transforms(kind, topic.contains("static"), payload)?;
        if let Some(odometry) = &mut self.odometry {
            odometry.leave_out(&mut transforms);
        }
        Ok(transforms)
    }

    fn take_goal(&mut self, message: ros2::PoseStamped, log_time_ns: u64) -> Result<()> {
        let stamp_ns = Some(message.header.stamp.stamp_ns()?).filter(|&ns| ns > 0).unwrap_or(log_time_ns);
        let place_m = DVec2::new(message.pose.position.x, message.pose.position.y);
        if place_m.is_finite() {
            self.goals.push(Goal { stamp_ns, frame_id: bare_frame(message.header.frame_id), place_m });
        }
        if self.goals.len() > MAX_GOALS {
            self.goals.drain(..MAX_GOALS / 2);
        }
        Ok(())
    }

    /// The newest goal up to a stamp, in the map.
    pub(super) fn goal(
        &self,
        map_frame: &str,
        stamp_ns: u64,
        tolerance_ns: u64,
        report: &mut ReadReport,
    ) -> Option<DVec2> {
        let goal = self.goals.iter().rev().find(|goal| goal.stamp_ns <= stamp_ns)?;
        match self.poses.lookup(map_frame, &goal.frame_id, stamp_ns, tolerance_ns) {
            Ok(map_from_goal) => Some(map_from_goal.transform_point(goal.place_m.extend(0.0)).truncate()),
            Err(error) => {
                let reason = format!("no transform from `{}` to `{map_frame}`: {error}", goal.frame_id);
                report.skip(self.goal_topic.as_deref().unwrap_or("goal"), reason, stamp_ns);
                None
            }
        }
    }
}
