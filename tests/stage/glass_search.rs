//! Candidates, hypotheses, the fit of a plane, boundaries and the memory of panes, pass by pass, against their twins.

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::{DVec3, Vec3, Vec4};
use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::map::Pane;
use limpid::sensor::BeamGrid;
use limpid::stage::glass::{
    ACCEPT, CANDIDATE, CANDIDATE_ROW, FIT, Glass, GlassMoment, GlassParams, MOST_CANDIDATES, REMEMBER, SCORE,
};

use crate::reference::glass::{hypothesis, is_candidate, lower_quartile, refined, refit};
use crate::support::glass_room::GlassRoom;
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;

const NONE: u32 = u32::MAX;
const SQUARES: usize = 8192;
const WIDE: usize = 128;

/// `found` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
struct Found {
    candidates: u32,
    panes: u32,
    inliers: u32,
    pad: u32,
    plane: Vec4,
    level: Vec4,
}

fn grid() -> BeamGrid {
    BeamGrid::of_scan(&GlassRoom { yaw: 0.0, ..GlassRoom::default() }.scan().0).unwrap()
}

fn params(grid: BeamGrid, config: &Config, pose: Rigid) -> GlassParams {
    let moment = GlassMoment { points: 0, local_from_lidar: pose, load: None };
    Glass { grid, load: limpid::map::PaneSet::default() }.params(config, &moment)
}

fn usual() -> GlassParams {
    params(grid(), &Config::default(), Rigid::IDENTITY)
}

#[test]
fn twin_of_candidates_at_all_sizes_and_with_cells_of_all_kinds() {
    if skipped() {
        return;
    }
    let mut random = Random(3);
    for columns in [1_u32, 2, 63, 64, 65] {
        let grid = BeamGrid { columns, ..grid() };
        let size = grid.cells() as usize;
        let steps = |random: &mut Random| match random.below(4) {
            0 => NONE,
            // Steps of 1 cm around the gap of 0.1 m, at the shortest and the longest range.
            1 => (300 + random.below(14)) << 18 | random.below(1 << 18),
            2 => 16_382 << 18,
            _ => random.below(1 << 18),
        };
        let cells: Vec<u32> = (0..2 * size).map(|_| steps(&mut random)).collect();
        let peaks: Vec<u32> = (0..size).map(|_| u32::from(random.below(5) == 0)).collect();
        let out = Fragment::new()
            .params("glass_params", &params(grid, &Config::default(), Rigid::IDENTITY))
            .input("beam_cells", &cells)
            .input("peaks", &peaks)
            .output("candidate_bits", size.div_ceil(32))
            .changed("glass_counters", &[0_u32; 16])
            .run(CANDIDATE, Invocations::line(size.div_ceil(32) as u32));
        let bits = out.words("candidate_bits");
        // A gap of whole steps is a matter of rounding; both sides agree half a step off.
        let want = |place: usize| {
            let [first, last] = [cells[2 * place], cells[2 * place + 1]];
            [0.095, 0.105].map(|gap_m| is_candidate(first, last, peaks[place] != 0, gap_m))
        };
        let wrong = (0..size).filter(|place| {
            let got = bits[place / 32] >> (place % 32) & 1 == 1;
            !want(*place).contains(&got)
        });
        assert_eq!(wrong.count(), 0, "{columns} columns");
        let beyond = (size..32 * bits.len()).filter(|place| bits[place / 32] >> (place % 32) & 1 == 1);
        assert_eq!(beyond.count(), 0);
        assert!(size < 64 || (0..size).any(|place| want(place)[0]) && (0..size).any(|place| !want(place)[0]));
    }
}

/// Points on a pane, with a centimetre of noise where `noisy`, and as many strewn about.
fn candidates(on: usize, strewn: usize, noisy: bool) -> Vec<[f32; 4]> {
    let mut random = Random(9);
    let mut unit = move || random.unit();
    let normal = Vec3::new(0.9, 0.4, 0.1).normalize();
    let u = Vec3::new(-0.4, 0.9, 0.0).normalize();
    let mut list: Vec<[f32; 4]> = (0..on)
        .map(|_| {
            let off = if noisy { 0.02 * (unit() - 0.5) } else { 0.0 };
            let p = normal * (4.0 + off) + u * (3.0 * unit() - 1.5) + normal.cross(u) * (2.0 * unit() - 1.0);
            [p.x, p.y, p.z, 5.0 + 40.0 * unit()]
        })
        .collect();
    list.extend((0..strewn).map(|_| [9.0 * unit() - 3.0, 9.0 * unit() - 5.0, 3.0 * unit() - 1.0, 200.0]));
    list
}

fn places(candidates: &[[f32; 4]]) -> Vec<DVec3> {
    candidates.iter().map(|c| Vec3::new(c[0], c[1], c[2]).as_dvec3()).collect()
}

