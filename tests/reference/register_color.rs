//! Colour at a depth pixel by projection in f64 (spec 1 §1).

use glam::DVec3;
use limpid::base::Rigid;
use limpid::sensor::CameraModel;

/// Where a depth pixel looks in the colour image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Source {
    /// The nearest colour pixel.
    Pixel(u32, u32),
    /// No depth, behind the colour camera or outside its image.
    Nowhere,
    /// So near the border between pixels that f32 may choose the other.
    Doubtful,
}

/// Distance in pixels of a border between pixels within which f32 may decide otherwise.
const EDGE_PX: f64 = 1e-3;

/// The colour pixel nearest to what depth pixel (`u`, `v`) sees.
pub(crate) fn source(
    depth_camera: &CameraModel,
    color_camera: &CameraModel,
    color_from_depth: Rigid,
    u: u32,
    v: u32,
    depth_m: f32,
) -> Source {
    let Some([x, y]) = depth_camera.ray(f64::from(u), f64::from(v)) else { return Source::Nowhere };
    let point = color_from_depth.transform_point(DVec3::new(x, y, 1.0) * f64::from(depth_m));
    if depth_m <= 0.0 || point.z <= 0.01 {
        return Source::Nowhere;
    }
    let [x, y] = color_camera.distortion.distort([point.x / point.z, point.y / point.z]);
    let at = [x * color_camera.fx + color_camera.cx, y * color_camera.fy + color_camera.cy];
    if at.iter().any(|a| ((a - 0.5).rem_euclid(1.0) - 0.5).abs() > 0.5 - EDGE_PX) {
        return Source::Doubtful;
    }
    let [x, y] = at.map(f64::round);
    let inside =
        x >= 0.0 && y >= 0.0 && x < f64::from(color_camera.width) && y < f64::from(color_camera.height);
    if inside { Source::Pixel(x as u32, y as u32) } else { Source::Nowhere }
}
