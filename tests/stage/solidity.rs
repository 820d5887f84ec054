//! Learned solidity: counts, beams, judgement.

use glam::{DVec2, Vec2, Vec4};
use limpid::gpu::Invocations;
use limpid::sensor::{Point, ReturnType};
use limpid::stage::ground::stated_now;
use limpid::stage::lidar::intensity_layers::IntensityLayersParams;
use limpid::stage::lidar::solidity::{
    BEAM_WORDS, BEAMS, COUNTS, COUNTS_OF_BUFFER, HIDDEN, INPUTS, JUDGE, SolidityModel, SolidityParams,
    judged_cells,
};

use crate::reference::solidity::{Place, WORDS, beams, counts, inputs, is_sheet, logit};
use crate::support::compare::{EXACT, Tolerance, assert_close, compare};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;
use crate::support::scan::point;

const PLACE: Place = Place {
    lidar: DVec2::new(3.0, 3.2),
    lidar_m: 1.0,
    side: 24,
    cell_m: 0.25,
    trend: [6.0, -0.5, 0.8],
    two_returns: 1.0,
    reach: 1,
    block: 2,
};
const STEP: Tolerance = Tolerance { absolute: 1.0, reason: "f32 against f64 at the border of a step" };
const SINGLE: Tolerance = Tolerance { absolute: 2e-3, reason: "sums and differences of variances in f32" };
/// Metres of height and sectors of direction that f32 may be off.
const HAIR: f64 = 1e-4;
const BEAM: Tolerance = Tolerance { absolute: 0.02, reason: "shares of sectors and of ranges in f32" };

fn params(place: &Place) -> SolidityParams {
    let [bright_at_1m, bright_slope, bright_scale] = place.trend.map(|number| number as f32);
    SolidityParams {
        lidar: place.lidar.as_vec2(),
        resolution_m: place.cell_m as f32,
        side: place.side as u32,
        height_min_m: 0.1,
        height_max_m: 2.0,
        bright_at_1m,
        bright_slope,
        bright_scale,
        two_returns: place.two_returns as f32,
        judged: 1,
        ground_stated: 1,
        least_returns: 4,
        reach_cells: place.reach as u32,
        block_cells: place.block as u32,
        blocks: place.blocks() as u32,
    }
}

fn placed(points: usize) -> IntensityLayersParams {
    IntensityLayersParams {
        window_from_lidar_x: Vec4::new(1.0, 0.0, 0.0, PLACE.lidar.x as f32),
        window_from_lidar_y: Vec4::new(0.0, 1.0, 0.0, PLACE.lidar.y as f32),
        window_from_lidar_z: Vec4::Z,
        lidar: Vec2::new(PLACE.lidar.x as f32, PLACE.lidar.y as f32),
        points: points as u32,
        ..super::intensity_layers::params(points)
    }
}

/// Some on the floor and below it, some higher than a robot, some outside of the window; no two alike.
fn points(random: &mut Random, count: usize) -> Vec<Point> {
    let mut within = |low: f64, high: f64| low + (high - low) * f64::from(random.unit());
    let mut points: Vec<Point> = (0..count)
        .map(|_| point([within(-3.5, 3.5), within(-3.5, 3.5), within(-1.3, 1.4)], within(-5.0, 200.0)))
        .collect();
    let kinds = [ReturnType::Single, ReturnType::First, ReturnType::Last, ReturnType::Both];
    for (number, point) in points.iter_mut().enumerate() {
        point.return_type = kinds[number % 4];
    }
    points
}

fn count(points: &[Point]) -> Outputs {
    let words: Vec<u32> =
        bytemuck::cast_slice::<Point, u8>(points).chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    Fragment::new()
        .params("intensity_layers_params", &placed(points.len()))
        .params("solidity_params", &params(&PLACE))
        .input("points", &words)
        .input("ground_now", &stated_now(PLACE.lidar_m))
        .changed("cell_counts", &vec![0_u32; PLACE.words()])
        .changed("beam_bins", &vec![0_u32; BEAM_WORDS as usize])
        .run(COUNTS_OF_BUFFER, Invocations::line(points.len() as u32))
}

