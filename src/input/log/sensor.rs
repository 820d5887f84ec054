//! A sensor of a log, of either kind, and what of it is ready.

use std::collections::VecDeque;

use crate::input::ReadReport;
use crate::input::frames::Posing;
use crate::input::log::camera::LogCamera;
use crate::input::log::lidar::LogLidar;
use crate::input::log::motion::Motion;
use crate::input::log::topics::Channel;
use crate::input::log::track::Track;
use crate::sensor::{Observation, SensorKind};

/// What a sensor's messages are read by.
pub(super) enum Reader {
    Camera(Box<LogCamera>),
    Lidar(Box<LogLidar>),
    /// The log has nothing of it.
    Absent,
}

/// A sensor of the log.
pub(super) struct LogSensor {
    /// Its name, and that of its topic where it has none.
    pub(super) name: String,
    pub(super) reader: Reader,
    /// Observations that wait for nothing but their turn, with the number of jumps before them.
    pub(super) ready: VecDeque<(u32, Observation)>,
    pub(super) track: Track,
}

impl LogSensor {
    pub(super) fn new(name: &str, reader: Reader) -> Self {
        Self { name: name.into(), reader, ready: VecDeque::new(), track: Track::default() }
    }

    pub(super) fn reads(&self, channel: &Channel) -> bool {
        match &self.reader {
            Reader::Camera(camera) => camera.reads(channel),
            Reader::Lidar(lidar) => lidar.topic == channel.topic,
            Reader::Absent => false,
        }
    }

    /// What a channel is used for, if it is.
    pub(super) fn role(&self, channel: &Channel) -> Option<&'static str> {
        match &self.reader {
            Reader::Camera(camera) => camera.role(channel),
            Reader::Lidar(lidar) => (lidar.topic == channel.topic).then_some("scans"),
            Reader::Absent => None,
        }
    }

    /// Stamp of the first observation that waits for more than its turn, nanoseconds.
    pub(super) fn waiting_ns(&self) -> Option<u64> {
        match &self.reader {
            Reader::Camera(camera) => camera.sync.waiting_ns(),
            Reader::Lidar(lidar) => lidar.waiting_ns(),
            Reader::Absent => None,
        }
    }

    /// How its observations fared that asked for a pose.
    pub(super) fn posing(&self) -> Option<(&Posing, SensorKind)> {
        match &self.reader {
            Reader::Camera(camera) => Some((&camera.sync.posing, SensorKind::Camera)),
            Reader::Lidar(lidar) => Some((lidar.posing(), SensorKind::Lidar)),
            Reader::Absent => None,
        }
    }

    /// What its own messages gave to tell.
    pub(super) fn report(&self) -> Option<&ReadReport> {
        match &self.reader {
            Reader::Camera(camera) => Some(&camera.report),
            Reader::Lidar(lidar) => Some(&lidar.report.read),
            Reader::Absent => None,
        }
    }

    /// Moves on what waits for nothing any more; `log_now_ns` is `None` at the end of the log.
    pub(super) fn settle(&mut self, motion: &Motion, log_now_ns: Option<u64>) {
        let jumps = self.track.jumps;
        match &mut self.reader {
            Reader::Camera(camera) => {
                match log_now_ns {
                    Some(_) => camera.sync.settle(&motion.poses, &mut camera.report),
                    None => camera.sync.finish(&motion.poses, &mut camera.report),
                }
                while let Some(observation) = camera.pop(motion) {
                    self.ready.push_back((jumps, observation));
                }
            }
            Reader::Lidar(lidar) => {
                while let Some(observation) = lidar.pop(motion, log_now_ns) {
                    self.ready.push_back((jumps, observation));
                }
            }
            Reader::Absent => {}
        }
    }

    /// As the messages come live: the clock says `now_ns`, and nothing waits for longer than `patience_ns`.
    #[cfg(feature = "ros2")]
    pub(super) fn go_by_clock(&mut self, now_ns: u64, patience_ns: u64) {
        match &mut self.reader {
            Reader::Camera(camera) => {
                camera.sync.be_patient_for(patience_ns);
                camera.sync.tell_time(now_ns);
            }
            Reader::Lidar(lidar) => lidar.be_patient_for(patience_ns),
            Reader::Absent => {}
        }
    }

    /// The transforms are about to start over: what was seen before they did is given with what is known.
    pub(super) fn restart_with_transforms(&mut self, motion: &Motion) {
        let jumps = self.track.jumps;
        match &mut self.reader {
            Reader::Camera(camera) => {
                camera.restart_with_transforms(motion);
                while let Some(observation) = camera.pop(motion) {
                    self.ready.push_back((jumps, observation));
                }
            }
            Reader::Lidar(lidar) => {
                while let Some(observation) = lidar.pop_before_restart(motion) {
                    self.ready.push_back((jumps, observation));
                }
            }
            Reader::Absent => {}
        }
    }
}
