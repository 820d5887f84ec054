//! Poses that jump: what no robot drives from one scan to the next, as after a relocalization or a loop closure.

use crate::base::Rigid;
use crate::base::seconds_between;
use crate::config::Config;

/// Stamps nearer to each other, equal or going back count as this far apart, seconds.
const LEAST_S: f64 = 0.1;

/// The poses of a lidar, scan after scan.
#[derive(Debug, Clone, Default)]
pub(crate) struct PoseTrack {
    last: Option<(u64, Rigid)>,
}

impl PoseTrack {
    /// Takes on the pose of a scan; whether the lidar would have had to move faster than `pose_jump_m_s` or turn faster than
    /// `pose_jump_deg_s` to get there from the scan before. The first never jumps.
    pub(crate) fn jumps(&mut self, config: &Config, stamp_ns: u64, map_from_lidar: Rigid) -> bool {
        let Some((last_ns, before)) = self.last.replace((stamp_ns, map_from_lidar)) else { return false };
        let seconds = seconds_between(last_ns, stamp_ns).max(LEAST_S);
        let moved = before.inverse().then(map_from_lidar);
        let turned_deg = 2.0 * moved.rotation.w.abs().min(1.0).acos().to_degrees();
        let above = |most: f64, moved: f64| most > 0.0 && moved > most * seconds;
        above(config.pose_jump_m_s, moved.translation_m.length()) || above(config.pose_jump_deg_s, turned_deg)
    }
}
