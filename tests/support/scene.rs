//! Analytic frames for stage tests: planes and boxes seen by a pinhole camera, with exact depth.

use glam::{DMat3, DQuat, DVec3};
use limpid::base::Rigid;
use limpid::sensor::CameraModel;
use limpid::sensor::{DepthImage, DepthSamples, FramePose, RgbdFrame};

/// 160x120 pixels, 57 degrees wide.
pub(crate) fn small_camera() -> CameraModel {
    crate::support::drive::camera()
}

/// Base at (x, y) turned by `yaw`; camera `height_m` above it, pitched down by `pitch`, radians.
pub(crate) fn pose(x: f64, y: f64, yaw: f64, height_m: f64, pitch: f64) -> FramePose {
    let optical = DQuat::from_mat3(&DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X));
    FramePose {
        map_from_base: Rigid { rotation: DQuat::from_rotation_z(yaw), translation_m: DVec3::new(x, y, 0.0) },
        base_from_camera: Rigid {
            rotation: DQuat::from_rotation_y(pitch) * optical,
            translation_m: DVec3::new(0.0, 0.0, height_m),
        },
    }
}

/// An axis-aligned box between two corners.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Block {
    pub(crate) min: DVec3,
    pub(crate) max: DVec3,
}

impl Block {
    pub(crate) fn new(min: [f64; 3], max: [f64; 3]) -> Self {
        Self { min: DVec3::from_array(min), max: DVec3::from_array(max) }
    }

    /// Smallest positive t at which `origin + t * direction` enters the box.
    fn hit(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            if direction[axis].abs() < 1e-12 {
                if origin[axis] < self.min[axis] || origin[axis] > self.max[axis] {
                    return None;
                }
                continue;
            }
            let a = (self.min[axis] - origin[axis]) / direction[axis];
            let b = (self.max[axis] - origin[axis]) / direction[axis];
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near <= far && near > 0.0).then_some(near)
    }
}

/// A floor at z = 0 and boxes on or above it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Scene {
    pub(crate) blocks: Vec<Block>,
}

impl Scene {
    pub(crate) fn of(blocks: &[Block]) -> Self {
        Self { blocks: blocks.to_vec() }
    }

    /// Depth along the optical axis for every pixel, metres; 0 where nothing is met.
    pub(crate) fn depth(&self, camera: &CameraModel, map_from_camera: Rigid) -> Vec<f32> {
        let pixels = (0..camera.height).flat_map(|v| (0..camera.width).map(move |u| (u, v)));
        pixels
            .map(|(u, v)| {
                let Some([x, y]) = camera.ray(f64::from(u), f64::from(v)) else { return 0.0 };
                let origin = map_from_camera.translation_m;
                let direction = map_from_camera.rotation * DVec3::new(x, y, 1.0);
                let floor = (direction.z < -1e-9).then(|| -origin.z / direction.z);
                let hits = self.blocks.iter().filter_map(|b| b.hit(origin, direction)).chain(floor);
                hits.min_by(f64::total_cmp).unwrap_or(0.0) as f32
            })
            .collect()
    }

    /// The frame that a float depth camera at `pose` takes.
    pub(crate) fn frame(&self, index: u64, camera: CameraModel, pose: FramePose) -> RgbdFrame {
        let map_from_camera = pose.map_from_base.then(pose.base_from_camera);
        frame(index, camera, Some(pose), DepthSamples::Metres(self.depth(&camera, map_from_camera)))
    }
}

/// A frame of given samples, at 30 Hz.
pub(crate) fn frame(
    index: u64,
    camera: CameraModel,
    pose: Option<FramePose>,
    samples: DepthSamples,
) -> RgbdFrame {
    let stamp_ns = 1_700_000_000_000_000_000 + index * 33_333_333;
    let depth = DepthImage { stamp_ns, frame_id: "camera".into(), camera, samples };
    RgbdFrame {
        index,
        depth,
        color: None,
        color_from_depth: None,
        color_missing: None,
        confidence: None,
        pose,
    }
}