fn scores(candidates: &[[f32; 4]], params: &GlassParams) -> Vec<u32> {
    let found = Found { candidates: candidates.len() as u32, ..Found::default() };
    let padded: Vec<[f32; 4]> = candidates.iter().copied().chain([[f32::NAN; 4]]).collect();
    let out = Fragment::new()
        .params("glass_params", params)
        .float_texture("candidates", CANDIDATE_ROW, MOST_CANDIDATES / CANDIDATE_ROW, &padded)
        .input("found", &[found])
        .changed("scores", &[0_u32; 512])
        .changed("survey", &vec![7_u32; 5 * SQUARES])
        .run(SCORE, Invocations::area(params.hypotheses.div_ceil(8), 16));
    let cleared = out.words("survey").iter().all(|&count| count == 0);
    let enough = candidates.len() >= params.min_inliers.max(3) as usize;
    assert_eq!(cleared, enough, "the survey is emptied where there is something to survey");
    out.words("scores").to_vec()
}

#[test]
fn twin_of_scores_at_all_sizes() {
    if skipped() {
        return;
    }
    for (on, strewn) in [(40, 0), (41, 22), (64, 0), (65, 63), (300, 200)] {
        let list = candidates(on, strewn, true);
        let places = places(&list);
        let params = usual();
        let got = scores(&list, &params);
        let mut best = 0;
        for number in 0..params.hypotheses {
            let Some((normal, distance_m)) = hypothesis(&places, params.seed, number) else {
                assert!(got[number as usize] <= places.len() as u32);
                continue;
            };
            let within = |tolerance_m: f64| {
                places.iter().filter(|p| (normal.dot(**p) - distance_m).abs() < tolerance_m).count() as u32
            };
            let (least, most) = (within(0.08 - 1e-4), within(0.08 + 1e-4));
            let score = got[number as usize];
            // A draw at the edge of what makes a plane may count as none.
            assert!((least..=most).contains(&score) || score == 0, "{number}: {score}, {least} to {most}");
            best = best.max(score);
        }
        assert!(best as usize >= on * 9 / 10, "{best} of {on}");
        assert!(got[params.hypotheses as usize..].iter().all(|&score| score == 0));
    }
}

#[test]
fn too_few_candidates_are_not_scored_and_points_that_are_all_the_same_make_no_plane() {
    if skipped() {
        return;
    }
    for count in [0, 1, 2, 3, 39] {
        assert!(scores(&candidates(count, 0, false), &usual()).iter().all(|&score| score == 0), "{count}");
    }
    assert!(scores(&[[1.0, 2.0, 0.5, 9.0]; 200], &usual()).iter().all(|&score| score == 0));
    let line: Vec<[f32; 4]> = (0..200).map(|k| [3.0, 0.02 * k as f32, 0.0, 9.0]).collect();
    assert!(scores(&line, &usual()).iter().all(|&score| score == 0), "points in line");
}

fn fit(candidates: &[[f32; 4]], scores: &[u32]) -> Found {
    let found = Found { candidates: candidates.len() as u32, ..Found::default() };
    let padded: Vec<[f32; 4]> = candidates.iter().copied().chain([[0.0; 4]]).collect();
    let out = Fragment::new()
        .params("glass_params", &usual())
        .float_texture("candidates", CANDIDATE_ROW, MOST_CANDIDATES / CANDIDATE_ROW, &padded)
        .input("scores", scores)
        .changed("found", &[found])
        .run(FIT, Invocations::line(1));
    bytemuck::pod_read_unaligned(cast_slice(out.words("found")))
}

#[test]
fn twin_of_the_fit() {
    if skipped() {
        return;
    }
    for (on, strewn, noisy) in [(40, 0, false), (63, 10, true), (65, 64, true), (400, 300, true)] {
        let list = candidates(on, strewn, noisy);
        let (places, params) = (places(&list), usual());
        let scores = scores(&list, &params);
        let top = scores.iter().max().unwrap();
        let number = scores.iter().position(|score| score == top).unwrap() as u32;
        let start = hypothesis(&places, params.seed, number).unwrap();
        let (normal, distance_m) = refit(&places, start, 0.08);
        let found = fit(&list, &scores);
        let got = found.plane.truncate().as_dvec3();
        assert!(got.dot(normal) > 1.0 - 1e-7, "{got} {normal}");
        assert!((f64::from(found.plane.w) - distance_m).abs() < 1e-4, "{} {distance_m}", found.plane.w);
        let near = |p: &DVec3| (normal.dot(*p) - distance_m).abs() < 0.08;
        let bright: Vec<f32> = list.iter().zip(&places).filter(|(_, p)| near(p)).map(|(c, _)| c[3]).collect();
        assert!(bright.len().abs_diff(found.inliers as usize) <= 1, "{} {}", bright.len(), found.inliers);
        if bright.len() == found.inliers as usize {
            assert_eq!(found.level.w, lower_quartile(&bright) * Config::default().glass_bright_ratio as f32);
        }
    }
}