/// Word `at` of every cell.
fn column(words: &[u32], at: usize) -> Vec<u32> {
    words[..PLACE.side * PLACE.side * WORDS].iter().skip(at).step_by(WORDS).copied().collect()
}

#[test]
fn twin_of_counts_at_edge_sizes() {
    if skipped() {
        return;
    }
    for number in [1, 63, 64, 65, 1500] {
        let points = points(&mut Random(number), number as usize);
        let out = count(&points);
        let (cells, bins) = counts(&points, &PLACE);
        for at in 0..WORDS {
            // A sum of steps may be off by one for each return; few cells have more than 8.
            let tolerance = match at {
                4 | 5 => STEP,
                6 | 10 => Tolerance { absolute: 4.0, ..STEP },
                7 | 11 => Tolerance { absolute: 600.0, ..STEP },
                _ => EXACT,
            };
            let want = column(&cells, at);
            assert_close(&format!("word {at}"), &column(out.words("cell_counts"), at), &want, tolerance);
        }
        let of_blocks = PLACE.side * PLACE.side * WORDS;
        let blocks = &out.words("cell_counts")[of_blocks..];
        assert_close("blocks", blocks, &cells[of_blocks..], STEP);
        assert_close("bins", out.words("beam_bins"), &bins, STEP);
        let (fewer, _) = counts(&points[1..], &PLACE);
        let same = [0, 1, 2, 3, 12].into_iter().all(|band| {
            compare("", &column(out.words("cell_counts"), band), &column(&fewer, band), EXACT).is_ok()
        });
        assert!(!same || fewer == cells, "control: one point fewer shows");
    }
}

fn beams_on_gpu(place: &Place, cells: &[u32], bins: &[u32]) -> Vec<f32> {
    run_beams(place, &params(place), cells, bins).floats("cell_beams")
}

fn run_beams(place: &Place, params: &SolidityParams, cells: &[u32], bins: &[u32]) -> Outputs {
    let (side, count) = (place.side as u32, place.side * place.side);
    let out = Fragment::new()
        .params("solidity_params", params)
        .input("cell_counts", cells)
        .input("beam_bins", bins)
        .input("ground_now", &stated_now(place.lidar_m))
        .output("cell_beams", 4 * count)
        .output("passable_cells", count)
        .output("solidity_inputs", INPUTS.len() * count)
        .changed("standing_cells", &vec![0_u32; 1 + count])
        .constants(&[("keep_inputs", true)])
        .run(BEAMS, Invocations::area(side, side));
    let stands = (0..count as u32).filter(|&cell| cells[cell as usize * WORDS + 5] > 0);
    let mut listed = out.words("standing_cells")[1..].to_vec();
    listed.truncate(out.words("standing_cells")[0] as usize);
    listed.sort_unstable();
    assert_eq!(listed, stands.collect::<Vec<_>>(), "every cell in which something stands, once");
    out
}

#[test]
fn twin_of_beams_at_edge_sizes() {
    if skipped() {
        return;
    }
    for side in [1, 7, 8, 9, 24] {
        let place = Place { side, ..PLACE };
        let (cells, bins) = counts(&points(&mut Random(side as u64), 3000), &place);
        // On the border of two bins f32 may fall into the other: what a hair changes is left out.
        let all = [0.0, HAIR, -HAIR].map(|hair| beams(&cells, &bins, &place, hair));
        let got = beams_on_gpu(&place, &cells, &bins);
        let mut compared = 0;
        for (cell, want) in all[0].iter().enumerate() {
            let far = |other: &[f64; 4]| want.iter().zip(other).any(|(a, b)| (a - b).abs() > BEAM.absolute);
            if !all[1..].iter().any(|other| far(&other[cell])) {
                assert_close(&format!("beams of {cell}"), &got[4 * cell..][..4], want, BEAM);
                compared += usize::from(want[1] > 1.0);
            }
        }
        assert!(side < 24 || compared > 100, "{compared}");
    }
}

