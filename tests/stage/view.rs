//! The box of cells that a camera can look at holds every cell that one of its rays crosses.

use glam::{DQuat, DVec3, EulerRot};
use limpid::Config;
use limpid::base::Rigid;
use limpid::sensor::CameraModel;
use limpid::stage::camera::see_through::field;
use limpid::stage::camera::view::cells_in_view;

use crate::support::camera_job::{small_map, tiny_camera};
use crate::support::random::Random;
use crate::support::scene::pose;

const SIDE: u32 = 120;

/// Cells under the rays of all pixels, out to the mark range.
fn crossed(camera: &CameraModel, from_camera: Rigid, config: &Config) -> Vec<[u32; 2]> {
    let pixels = (0..camera.height).flat_map(|v| (0..camera.width).map(move |u| (u, v)));
    let mut cells = Vec::new();
    for (u, v) in pixels.step_by(7) {
        let Some([x, y]) = camera.ray(f64::from(u), f64::from(v)) else { continue };
        let direction = (from_camera.rotation * DVec3::new(x, y, 1.0)).truncate().normalize_or_zero();
        for step in 0..100 {
            let at = from_camera.translation_m.truncate()
                + direction * config.mark_range_m * f64::from(step) / 99.0;
            let cell = (at / config.resolution_m).floor();
            if cell.min_element() >= 0.0 && cell.max_element() < f64::from(SIDE) {
                cells.push([cell.x as u32, cell.y as u32]);
            }
        }
    }
    cells
}

fn outside([x, y, width, height]: [u32; 4], cells: &[[u32; 2]]) -> usize {
    let inside = |c: &&[u32; 2]| (x..x + width).contains(&c[0]) && (y..y + height).contains(&c[1]);
    cells.len() - cells.iter().filter(inside).count()
}

#[test]
fn truth_no_ray_leaves_the_box_in_any_attitude() {
    let (config, camera, mut random) = (small_map(), tiny_camera(), Random(81));
    let mut narrower = 0;
    for _ in 0..200 {
        let angles = [0; 3].map(|_| f64::from(random.unit()) * std::f64::consts::TAU);
        let rotation = DQuat::from_euler(EulerRot::ZYX, angles[0], angles[1], angles[2]);
        let translation_m = DVec3::new(f64::from(random.unit()) * 6.0, f64::from(random.unit()) * 6.0, 1.0);
        let from_camera = Rigid { rotation, translation_m };
        let view = cells_in_view(field(&camera), from_camera, &config, SIDE);
        assert_eq!(outside(view, &crossed(&camera, from_camera, &config)), 0, "{from_camera:?} {view:?}");
        assert!(view[0] + view[2] <= SIDE && view[1] + view[3] <= SIDE && view[2] > 0 && view[3] > 0);
        narrower += u32::from(view[2] * view[3] < SIDE * SIDE / 2);
    }
    assert!(narrower > 50, "the box is worth its while: {narrower} of 200");
}

#[test]
fn truth_a_level_camera_sees_what_is_ahead() {
    let config = small_map();
    let level = pose(0.0, 0.0, 0.0, 0.6, 0.2).base_from_camera;
    let from_camera = Rigid { translation_m: DVec3::new(3.0, 3.0, 0.6), ..level };
    let view = cells_in_view(field(&tiny_camera()), from_camera, &config, SIDE);
    // 57 degrees wide, 4 m far: from x = 3 m on, and 4 m sin 29 degrees to either side.
    assert!(view[0] >= 58 && view[0] <= 60 && view[0] + view[2] == SIDE, "{view:?}");
    assert!(view[1] >= 14 && view[1] <= 22 && view[3] >= 76 && view[3] <= 92, "{view:?}");
    let off_the_map = Rigid { translation_m: DVec3::new(1e6, -1e6, 0.6), ..level };
    assert_eq!(cells_in_view(field(&tiny_camera()), off_the_map, &config, SIDE), [119, 0, 1, 1]);
}

#[test]
fn control_a_box_of_half_the_size_loses_rays() {
    let (config, camera) = (small_map(), tiny_camera());
    let level = pose(0.0, 0.0, 0.4, 0.6, 0.2).base_from_camera;
    let from_camera = Rigid { translation_m: DVec3::new(3.0, 3.0, 0.6), ..level };
    let [x, y, width, height] = cells_in_view(field(&camera), from_camera, &config, SIDE);
    assert!(outside([x, y, width / 2, height], &crossed(&camera, from_camera, &config)) > 100);
}
