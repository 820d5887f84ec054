//! The robot's poses along its way.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec2, DVec3};

use super::scene::Scene;
use super::settings::Camera;
use crate::base::Rigid;
use crate::sensor::FramePose;

/// The left imager's optical frame in the robot base.
pub(crate) fn base_from_camera(camera: &Camera) -> Rigid {
    let optical = DQuat::from_mat3(&DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X));
    Rigid {
        rotation: (DQuat::from_rotation_y(camera.pitch_rad) * optical).normalize(),
        translation_m: DVec3::new(camera.forward_m, 0.0, camera.height_m),
    }
}

/// Place and heading of the robot, frame by frame: from point to point in steps of `step_m`, turning on
/// the spot by at most `turn_rad` a frame. At most `frames`, fewer where the way ends before.
pub fn poses(scene: &Scene) -> Vec<FramePose> {
    let base_from_camera = base_from_camera(&scene.camera);
    places(scene)
        .into_iter()
        .map(|(at, yaw)| FramePose {
            map_from_base: Rigid { rotation: DQuat::from_rotation_z(yaw), translation_m: at.extend(0.0) },
            base_from_camera,
        })
        .collect()
}

/// Stamp of the first frame.
const START_NS: u64 = 1_700_000_000_000_000_000;

/// Stamp of frame `index`.
pub fn stamp_ns(scene: &Scene, index: u64) -> u64 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a checked, positive rate")]
    let period_ns = (1e9 / scene.trajectory.rate_hz).round() as u64;
    START_NS + index * period_ns
}

/// Seconds from the first frame to a stamp.
pub(crate) fn seconds_at(stamp_ns: u64) -> f64 {
    std::time::Duration::from_nanos(stamp_ns.saturating_sub(START_NS)).as_secs_f64()
}

/// Where the robot is at any time: between the poses of frames as transforms are interpolated.
#[derive(Debug, Clone)]
pub struct Way {
    stamps_ns: Vec<u64>,
    poses: Vec<Rigid>,
}

impl Way {
    /// Of a checked scene.
    pub fn of(scene: &Scene) -> Self {
        let poses: Vec<Rigid> = poses(scene).iter().map(|pose| pose.map_from_base).collect();
        let stamps_ns = (0_u64..).take(poses.len()).map(|index| stamp_ns(scene, index)).collect();
        Self { stamps_ns, poses }
    }

    /// The stamp of its start.
    pub fn start_ns(&self) -> u64 {
        self.stamps_ns.first().copied().unwrap_or(START_NS)
    }

    /// Map from base; before the start and after the end the robot stands still.
    pub fn at(&self, stamp_ns: u64) -> Rigid {
        let next = self.stamps_ns.partition_point(|&stamp| stamp < stamp_ns);
        let (Some(&after), Some(before)) = (self.stamps_ns.get(next), next.checked_sub(1)) else {
            let end = if next == 0 { self.poses.first() } else { self.poses.last() };
            return end.copied().unwrap_or(Rigid::IDENTITY);
        };
        let start = self.stamps_ns[before];
        let nanoseconds = |ns: u64| std::time::Duration::from_nanos(ns).as_secs_f64();
        let share = nanoseconds(stamp_ns - start) / nanoseconds(after - start);
        self.poses[before].interpolate(self.poses[next], share)
    }
}

fn places(scene: &Scene) -> Vec<(DVec2, f64)> {
    let way = &scene.trajectory;
    let frames = way.frames as usize;
    let points: Vec<DVec2> = way.waypoints_m.iter().copied().map(DVec2::from_array).collect();
    let (Some(&start), Some(&second)) = (points.first(), points.get(1).or(points.first())) else {
        return Vec::new();
    };
    let (mut at, mut yaw) = (start, heading(start, second).unwrap_or(way.yaw_rad));
    let mut places = vec![(at, yaw)];
    if points.len() == 1 {
        places.resize(frames, (at, yaw));
        return places;
    }
    for &goal in &points[1..] {
        let Some(wanted) = heading(at, goal) else { continue };
        while places.len() < frames {
            let off = (wanted - yaw + PI).rem_euclid(TAU) - PI;
            let left_m = at.distance(goal);
            if off.abs() > 1e-9 {
                yaw = if off.abs() <= way.turn_rad { wanted } else { yaw + off.signum() * way.turn_rad };
            } else if left_m > way.step_m {
                at += (goal - at) / left_m * way.step_m;
            } else if left_m > 1e-9 {
                at = goal;
            } else {
                break;
            }
            places.push((at, yaw));
        }
    }
    places.truncate(frames);
    places
}

fn heading(from: DVec2, to: DVec2) -> Option<f64> {
    (from.distance(to) > 1e-9).then(|| (to - from).to_angle())
}
