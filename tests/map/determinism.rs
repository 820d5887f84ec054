//! Same input, same adapter: the same bits, however many frames are under way.

use crate::support::run::FrameOutput;
use limpid::Config;
use limpid::config::Method;
use limpid::sensor::{DepthSamples, RgbdFrame};

use crate::support::gpu::skipped;
use crate::support::random::Random;
use crate::support::run::{open, run};
use crate::support::scene::{Block, Scene, pose, small_camera};

/// A moving camera with holes and spikes.
fn sequence() -> Vec<RgbdFrame> {
    let scene = Scene::of(&[
        Block::new([2.5, -3.0, 0.0], [2.7, 3.0, 2.5]),
        Block::new([1.5, 0.2, 0.0], [1.8, 0.6, 0.4]),
    ]);
    let mut random = Random(77);
    (0..9)
        .map(|i| {
            let at = i as f64;
            let mut frame = scene.frame(i, small_camera(), pose(0.09 * at, 0.03 * at, 0.1 * at, 0.6, 0.25));
            let DepthSamples::Metres(depth) = &mut frame.depth.samples else { unreachable!() };
            for d in depth.iter_mut() {
                *d *= [0.0, 2.0, 1.0][random.below(20).min(2) as usize];
            }
            frame.confidence = Some(depth.iter().map(|_| random.unit()).collect());
            frame
        })
        .collect()
}

fn in_flight(config: &Config, frames: &[RgbdFrame]) -> Vec<FrameOutput> {
    let mut pipeline = open(config, &frames[0]);
    let (mut outs, mut most) = (Vec::new(), 0);
    for frame in frames {
        if pipeline.is_full() {
            outs.extend(pipeline.receive().unwrap());
        }
        pipeline.submit(frame).unwrap();
        most = most.max(pipeline.executor().in_flight());
    }
    assert_eq!(most, 3);
    while let Some(out) = pipeline.receive().unwrap() {
        outs.push(out);
    }
    outs
}

#[test]
fn two_runs_and_three_frames_in_flight_give_the_same_bits() {
    if skipped() {
        return;
    }
    for method in [Method::Range, Method::Median] {
        let config = Config { method, ..Config::default() };
        let frames = sequence();
        let first = run(&config, &frames);
        assert!(first.last().unwrap().counters.hit_cells > 20);
        assert!(first == run(&config, &frames), "a second run differs");
        assert!(first == in_flight(&config, &frames), "three frames in flight differ");
    }
}

#[test]
fn control_another_sequence_differs() {
    if skipped() {
        return;
    }
    let mut frames = sequence();
    let first = run(&Config::default(), &frames);
    let DepthSamples::Metres(depth) = &mut frames[4].depth.samples else { unreachable!() };
    depth[60 * 160 + 80] = 0.7;
    frames[4].confidence.as_mut().unwrap()[60 * 160 + 80] = 1.0;
    let other = run(&Config::default(), &frames);
    assert!(first[..4] == other[..4] && first[4..] != other[4..]);
}

#[test]
fn a_fourth_frame_in_flight_is_refused() {
    if skipped() {
        return;
    }
    let frames = sequence();
    let mut pipeline = open(&Config::default(), &frames[0]);
    frames[..3].iter().for_each(|frame| pipeline.submit(frame).unwrap());
    assert!(pipeline.submit(&frames[3]).unwrap_err().to_string().contains("in flight"));
    let mut outs = vec![pipeline.receive().unwrap().unwrap()];
    pipeline.submit(&frames[3]).unwrap();
    while let Some(out) = pipeline.receive().unwrap() {
        outs.push(out);
    }
    assert!(outs == run(&Config::default(), &frames[..4]), "the refusal changed nothing");
}
