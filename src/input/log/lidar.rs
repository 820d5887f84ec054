//! One lidar of a log: clouds, or raw packets that are joined to revolutions.
//!
//! A `VelodyneScan` whose packets make a revolution is one scan, as its driver cut it; smaller ones are joined and cut
//! where the azimuth wraps.

use std::collections::VecDeque;

use crate::base::Result;
use crate::config::Config;
use crate::input::frames::Posing;
use crate::input::log::cameras::clouds_of_cameras;
use crate::input::log::layout::Layout;
use crate::input::log::motion::Motion;
use crate::input::log::topics::{Channels, Kind, Wire};
use crate::input::points::velodyne::{Cut, Decoder, ScanMessage};
use crate::input::points::{Options, ScanReport, check_reach, cloud, laser, livox};
use crate::input::scan_pose::ScanPoser;
use crate::message::{decode_error, foxglove};
use crate::sensor::{Observation, Scan};

/// How far past a stamp transforms are taken in, nanoseconds of their stamps.
const WAIT_NS: u64 = 2_000_000_000;

/// How far past a scan's message a log is read for transforms, nanoseconds of log time: more than [`WAIT_NS`], as a log may
/// be recorded from a slow replay.
const WAIT_LOG_NS: u64 = 10_000_000_000;

/// Most scans that wait.
const MAX_WAITING: usize = 64;

/// A scan that waits for its pose.
struct Waiting {
    scan: Scan,
    /// Stamp up to which poses are needed, nanoseconds.
    end_ns: u64,
    log_time_ns: u64,
    /// Whether its stamp came after the lidar's stamps had jumped back and before the transforms' did.
    jumped: bool,
}

/// See the module.
pub(super) struct LogLidar {
    pub(super) topic: String,
    options: Options,
    poser: ScanPoser,
    /// Whether the map is this lidar's own frame where there are no poses at all.
    alone: bool,
    /// Of a topic with packets, from its first message on.
    decoder: Option<Decoder>,
    cloud: Option<Scan>,
    waiting: VecDeque<Waiting>,
    /// Log time of the newest message, nanoseconds.
    log_time_ns: u64,
    /// How far past a scan's message transforms are waited for, nanoseconds of log time.
    patience_ns: u64,
    jumped: bool,
    pub(super) report: ScanReport,
    /// Messages and clouds that gave no scan.
    pub(super) unusable: u64,
}

impl LogLidar {
    /// `alone`: whether there is no other lidar.
    pub(super) fn new(topic: String, options: Options, config: &Config, alone: bool) -> Self {
        Self {
            topic,
            options,
            poser: ScanPoser::new(config),
            alone,
            decoder: None,
            cloud: None,
            waiting: VecDeque::new(),
            log_time_ns: 0,
            patience_ns: WAIT_LOG_NS,
            jumped: false,
            report: ScanReport::default(),
            unusable: 0,
        }
    }

    /// How scans fared that asked for a pose.
    pub(super) fn posing(&self) -> &Posing {
        &self.poser.posing
    }

    /// From now on a scan waits for its pose at most so long, nanoseconds of log time.
    #[cfg(feature = "ros2")]
    pub(super) fn be_patient_for(&mut self, patience_ns: u64) {
        self.patience_ns = patience_ns;
    }

    /// Takes in a message; a bad one is counted.
    pub(super) fn take(&mut self, kind: Kind, log_time_ns: u64, payload: &[u8]) {
        self.log_time_ns = self.log_time_ns.max(log_time_ns);
        if let Err(error) = self.decode(kind, payload) {
            self.report.read.skip(&self.topic, error.to_string(), log_time_ns);
            self.unusable += 1;
        }
    }

    fn decode(&mut self, kind: Kind, payload: &[u8]) -> Result<()> {
        let scan = match kind {
            Kind::RosPointCloud(wire) => {
                cloud::check_size(&wire.decode("sensor_msgs/PointCloud2", payload)?)?;
                cloud::from_ros(wire.decode("sensor_msgs/PointCloud2", payload)?, &self.options)?
            }
            Kind::OldPointCloud(wire) => {
                cloud::from_old(wire.decode("sensor_msgs/PointCloud", payload)?, &self.options)?
            }
            Kind::FoxglovePointCloud => {
                let message = foxglove::decode_protobuf("foxglove.PointCloud", payload)?;
                cloud::from_foxglove(&message, &self.options)?
            }
            Kind::VelodyneScan(Wire::Cdr) => {
                self.take_packets(&ScanMessage::from_cdr(payload)?);
                return Ok(());
            }
            Kind::VelodyneScan(Wire::Ros1) => {
                self.take_packets(&ScanMessage::from_ros1(payload)?);
                return Ok(());
            }
            Kind::LivoxCustom(wire) => {
                livox::check_size(&wire.decode("livox CustomMsg", payload)?)?;
                livox::from_custom_msg(wire.decode("livox CustomMsg", payload)?)?
            }
            Kind::FoxgloveLaserScan => {
                laser::from_foxglove(foxglove::decode_protobuf("foxglove.LaserScan", payload)?)?
            }
            Kind::LaserScan(wire) => laser::from_laser_scan(wire.decode("sensor_msgs/LaserScan", payload)?)?,
            Kind::MultiEchoLaserScan(wire) => {
                laser::from_multi_echo(wire.decode("sensor_msgs/MultiEchoLaserScan", payload)?)?
            }
            _ => return Err(decode_error("scan", "the topic holds another type")),
        };
        check_reach("scan", &scan)?;
        self.cloud = Some(scan);
        Ok(())
    }

