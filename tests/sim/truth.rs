//! The true map of a room that is known in closed form.

use std::collections::HashMap;

use glam::DVec2;
use limpid::Config;
use limpid::map::Grid;
use limpid::sim::scene::{Pane, Scene};
use limpid::sim::truth::{FREE, GLASS, OCCUPIED, TrueMap, UNKNOWN};

use super::{a_box, look, small_room};
use crate::support::gpu::skipped;

/// A box 1.5 m ahead to the left, a pane to the right; walls off the cells' borders.
fn room() -> Scene {
    let mut scene = small_room();
    scene.rooms[0].min_m = [-1.03, -2.02];
    scene.rooms[0].max_m = [3.52, 2.02];
    scene.camera.width = 256;
    scene.camera.height = 144;
    scene.camera.pitch_rad = 0.25;
    scene.boxes.push(a_box([1.52, 0.62, 0.52], [0.4, 0.4, 1.04]));
    let yaw_rad = std::f64::consts::PI;
    let center_m = [1.83, -0.8, 1.0];
    scene.panes.push(Pane { center_m, width_m: 0.8, height_m: 2.0, yaw_rad, material: "glass".into() });
    scene
}

fn observed(scene: &Scene) -> TrueMap {
    let mut map = TrueMap::new(scene, &Config::default());
    map.observe(&look(scene), &scene.camera.model());
    map
}

fn at(map: &TrueMap, x: f64, y: f64) -> i8 {
    let grid = map.grid();
    let column = ((x - grid.origin_x_m) / grid.resolution_m) as usize;
    let row = ((y - grid.origin_y_m) / grid.resolution_m) as usize;
    map.cells()[row * grid.width as usize + column]
}

#[test]
fn truth_of_cells_before_beside_and_behind_things() {
    if skipped() {
        return;
    }
    let map = observed(&room());
    assert_eq!(at(&map, 1.2, 0.62), FREE, "before the box");
    assert_eq!(at(&map, 1.31, 0.62), OCCUPIED, "its face");
    assert_eq!(at(&map, 1.52, 0.62), UNKNOWN, "inside it");
    assert_eq!(at(&map, 2.0, 0.8), UNKNOWN, "behind it");
    assert_eq!(at(&map, 1.7, -0.8), FREE, "before the pane");
    assert_eq!(at(&map, 1.83, -0.8), GLASS, "the pane");
    assert_eq!(at(&map, 2.5, -1.1), UNKNOWN, "behind the pane, though light comes through");
    assert_eq!(at(&map, 3.0, 0.0), FREE, "between the two");
    assert_eq!(at(&map, 3.52, 0.0), OCCUPIED, "the wall");
    assert_eq!(at(&map, 3.7, 0.0), UNKNOWN, "outside");
    assert_eq!(at(&map, -0.5, 0.0), UNKNOWN, "behind the robot");
    assert_eq!(at(&map, 0.3, 1.5), UNKNOWN, "beside the view");
}

/// Whether a cell's centre is in the view on the floor plan, and in front of all things.
fn visible_twin(scene: &Scene, at: DVec2) -> bool {
    let camera = scene.camera.model();
    let half = (f64::from(camera.width) / 2.0 / camera.fx).atan();
    let block = DVec2::new(1.52, 0.62);
    let (pane_x, pane_y) = (1.83, -0.8);
    let steps = 400;
    let open = |p: DVec2| (p - block).abs().max_element() > 0.2;
    let crosses_pane = at.x > pane_x && (at.y * pane_x / at.x - pane_y).abs() < 0.4;
    at.x > 0.6
        && at.to_angle().abs() < half
        && at.length() < 5.0
        && !crosses_pane
        && (1..=steps).all(|k| open(at * (f64::from(k) / f64::from(steps))))
}

#[test]
fn twin_of_the_free_set_on_the_floor_plan() {
    if skipped() {
        return;
    }
    let scene = room();
    let map = observed(&scene);
    let (cells, grid) = (map.cells(), map.grid());
    let center = |x: u32, y: u32| {
        DVec2::new(grid.origin_x_m, grid.origin_y_m)
            + DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) * grid.resolution_m
    };
    let mut counts: HashMap<(bool, bool), u32> = HashMap::new();
    for y in 0..grid.height {
        for x in 0..grid.width {
            let p = center(x, y);
            let inside = p.x > 0.7 && p.x < 3.45 && p.y.abs() < 1.95;
            // Cells at the rim of what is visible may go either way.
            let around = [(-1, -1), (-1, 1), (1, -1), (1, 1)]
                .map(|(dx, dy)| p + DVec2::new(dx.into(), dy.into()) * 0.06);
            let want = visible_twin(&scene, p);
            if inside && around.iter().all(|&q| visible_twin(&scene, q) == want) {
                *counts.entry((want, cells[(y * grid.width + x) as usize] == FREE)).or_default() += 1;
            }
        }
    }
    let count = |want, got| counts.get(&(want, got)).copied().unwrap_or(0);
    assert!(count(true, true) > 1000 && count(false, false) > 300, "{counts:?}");
    assert!(count(true, false) * 100 < count(true, true), "seen cells are missing: {counts:?}");
    assert!(count(false, true) * 100 < count(false, false), "hidden cells are free: {counts:?}");
}

#[test]
fn what_was_seen_stays_seen_and_an_unseen_map_is_unknown() {
    if skipped() {
        return;
    }
    let scene = room();
    let empty = TrueMap::new(&scene, &Config::default());
    assert!(empty.cells().iter().all(|&cell| cell == UNKNOWN));
    let mut map = observed(&scene);
    let before = map.cells();
    let mut blind = look(&scene);
    blind.true_depth_m.fill(0.0);
    map.observe(&blind, &scene.camera.model());
    assert_eq!(map.cells(), before);
    let Grid { width, height, .. } = map.grid();
    assert_eq!(before.len(), (width * height) as usize);
}