#[test]
fn truth_beams_that_go_on_are_told_from_those_that_end() {
    if skipped() {
        return;
    }
    // In front a screen that every second beam passes, to a wall 1 m behind it.
    let mut points = Vec::new();
    for turn in -40..40 {
        for ring in -6..6 {
            let (turn, slope) = (0.004 * f64::from(turn), 0.03 * f64::from(ring) + 0.005);
            let passes = points.len() % 2 == 0;
            let x: f64 = if passes { 2.6 } else { 1.6 };
            points.push(point([x, x * turn, x.hypot(x * turn) * slope], 50.0));
        }
    }
    let (cells, bins) = counts(&points, &PLACE);
    let beams = beams_on_gpu(&PLACE, &cells, &bins);
    let at = |x: f64| {
        let cell = (PLACE.lidar.y / 0.25) as usize * 24 + ((x + PLACE.lidar.x) / 0.25) as usize;
        let ended: u32 = cells[cell * WORDS..][..4].iter().sum();
        (f64::from(ended), f64::from(beams[4 * cell]), f64::from(beams[4 * cell + 1]))
    };
    let (ended, before, behind) = at(1.6);
    assert!(before < 1.0 && (behind / (ended + behind) - 0.5).abs() < 0.15, "{ended} {before} {behind}");
    let (ended, before, behind) = at(2.6);
    assert!(behind < 1.0 && (before / (ended + before) - 0.5).abs() < 0.15, "{ended} {before} {behind}");
}

fn judge(
    place: &Place,
    params: &SolidityParams,
    cells: &[u32],
    beams: &[f32],
    model: &SolidityModel,
) -> Outputs {
    let count = place.side * place.side;
    let before = run_beams(place, params, cells, &vec![0; BEAM_WORDS as usize]);
    let weights: Vec<f32> = model.words().chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    Fragment::new()
        .params("solidity_params", params)
        .input("cell_counts", cells)
        .input("cell_beams", &beams.chunks_exact(4).map(|b| [b[0], b[1], b[2], b[3]]).collect::<Vec<_>>())
        .input("ground_now", &stated_now(place.lidar_m))
        .input("solidity_weights", &weights)
        .input("standing_cells", before.words("standing_cells"))
        .changed("passable_cells", before.words("passable_cells"))
        .changed("solidity_inputs", &vec![0.0_f32; INPUTS.len() * count])
        .constants(&[("keep_inputs", true)])
        .run(JUDGE, judged_cells(place.side as u32))
}

/// A model whose weights are all different.
fn model(bias: f32) -> SolidityModel {
    let inner = (0..HIDDEN * (INPUTS.len() + 1)).map(|at| ((at * 7 % 23) as f32 - 11.0) * 0.005).collect();
    let outer = (0..HIDDEN).map(|at| at as f32 - 3.2).collect();
    SolidityModel { inner, outer, bias: [bias, bias + 0.125], least_returns: 4 }
}

