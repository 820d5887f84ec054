//! Depth pixels into cells in f64 (spec 1 §3, back-projection and hits).

use glam::DVec3;
use limpid::Config;
use limpid::base::Rigid;
use limpid::sensor::CameraModel;

/// What one cell gets from one frame.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Hits {
    pub(crate) count: u32,
    pub(crate) weight: f64,
    /// Highest hit above the ground, metres; 0 without hits.
    pub(crate) top_m: f64,
    /// Lowest hit above the ground, metres; 0 without hits.
    pub(crate) low_m: f64,
    pub(crate) floor: bool,
    /// Some point lies so near an edge that f32 may put it on the other side.
    pub(crate) doubtful: bool,
}

/// Distance of an edge within which f32 may decide otherwise: 24 bits at 12 m are 1e-6 m, and a handful of operations.
pub(crate) const EDGE_M: f64 = 2e-5;

/// Hits per cell of a window of `side` cells whose corner is the origin of `window_from_camera`.
pub(crate) fn back_project(
    config: &Config,
    side: usize,
    camera: &CameraModel,
    window_from_camera: Rigid,
    depth_m: &[f32],
    reliability: &[f32],
) -> Vec<Hits> {
    let mut cells = vec![Hits::default(); side * side];
    let eye = window_from_camera.translation_m;
    for (pixel, (&depth, &weight)) in depth_m.iter().zip(reliability).enumerate() {
        let (u, v) = (pixel as u32 % camera.width, pixel as u32 / camera.width);
        let Some([x, y]) = camera.ray(f64::from(u), f64::from(v)) else { continue };
        if depth <= 0.0 || f64::from(weight) <= config.tau {
            continue;
        }
        let point = window_from_camera.transform_point(DVec3::new(x, y, 1.0) * f64::from(depth));
        let range = (point - eye).truncate().length();
        for cell in near_cells(point, config.resolution_m, side) {
            cells[cell].doubtful |= edge_distance(config, point, range) < EDGE_M;
        }
        let Some(cell) = cell_at(point, config.resolution_m, side) else { continue };
        if range > config.mark_range_m {
            continue;
        }
        let hits = &mut cells[cell];
        if (config.height_min_m..=config.height_max_m).contains(&point.z) {
            hits.low_m = if hits.count == 0 { point.z } else { hits.low_m.min(point.z) };
            hits.count += 1;
            hits.weight += f64::from(weight);
            hits.top_m = hits.top_m.max(point.z);
        }
        hits.floor |= point.z.abs() < config.height_min_m;
    }
    cells
}

fn cell_at(point: DVec3, resolution_m: f64, side: usize) -> Option<usize> {
    let [x, y] = [point.x, point.y].map(|at| (at / resolution_m).floor());
    let inside = |at: f64| at >= 0.0 && at < side as f64;
    (inside(x) && inside(y)).then(|| y as usize * side + x as usize)
}

fn near_cells(point: DVec3, resolution_m: f64, side: usize) -> impl Iterator<Item = usize> {
    let shifts = [-EDGE_M, EDGE_M];
    shifts.into_iter().flat_map(move |dx| {
        shifts.into_iter().filter_map(move |dy| cell_at(point + DVec3::new(dx, dy, 0.0), resolution_m, side))
    })
}

fn edge_distance(config: &Config, point: DVec3, range: f64) -> f64 {
    let to_cell_edge = |at: f64| {
        let share = (at / config.resolution_m).rem_euclid(1.0);
        share.min(1.0 - share) * config.resolution_m
    };
    [
        to_cell_edge(point.x),
        to_cell_edge(point.y),
        (point.z - config.height_min_m).abs(),
        (point.z + config.height_min_m).abs(),
        (point.z - config.height_max_m).abs(),
        (range - config.mark_range_m).abs(),
    ]
    .into_iter()
    .fold(f64::INFINITY, f64::min)
}
