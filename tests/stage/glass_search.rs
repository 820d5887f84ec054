//! Intensity peaks, candidates, hypotheses and the fit of a plane, pass by pass, against their twins.

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::{DVec3, Vec3, Vec4};
use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::sensor::BeamGrid;
use limpid::stage::glass::{
    CANDIDATE, CANDIDATE_ROW, FIT, Glass, GlassMoment, GlassParams, MOST_CANDIDATES, PEAK, SCORE,
};
use limpid::stage::lidar::intensity_layers::POINT_ROW;

use crate::reference::glass::{hypothesis, is_candidate, lower_quartile, peaks, refit};
use crate::support::glass_room::GlassRoom;
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const NONE: u32 = u32::MAX;
pub(super) const SQUARES: usize = 8192;

/// `found` of the shaders.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
pub(super) struct Found {
    pub(super) candidates: u32,
    pub(super) panes: u32,
    pub(super) inliers: u32,
    pub(super) mirrors: u32,
    pub(super) plane: Vec4,
    pub(super) level: Vec4,
}

pub(super) fn grid() -> BeamGrid {
    BeamGrid::of_scan(&GlassRoom { yaw: 0.0, ..GlassRoom::default() }.scan().0).unwrap()
}

pub(super) fn params(grid: BeamGrid, config: &Config, pose: Rigid) -> GlassParams {
    let moment = GlassMoment { points: 0, local_from_lidar: pose, load: None };
    Glass { grid, load: limpid::map::PaneSet::default() }.params(config, &moment)
}

pub(super) fn usual() -> GlassParams {
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

#[test]
fn twin_of_peaks_lobes_are_some_and_plateaus_are_none() {
    if skipped() {
        return;
    }
    let grid = BeamGrid { rows: 5, level_row: 2, columns: 360, ..grid() };
    let lobe = |k: f32, width: f32| 10.0 + 190.0 * (-(k / width).powi(2)).exp();
    let plateau = |k: f32, width: f32| if k.abs() < width { 200.0 } else { 10.0 };
    // As a beam's width blurs it.
    let blurred = |k: f32, width: f32| 10.0 + 190.0 * (0.5 + (width - k.abs()) / 2.0).clamp(0.0, 1.0);
    for width in [3.0, 6.0, 10.0, 14.0] {
        for (profile, is_lobe) in
            [(&lobe as &dyn Fn(f32, f32) -> f32, true), (&plateau, false), (&blurred, false)]
        {
            let row: Vec<f32> = (0..360).map(|column| profile(column as f32 - 180.2, width)).collect();
            let (mut points, mut cells) = (Vec::new(), Vec::new());
            for (column, intensity) in row.iter().enumerate() {
                let (sin, cos) = (column as f32).to_radians().sin_cos();
                for up in 0..5 {
                    cells.extend([500 << 18 | (points.len() / 8) as u32, NONE]);
                    points.extend([5.0 * cos, 5.0 * sin, 0.1 * up as f32, *intensity, 0.0, 0.0, 0.0, 0.0]);
                }
            }
            let height = (2 * cells.len() as u32 / 2).div_ceil(POINT_ROW);
            points.resize(4 * (POINT_ROW * height) as usize, 0.0);
            let out = Fragment::new()
                .params("glass_params", &params(grid.clone(), &Config::default(), Rigid::IDENTITY))
                .texture("points", [POINT_ROW, height], cast_slice(&points))
                .input("beam_cells", &cells)
                .changed("peaks", &vec![0_u32; cells.len() / 2])
                .run(PEAK, Invocations::line(360));
            let got: Vec<bool> = out.words("peaks").chunks(5).map(|rows| rows[2] != 0).collect();
            assert_eq!(got, peaks(&row), "width {width}, lobe: {is_lobe}");
            assert_eq!(got.contains(&true), is_lobe, "width {width}");
        }
    }
}