#[test]
fn twin_of_judgement_at_edge_sizes() {
    if skipped() {
        return;
    }
    for side in [1, 7, 8, 9, 24] {
        let (reach, block) = if side == 9 { (2, 4) } else { (1, 2) };
        let place = Place { side, reach, block, ..PLACE };
        let (cells, bins) = counts(&points(&mut Random(40 + side as u64), 6000), &place);
        let beams = beams(&cells, &bins, &place, 0.0);
        let flat: Vec<f32> = beams.iter().flatten().map(|&beams| beams as f32).collect();
        let stands: Vec<usize> = (0..side * side).filter(|cell| cells[cell * WORDS + 5] > 0).collect();
        let twins: Vec<_> =
            stands.iter().map(|cell| inputs(&cells, &beams, &place, [cell % side, cell / side])).collect();
        let sum = |inputs: &[f64]| -> f64 { logit(inputs, &model(0.0)) };
        // Half of the cells are solid.
        let mut sums: Vec<f64> = twins.iter().map(|inputs| sum(inputs)).collect();
        sums.sort_by(f64::total_cmp);
        let middle = sums.get(sums.len() / 2).copied().unwrap_or(0.0);
        let out = judge(&place, &params(&place), &cells, &flat, &model(-middle as f32));
        let (got, passable) = (out.floats("solidity_inputs"), out.words("passable_cells"));
        let mut found = [0, 0];
        for (&cell, want) in stands.iter().zip(&twins) {
            let own = &got[cell * INPUTS.len()..][..INPUTS.len()];
            for (at, name) in INPUTS.iter().enumerate() {
                assert_close(&format!("{name} of {cell}"), &own[at..=at], &want[at..=at], SINGLE);
            }
            // Enough returns, and not around the lidar itself.
            let clear = (sum(want) - middle).abs() > 0.01 && !is_sheet(want);
            if clear && want[1] > 2.6 && want[3] > (0.5_f64 / 5.0).log2() {
                assert_eq!(passable[cell] == 1, sum(want) < middle, "cell {cell}: {}", sum(want));
                found[passable[cell] as usize] += 1;
            }
        }
        assert!(side < 24 || found.iter().all(|&cells| cells > 50), "{found:?}");
    }
}

#[test]
fn truth_little_evidence_no_ground_and_flat_scans_are_solid() {
    if skipped() {
        return;
    }
    let place = Place { side: 3, lidar: DVec2::new(-2.0, 0.4), ..PLACE };
    let mut cells = vec![0; place.words()];
    let returns = |cells: &mut Vec<u32>, cell: usize, count: u32| {
        cells[cell * WORDS..][..8].copy_from_slice(&[
            count,
            0,
            0,
            0,
            65536 - 60,
            90,
            48 * count,
            48 * 48 * count,
        ]);
    };
    returns(&mut cells, 0, 2);
    returns(&mut cells, 1, 1);
    // Nothing but a return over the robot; nothing at all.
    cells[8 * WORDS + 12] = 1;
    let always = SolidityModel { outer: vec![0.0; HIDDEN], ..model(-1.0) };
    let run = |params: &SolidityParams, cells: &[u32]| -> Vec<u32> {
        judge(&place, params, cells, &[0.0; 36], &always).words("passable_cells").to_vec()
    };
    assert_eq!(run(&params(&place), &cells), [0, 0, 1, 1, 1, 1, 1, 1, 0], "three returns are too few");
    returns(&mut cells, 1, 2);
    assert_eq!(run(&params(&place), &cells)[..2], [1, 1]);
    let flat = SolidityParams { judged: 0, ..params(&place) };
    assert_eq!(run(&flat, &cells), [0, 0, 1, 1, 1, 1, 1, 1, 0]);
    let lost = SolidityParams { ground_stated: 0, ..params(&place) };
    assert_eq!(run(&lost, &cells), [0; 9], "what is floor is not known either");
}

#[test]
fn truth_a_thin_upright_sheet_is_solid_whatever_the_model_says() {
    if skipped() {
        return;
    }
    let always = SolidityModel { outer: vec![0.0; HIDDEN], ..model(-9.0) };
    let called = |thickness: f64| {
        // A wall across the view, of so much depth, with nothing behind it.
        let mut random = Random(3);
        let mut points = Vec::new();
        for turn in -60..60 {
            for ring in -10..10 {
                let (x, turn) = (1.6 + thickness * f64::from(random.unit()), 0.005 * f64::from(turn));
                points.push(point([x, x * turn, x * 0.03 * f64::from(ring)], 50.0));
            }
        }
        let (cells, bins) = counts(&points, &PLACE);
        let flat: Vec<f32> =
            beams(&cells, &bins, &PLACE, 0.0).into_iter().flatten().map(|beams| beams as f32).collect();
        let out = judge(&PLACE, &params(&PLACE), &cells, &flat, &always);
        let cell = (PLACE.lidar.y / 0.25) as usize * 24 + ((1.65 + PLACE.lidar.x) / 0.25) as usize;
        out.words("passable_cells")[cell]
    };
    assert_eq!([called(0.01), called(0.4)], [0, 1]);
}