#[test]
fn a_fit_of_too_few_or_to_nothing_leaves_no_plane() {
    if skipped() {
        return;
    }
    assert_eq!(fit(&candidates(39, 0, false), &[0; 512]).inliers, 0);
    assert_eq!(fit(&candidates(60, 0, false), &[0; 512]).inliers, 0, "no hypothesis has a score");
}

/// A survey in which a function gives the counts of each square.
fn survey(counts: impl Fn(usize, usize) -> [u32; 5]) -> Vec<u32> {
    let mut words = vec![0; 5 * SQUARES];
    for v in 0..64 {
        for u in 0..WIDE {
            for (kind, count) in counts(u, v).into_iter().enumerate() {
                words[kind * SQUARES + v * WIDE + u] = count;
            }
        }
    }
    words
}

const SHOWN: [u32; 5] = [4, 0, 0, 0, 0];
const BRIGHT: [u32; 5] = [0, 0, 9, 0, 0];
const BEYOND: [u32; 5] = [0, 0, 0, 6, 0];

fn accept(survey: &[u32], candidates: &[[f32; 4]], tilt: f32) -> Outputs {
    let normal = Vec3::new(tilt.cos(), 0.0, tilt.sin());
    let found = Found {
        candidates: candidates.len() as u32,
        inliers: 50,
        plane: normal.extend(4.0),
        level: Vec4::new(0.0, 1.0, 0.0, 30.0),
        ..Found::default()
    };
    Fragment::new()
        .params("glass_params", &usual())
        .float_texture("candidates", CANDIDATE_ROW, MOST_CANDIDATES / CANDIDATE_ROW, candidates)
        .input("survey", survey)
        .changed("found", &[found])
        .texture_output("left", CANDIDATE_ROW, MOST_CANDIDATES / CANDIDATE_ROW)
        .changed("scan_panes", &[Pane::default(); 4])
        .changed("scores", &[1_u32; 512])
        .changed("glass_counters", &[0_u32; 16])
        .run(ACCEPT, Invocations::line(1))
}

fn found_panes(out: &Outputs) -> u32 {
    out.words("found")[1]
}

#[test]
fn truth_boundaries_go_over_frames_and_end_at_walls() {
    if skipped() {
        return;
    }
    // Glass at u = 60..=66 and v = 30..=34; beyond a frame of two squares a view through at u = 69..=72; wall around.
    let squares = |u: usize, v: usize| match (u, v) {
        (60..=66, 30..=34) => SHOWN,
        (69..=72, 30..=34) => BEYOND,
        (_, 20..=45) => BRIGHT,
        _ => [0; 5],
    };
    let on = [4.0, 0.3, 0.0, 20.0];
    let off = [2.0, 1.0, 0.4, 20.0];
    let behind = [8.0, 0.0, 0.0, 20.0];
    let list: Vec<[f32; 4]> = (0..130).map(|k| [on, off, behind][k % 3]).collect();
    let out = accept(&survey(squares), &list, 0.0);
    assert_eq!(found_panes(&out), 1);
    let pane: Pane = bytemuck::pod_read_unaligned(cast_slice(&out.words("scan_panes")[..16]));
    let metres = |square: usize, middle: f32| (square as f32 - middle) * 0.25;
    let want = Vec4::new(metres(60, 64.0), metres(73, 64.0), metres(30, 32.0), metres(35, 32.0));
    assert_eq!(pane.extent_m, want);
    assert_eq!((pane.normal, pane.level), (Vec4::new(1.0, 0.0, 0.0, 4.0), Vec4::new(0.0, 1.0, 0.0, 30.0)));
    let left = list.iter().filter(|c| **c == off).count();
    assert_eq!(out.words("found")[0] as usize, left);
    assert!(out.floats("left")[..4 * left].chunks(4).all(|c| c == off));
    assert!(out.words("scores").iter().all(|&score| score == 0));
    // A wall of a metre ends it.
    let wall = |u: usize, v: usize| if (67..=70).contains(&u) { BRIGHT } else { squares(u, v) };
    let out = accept(&survey(wall), &list, 0.0);
    let pane: Pane = bytemuck::pod_read_unaligned(cast_slice(&out.words("scan_panes")[..16]));
    assert_eq!((found_panes(&out), pane.extent_m.y), (1, metres(67, 64.0)));
    // The controls: nothing goes on behind it, or it lies.
    let blind = |u: usize, v: usize| match squares(u, v) {
        SHOWN => [0, 0, 0, 0, 4],
        BEYOND => BRIGHT,
        other => other,
    };
    assert_eq!(found_panes(&accept(&survey(blind), &list, 0.0)), 0);
    assert_eq!(found_panes(&accept(&survey(squares), &list, 1.0)), 0, "a floor");
    // Glass that shows on less than a tenth of the beams is no pane.
    let thin = |u: usize, v: usize| if squares(u, v) == SHOWN { [4, 0, 60, 0, 0] } else { squares(u, v) };
    let out = accept(&survey(thin), &list, 0.0);
    assert_eq!((found_panes(&out), out.words("glass_counters")[6]), (0, 1));
}

