//! Scans with what their recording says of the robot: poses at the scan's stamp and at those of its first and last point,
//! and the goal.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use glam::DVec2;

use crate::base::Rigid;
use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::bag;
use crate::input::log::LogPoses;
use crate::input::points;
use crate::input::points::{Options, ScanReport, Scans};
use crate::input::pose::PoseResolver;
use crate::input::report::merge;
use crate::input::transforms::TransformError;
use crate::sensor::Scan;
use crate::sensor::{Observation, SensorData, SensorPose, Sweep};

/// Frame of a lidar whose recording and configuration name none.
const NAMELESS: &str = "lidar";

/// Points spread over less than this are taken as measured at once, seconds.
const LEAST_SWEEP_S: f32 = 1e-4;

/// Where poses come from.
enum Poses {
    /// The map is the lidar's own frame.
    None,
    /// `static_transforms` alone.
    Stated(PoseResolver),
    /// A log with transforms or odometry.
    Log(Box<LogPoses>),
}

/// A stream of scans with poses; see the module.
pub struct PosedScans {
    scans: Box<dyn Scans>,
    poses: Poses,
    config: Config,
    report: ReadReport,
}

impl PosedScans {
    /// Opens any recording that [`points::open`] reads. Where it has neither transforms nor odometry and the configuration
    /// states no transforms, maps lie in the lidar's own frame.
    ///
    /// # Errors
    /// What [`points::open`] returns; [`Error::Config`] for a configured topic that is absent or of another type.
    pub fn open(path: &Path, config: &Config) -> Result<Self> {
        let options = Options {
            topic: Some(config.scan_topic.clone()).filter(|topic| !topic.is_empty()),
            model: config.velodyne_model,
            return_codes: config.return_codes,
        };
        let scans = points::open(path, &options)?;
        let poses = open_poses(path, config)?;
        Ok(Self { scans, poses, config: config.clone(), report: ReadReport::default() })
    }

    /// The next scan with its pose and goal; the pose is `None` where it is not known at that stamp, which is counted.
    ///
    /// # Errors
    /// Only what ends the recording.
    pub fn next_observation(&mut self) -> Result<Option<Observation>> {
        let Some(scan) = self.scans.next_scan()? else { return Ok(None) };
        let frame_id =
            [&self.config.lidar_frame, &scan.frame_id].into_iter().find(|name| !name.is_empty()).cloned();
        let frame_id = frame_id.unwrap_or_else(|| NAMELESS.into());
        let times = sweep_times(&scan);
        if let Poses::Log(log) = &mut self.poses {
            // Some drivers stamp a scan after its last point.
            let end_ns = scan.stamp_ns.max(shifted(scan.stamp_ns, times.map_or(0.0, |[_, last_s]| last_s)));
            let log_time_ns = self.scans.log_time_ns().unwrap_or(end_ns);
            log.read_to(&frame_id, end_ns, log_time_ns, &mut self.report)?;
        }
        let posed = match &self.poses {
            Poses::None => None,
            Poses::Stated(resolver) => Some(resolver),
            Poses::Log(log) => log.posed().then_some(&log.poses),
        };
        let (map_frame, pose) = match posed {
            None => (frame_id.clone(), Some(SensorPose::SENSOR)),
            Some(resolver) => {
                let pose = pose(resolver, &frame_id, scan.stamp_ns, times, &mut self.report);
                if let Err(error) = &pose {
                    let reason = resolver.missing_reason(&frame_id, error);
                    self.report.skip(&frame_id, reason, scan.stamp_ns);
                }
                (self.config.map_frame.clone(), pose.ok())
            }
        };
        let goal_m = self.goal(&map_frame, scan.stamp_ns);
        Ok(Some(Observation { sensor: 0, pose, map_frame, goal_m, data: SensorData::Scan(scan) }))
    }

    /// The goal of the topic, in the map.
    fn goal(&mut self, map_frame: &str, stamp_ns: u64) -> Option<DVec2> {
        let Poses::Log(log) = &self.poses else { return None };
        let goal = log.goal(stamp_ns)?;
        match log.poses.lookup(map_frame, &goal.frame_id, stamp_ns) {
            Ok(map_from_goal) => Some(map_from_goal.transform_point(goal.place_m.extend(0.0)).truncate()),
            Err(error) => {
                let reason = format!("no transform from `{}` to `{map_frame}`: {error}", goal.frame_id);
                self.report.skip(&self.config.goal_topic, reason, stamp_ns);
                None
            }
        }
    }

    /// What was met so far, poses included.
    pub fn report(&self) -> ScanReport {
        let mut report = self.scans.report().clone();
        merge(&mut report.read, &self.report);
        report
    }

    /// How many scans the recording says it holds, where it does.
    pub fn scan_count_hint(&self) -> Option<u64> {
        self.scans.scan_count_hint()
    }
}

fn open_poses(path: &Path, config: &Config) -> Result<Poses> {
    let mut start = Vec::new();
    if path.is_file() {
        let file = File::open(path).map_err(Error::file(path))?;
        file.take(16).read_to_end(&mut start).map_err(Error::file(path))?;
    }
    if start.starts_with(::mcap::MAGIC) || start.starts_with(bag::MAGIC) {
        let log = LogPoses::open(path, &start, config)?;
        return Ok(log.map_or(Poses::None, |log| Poses::Log(Box::new(log))));
    }
    if config.static_transforms.is_empty() {
        return Ok(Poses::None);
    }
    Ok(Poses::Stated(PoseResolver::new(config)?))
}

/// Times of the first and the last point, where points have times that differ.
fn sweep_times(scan: &Scan) -> Option<[f32; 2]> {
    let times = || scan.points.iter().map(|point| point.time_s);
    let (first, last) = (times().fold(f32::INFINITY, f32::min), times().fold(f32::NEG_INFINITY, f32::max));
    (scan.columns.time && last - first > LEAST_SWEEP_S && last - first < 10.0).then_some([first, last])
}

/// A stamp some seconds later, or earlier.
fn shifted(stamp_ns: u64, seconds: f32) -> u64 {
    let nanoseconds = crate::base::duration_ns(f64::from(seconds.abs()));
    if seconds < 0.0 { stamp_ns.saturating_sub(nanoseconds) } else { stamp_ns.saturating_add(nanoseconds) }
}

fn pose(
    resolver: &PoseResolver,
    frame_id: &str,
    stamp_ns: u64,
    times: Option<[f32; 2]>,
    report: &mut ReadReport,
) -> std::result::Result<SensorPose, TransformError> {
    let (map_from_base, base_from_lidar) = resolver.lidar_pose(frame_id, stamp_ns, report)?;
    let at = |seconds: f32| resolver.map_from(frame_id, shifted(stamp_ns, seconds));
    let sweep = times.and_then(|[first_s, last_s]| match (at(first_s), at(last_s)) {
        (Ok(map_from_first), Ok(map_from_last)) => {
            let moves: fn(Rigid) -> [f64; 7] = |m| {
                let (t, r) = (m.translation_m, m.rotation);
                [t.x, t.y, t.z, r.x, r.y, r.z, r.w]
            };
            // A lidar that stood still needs no deskewing.
            (moves(map_from_first) != moves(map_from_last)).then_some(Sweep {
                first_s,
                last_s,
                map_from_first,
                map_from_last,
            })
        }
        (first, last) => {
            let reason = first.err().or(last.err()).map_or_else(String::new, |error| error.to_string());
            report.note(format!("scans are not deskewed where a point's time has no pose: {reason}"));
            None
        }
    });
    Ok(SensorPose { map_from_base, base_from_sensor: base_from_lidar, sweep })
}
