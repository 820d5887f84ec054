//! Panes as cells of the map.

use glam::{DVec2, DVec3, Vec4};
use limpid::gpu::Invocations;
use limpid::map::Pane;
use limpid::stage::glass::pane_cells::{PANE_CELLS, PaneCellsParams};

use crate::reference::pane_cells::{Corners, marks};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const CELL_M: f64 = 0.125;
const TRANSPARENT: u32 = 4;
const KEPT: usize = 16;

fn params(side: usize, band_m: Option<[f64; 2]>) -> PaneCellsParams {
    let [low, high] = band_m.unwrap_or([f64::NAN; 2]);
    PaneCellsParams {
        window_from_lidar_x: Vec4::X,
        window_from_lidar_y: Vec4::Y,
        window_from_lidar_z: Vec4::Z,
        side: side as u32,
        resolution_m: CELL_M as f32,
        band_low_m: low as f32,
        band_high_m: high as f32,
        any_height: u32::from(band_m.is_none()),
        pad0: 0,
        pad1: 0,
        pad2: 0,
    }
}

fn pane(corners: &Corners) -> Pane {
    let (along, up) = (corners.low_right - corners.low_left, corners.high_left - corners.low_left);
    let (u, normal) = (along.normalize(), along.cross(up).normalize());
    let v = normal.cross(u);
    let [u0, v0] = [u.dot(corners.low_left), v.dot(corners.low_left)];
    let extent = [u0, u0 + along.length(), v0, v0 + up.dot(v)];
    Pane {
        normal: normal.extend(normal.dot(corners.low_left)).as_vec4(),
        level: u.extend(0.0).as_vec4(),
        extent_m: Vec4::from(extent.map(|m| m as f32)),
        id: 1,
        ..Pane::default()
    }
}

/// Cells of glass, row by row.
fn run(params: &PaneCellsParams, panes: &[Pane]) -> Vec<bool> {
    let cells = (params.side * params.side) as usize;
    let mut words = vec![panes.len() as u32, 0, 0, 0];
    let mut list = panes.to_vec();
    list.resize(KEPT, Pane::default());
    words.extend_from_slice(bytemuck::cast_slice(&list));
    let out = Fragment::new()
        .params("pane_cells_params", params)
        .input("panes", &words)
        .changed("cell_class", &vec![1_u32; cells])
        .run(PANE_CELLS, Invocations::area(params.side, params.side));
    out.words("cell_class").iter().map(|word| word & 0xff == TRANSPARENT).collect()
}

/// Upright, from `low_m` to `high_m` above the lidar, across a window of `side` cells.
fn upright(side: usize, low_m: f64, high_m: f64) -> Corners {
    let size = side as f64 * CELL_M;
    let at = |share: f64, z: f64| DVec3::new(0.3 * size + 0.1 * share, (0.2 + 0.6 * share) * size, z);
    Corners { low_left: at(0.0, low_m), low_right: at(1.0, low_m), high_left: at(0.0, high_m) }
}

#[test]
fn truth_a_pane_counts_where_it_is_in_the_way() {
    if skipped() {
        return;
    }
    let side = 24;
    // The lidar 1 m above the ground: things from 0.1 to 2 m above it are in the way.
    let band_m = Some([-0.9, 1.0]);
    let marked = |low_m: f64, high_m: f64, band_m| {
        run(&params(side, band_m), &[pane(&upright(side, low_m, high_m))])
            .iter()
            .filter(|cell| **cell)
            .count()
    };
    let whole = marked(-0.9, 1.0, band_m);
    assert!(whole >= 14, "{whole}");
    assert_eq!(marked(-1.0, 3.0, band_m), whole, "higher than the robot");
    assert_eq!(marked(1.2, 2.0, band_m), whole, "its edge may be 0.3 m lower");
    assert_eq!(marked(1.4, 2.5, band_m), 0, "a high window");
    assert_eq!(marked(-2.5, -1.1, band_m), whole, "its edge may be 0.3 m higher");
    assert_eq!(marked(-2.5, -1.3, band_m), 0, "below what the robot drives over");
    assert_eq!(marked(1.4, 2.5, None), whole, "where the ground is not known");
}

#[test]
fn twin_on_panes_that_lean_at_all_sizes() {
    if skipped() {
        return;
    }
    let (mut random, mut all, mut in_way) = (Random(7), 0, 0);
    for side in [1, 7, 8, 9, 24, 33] {
        for _ in 0..8 {
            let size = side as f64 * CELL_M;
            let mut share = || f64::from(random.below(1000)) / 1000.0;
            let low_left = DVec3::new(size * share(), size * share(), 8.0 * share() - 5.0);
            let along = DVec3::new(size * (share() - 0.5), size * (share() - 0.5), 0.0);
            let across = DVec3::new(-along.y, along.x, 0.0).normalize_or(DVec3::X);
            let up = DVec3::Z * (0.5 + 2.0 * share()) + across * 0.6 * (share() - 0.5);
            if along.length() < 0.2 {
                continue;
            }
            let corners = Corners { low_left, low_right: low_left + along, high_left: low_left + up };
            let band_m = Some([-0.9, 1.0]);
            let got = run(&params(side, band_m), &[pane(&corners)]);
            for (at, got) in got.iter().enumerate() {
                let centre_m = DVec2::new((at % side) as f64 + 0.5, (at / side) as f64 + 0.5) * CELL_M;
                // Within rounding of a border either is right.
                let sure = marks(&corners, centre_m, CELL_M - 1e-4, band_m);
                let may = marks(&corners, centre_m, CELL_M + 1e-4, band_m);
                assert!((!sure || *got) && (may || !*got), "side {side}, cell {at}");
                all += usize::from(marks(&corners, centre_m, CELL_M, None));
                in_way += usize::from(*got);
            }
        }
    }
    assert!(in_way > 50 && all > in_way + 50, "{in_way} of {all}");
}

#[test]
fn poison_marks_nothing() {
    if skipped() {
        return;
    }
    let good = pane(&upright(9, -0.5, 0.5));
    let none = Pane { id: 0, ..good };
    let lies = Pane { normal: Vec4::new(0.0, 0.0, 1.0, 0.2), level: Vec4::X, ..good };
    let nowhere = Pane { normal: Vec4::NAN, ..good };
    let endless = Pane { extent_m: Vec4::new(1e30, 2e30, -1.0, 1.0), ..good };
    let band_m = Some([-0.9, 1.0]);
    assert!(run(&params(9, band_m), &[none, lies, nowhere, endless]).iter().all(|cell| !cell));
    assert!(run(&params(9, band_m), &[none, good]).iter().any(|cell| *cell), "the control");
}
