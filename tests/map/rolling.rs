//! The window rolls with the robot: what leaves it is forgotten, what stays keeps its bits.

use std::collections::HashMap;

use crate::support::run::FrameOutput;
use limpid::sensor::RgbdFrame;

use crate::support::camera_job::{small_map, tiny_camera};
use crate::support::gpu::skipped;
use crate::support::run::{occupancy, run};
use crate::support::scene::{Block, Scene, pose};

fn scene() -> Scene {
    Scene::of(&[
        Block::new([1.52, -1.0, 0.0], [1.7, 1.0, 1.5]),
        Block::new([-3.2, 0.5, 0.0], [-3.0, 0.9, 0.5]),
    ])
}

/// Looks at the wall, turns round, drives away until the wall is out of the window, and backs up again.
fn there_and_back() -> Vec<RgbdFrame> {
    let turn = |i: u64| (0.01, (i as f64) * 0.314);
    let away = |i: u64| (0.01 - 0.37 * i as f64, std::f64::consts::PI);
    let poses = (0..9)
        .map(|_| turn(0))
        .chain((1..10).map(turn))
        .chain((1..6).map(away))
        .chain((0..5).rev().map(away));
    let frame = |(index, (x, yaw)): (usize, (f64, f64))| {
        scene().frame(index as u64, tiny_camera(), pose(x, 0.02, yaw, 0.6, 0.2))
    };
    poses.enumerate().map(frame).collect()
}

/// (evidence, occupancy bits, occupied) by map cell.
fn by_map_cell(out: &FrameOutput) -> HashMap<[i64; 2], (f32, u32, bool)> {
    let layers = out.layers.as_ref().unwrap();
    let corner =
        [out.grid.origin_x_m, out.grid.origin_y_m].map(|m| (m / out.grid.resolution_m).round() as i64);
    let width = out.grid.width as usize;
    let at = |i: usize| [corner[0] + (i % width) as i64, corner[1] + (i / width) as i64];
    let value = |i: usize| (layers.evidence[i], layers.occupancy[i].to_bits(), layers.occupied[i] == 1.0);
    (0..layers.evidence.len()).map(|i| (at(i), value(i))).collect()
}

#[test]
fn cells_that_stay_keep_their_bits_and_new_ones_are_unknown() {
    if skipped() {
        return;
    }
    let outs = run(&small_map(), &there_and_back());
    let (mut kept, mut fresh, mut before) = (0, 0, HashMap::new());
    for out in &outs {
        let now = by_map_cell(out);
        for (cell, (evidence, p, occupied)) in &now {
            let unseen = *evidence == -1.0;
            match before.get(cell) {
                Some((_, p_before, occupied_before)) if unseen => {
                    assert_eq!(
                        (p, occupied),
                        (p_before, occupied_before),
                        "frame {} cell {cell:?}",
                        out.index
                    );
                    kept += u32::from(*p != 0);
                }
                None if unseen => {
                    assert_eq!((*p, *occupied), (0, false), "frame {} cell {cell:?} is new", out.index);
                    fresh += 1;
                }
                _ => {}
            }
        }
        before = now;
    }
    assert!(kept > 300 && fresh > 5000, "{kept} kept, {fresh} new");
}

#[test]
fn what_left_the_window_is_forgotten() {
    if skipped() {
        return;
    }
    let outs = run(&small_map(), &there_and_back());
    let looked = &outs[8];
    assert!(occupancy(looked, 1.53, 0.02) > 0.7);
    // The first tenth of the turn still shows the wall's middle; then it is out of view, and kept.
    let (last_seen, turned) = (&outs[9], &outs[17]);
    assert_eq!(occupancy(turned, 1.53, 0.02).to_bits(), occupancy(last_seen, 1.53, 0.02).to_bits());
    let back = outs.last().unwrap();
    assert_eq!(back.grid, looked.grid, "where it began");
    assert_eq!(occupancy(back, 1.53, 0.02), 0.0);
    assert_eq!(back.costmap[crate::support::run::cell(back, 1.53, 0.02)], 255);
}

#[test]
fn the_grid_is_snapped_and_centred() {
    if skipped() {
        return;
    }
    for out in run(&small_map(), &there_and_back()) {
        let base = out.map_from_base.translation_m;
        for (origin, at) in [(out.grid.origin_x_m, base.x), (out.grid.origin_y_m, base.y)] {
            let cells = origin / 0.05;
            assert!((cells - cells.round()).abs() < 1e-9);
            assert!((0.0..0.05).contains(&(at - origin - 3.0)), "frame {}", out.index);
        }
    }
}

#[test]
fn a_map_far_from_the_origin_is_the_same_map() {
    if skipped() {
        return;
    }
    // 2^16 cells of 1/16 m: the shift is exact in binary, in f64 and in cells.
    let config = limpid::Config { resolution_m: 0.0625, map_size_m: 6.0, ..small_map() };
    let [near, far] = [0.0, 4096.0].map(|shift| {
        let mut frames = there_and_back();
        frames.truncate(20);
        for frame in &mut frames {
            let base = &mut frame.pose.as_mut().unwrap().map_from_base.translation_m;
            // The same eighth of a millimetre in both runs.
            base.x = (base.x * 8192.0).round() / 8192.0 + shift;
            base.y = (base.y * 8192.0).round() / 8192.0 - shift;
        }
        run(&config, &frames)
    });
    for (near, far) in near.iter().zip(&far) {
        assert_eq!(near.layers, far.layers, "frame {}", near.index);
        assert_eq!(far.grid.origin_x_m - near.grid.origin_x_m, 4096.0);
    }
}
