//! Panes as cells of the map.

use bytemuck::{cast_slice, pod_read_unaligned};
use glam::{DQuat, DVec2, DVec3, Vec4};
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::map::Pane;
use limpid::stage::glass::pane_cells::{
    GlassLidar, PANE_CELLS, PaneCellsParams, SHARE_PANES, layer_params, share_params,
};

use crate::reference::pane_cells::{Corners, marks};
use crate::support::compare::{Tolerance, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const CELL_M: f64 = 0.125;
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
        height_min_m: 0.1,
        height_max_m: 2.0,
        pad: 0,
    }
}

pub(super) fn pane(corners: &Corners) -> Pane {
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

/// The panes as a scan's passes leave them.
fn list_of(panes: &[Pane]) -> Vec<u32> {
    let mut words = vec![panes.len() as u32, 0, 0, 0];
    let mut list = panes.to_vec();
    list.resize(KEPT, Pane::default());
    words.extend_from_slice(cast_slice(&list));
    words
}

const ORIGIN_SLOT: [u32; 2] = [5, 3];

/// The ground as the passes before tell it; not seen.
const UNSEEN: [[f32; 4]; 5] = [[0.0, 0.0, 1.0, 0.0], [0.0; 4], [0.0; 4], [0.0; 4], [0.0; 4]];

/// The layer over a ground that is not seen.
fn layer(
    params: &PaneCellsParams,
    before: &[[u32; 2]],
    tick: u32,
    lidar: GlassLidar,
    panes: &[Pane],
    shared: &[Pane],
) -> Vec<[u32; 2]> {
    layer_over(&UNSEEN, params, before, (tick, lidar), panes, shared)
}

/// The layer after a scan of `lidar` at which `map_panes` holds `shared`, slot by slot.
fn layer_over(
    ground: &[[f32; 4]; 5],
    params: &PaneCellsParams,
    before: &[[u32; 2]],
    (tick, lidar): (u32, GlassLidar),
    panes: &[Pane],
    shared: &[Pane],
) -> Vec<[u32; 2]> {
    let side = params.side;
    let out = Fragment::new()
        .params("pane_cells_params", params)
        .params("pane_layer_params", &layer_params(tick, lidar, ORIGIN_SLOT.map(|slot| slot % side)))
        .input("panes", &list_of(panes))
        .input("map_panes", shared)
        .input("ground_now", ground)
        .changed("pane_records", before)
        .run(PANE_CELLS, Invocations::area(side, side));
    cast_slice(out.words("pane_records")).to_vec()
}

/// As window cells, row by row.
fn in_window(ring: &[[u32; 2]]) -> Vec<[u32; 2]> {
    let side = ring.len().isqrt();
    let [x0, y0] = ORIGIN_SLOT.map(|slot| slot as usize);
    (0..ring.len()).map(|at| ring[(at / side + y0) % side * side + (at % side + x0) % side]).collect()
}

/// Two lidars' worth of panes in the map, those of the second last; `found` is the tick in all of them.
fn shared(number: u32, panes: &[Pane], found: u32) -> Vec<Pane> {
    let mut all = vec![Pane::default(); 2 * KEPT];
    panes
        .iter()
        .enumerate()
        .for_each(|(k, pane)| all[number as usize * KEPT + k] = Pane { age: found, ..*pane });
    all
}

const FRONT: GlassLidar = GlassLidar { sensor: 4, number: 1 };

/// Cells of glass, row by row.
fn run(params: &PaneCellsParams, panes: &[Pane]) -> Vec<bool> {
    let nothing = vec![[0, 0]; (params.side * params.side) as usize];
    let after = layer(params, &nothing, 9, FRONT, panes, &shared(1, panes, 9));
    in_window(&after).iter().map(|record| record[1] != 0).collect()
}

/// Cells of a window of `side` cells that a pane crosses, whatever its height, row by row.
fn crossed(side: usize, corners: &Corners) -> Vec<bool> {
    let centre_m = |at: usize| DVec2::new((at % side) as f64 + 0.5, (at / side) as f64 + 0.5) * CELL_M;
    (0..side * side).map(|at| marks(corners, centre_m(at), CELL_M, None)).collect()
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
fn truth_heights_count_from_the_ground_that_is_seen() {
    if skipped() {
        return;
    }
    let side = 24;
    let marked = |ground: [f32; 4], low_m: f64, high_m: f64, band_m| {
        let mut now = UNSEEN;
        (now[0], now[1][0]) = (ground, 1.0);
        let (nothing, panes) = (vec![[0, 0]; side * side], [pane(&upright(side, low_m, high_m))]);
        let after =
            layer_over(&now, &params(side, band_m), &nothing, (9, FRONT), &panes, &shared(1, &panes, 9));
        after.iter().filter(|record| record[1] != 0).count()
    };
    // The ground lies 1 m below the lidar, whatever is stated, and whether or not there is a map.
    for band_m in [None, Some([-3.0, -2.5])] {
        assert!(marked([0.0, 0.0, 1.0, 1.0], -0.9, 1.0, band_m) >= 14);
        assert_eq!(marked([0.0, 0.0, 1.0, 1.0], 1.4, 2.5, band_m), 0, "a high window");
        assert_eq!(marked([0.0, 0.0, 1.0, 1.0], -2.5, -1.3, band_m), 0, "below what the robot drives over");
    }
    // It rises by 1 m in 2 m along y: a pane that hangs 2 m above the lidar is in the way where the ground is high.
    let rising = marked([0.0, -0.5, 1.0, 1.0], 2.0, 3.0, None);
    let whole = marked([0.0, 0.0, 1.0, 1.0], -0.9, 1.0, None);
    assert!(rising > 0 && rising < whole, "{rising} of {whole}");
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
            let low_left = DVec3::new(size * share(), size * share(), 5.0 * share() - 3.5);
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

#[test]
fn the_layer_marks_the_cells_that_a_pane_crosses_and_clears_its_own() {
    if skipped() {
        return;
    }
    let side = 9;
    let corners = upright(side, -0.5, 0.5);
    let panes = [pane(&corners)];
    let nothing = vec![[0, 0]; side * side];
    let layer = |before: &[[u32; 2]], tick, lidar, panes: &[Pane], shared: &[Pane]| {
        self::layer(&params(side, None), before, tick, lidar, panes, shared)
    };
    let marked = layer(&nothing, 70, FRONT, &panes, &shared(1, &panes, 60));
    let want: Vec<[u32; 2]> =
        crossed(side, &corners).iter().map(|&glass| if glass { [1 | 5 << 24, 60] } else { [0, 0] }).collect();
    assert!(want.iter().any(|record| record[1] == 60), "the pane crosses cells");
    assert_eq!(in_window(&marked), want);
    assert_eq!(layer(&marked, 80, FRONT, &[], &shared(1, &[], 0)), nothing, "it went");
    let rear = GlassLidar { sensor: 0, number: 0 };
    assert_eq!(layer(&marked, 80, rear, &[], &shared(0, &[], 0)), marked, "what another saw stays");
    let mine = layer(&marked, 80, rear, &panes, &shared(0, &panes, 80));
    assert!(
        mine.iter().zip(&marked).all(|(now, was)| was[1] == 0 && now[1] == 0 || *now == [1 | 1 << 24, 80])
    );
    assert_eq!(layer(&marked, 80, rear, &panes, &shared(0, &panes, 59)), marked, "found before it");
}

#[test]
fn the_layer_at_edge_sizes_and_with_poison() {
    if skipped() {
        return;
    }
    for side in [1, 7, 8, 17] {
        let corners = upright(side, -0.5, 0.5);
        let panes = [Pane { id: 3, ..pane(&corners) }];
        let nothing = vec![[0, 0]; side * side];
        let params = params(side, None);
        let marked = layer(&params, &nothing, 9, FRONT, &panes, &shared(1, &panes, 9));
        let count = crossed(side, &corners).iter().filter(|glass| **glass).count();
        assert_eq!(marked.iter().filter(|record| **record == [3 | 5 << 24, 9]).count(), count, "side {side}");
        let nowhere = [Pane { normal: Vec4::NAN, ..panes[0] }, Pane { id: 0, ..panes[0] }];
        assert_eq!(layer(&params, &nothing, 9, FRONT, &nowhere, &shared(1, &nowhere, 9)), nothing);
    }
}

/// `map_panes` after a scan of the second lidar.
fn share(before: &[Pane], tick: u32, local_from_lidar: Rigid, panes: &[Pane]) -> Vec<Pane> {
    let out = Fragment::new()
        .params("share_panes_params", &share_params(tick, FRONT, local_from_lidar))
        .input("panes", &list_of(panes))
        .changed("map_panes", before)
        .run(SHARE_PANES, Invocations::line(KEPT as u32));
    cast_slice::<u32, u8>(out.words("map_panes")).chunks_exact(64).map(pod_read_unaligned).collect()
}

const MOVED: Tolerance =
    Tolerance { absolute: 2e-5, reason: "f32 at ten metres, and a handful of operations" };

#[test]
fn twin_of_panes_in_the_map() {
    if skipped() {
        return;
    }
    let turn = DQuat::from_euler(glam::EulerRot::ZYX, 2.1, 0.1, -0.05);
    let local_from_lidar = Rigid { rotation: turn, translation_m: DVec3::new(3.0, -7.0, 0.4) };
    let panes: Vec<Pane> =
        (0..5).map(|k| Pane { id: k + 7, hits: 3, ..pane(&upright(9 + k as usize, -0.5, 0.5)) }).collect();
    let got = share(&[Pane::default(); 2 * KEPT], 44, local_from_lidar, &panes);
    for (k, got) in got.iter().enumerate() {
        let Some(pane) = k.checked_sub(KEPT).and_then(|k| panes.get(k)) else {
            assert_eq!(got.id, 0, "pane {k}");
            continue;
        };
        let want = pane.moved(local_from_lidar);
        let numbers = |pane: &Pane| [pane.normal, pane.level, pane.extent_m].map(|v| v.to_array()).concat();
        assert_close("pane", &numbers(got), &numbers(&want), MOVED);
        assert_eq!((got.id, got.hits, got.age), (want.id, 3, 44));
    }
}

#[test]
fn truth_a_pane_keeps_the_tick_at_which_it_was_last_found() {
    if skipped() {
        return;
    }
    let seen = [Pane { hits: 3, ..pane(&upright(9, -0.5, 0.5)) }];
    let after = |before: &[Pane], tick, panes: &[Pane]| share(before, tick, Rigid::IDENTITY, panes);
    let first = after(&[Pane::default(); 2 * KEPT], 10, &seen);
    assert_eq!(first[KEPT].age, 10);
    let kept = after(&first, 20, &seen);
    assert_eq!(kept[KEPT].age, 10, "kept, and not found");
    let found = [Pane { hits: 4, ..seen[0] }];
    assert_eq!(after(&kept, 30, &found)[KEPT].age, 30);
    let other = [Pane { id: 2, ..seen[0] }];
    assert_eq!(after(&kept, 30, &other)[KEPT].age, 30, "another in its place");
    assert_eq!(after(&kept, 30, &[])[KEPT].id, 0);
    let mut of_rear = [Pane::default(); 2 * KEPT];
    of_rear[3] = seen[0];
    assert_eq!(after(&of_rear, 30, &seen)[3], seen[0], "another lidar's stay");
}
