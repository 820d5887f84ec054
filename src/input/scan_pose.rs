//! A scan with its pose: at its stamp, and at the times of its first and last point.

use crate::base::{Rigid, duration_ns};
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::frames::Posing;
use crate::input::pose::PoseResolver;
use crate::input::transforms::TransformError;
use crate::message::bare_name;
use crate::sensor::{Observation, Scan, SensorData, SensorPose, Sweep};

/// Frame of a lidar whose recording and configuration name none.
const NAMELESS: &str = "lidar";

/// Points spread over less than this are taken as measured at once, seconds.
const LEAST_SWEEP_S: f32 = 1e-4;

/// What a lidar's scans are posed by.
#[derive(Debug)]
pub(crate) struct ScanPoser {
    lidar_frame: String,
    map_frame: String,
    /// `transform_tolerance_s`, nanoseconds.
    pub(crate) tolerance_ns: u64,
    /// How scans fared that asked for a pose.
    pub(crate) posing: Posing,
}

impl ScanPoser {
    pub(crate) fn new(config: &Config) -> Self {
        Self {
            lidar_frame: bare_name(&config.lidar_frame).into(),
            map_frame: bare_name(&config.map_frame).into(),
            tolerance_ns: duration_ns(config.transform_tolerance_s),
            posing: Posing::default(),
        }
    }

    /// The lidar's frame.
    pub(crate) fn frame<'a>(&'a self, scan: &'a Scan) -> &'a str {
        let named = [self.lidar_frame.as_str(), &scan.frame_id].into_iter().find(|name| !name.is_empty());
        named.unwrap_or(NAMELESS)
    }

    /// Stamp up to which poses are needed, nanoseconds: some drivers stamp a scan after its last point.
    pub(crate) fn end_ns(scan: &Scan) -> u64 {
        scan.stamp_ns.max(shifted(scan.stamp_ns, sweep_times(scan).map_or(0.0, |[_, last_s]| last_s)))
    }

    /// The scan with its pose, `None` where it is not known at that stamp, which is counted. Without `poses` the map is
    /// the lidar's own frame.
    pub(crate) fn observe(
        &mut self,
        scan: Scan,
        poses: Option<&PoseResolver>,
        report: &mut ReadReport,
    ) -> Observation {
        let frame_id = self.frame(&scan).to_owned();
        let (map_frame, pose) = match poses {
            None => (frame_id, Some(SensorPose::SENSOR)),
            Some(poses) => {
                let pose = self.pose(poses, &frame_id, &scan, report);
                match &pose {
                    Ok(_) => self.posing.posed += 1,
                    Err(error) => {
                        report.skip(&frame_id, poses.missing_reason(&frame_id, error), scan.stamp_ns);
                        self.posing.miss(&frame_id, scan.stamp_ns, error);
                    }
                }
                (self.map_frame.clone(), pose.ok())
            }
        };
        Observation { sensor: 0, pose, map_frame, goal_m: None, data: SensorData::Scan(scan) }
    }

    fn pose(
        &self,
        poses: &PoseResolver,
        frame_id: &str,
        scan: &Scan,
        report: &mut ReadReport,
    ) -> Result<SensorPose, TransformError> {
        let (map_from_base, base_from_sensor) =
            poses.lidar_pose(frame_id, scan.stamp_ns, self.tolerance_ns, report)?;
        let at = |seconds: f32| poses.map_from(frame_id, shifted(scan.stamp_ns, seconds), self.tolerance_ns);
        let sweep = sweep_times(scan).and_then(|[first_s, last_s]| match (at(first_s), at(last_s)) {
            // A lidar that stood still needs no deskewing.
            (Ok(map_from_first), Ok(map_from_last)) => (numbers(map_from_first) != numbers(map_from_last))
                .then_some(Sweep { first_s, last_s, map_from_first, map_from_last }),
            (first, last) => {
                let reason = first.err().or(last.err()).map_or_else(String::new, |error| error.to_string());
                report.note(format!("scans are not deskewed where a point's time has no pose: {reason}"));
                None
            }
        });
        Ok(SensorPose { map_from_base, base_from_sensor, sweep })
    }
}

fn numbers(rigid: Rigid) -> [f64; 7] {
    let (t, r) = (rigid.translation_m, rigid.rotation);
    [t.x, t.y, t.z, r.x, r.y, r.z, r.w]
}

/// Times of the first and the last point, where points have times that differ.
fn sweep_times(scan: &Scan) -> Option<[f32; 2]> {
    let times = || scan.points.iter().map(|point| point.time_s);
    let (first, last) = (times().fold(f32::INFINITY, f32::min), times().fold(f32::NEG_INFINITY, f32::max));
    (scan.columns.time && last - first > LEAST_SWEEP_S && last - first < 10.0).then_some([first, last])
}

/// A stamp some seconds later, or earlier.
fn shifted(stamp_ns: u64, seconds: f32) -> u64 {
    let nanoseconds = duration_ns(f64::from(seconds.abs()));
    if seconds < 0.0 { stamp_ns.saturating_sub(nanoseconds) } else { stamp_ns.saturating_add(nanoseconds) }
}
