//! Which cells a camera can look at: the bounding box of its view on the ground.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec2};

use crate::base::Rigid;
use crate::config::Config;

/// Steps along each side of the image in which its border is followed.
const STEPS: u32 = 16;

/// First cell along x and y, cells along x and y, of a box that holds every cell that a ray within `field`
/// (bounds of x/z and y/z) crosses within the mark range. At least one cell, at most the whole window.
pub fn cells_in_view(field: [Vec2; 2], window_from_camera: Rigid, config: &Config, side: u32) -> [u32; 4] {
    let camera = window_from_camera.translation_m.truncate();
    let sector = azimuths(field, window_from_camera);
    let range = config.mark_range_m;
    let reach = |azimuth: f64| camera + DVec2::from_angle(azimuth) * range;
    let (first, last) = sector.unwrap_or((-PI, PI));
    let quarters = (-4..=8).map(|quarter| f64::from(quarter) * PI / 2.0);
    let corners = quarters.filter(|azimuth| (first..=last).contains(azimuth)).chain([first, last]).map(reach);
    let (low, high) = corners.fold((camera, camera), |(low, high), at| (low.min(at), high.max(at)));
    let cell = |metres: f64, rim: f64| {
        let cell = (metres / config.resolution_m + rim).floor().clamp(0.0, f64::from(side - 1));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the window")]
        let cell = cell as u32;
        cell
    };
    let (x, y) = (cell(low.x, -1.0), cell(low.y, -1.0));
    [x, y, cell(high.x, 1.0) - x + 1, cell(high.y, 1.0) - y + 1]
}

/// The azimuths of all rays, as an interval of at most half a turn that may begin below -pi; `None` where
/// straight up or down is in view or the rays spread wider.
fn azimuths(field: [Vec2; 2], window_from_camera: Rigid) -> Option<(f64, f64)> {
    let up = window_from_camera.rotation.conjugate() * DVec3::Z;
    for vertical in [up, -up] {
        let ray = (vertical / vertical.z).truncate().as_vec2();
        let inside = ray.cmpge(field[0]).all() && ray.cmple(field[1]).all();
        if vertical.z > 1e-9 && inside {
            return None;
        }
    }
    let border = (0..=STEPS).flat_map(|step| {
        let at = field[0].lerp(field[1], step as f32 / STEPS as f32);
        [(at.x, field[0].y), (at.x, field[1].y), (field[0].x, at.y), (field[1].x, at.y)]
    });
    let azimuth_of = |(x, y): (f32, f32)| {
        let ray = window_from_camera.rotation * DVec3::new(f64::from(x), f64::from(y), 1.0);
        ray.y.atan2(ray.x)
    };
    let middle = field[0].midpoint(field[1]);
    let centre = azimuth_of((middle.x, middle.y));
    let off_centre = |azimuth: f64| (azimuth - centre + PI).rem_euclid(TAU) - PI;
    let spread = border.map(azimuth_of).map(off_centre);
    let (least, most) = spread.fold((0.0_f64, 0.0_f64), |(a, b), off| (a.min(off), b.max(off)));
    // The border is followed in steps; a margin covers what lies between them.
    let margin = 0.02;
    (most - least < 3.0).then_some((centre + least - margin, centre + most + margin))
}
