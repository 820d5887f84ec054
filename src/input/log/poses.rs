//! The poses and goals of a log, read beside its scans: transforms, odometry, `geometry_msgs/PoseStamped`.

use std::path::Path;

use glam::DVec2;

use crate::base::Result;
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::bag;
use crate::input::bag::BagRecords;
use crate::input::event::TransformEvent;
use crate::input::log::decode;
use crate::input::log::odometry::Odometry;
use crate::input::log::topics::{Channel, Channels, Kind};
use crate::input::log::{Record, Records, scan as scan_channels};
use crate::input::mcap::McapRecords;
use crate::input::pose::PoseResolver;
use crate::message::{bare_frame, ros2};

/// How far past a stamp transforms are taken in, nanoseconds of their stamps.
const WAIT_NS: u64 = 2_000_000_000;

/// How far past a scan's message a log is read for transforms, nanoseconds of log time: more than [`WAIT_NS`], as a log may
/// be recorded from a slow replay.
const WAIT_LOG_NS: u64 = 10_000_000_000;

/// A goal as it came.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Goal {
    pub(crate) stamp_ns: u64,
    pub(crate) frame_id: String,
    pub(crate) place_m: DVec2,
}

/// See the module.
pub(crate) struct LogPoses {
    records: Box<dyn Records + Send>,
    channels: Channels,
    odometry_topic: Option<String>,
    odometry: Option<Odometry>,
    goal_topic: Option<String>,
    /// Everything known so far, the stated transforms included.
    pub(crate) poses: PoseResolver,
    goals: Vec<Goal>,
    /// Newest log time.
    log_time_ns: u64,
    at_end: bool,
}

/// What a log of messages holds, as far as choosing a path goes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Contents {
    /// Depth images.
    pub camera: bool,
    /// Lidar scans.
    pub lidar: bool,
}

fn channels_of<R: Records>(path: &Path) -> Result<Channels> {
    let mut channels = Channels::default();
    R::summary(path)?.into_iter().for_each(|record| channels.learn(record));
    if channels.is_empty() {
        scan_channels(&mut R::open(path)?, &mut channels)?;
    }
    Ok(channels)
}

/// What an MCAP file or a ROS 1 bag holds.
///
/// # Errors
/// [`crate::Error::File`], [`crate::Error::Format`].
pub(crate) fn contents(path: &Path, is_bag: bool) -> Result<Contents> {
    let channels = if is_bag { channels_of::<BagRecords>(path)? } else { channels_of::<McapRecords>(path)? };
    Ok(Contents {
        camera: crate::input::log::topics::find_depth(&channels).is_some(),
        lidar: channels.of_kind(Kind::is_scan).next().is_some(),
    })
}

impl LogPoses {
    /// Opens an MCAP file or a ROS 1 bag (by its first bytes); `None` where it has neither transforms nor odometry, nor the
    /// configuration any, and no goals are asked for.
    ///
    /// # Errors
    /// [`crate::Error::File`], [`crate::Error::Format`]; [`crate::Error::Config`] for a configured topic that is absent or
    /// of another type.
    pub(crate) fn open(path: &Path, start: &[u8], config: &Config) -> Result<Option<Self>> {
        if start.starts_with(bag::MAGIC) {
            Self::of::<BagRecords>(path, config)
        } else {
            Self::of::<McapRecords>(path, config)
        }
    }

