//! The methods and their settings (spec 1 §4, §5).

use limpid::Config;
use limpid::config::Method;
use limpid::sensor::{DepthSamples, RgbdFrame};

use crate::support::gpu::skipped;
use crate::support::run::{cell, evidence, lethal, run, still};
use crate::support::scene::{Block, Scene, frame, pose, small_camera};

fn with(method: Method) -> Config {
    Config { method, ..Config::default() }
}

fn level() -> limpid::sensor::FramePose {
    pose(0.01, 0.02, 0.0, 0.6, 0.0)
}

/// A wall whose face lies at x = 1.53 (y in -1..1) and nothing else.
fn wall() -> Scene {
    Scene::of(&[Block::new([1.53, -1.0, 0.0], [1.7, 1.0, 1.5])])
}

/// A frame whose pixels all hold `metres`.
fn flat(index: u64, metres: f32) -> RgbdFrame {
    frame(index, small_camera(), Some(level()), DepthSamples::Metres(vec![metres; 160 * 120]))
}

#[test]
fn range_gating_drops_what_naive_clears_with() {
    if skipped() {
        return;
    }
    let far = [flat(0, 5.2)];
    let naive = &run(&with(Method::Naive), &far)[0];
    assert_eq!((naive.counters.valid, naive.counters.low_reliability), (160 * 120, 0));
    assert_eq!(evidence(naive, 2.0, 0.02), 0.0, "the rays clear");
    let range = &run(&with(Method::Range), &far)[0];
    assert_eq!((range.counters.valid, range.counters.low_reliability), (0, 160 * 120));
    assert!(range.layers.as_ref().unwrap().evidence.iter().all(|&e| e == -1.0), "neither marks nor clears");
    assert!(range.images.as_ref().unwrap().depth_m.iter().all(|&d| d == 0.0));
}

#[test]
fn a_spike_marks_for_naive_and_not_for_median() {
    if skipped() {
        return;
    }
    let mut first = still(&wall(), level(), 1).remove(0);
    let DepthSamples::Metres(samples) = &mut first.depth.samples else { unreachable!() };
    samples[60 * 160 + 80] = 0.8;
    for (method, want) in [(Method::Naive, 1.0), (Method::Median, 0.0)] {
        assert_eq!(evidence(&run(&with(method), &[first.clone()])[0], 0.81, 0.02), want, "{method:?}");
    }
}

#[test]
fn temporal_rejection_marks_from_the_third_hit() {
    if skipped() {
        return;
    }
    let out = run(&Config { lambda: 0.0, ..with(Method::Temporal) }, &still(&wall(), level(), 5));
    let marks: Vec<f32> = out.iter().map(|out| evidence(out, 1.54, 0.02)).collect();
    assert_eq!(marks, [-1.0, -1.0, 1.0, 1.0, 1.0]);
    assert_eq!(out.iter().position(|out| lethal(out, 1.54, 0.02)), Some(2));
    // Hit in every third frame only: at most two of five.
    let near = wall();
    let far = Scene::of(&[Block::new([3.53, -4.0, 0.0], [3.7, 4.0, 2.5])]);
    let frames: Vec<_> =
        (0..10).map(|i| if i % 3 == 0 { &near } else { &far }.frame(i, small_camera(), level())).collect();
    let out = run(&with(Method::Temporal), &frames);
    assert!(out.iter().all(|out| evidence(out, 1.54, 0.02) <= 0.0), "never marks");
    assert!(run(&with(Method::Naive), &frames).iter().any(|out| evidence(out, 1.54, 0.02) == 1.0));
}

#[test]
fn min_hits_asks_for_that_many_pixels() {
    if skipped() {
        return;
    }
    let mut samples = vec![0.0; 160 * 120];
    for v in 58..61 {
        samples[v * 160 + 80] = 1.0;
    }
    let three = frame(0, small_camera(), Some(level()), DepthSamples::Metres(samples));
    for (min_hits, want) in [(1, 1.0), (3, 1.0), (4, -1.0)] {
        let out = &run(&Config { min_hits, ..Config::default() }, std::slice::from_ref(&three))[0];
        assert_eq!(evidence(out, 1.01, 0.02), want, "{min_hits} hits");
        assert_eq!((out.counters.hits, out.counters.hit_cells), (3, u32::from(want > 0.0)));
    }
}

#[test]
fn half_of_the_image_as_holes_is_at_the_degraded_limit() {
    if skipped() {
        return;
    }
    let holes = |count: usize| {
        let mut samples = vec![2.0; 160 * 120];
        samples[..count].fill(0.0);
        frame(0, small_camera(), Some(level()), DepthSamples::Metres(samples))
    };
    for (count, degraded) in [(9600, false), (9601, true), (0, false), (19200, true)] {
        let out = &run(&Config::default(), &[holes(count)])[0];
        assert_eq!(out.counters.low_reliability as usize, count);
        assert_eq!(out.low_reliability_fraction, count as f64 / 19200.0);
        assert_eq!(out.degraded, degraded, "{count} holes");
    }
}

#[test]
fn integers_and_floats_of_the_same_depth_give_the_same_map() {
    if skipped() {
        return;
    }
    let scene = wall();
    let floats = scene.frame(0, small_camera(), level());
    let DepthSamples::Metres(metres) = &floats.depth.samples else { unreachable!() };
    let raw: Vec<u16> = metres.iter().map(|m| (m * 1000.0).round() as u16).collect();
    let rounded: Vec<f32> = raw.iter().map(|&r| f32::from(r) * 0.001).collect();
    let integers = frame(0, small_camera(), Some(level()), DepthSamples::Integer { raw, unit_m: 0.001 });
    let floats = frame(0, small_camera(), Some(level()), DepthSamples::Metres(rounded));
    let [a, b] = [integers, floats].map(|frame| run(&Config::default(), &[frame]).remove(0));
    assert_eq!((&a.layers, &a.images, a.counters), (&b.layers, &b.images, b.counters));
    assert!(lethal(&a, 1.54, 0.02) || evidence(&a, 1.54, 0.02) == 1.0);
}

#[test]
fn only_the_costmap_is_read_back_unless_asked() {
    if skipped() {
        return;
    }
    let first = wall().frame(0, small_camera(), level());
    let options = crate::support::run::Options::default();
    let mut pipeline = crate::support::run::Pipeline::open(&Config::default(), &first, &options).unwrap();
    let out = crate::support::run::step(&mut pipeline, &first);
    assert!(out.layers.is_none() && out.images.is_none());
    let full = &run(&Config::default(), &[first])[0];
    assert_eq!((&out.costmap, out.counters), (&full.costmap, full.counters));
    assert_eq!(out.costmap[cell(&out, 1.54, 0.02)], 255);
}