    fn take_packets(&mut self, message: &ScanMessage) {
        let report = &mut self.report.read;
        if message.packets.is_empty() {
            report.skip(&self.topic, "the message has no packets", message.stamp_ns);
            self.unusable += 1;
        }
        let decoder =
            self.decoder.get_or_insert_with(|| Decoder::new(&self.topic, &message.frame_id, &self.options));
        let whole = message.is_revolution();
        if whole {
            decoder.finish(report);
        }
        for (at, packet) in message.packets.iter().enumerate() {
            let cut = match (whole, at + 1 == message.packets.len()) {
                (false, _) => Cut::AtWrap,
                (true, false) => Cut::Not,
                (true, true) => Cut::After,
            };
            decoder.push(packet.payload, packet.stamp_ns, cut, report);
        }
    }

    /// The log is at its end.
    pub(super) fn finish(&mut self) {
        if let Some(decoder) = &mut self.decoder {
            decoder.finish(&mut self.report.read);
        }
    }

    /// The next scan that has points, as it was decoded.
    pub(super) fn next_scan(&mut self) -> Option<Scan> {
        loop {
            let mut scan = self.cloud.take().or_else(|| self.decoder.as_mut()?.pop())?;
            if !scan.points.is_empty() {
                self.report.count(&mut scan);
                return Some(scan);
            }
            self.report.count_empty(&self.topic, &scan);
            self.unusable += 1;
        }
    }

    /// Has a scan wait for its pose; `jumped`: its stamp lies before those that came before.
    pub(super) fn wait(&mut self, scan: Scan, jumped: bool) {
        self.jumped |= jumped;
        let end_ns = ScanPoser::end_ns(&scan);
        let (log_time_ns, jumped) = (self.log_time_ns, self.jumped);
        self.waiting.push_back(Waiting { scan, end_ns, log_time_ns, jumped });
    }

    /// Stamp of the scan that waits first, nanoseconds.
    pub(super) fn waiting_ns(&self) -> Option<u64> {
        self.waiting.front().map(|waiting| waiting.scan.stamp_ns)
    }

    /// The next scan whose pose is settled or cannot be any more, as the log has been read up to `log_now_ns` (`None`: to
    /// its end). Log times are compared with log times and stamps with stamps: their clocks may differ.
    pub(super) fn pop(&mut self, motion: &Motion, log_now_ns: Option<u64>) -> Option<Observation> {
        let first = self.waiting.front()?;
        let settled = self.waiting.len() > MAX_WAITING
            || log_now_ns.is_none_or(|log_now_ns| self.settled(first, motion, log_now_ns));
        if settled { self.release(motion) } else { None }
    }

    fn settled(&self, waiting: &Waiting, motion: &Motion, log_now_ns: u64) -> bool {
        let Waiting { scan, end_ns, log_time_ns, .. } = waiting;
        let (poses, frame) = (&motion.poses, self.poser.frame(scan));
        let ahead =
            || poses.newest_ns(frame).is_some_and(|newest_ns| newest_ns > end_ns.saturating_add(WAIT_NS));
        let waited = log_now_ns > log_time_ns.saturating_add(self.patience_ns);
        log_now_ns > *log_time_ns && (!motion.posed() || waited || poses.settled(frame, *end_ns) || ahead())
    }

    /// Gives the first scan that waits with what is known.
    fn release(&mut self, motion: &Motion) -> Option<Observation> {
        let scan = self.waiting.pop_front()?.scan;
        let poses = (motion.posed() || !self.alone).then_some(&motion.poses);
        let report = &mut self.report.read;
        let mut observation = self.poser.observe(scan, poses, report);
        let stamp_ns = observation.stamp_ns();
        observation.goal_m = motion.goal(&observation.map_frame, stamp_ns, self.poser.tolerance_ns, report);
        Some(observation)
    }

    /// The transforms are about to start over: the next of the scans that were seen before they did.
    pub(super) fn pop_before_restart(&mut self, motion: &Motion) -> Option<Observation> {
        if self.waiting.front().is_some_and(|first| !first.jumped) {
            return self.release(motion);
        }
        self.jumped = false;
        self.waiting.iter_mut().for_each(|waiting| waiting.jumped = false);
        None
    }
}

/// The topic to take. Clouds that have what is needed come before those that lack it, clouds before flat scans, which are often
/// made of them, and packets before clouds, as clouds are made of packets and may have lost returns; then by name. A camera's
/// own cloud beside its depth images is none.
pub(super) fn find(channels: &Channels) -> Option<String> {
    let own = clouds_of_cameras(channels);
    let rank = |channel: &&super::topics::Channel| {
        let flat = channel.kind.is_some_and(Kind::is_flat_scan);
        let packets = matches!(channel.kind, Some(Kind::VelodyneScan(_)));
        let lacks = channels.layout(&channel.topic).map_or([false; 6], Layout::lacks);
        (lacks[..3].to_vec(), flat, !packets, lacks[3..].to_vec(), channel.topic.clone())
    };
    let scans = channels.of_kind(Kind::is_scan).filter(|channel| !own.contains(&channel.topic));
    scans.min_by_key(rank).map(|channel| channel.topic.clone())
}

/// One line for the report.
pub(super) fn note(channels: &Channels, topic: &str) -> String {
    let others = channels.of_kind(Kind::is_scan).map(|channel| channel.topic.as_str());
    let others: Vec<&str> = others.filter(|other| *other != topic).take(40).collect();
    if others.is_empty() {
        format!("topic: {topic}")
    } else {
        format!("topic: {topic} (others with scans: {})", others.join(", "))
    }
}