    fn of<R: Records + Send + 'static>(path: &Path, config: &Config) -> Result<Option<Self>> {
        let channels = channels_of::<R>(path)?;
        let is_odometry = |kind| matches!(kind, Kind::RosOdometry(_));
        let is_goal = |kind| matches!(kind, Kind::RosPoseStamped(_));
        let odometry_topic =
            channels.configured(path, "odometry_topic", &config.odometry_topic, is_odometry)?;
        let goal_topic = channels.configured(path, "goal_topic", &config.goal_topic, is_goal)?;
        let posed =
            odometry_topic.is_some() || channels.has_transforms() || !config.static_transforms.is_empty();
        if !posed && goal_topic.is_none() {
            return Ok(None);
        }
        Ok(Some(Self {
            records: Box::new(R::open(path)?),
            channels,
            odometry: odometry_topic.as_ref().map(|_| Odometry::new(config)),
            odometry_topic,
            goal_topic,
            poses: PoseResolver::new(config)?,
            goals: Vec::new(),
            log_time_ns: 0,
            at_end: false,
        }))
    }

    /// Whether there are poses, and not only goals.
    pub(crate) fn posed(&self) -> bool {
        self.odometry_topic.is_some() || self.channels.has_transforms() || self.poses.has_stated()
    }

    /// Reads on until the pose of `frame` at a stamp, of a scan that was logged at `log_time_ns`, is settled or cannot be
    /// any more. Log times are compared with log times and stamps with stamps: their clocks may differ.
    pub(crate) fn read_to(
        &mut self,
        frame: &str,
        stamp_ns: u64,
        log_time_ns: u64,
        report: &mut ReadReport,
    ) -> Result<()> {
        let posed = self.posed();
        let last_ns = stamp_ns.saturating_add(WAIT_NS);
        let enough = |this: &Self| {
            let ahead = || this.poses.newest_ns(frame).is_some_and(|newest_ns| newest_ns > last_ns);
            let waited = this.log_time_ns > log_time_ns.saturating_add(WAIT_LOG_NS);
            this.log_time_ns > log_time_ns
                && (!posed || waited || this.poses.settled(frame, stamp_ns) || ahead())
        };
        while !self.at_end && !enough(self) {
            self.step(report)?;
        }
        Ok(())
    }

    /// The newest goal up to a stamp.
    pub(crate) fn goal(&self, stamp_ns: u64) -> Option<&Goal> {
        self.goals.iter().rev().find(|goal| goal.stamp_ns <= stamp_ns)
    }

    fn step(&mut self, report: &mut ReadReport) -> Result<()> {
        let (channels, odometry, goal) = (&self.channels, &self.odometry_topic, &self.goal_topic);
        let wanted = |id: u32| {
            channels.get(id).is_some_and(|channel| {
                let chosen = [odometry, goal].into_iter().any(|topic| topic.as_ref() == Some(&channel.topic));
                chosen || channel.kind.is_some_and(Kind::is_transforms)
            })
        };
        match self.records.next(&wanted)? {
            None => self.at_end = true,
            Some(Record::Message { channel_id, log_time_ns, data }) => {
                self.log_time_ns = self.log_time_ns.max(log_time_ns);
                let Some(Channel { topic, kind: Some(kind), .. }) = self.channels.get(channel_id) else {
                    return Ok(());
                };
                let (topic, kind) = (topic.clone(), *kind);
                if let Err(error) = self.take(&topic, kind, log_time_ns, &data, report) {
                    report.skip(&topic, error.to_string(), log_time_ns);
                }
            }
            Some(Record::Statistics { .. }) => {}
            Some(about_channels) => self.channels.learn(about_channels),
        }
        Ok(())
    }

    fn take(
        &mut self,
        topic: &str,
        kind: Kind,
        log_time_ns: u64,
        payload: &[u8],
        report: &mut ReadReport,
    ) -> Result<()> {
        if let Kind::RosPoseStamped(wire) = kind {
            let message: ros2::PoseStamped = wire.decode("geometry_msgs/PoseStamped", payload)?;
            self.take_goal(message, log_time_ns)?;
            return Ok(());
        }
        for transform in self.transforms(topic, kind, payload, report)? {
            if self.poses.jumps_back(&transform) {
                self.poses.tree.clear_samples();
                report
                    .note("transform stamps jumped back by more than a second: transforms start over there");
            }
            self.poses.take(topic, &transform, report);
        }
        Ok(())
    }

    fn take_goal(&mut self, message: ros2::PoseStamped, log_time_ns: u64) -> Result<()> {
        let stamp_ns = Some(message.header.stamp.stamp_ns()?).filter(|&ns| ns > 0).unwrap_or(log_time_ns);
        let place_m = DVec2::new(message.pose.position.x, message.pose.position.y);
        if place_m.is_finite() {
            self.goals.push(Goal { stamp_ns, frame_id: bare_frame(message.header.frame_id), place_m });
        }
        // Only the newest can still count; a bound against hostile files.
        if self.goals.len() > 1024 {
            self.goals.drain(..512);
        }
        Ok(())
    }

    fn transforms(
        &mut self,
        topic: &str,
        kind: Kind,
        payload: &[u8],
        report: &mut ReadReport,
    ) -> Result<Vec<TransformEvent>> {
        if let (Kind::RosOdometry(_), Some(odometry)) = (kind, &mut self.odometry) {
            return Ok(odometry.take(decode::odometry(kind, payload)?, report));
        }
        let mut transforms = decode::transforms(kind, topic.contains("static"), payload)?;
        if let Some(odometry) = &mut self.odometry {
            odometry.leave_out(&mut transforms);
        }
        Ok(transforms)
    }
}