/// `kept` and `panes` after one scan that shows `fresh`.
fn remember(kept: &Pane, fresh: &Pane, pose: Rigid) -> (Vec<Pane>, Vec<Pane>) {
    let mut list = [Pane::default(); 16];
    list[0] = *kept;
    let header = |count: u32, panes: &[Pane]| {
        let words: &[u32] = cast_slice(panes);
        [&[count, 0, 0, 0], words].concat()
    };
    let mut scan = [Pane::default(); 4];
    scan[0] = *fresh;
    let out = Fragment::new()
        .params("glass_params", &params(grid(), &Config::default(), pose))
        .input("scan_panes", &scan)
        .input("found", &[Found { panes: 1, ..Found::default() }])
        .input("loaded_panes", &[Pane::default(); 16])
        .changed("kept", &header(kept.id, &list))
        .changed("pane_counts", &[0_u32; 128])
        .output("panes", 4 + 16 * 16)
        .changed("met_points", &[9_u32; 2])
        .texture_output("pane_texels", 4, 16)
        .run(REMEMBER, Invocations::line(1));
    assert_eq!(out.words("met_points")[0], 0);
    // The texels are the panes, with numbers as floats.
    for (slot, (texels, pane)) in
        out.floats("pane_texels").chunks(16).zip(out.words("panes")[4..].chunks(16)).enumerate()
    {
        assert!(
            texels[..12].iter().map(|value| value.to_bits()).eq(pane[..12].iter().copied()),
            "slot {slot}"
        );
        let numbers = [pane[12], pane[13], out.words("panes")[0], 0].map(|number| number as f32);
        assert_eq!(texels[12..], numbers, "slot {slot}");
    }
    let read = |name: &str| {
        let panes = out.words(name)[4..].chunks(16);
        panes.map(|words| bytemuck::pod_read_unaligned::<Pane>(cast_slice(words))).collect()
    };
    (read("kept"), read("panes"))
}

#[test]
fn twin_of_the_memory_of_panes() {
    if skipped() {
        return;
    }
    let pane = |degrees: f32, distance_m: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Pane {
            normal: Vec4::new(cos, sin, 0.0, distance_m),
            level: Vec4::new(-sin, cos, 0.0, 30.0),
            extent_m: Vec4::new(-1.5, 2.0, -1.0, 1.5),
            id: 1,
            hits: 3,
            misses: 0,
            age: 5,
        }
    };
    let pose =
        Rigid { rotation: glam::DQuat::from_rotation_z(0.7), translation_m: DVec3::new(0.4, -0.8, 0.2) };
    let to_lidar = pose.inverse();
    for (degrees, distance_m, same) in
        [(0.0, 4.0, true), (3.0, 4.1, true), (-5.0, 3.8, true), (12.0, 4.0, false), (0.0, 4.5, false)]
    {
        let (kept, fresh) = (pane(0.0, 4.0), pane(degrees, distance_m));
        let seen = fresh.moved(to_lidar);
        let (after, now) = remember(&kept, &seen, pose);
        let count = after.iter().filter(|pane| pane.id != 0).count();
        assert_eq!(count, if same { 1 } else { 2 }, "{degrees} degrees, {distance_m} m");
        assert_eq!(now[0].id, 1);
        if same {
            let (normal, on_plane_m) = refined(&kept, &fresh);
            let got = after[0].unit_normal().as_dvec3();
            assert!(got.dot(normal) > 1.0 - 1e-7, "{got} {normal}");
            assert!((got.dot(on_plane_m) - f64::from(after[0].normal.w)).abs() < 1e-4);
            assert_eq!((after[0].hits, after[0].misses, after[0].age), (4, 0, 6));
            // The scan's own plane fits it best.
            assert!((now[0].normal - seen.normal).abs().max_element() < 1e-4, "{:?} {seen:?}", now[0]);
        } else {
            assert_eq!((after[1].id, after[1].hits, after[1].age), (2, 1, 1));
            assert_eq!((after[0].hits, after[0].normal), (3, kept.normal));
        }
    }
}
