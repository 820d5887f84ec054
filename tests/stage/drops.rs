//! Drops: how rays vote, what a message says of a cell, and what becomes of the layer.

use bytemuck::cast_slice;
use glam::{DQuat, DVec2, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::stage::camera::back_project::rays;
use limpid::stage::drops::{
    DECIDE, DropMoment, DropParams, JUDGE, MOST_POINTS, PIXELS, RETURNS, VIEW, VIEW_BINS,
};
use limpid::stage::lidar::intensity_layers::{POINT_ROW, SECTORS};

use crate::reference::drops::{Judge, Kind, Look, Says, Votes, decide, deep_kind};
use crate::support::camera_job::{job, small_map, tiny_camera};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;
use crate::support::scene::{Block, Scene, pose};

const SIDE: u32 = 120;
const CELLS: usize = 120 * 120;
/// Rays that may fall on either side of a cell's border, or of a threshold, in f32.
const BORDER: u32 = 16;

/// A camera 0.5 m above a platform, in the window, and depth of the platform with its edge 1.3 m ahead, and of a wall.
fn platform(pitch: f64, wall_x: f64) -> (Rigid, Vec<f32>) {
    let at = pose(0.0, 0.0, 0.2, 1.1, pitch);
    let map_from_camera = at.map_from_base.then(at.base_from_camera);
    let wall = Block::new([wall_x, -9.0, 0.0], [wall_x + 0.2, 9.0, 3.0]);
    let scene = Scene::of(&[Block::new([-9.0, -9.0, -1.0], [1.3, 9.0, 0.6]), wall]);
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

fn look(eye: DVec3, range_m: f64) -> Look {
    Look { eye, drop_m: 0.15, floor_m: 0.1, range_m, resolution_m: 0.05, side: SIDE.into() }
}

/// Votes as the passes leave them.
fn votes_of(words: &[u32]) -> Vec<Votes> {
    let cell = |words: &[u32; 4]| {
        let [low, high] = [0, 16].map(|shift| [0, 1, 2].map(|at| (words[at] >> shift) & 0xffff));
        let counts = [low[0], high[0], low[1], high[1], low[2], high[2]];
        let deep = f64::from((low[1] + high[1]).max(1));
        Votes { counts, depth_m: f64::from(words[3]) / 1024.0 / deep }
    };
    cast_slice::<u32, [u32; 4]>(words).iter().map(cell).collect()
}

fn pixels(camera_at: Rigid, depth_m: &[f32], now: &[[f32; 4]; 5]) -> Vec<Votes> {
    let job = job(&config(), tiny_camera());
    let out = Fragment::new()
        .params("drop_params", &DropParams::of_frame(&job, &moment(camera_at)))
        .input("depth_m", depth_m)
        .input("reliability", &vec![1.0_f32; depth_m.len()])
        .input("rays", &rays(&job.depth))
        .input("ground_now", now)
        .changed("drop_marks", &vec![0_u32; 4 * CELLS])
        .constants(&[("distorted", false)])
        .run(PIXELS, Invocations::area(80, 60));
    votes_of(out.words("drop_marks"))
}

#[test]
fn truth_rays_over_the_edge_are_deep_and_those_before_it_ground() {
    if skipped() {
        return;
    }
    let (camera_at, depth_m) = platform(0.4, 9.0);
    let votes = pixels(camera_at, &depth_m, &seen(0.5));
    let edge = 3.0 + 1.3;
    let x_of = |cell: usize| (cell as u32 % SIDE) as f64 * 0.05;
    let has = |cell: &usize, kind: Kind| votes[*cell].counts[kind as usize] > 0;
    let of = |kind: Kind| (0..CELLS).filter(move |cell| has(cell, kind));
    let ground: Vec<_> = of(Kind::Ground).collect();
    // The camera does not look as far up as images of the lower floor would lie.
    let open: Vec<_> = of(Kind::Unsure).collect();
    assert!(ground.len() > 100 && ground.iter().all(|cell| x_of(*cell) <= edge + 1e-6));
    assert!(open.len() > 60 && open.iter().all(|cell| x_of(*cell) + 0.05 >= edge - 1e-6));
    assert!(open.iter().any(|cell| x_of(*cell) < edge + 0.051), "at the edge");
    assert_eq!([Kind::Shallow, Kind::Open, Kind::Mirrored].map(|kind| of(kind).count()), [0; 3]);
    assert!(open.iter().all(|cell| (votes[*cell].depth_m - 0.6).abs() < 2e-3), "0.6 m deep");
    // Where the ground was not seen, and from below it, nobody votes.
    let unseen = limpid::stage::ground::stated_now(0.0);
    let mut above = seen(-0.1);
    above[0] = [0.0, 0.0, 1.0, -0.6];
    for now in [unseen, above] {
        assert!(pixels(camera_at, &depth_m, &now).iter().all(|votes| votes.counts == [0; 6]));
    }
}

#[test]
fn twin_of_pixels_with_spikes_and_mirror_images() {
    if skipped() {
        return;
    }
    let (camera_at, mut depth_m) = platform(0.15, 4.6);
    let mut random = Random(3);
    for depth in &mut depth_m {
        *depth *= match random.below(40) {
            0 => 0.0,
            1 => 2.5,
            2..12 => 1.0 + 0.35 * random.unit(),
            _ => 1.0,
        };
    }
    let got = pixels(camera_at, &depth_m, &seen(0.5));
    let look = look(camera_at.translation_m, config().mark_range_m);
    let camera = tiny_camera();
    let mut want = vec![[0_u32; 6]; CELLS];
    for (v, u) in (0..camera.height).flat_map(|v| (0..camera.width).map(move |u| (v, u))) {
        let depth = f64::from(depth_m[(v * camera.width + u) as usize]);
        let [x, y] = camera.ray(u.into(), v.into()).unwrap();
        let place = camera_at.transform_point(DVec3::new(x, y, 1.0) * depth);
        let Some((at, kind)) = look.crossing(place).filter(|_| depth > 0.0) else { continue };
        let kind = match kind {
            Kind::Open => deep_kind(&camera, camera_at, &depth_m, place, [u, v]),
            kind => kind,
        };
        look.cell(at).into_iter().for_each(|cell| want[cell][kind as usize] += 1);
    }
    for kind in [Kind::Ground, Kind::Shallow, Kind::Open, Kind::Unsure, Kind::Mirrored, Kind::Rough] {
        let of = |counts: &[u32; 6]| counts[kind as usize];
        let total: u32 = want.iter().map(of).sum();
        let differ: u32 = got.iter().zip(&want).map(|(got, want)| of(&got.counts).abs_diff(of(want))).sum();
        assert!(total > 3 && differ <= BORDER, "{kind:?}: {differ} of {total}");
    }
}

/// Votes of a scan by both passes.
fn returns(points: &[[f32; 3]]) -> Vec<Votes> {
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
        .changed("drop_view", &vec![0_u32; (SECTORS * VIEW_BINS) as usize])
        .run(VIEW, Invocations::line(count.min(MOST_POINTS)));
    let out = Fragment::new()
        .params("drop_params", &params)
        .texture("points", texture, cast_slice(&words))
        .input("ground_now", &now)
        .changed("drop_marks", &vec![0_u32; 4 * CELLS])
        .input("drop_view", out.words("drop_view"))
        .run(RETURNS, Invocations::line(count.min(MOST_POINTS)));
    votes_of(out.words("drop_marks"))
}

fn cell(x: f64, y: f64) -> usize {
    let at = |m: f64| ((m + 3.0) / 0.05).floor() as usize;
    at(y) * SIDE as usize + at(x)
}

/// 0.6 m below a floor that lies 1.2 m below the lidar, 1.83 m away: its beam meets the floor's height at 1.22 m.
const DEEP: [f32; 3] = [1.83, 0.01, -1.8];

#[test]
fn truth_points_below_the_floor_vote_by_what_is_seen_where_their_image_would_be() {
    if skipped() {
        return;
    }
    let floor = [1.0, 0.01, -1.2];
    let votes = returns(&[floor, DEEP]);
    assert_eq!(votes[cell(1.0, 0.01)].counts, [1, 0, 0, 0, 0, 0]);
    assert_eq!(votes[cell(1.22, 0.01)].counts, [0, 0, 0, 1, 0, 0], "nobody looks there");
    assert!((votes[cell(1.22, 0.01)].depth_m - 0.6).abs() < 2e-3);
    assert_eq!(votes.iter().map(|votes| votes.counts.iter().sum::<u32>()).sum::<u32>(), 2);
    // As far above the floor as it lies below: (1.83, 0.01, -0.6).
    let towards = |share: f32, turn: f32| [1.83 * share, 0.01 + turn * share, -0.6 * share];
    let past = returns(&[floor, DEEP, towards(2.0, 0.0), towards(2.0, 0.012)]);
    assert_eq!(past[cell(1.22, 0.01)].counts, [0, 0, 1, 0, 0, 0], "beams go on behind it");
    let there = returns(&[floor, DEEP, towards(1.02, 0.0), towards(2.0, 0.012)]);
    assert_eq!(there[cell(1.22, 0.01)].counts, [0, 0, 0, 0, 1, 0], "a thing stands there");
    // Numbers that are none, and what is too far.
    let poison = [
        [f32::NAN, 0.0, -9.0],
        [f32::INFINITY, 1.0, -3.0],
        [1.0, f32::NEG_INFINITY, 0.0],
        [1e30, 1.0, -1e30],
        [30.0, 0.0, -900.0],
    ];
    assert!(returns(&poison).iter().all(|votes| votes.counts == [0; 6]));
}

#[test]
fn edge_sizes_of_scans() {
    if skipped() {
        return;
    }
    for count in [1, 63, 64, 65] {
        assert_eq!(returns(&vec![DEEP; count])[cell(1.22, 0.01)].counts[3], count as u32);
    }
    // A scan of more points than a cell can count is looked at in part.
    let many = returns(&vec![DEEP; 2 * MOST_POINTS as usize + 5])[cell(1.22, 0.01)].counts[3];
    assert!(many > MOST_POINTS / 2 && many <= MOST_POINTS, "{many}");
}

/// Words of votes as the passes leave them.
fn words_of(votes: &[Votes]) -> Vec<[u32; 4]> {
    let words = |votes: &Votes| {
        let [ground, shallow, open, unsure, mirrored, rough] = votes.counts;
        let depth = (votes.depth_m * 1024.0) as u32 * votes.deep();
        [ground | shallow << 16, open | unsure << 16, mirrored | rough << 16, depth]
    };
    votes.iter().map(words).collect()
}

/// What a frame says of each cell, by the pass; a camera at (1, 3), 0.5 m above the ground.
fn judged(votes: &[Votes], known: &[i32]) -> Vec<Says> {
    let params = DropParams::of_frame(&job(&config(), tiny_camera()), &moment(eye()));
    let cells: Vec<[u32; 4]> = known.iter().map(|known| [known.cast_unsigned(), 1, 0, 0]).collect();
    let out = Fragment::new()
        .params("drop_params", &params)
        .input("drop_marks", &words_of(votes))
        .input("drop_cells", &cells)
        .input("ground_now", &seen(0.5))
        .output("drop_said", CELLS)
        .run(JUDGE, Invocations::area(SIDE, SIDE));
    let says = |word: &u32| match word & 3 {
        0 => Says::Nothing,
        1 => Says::Ground,
        _ => Says::Drop,
    };
    out.words("drop_said").iter().map(says).collect()
}

fn eye() -> Rigid {
    Rigid { rotation: DQuat::IDENTITY, translation_m: DVec3::new(1.0, 3.0, 0.5) }
}

fn some(kind: Kind, depth_m: f64) -> Votes {
    let mut counts = [0; 6];
    counts[kind as usize] = 5;
    Votes { counts, depth_m }
}

/// Votes of a strip along x through the camera, by distance from it.
fn strip(of: impl Fn(f64) -> Votes) -> Vec<Votes> {
    let mut votes = vec![Votes::default(); CELLS];
    for (y, x) in (57..63).flat_map(|y| (20..SIDE as usize).map(move |x| (y, x))) {
        votes[y * SIDE as usize + x] = of((x as f64 + 0.5) * 0.05 - 1.0);
    }
    votes
}

/// Drops of the strip's middle, by distance from the camera.
fn drops_of(votes: &[Votes], known: &[i32]) -> Vec<f64> {
    let says = judged(votes, known);
    let row = 60 * SIDE as usize;
    let drops = (20..SIDE as usize).filter(|x| says[row + x] == Says::Drop);
    drops.map(|x| (x as f64 + 0.5) * 0.05 - 1.0).collect()
}

#[test]
fn truth_what_is_a_drop_in_one_message() {
    if skipped() {
        return;
    }
    let unknown = vec![0; CELLS];
    let ground = some(Kind::Ground, 0.0);
    let from = |edge: f64, kind: Kind| {
        move |x: f64| if x < edge { some(Kind::Ground, 0.0) } else { some(kind, 0.4) }
    };
    let open = drops_of(&strip(from(1.0, Kind::Open)), &unknown);
    assert!(open.len() > 10 && open[0] < 1.05, "the edge of a platform: {open:?}");
    let trench = |x: f64| if x < 1.4 { from(1.0, Kind::Open)(x) } else { ground };
    assert_eq!(drops_of(&strip(trench), &unknown).len(), 8, "all of a trench whose floor is seen");
    // A ramp goes down slowly: what is deep begins after 0.4 m of what is not.
    let ramp =
        |x: f64| if (1.0..1.4).contains(&x) { some(Kind::Shallow, 0.0) } else { from(1.0, Kind::Open)(x) };
    assert_eq!(drops_of(&strip(ramp), &unknown), [0.0; 0], "a ramp");
    let smeared =
        |x: f64| if (1.0..1.1).contains(&x) { some(Kind::Shallow, 0.0) } else { from(1.0, Kind::Open)(x) };
    assert!(drops_of(&strip(smeared), &unknown).len() > 8, "an edge that a matcher smears");
    assert_eq!(drops_of(&strip(|_| some(Kind::Open, 0.4)), &unknown), [0.0; 0], "no ground before it");
    let known: Vec<i32> = (0..CELLS).map(|cell| if cell % 120 < 40 { -3 } else { 0 }).collect();
    let seen_before = strip(|x| if x < 1.0 { Votes::default() } else { some(Kind::Open, 0.4) });
    assert!(drops_of(&seen_before, &known).len() > 8, "ground that was seen before");
    assert_eq!(drops_of(&strip(from(1.0, Kind::Mirrored)), &unknown), [0.0; 0], "mirror images");
    assert_eq!(drops_of(&strip(from(1.0, Kind::Rough)), &unknown), [0.0; 0], "spikes");
    let mixed = |x: f64| Votes { counts: [4, 0, 6, 0, 0, 0], depth_m: 0.4 * f64::from(u8::from(x > 1.0)) };
    assert_eq!(
        drops_of(&strip(|x| if x < 1.0 { ground } else { mixed(x) }), &unknown),
        [0.0; 0],
        "half of it ground"
    );
}

#[test]
fn truth_what_may_be_mirrored_is_a_drop_as_a_floor_with_no_ground_behind() {
    if skipped() {
        return;
    }
    let unknown = vec![0; CELLS];
    let ground = some(Kind::Ground, 0.0);
    let floor = |x: f64| if x < 1.0 { ground } else { some(Kind::Unsure, 1.1) };
    assert!(drops_of(&strip(floor), &unknown).len() > 8, "a lower floor");
    // A wall 3 m away, as it would be mirrored.
    let wall = |x: f64| if x < 1.0 { ground } else { some(Kind::Unsure, 0.5 * (3.0 / x - 1.0)) };
    let to_images = |x: f64| if x < 1.8 { wall(x) } else { some(Kind::Mirrored, 0.0) };
    assert_eq!(drops_of(&strip(to_images), &unknown), [0.0; 0], "a wall whose lower part is seen mirrored");
    let ceiling = |x: f64| if x < 1.0 { ground } else { some(Kind::Unsure, 2.5) };
    let to_images = |x: f64| if x < 1.8 { ceiling(x) } else { some(Kind::Mirrored, 0.0) };
    assert_eq!(drops_of(&strip(to_images), &unknown), [0.0; 0], "a ceiling");
    let patch = |x: f64| if x < 1.5 { floor(x) } else { ground };
    assert_eq!(drops_of(&strip(patch), &unknown), [0.0; 0], "ground behind it");
}

#[test]
fn twin_of_what_a_message_says() {
    if skipped() {
        return;
    }
    let mut random = Random(11);
    // Patches of 6 x 6 cells of one kind each, with single cells of another.
    let patches: Vec<usize> =
        (0..400).map(|_| [0, 0, 0, 1, 2, 2, 3, 4, 6][random.below(9) as usize]).collect();
    let kinds = [Kind::Ground, Kind::Shallow, Kind::Open, Kind::Unsure, Kind::Mirrored, Kind::Rough];
    let votes: Vec<Votes> = (0..CELLS)
        .map(|cell| {
            let patch = patches[cell / 120 / 6 * 20 + cell % 120 / 6];
            let kind = if random.chance(0.05) { random.below(7) as usize } else { patch };
            let depth_m = (0.2 + 0.1 * (patch as f64) + 0.02 * f64::from(random.unit())).min(1.9);
            kinds.get(kind).map_or(Votes::default(), |kind| some(*kind, (depth_m * 1024.0).floor() / 1024.0))
        })
        .collect();
    let known: Vec<i32> = (0..CELLS).map(|_| [0, 0, 0, -3, 6][random.below(5) as usize]).collect();
    let got = judged(&votes, &known);
    let look = look(eye().translation_m, config().mark_range_m);
    let judge = Judge { look, votes: &votes, known: &known, least_votes: 3, edge_m: 0.7, drops_after: 6 };
    let want: Vec<Says> = (0..CELLS).map(|cell| judge.says(cell)).collect();
    let count = |of: Says| want.iter().filter(|says| **says == of).count();
    assert!(count(Says::Drop) > 200 && count(Says::Ground) > 1000, "{}", count(Says::Drop));
    let deep = votes.iter().filter(|votes| votes.deep() > 0).count();
    assert!(deep > count(Says::Drop) + 200, "{deep}");
    // A step of a walk may fall on either side of a cell's border in f32.
    let differ = got.iter().zip(&want).filter(|(got, want)| got != want).count();
    assert!(differ * 50 < count(Says::Drop), "{differ} of {}", count(Says::Drop));
}

#[test]
fn twin_of_what_becomes_of_a_cell() {
    if skipped() {
        return;
    }
    let mut random = Random(9);
    let side = 33_u32;
    let cells = (side * side) as usize;
    let old: Vec<[u32; 4]> = (0..cells)
        .map(|_| {
            let known = random.below(25) as i32 - 12;
            let flags = random.below(8) << 24 | u32::from(random.chance(0.3));
            [known.cast_unsigned(), random.below(60), flags, random.below(900)]
        })
        .collect();
    let says: Vec<u32> = (0..cells).map(|_| [0, 1, 2 | 700 << 2][random.below(3) as usize]).collect();
    let at = DropMoment { side, ..moment(Rigid::IDENTITY) };
    for params in
        [DropParams::of_frame(&job(&config(), tiny_camera()), &at), DropParams::of_scan(&config(), &at, 9)]
    {
        let out = Fragment::new()
            .params("drop_params", &params)
            .input("drop_said", &says)
            .changed("drop_cells", &old)
            .run(DECIDE, Invocations::area(side, side));
        let mut turned = 0;
        for (number, got) in cast_slice::<u32, [u32; 4]>(out.words("drop_cells")).iter().enumerate() {
            let [known, tick, flags, depth] = old[number];
            let said = [Says::Nothing, Says::Ground, Says::Drop][(says[number] & 3) as usize];
            let before = (known.cast_signed(), flags & 1 == 1);
            let after = decide(before.0, before.1, said, params.drops_after.cast_signed());
            let kept = said == Says::Nothing || tick > 40;
            let depth = if said == Says::Drop { 700 } else { depth };
            let want = [after.0.cast_unsigned(), 40, 3 << 24 | u32::from(after.1), depth];
            assert_eq!(*got, if kept { old[number] } else { want }, "{number}: {said:?}");
            turned += usize::from(!kept && after.1 != before.1);
        }
        assert!(turned > 50, "{turned}");
    }
}

#[test]
fn votes_lie_in_the_cell_in_which_a_ray_meets_the_ground() {
    // The twin's own: halfway between an eye 0.5 m above the ground and a place 0.5 m below it.
    let look = look(DVec3::new(1.0, 3.0, 0.5), 4.0);
    let (at, kind) = look.crossing(DVec3::new(2.0, 3.4, -0.5)).unwrap();
    assert!(at.distance(DVec2::new(1.5, 3.2)) < 1e-12);
    assert_eq!(kind, Kind::Open);
}
