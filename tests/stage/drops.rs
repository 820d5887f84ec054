//! Drops: what lies below the ground, what explains it, and what becomes of the layer.

use bytemuck::cast_slice;
use glam::{DQuat, DVec2, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::stage::camera::back_project::rays;
use limpid::stage::drops::{DECIDE_OF_FRAME, DECIDE_OF_SCAN, DropMoment, DropParams, PIXELS, REACH, RETURNS};
use limpid::stage::lidar::intensity_layers::{POINT_ROW, SECTORS};

use crate::reference::drops::{Known, Look, Seen, decide, is_in_ground, seen_mirrored};
use crate::support::camera_job::{job, small_map, tiny_camera};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;
use crate::support::scene::{Block, Scene, pose};

const SIDE: u32 = 120;
const CELLS: usize = 120 * 120;
const MIRRORED: u32 = 0x8000_0000;
/// Points that may fall on either side of a cell's border in f32.
const BORDER: u32 = 12;

/// A camera 0.5 m above a platform, in the window, and depth of the platform with its edge 1.3 m ahead.
fn platform() -> (Rigid, Vec<f32>) {
    let at = pose(0.0, 0.0, 0.2, 1.1, 0.4);
    let map_from_camera = at.map_from_base.then(at.base_from_camera);
    let scene = Scene::of(&[Block::new([-9.0, -9.0, -1.0], [1.3, 9.0, 0.6])]);
    let depth_m = scene.depth(&tiny_camera(), map_from_camera);
    let translation_m = map_from_camera.translation_m + DVec3::new(3.0, 3.0, -0.6);
    (Rigid { translation_m, ..map_from_camera }, depth_m)
}

fn moment(window_from_sensor: Rigid) -> DropMoment {
    DropMoment { window_from_sensor, side: SIDE, origin_slot: [0, 0], tick: 40, sensor: 2 }
}

/// A ground seen, level at z = 0 of the window, with the sensor `height_m` above it.
fn seen(height_m: f32) -> [[f32; 4]; 5] {
    let mut now = limpid::stage::ground::stated_now(0.0);
    now[1] = [1.0, height_m, 0.0, 0.0];
    now
}

fn config() -> Config {
    Config { drop_m: 0.15, ..small_map() }
}

fn pixels(
    camera_at: Rigid,
    depth_m: &[f32],
    hits: &[[u32; 4]],
    known: &[[u32; 4]],
    now: &[[f32; 4]; 5],
) -> Vec<u32> {
    let job = job(&config(), tiny_camera());
    let out = Fragment::new()
        .params("drop_params", &DropParams::of_frame(&job, &moment(camera_at)))
        .input("depth_m", depth_m)
        .input("reliability", &vec![1.0_f32; depth_m.len()])
        .input("rays", &rays(&job.depth))
        .input("cell_hits", hits)
        .input("drop_cells", known)
        .input("ground_now", now)
        .changed("drop_marks", &vec![0_u32; 2 * CELLS])
        .constants(&[("distorted", false)])
        .run(PIXELS, Invocations::area(80, 60));
    out.words("drop_marks").iter().step_by(2).copied().collect()
}

fn places(camera_at: Rigid, depth_m: &[f32]) -> Vec<DVec3> {
    let camera = tiny_camera();
    let pixels = (0..camera.height).flat_map(|v| (0..camera.width).map(move |u| (u, v)));
    let placed = pixels.zip(depth_m).filter(|(_, depth)| **depth > 0.0).map(|((u, v), depth)| {
        let [x, y] = camera.ray(u.into(), v.into()).unwrap();
        camera_at.transform_point(DVec3::new(x, y, 1.0) * f64::from(*depth))
    });
    placed.collect()
}

#[test]
fn truth_only_what_lies_beyond_the_edge_is_marked() {
    if skipped() {
        return;
    }
    let (camera_at, depth_m) = platform();
    let empty = vec![[0_u32; 4]; CELLS];
    let marks = pixels(camera_at, &depth_m, &empty, &empty, &seen(0.5));
    let edge = 3.0 + 1.3;
    let x_of = |cell: usize| (cell as u32 % SIDE) as f64 * 0.05;
    let marked: Vec<usize> = (0..CELLS).filter(|cell| marks[*cell] != 0).collect();
    assert!(marked.len() > 100 && marked.iter().all(|cell| x_of(*cell) + 0.05 >= edge - 1e-6));
    assert!(marked.iter().any(|cell| x_of(*cell) < edge + 0.051), "the edge is closed");
    // Where the ground was not seen, and from below it, nothing is.
    let unseen = limpid::stage::ground::stated_now(0.0);
    assert!(pixels(camera_at, &depth_m, &empty, &empty, &unseen).iter().all(|mark| *mark == 0));
    assert!(pixels(camera_at, &depth_m, &empty, &empty, &seen(-0.1)).iter().all(|mark| *mark == 0));
}

#[test]
fn twin_with_ground_and_things_here_and_there() {
    if skipped() {
        return;
    }
    let (camera_at, depth_m) = platform();
    let mut random = Random(3);
    // Top 1 is floor alone.
    let hits: Vec<[u32; 4]> = (0..CELLS)
        .map(|_| match random.below(400) {
            0 => [0, 0, 1, 0],
            1 => [3, 3, 500, 0],
            _ => [0; 4],
        })
        .collect();
    let known: Vec<[u32; 4]> =
        (0..CELLS).map(|_| [0, 1, 0, [2, 3][usize::from(random.chance(0.004))]]).collect();
    let got = pixels(camera_at, &depth_m, &hits, &known, &seen(0.5));
    let look = Look {
        eye: camera_at.translation_m,
        height: &|place| place.z,
        drop_m: config().drop_m,
        range_m: config().mark_range_m,
        resolution_m: 0.05,
        side: SIDE.into(),
    };
    let mut want = vec![(0, false); CELLS];
    for place in places(camera_at, &depth_m) {
        let ground = |cell: usize| hits[cell][2] == 1 || known[cell][3] >= 3;
        let far = (place - camera_at.translation_m).truncate().length() > config().mark_range_m;
        let explains = |crossing: DVec2| {
            let mirror = match seen_mirrored(&tiny_camera(), camera_at, &depth_m, place) {
                Seen::InTheWay => true,
                Seen::Past => false,
                Seen::Not => far,
            };
            mirror
                || is_in_ground(&look, crossing, &ground)
                || look.around(crossing, ground)
                || look.around(place.truncate(), |cell| hits[cell][0] > 0)
        };
        look.mark(&mut want, place, explains);
    }
    let total: u32 = want.iter().map(|(count, _)| count).sum();
    let differ: u32 = got.iter().zip(&want).map(|(got, (count, _))| (got & 0xffff).abs_diff(*count)).sum();
    assert!(total > 60 && differ <= BORDER, "{differ} of {total}");
    let explained = |marks: &[u32]| marks.iter().filter(|mark| *mark & MIRRORED != 0).count();
    let twin = want.iter().filter(|(_, mirrored)| *mirrored).count();
    assert!(twin > 10 && explained(&got).abs_diff(twin) <= BORDER as usize, "{} {twin}", explained(&got));
}

/// Marks of cells, and how far the floor was seen by sector, after both passes over a scan.
fn returns(points: &[[f32; 3]], known: &[[u32; 4]]) -> Vec<[u32; 2]> {
    let words: Vec<[f32; 8]> = points.iter().map(|p| [p[0], p[1], p[2], 9.0, 0.0, 0.0, 0.0, 0.0]).collect();
    let count = points.len() as u32;
    let lidar_at = Rigid { rotation: DQuat::IDENTITY, translation_m: DVec3::new(3.0, 3.0, 0.0) };
    let params = DropParams::of_scan(&config(), &moment(lidar_at), count);
    let mut now = seen(1.2);
    now[0] = [0.0, 0.0, 1.0, 1.2];
    let texture = [POINT_ROW, (2 * count).div_ceil(POINT_ROW)];
    let out = Fragment::new()
        .params("drop_params", &params)
        .texture("points", texture, cast_slice(&words))
        .input("ground_now", &now)
        .changed("drop_marks", &vec![0_u32; 2 * CELLS])
        .changed("floor_reach", &vec![0_u32; SECTORS as usize])
        .run(REACH, Invocations::line(count));
    let out = Fragment::new()
        .params("drop_params", &params)
        .texture("points", texture, cast_slice(&words))
        .input("ground_now", &now)
        .changed("drop_marks", out.words("drop_marks"))
        .input("floor_reach", out.words("floor_reach"))
        .input("drop_cells", known)
        .run(RETURNS, Invocations::line(count));
    cast_slice(out.words("drop_marks")).to_vec()
}

fn cell(x: f64, y: f64) -> usize {
    let at = |m: f64| ((m + 3.0) / 0.05).floor() as usize;
    at(y) * SIDE as usize + at(x)
}

#[test]
fn truth_points_below_the_floor_are_drops_unless_the_floor_goes_on() {
    if skipped() {
        return;
    }
    let unknown = vec![[0_u32; 4]; CELLS];
    // 1.2 m below the lidar lies the floor, seen to 1.0 m ahead; a point 0.6 m deeper, 1.83 m away: its beam crosses at 1.22 m.
    let floor = [1.0, 0.01, -1.2];
    let deep = [1.83, 0.01, -1.8];
    let marks = returns(&[floor, deep], &unknown);
    assert_eq!(marks[cell(1.0, 0.01)], [0, 1]);
    assert_eq!(marks[cell(1.83, 0.01)], [1, 0]);
    assert_eq!(marks[cell(1.22, 0.01)], [1, 0], "the edge");
    assert_eq!(marks.iter().filter(|mark| **mark != [0, 0]).count(), 3);
    // The floor goes on beyond: what lies below is its mirror image.
    let marks = returns(&[floor, deep, [1.5, 0.012, -1.19]], &unknown);
    assert_eq!(marks[cell(1.83, 0.01)], [MIRRORED, 0]);
    assert_eq!(marks[cell(1.22, 0.01)], [0, 0]);
    // It was seen there before.
    let mut known = unknown.clone();
    known[cell(1.22, 0.01)][3] = 3;
    assert_eq!(returns(&[floor, deep], &known)[cell(1.83, 0.01)], [MIRRORED, 0]);
    // Not deep enough, and numbers that are none.
    let poison = [
        [f32::NAN, 0.0, -9.0],
        [f32::INFINITY, 1.0, -3.0],
        [1.0, f32::NEG_INFINITY, 0.0],
        [1e30, 1.0, -1e30],
    ];
    let marks = returns(&[&poison[..], &[[1.3, 0.0, -1.33]]].concat(), &unknown);
    assert!(marks.iter().all(|mark| *mark == [0, 0]));
}

#[test]
fn edge_sizes_of_scans() {
    if skipped() {
        return;
    }
    let unknown = vec![[0_u32; 4]; CELLS];
    for count in [1, 63, 64, 65] {
        let marks = returns(&vec![[1.83, 0.01, -1.8]; count], &unknown);
        assert_eq!(marks[cell(1.83, 0.01)][0], count as u32);
    }
}

#[test]
fn twin_of_what_becomes_of_a_cell() {
    if skipped() {
        return;
    }
    let mut random = Random(9);
    let side = 33_u32;
    let cells = (side * side) as usize;
    let old: Vec<Known> = (0..cells)
        .map(|_| Known {
            sure: random.unit(),
            tick: random.below(60),
            sensor: random.below(8),
            drops: random.chance(0.3),
            ground: [0, 1, 5, 255][random.below(4) as usize],
        })
        .collect();
    let word = |known: &Known| {
        [known.sure.to_bits(), known.tick, known.sensor << 24 | u32::from(known.drops), known.ground]
    };
    let marks: Vec<[u32; 2]> = (0..cells)
        .map(|_| {
            let points = [0, 0, 1, 2, 70_000][random.below(5) as usize];
            [points | if random.chance(0.3) { MIRRORED } else { 0 }, u32::from(random.chance(0.3))]
        })
        .collect();
    let hits: Vec<[u32; 4]> = marks.iter().map(|mark| [0, 0, mark[1], 0]).collect();
    let at = DropMoment { side, ..moment(Rigid::IDENTITY) };
    let of_frame = DropParams::of_frame(&job(&config(), tiny_camera()), &at);
    let before: Vec<[u32; 4]> = old.iter().map(word).collect();
    let fragment = || {
        Fragment::new()
            .params("drop_params", &of_frame)
            .input("drop_marks", &marks)
            .changed("drop_cells", &before)
    };
    let area = Invocations::area(side, side);
    let by_frame = fragment().input("cell_hits", &hits).run(DECIDE_OF_FRAME, area);
    let by_scan = fragment().run(DECIDE_OF_SCAN, area);
    assert_eq!(by_frame.words("drop_cells"), by_scan.words("drop_cells"), "the ground is told in two ways");
    let mut changed = 0;
    for (number, got) in cast_slice::<u32, [u32; 4]>(by_frame.words("drop_cells")).iter().enumerate() {
        let [mark, ground] = marks[number];
        let want = decide(old[number], mark & 0x00ff_ffff, mark & MIRRORED != 0, ground == 1, (40, 3));
        let sure = f32::from_bits(got[0]);
        assert!((sure - want.sure).abs() < 1e-6, "{number}: {sure}, {want:?}");
        if (want.sure - 0.7).abs() > 1e-5 && (want.sure - 0.49).abs() > 1e-5 {
            assert_eq!(got[1..], word(&want)[1..], "{number}: {:?}", old[number]);
        }
        changed += usize::from(want != old[number]);
    }
    assert!(changed > 200, "{changed}");
}
