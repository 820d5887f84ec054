//! A small camera and map for tests of single passes.

use std::sync::Arc;

use glam::DVec3;
use limpid::Config;
use limpid::base::Rigid;
use limpid::sensor::FramePose;
use limpid::sensor::{CameraModel, Distortion};
use limpid::stage::{CameraJob, MapJob};

use crate::support::scene::Scene;

/// 80x60 pixels, 57 degrees wide.
pub(crate) fn tiny_camera() -> CameraModel {
    CameraModel {
        width: 80,
        height: 60,
        fx: 73.0,
        fy: 73.0,
        cx: 39.3,
        cy: 29.6,
        distortion: Distortion::None,
    }
}

/// 6 m of map in 120x120 cells.
pub(crate) fn small_map() -> Config {
    Config { map_size_m: 6.0, mark_range_m: 4.0, ..Config::default() }
}

pub(crate) fn job(config: &Config, depth: CameraModel) -> CameraJob {
    CameraJob {
        map: Arc::new(MapJob::of_camera(config, config.cells_per_side().unwrap())),
        sensor: 0,
        scope: String::new(),
        config: config.clone(),
        depth,
        float_depth: true,
        color: None,
        color_aligned: false,
        confidence: false,
        drm: None,
        depth_alone: false,
        images: false,
        layers: true,
        cell_inputs: false,
    }
}

/// What a camera at `pose` sees, and where it is from the corner of a window at (`-half_m`, `-half_m`).
pub(crate) fn view(scene: &Scene, camera: &CameraModel, pose: FramePose, half_m: f64) -> (Rigid, Vec<f32>) {
    let map_from_camera = pose.map_from_base.then(pose.base_from_camera);
    let translation_m = map_from_camera.translation_m + DVec3::new(half_m, half_m, 0.0);
    (Rigid { translation_m, ..map_from_camera }, scene.depth(camera, map_from_camera))
}
