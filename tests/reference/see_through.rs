//! Cells that a trusted ray crosses before it ends, by trying every ray on every cell (spec 1 §3).

use glam::{DVec2, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::sensor::CameraModel;

/// A trusted pixel's ray from the camera to its point, in window coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub(crate) from: DVec3,
    pub(crate) to: DVec3,
    /// Unit vector across the ray on the ground.
    across: DVec2,
}

/// The rays of all trusted pixels.
pub(crate) fn trusted_rays(
    config: &Config,
    camera: &CameraModel,
    window_from_camera: Rigid,
    depth_m: &[f32],
    reliability: &[f32],
) -> Vec<Ray> {
    let pixels = depth_m.iter().zip(reliability).enumerate();
    pixels
        .filter(|(_, (depth, weight))| **depth > 0.0 && f64::from(**weight) > config.tau)
        .filter_map(|(pixel, (&depth, _))| {
            let (u, v) = (pixel as u32 % camera.width, pixel as u32 / camera.width);
            let [x, y] = camera.ray(f64::from(u), f64::from(v))?;
            let to = window_from_camera.transform_point(DVec3::new(x, y, 1.0) * f64::from(depth));
            Some(Ray::new(window_from_camera.translation_m, to))
        })
        .collect()
}

impl Ray {
    pub(crate) fn new(from: DVec3, to: DVec3) -> Self {
        Self { from, to, across: (to - from).truncate().perp().normalize_or_zero() }
    }

    /// Whether the ray's line passes the square round `centre` by (a quick answer for most cells).
    fn misses(&self, centre: DVec2, side_m: f64) -> bool {
        (centre - self.from.truncate()).dot(self.across).abs() > 0.71 * side_m
    }

    /// Whether the ray enters and leaves the square over `corner` before its end, and between the two is at a
    /// height in `low_m..=high_m`.
    pub(crate) fn crosses(&self, corner: DVec2, side_m: f64, low_m: f64, high_m: f64) -> bool {
        let along = self.to - self.from;
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for axis in 0..2 {
            let (low, high) = (corner[axis] - self.from[axis], corner[axis] + side_m - self.from[axis]);
            if along[axis].abs() < 1e-12 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
                continue;
            }
            let (a, b) = (low / along[axis], high / along[axis]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        let heights = [enter, leave].map(|t| self.from.z + t * along.z);
        let (lowest, highest) = (heights[0].min(heights[1]), heights[0].max(heights[1]));
        enter < leave && leave <= 1.0 && highest >= low_m && lowest <= high_m
    }
}

/// Whether the cell over `corner` is seen through up to `top_m` (the highest hit recorded there), hits and floor
/// points aside.
pub(crate) fn seen_through(config: &Config, rays: &[Ray], corner: DVec2, top_m: Option<f64>) -> bool {
    let high_m = top_m.unwrap_or(config.height_max_m).min(config.height_max_m);
    let centre = corner + 0.5 * config.resolution_m;
    let Some(eye) = rays.first().map(|ray| ray.from.truncate()) else { return false };
    (centre - eye).length() <= config.mark_range_m
        && rays.iter().any(|ray| {
            !ray.misses(centre, config.resolution_m)
                && ray.crosses(corner, config.resolution_m, config.height_min_m, high_m)
        })
}