#[test]
fn poison_is_left_out_and_nothing_becomes_no_number() {
    if skipped() {
        return;
    }
    let ahead = point([1.1, 0.1, 0.2], 50.0);
    let mut bad = Vec::new();
    for poison in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        bad.push(Point { x_m: poison, ..ahead });
        bad.push(Point { z_m: poison, ..ahead });
        bad.push(Point { intensity: poison, ..ahead });
        bad.push(Point { time_s: poison, ..ahead });
    }
    let out = count(&bad);
    assert!(out.words("cell_counts").iter().chain(out.words("beam_bins")).all(|&word| word == 0));
    let huge = [3.0e38, -3.0e38].map(|x_m| Point { x_m, ..ahead });
    let dark = [0.0, -1.0, 3.0e38, 1.0e-40].map(|intensity| Point { intensity, ..ahead });
    let here = Point { x_m: 0.0, y_m: 0.0, ..ahead };
    let out = count(&[&huge[..], &dark[..], &[here]].concat());
    assert_eq!((0..4).map(|band| column(out.words("cell_counts"), band).iter().sum::<u32>()).sum::<u32>(), 5);
    for word in [1, u32::MAX] {
        let place = Place { side: 3, ..PLACE };
        let (cells, bins) = (vec![word; place.words()], vec![word; BEAM_WORDS as usize]);
        let beams = beams_on_gpu(&place, &cells, &bins);
        assert!(beams.iter().all(|beams| beams.is_finite()));
        let out = judge(&place, &params(&place), &cells, &beams, &model(0.1));
        assert!(out.floats("solidity_inputs").iter().all(|input| input.is_finite()), "{word}");
    }
    Fragment::new()
        .params("intensity_layers_params", &placed(1))
        .params("solidity_params", &params(&PLACE))
        .input("ground_now", &stated_now(1.0))
        .input("points", &[0_u32; 8])
        .changed("cell_counts", &[0_u32; WORDS])
        .changed("beam_bins", &[0_u32; 4])
        .refuses_nothing(COUNTS_OF_BUFFER);
}

#[test]
fn points_in_a_texture_are_counted_as_those_in_a_buffer() {
    if skipped() {
        return;
    }
    let points = points(&mut Random(9), 513);
    let buffer = count(&points);
    let texture = Fragment::new()
        .params("intensity_layers_params", &placed(points.len()))
        .params("solidity_params", &params(&PLACE))
        .texture("points", [1024, 2], bytemuck::cast_slice(&points))
        .input("ground_now", &stated_now(PLACE.lidar_m))
        .changed("cell_counts", &vec![0_u32; PLACE.words()])
        .changed("beam_bins", &vec![0_u32; BEAM_WORDS as usize])
        .run(COUNTS, Invocations::line(513));
    for name in ["cell_counts", "beam_bins"] {
        assert_eq!(texture.words(name), buffer.words(name));
    }
}

#[test]
fn weight_files_of_another_kind_are_refused() {
    let shipped = SolidityModel::shipped().unwrap();
    assert_eq!(shipped.inner.len(), HIDDEN * (INPUTS.len() + 1));
    let bytes = limpid::stage::lidar::solidity::SHIPPED;
    let refused = |bytes: &[u8]| SolidityModel::from_bytes(bytes).unwrap_err().to_string();
    assert!(refused(&bytes[..bytes.len() / 2]).contains("no safetensors file"));
    assert!(refused(include_bytes!("../../weights/drm-net.safetensors")).contains("`format`"));
    let swapped = String::from_utf8_lossy(bytes).into_owned();
    assert!(swapped.contains("lidar-solidity"));
    let at = bytes.windows(8).position(|window| window == b"went_on,").unwrap();
    let mut other = bytes.to_vec();
    other[at] = b'W';
    assert!(refused(&other).contains("`inputs`"));
}
