//! Method drm through the whole pipeline: the reliability that weighs the map is the network's.

use crate::support::run::Options;
use crate::support::run::Pipeline;
use limpid::Config;
use limpid::base::Rigid;
use limpid::config::{Fusion, Method};
use limpid::network::weights::{NATIVE_SIZE, Network};
use limpid::network::{Backend, Inference};
use limpid::sensor::{ColorImage, DepthSamples, RgbdFrame};

use crate::reference;
use crate::support::compare::{Tolerance, assert_close};
use crate::support::gpu::context;
use crate::support::gpu::skipped;
use crate::support::random::Random;
use crate::support::run::{FrameOutput, all, step};
use crate::support::scene::{Block, Scene, pose, small_camera};

const WEIGHTS: &str = "testdata/reference/network.safetensors";

const ROUNDING: Tolerance = Tolerance { absolute: 2e-5, reason: "float32 from pixels to reliability" };

fn config() -> Config {
    Config { method: Method::Drm, fusion: Fusion::Weight, weights: WEIGHTS.into(), ..Config::default() }
}

fn network() -> Network {
    Network::from_bytes(&std::fs::read(WEIGHTS).unwrap()).unwrap()
}

/// A frame with a hole and with noise for colour, aligned to depth.
fn frame(index: u64) -> RgbdFrame {
    let scene = Scene::of(&[Block::new([1.53, -1.0, 0.0], [1.7, 1.0, 1.5])]);
    let camera = small_camera();
    let mut frame = scene.frame(index, camera, pose(0.01 + 0.02 * index as f64, 0.02, 0.0, 0.6, 0.2));
    let DepthSamples::Metres(samples) = &mut frame.depth.samples else { unreachable!() };
    for row in 40..60 {
        samples[row * 160 + 30..row * 160 + 70].fill(0.0);
    }
    samples[0] = f32::NAN;
    samples[1] = f32::INFINITY;
    samples[2] = -1.0;
    let mut random = Random(index);
    let rgb = (0..3 * 160 * 120).map(|_| random.below(256) as u8).collect();
    let stamp_ns = frame.depth.stamp_ns;
    frame.color = Some(ColorImage { stamp_ns, camera, rgb });
    frame.color_from_depth = Some(Rigid::IDENTITY);
    frame
}

fn options(first: &RgbdFrame) -> Options {
    all().with_color_of(std::iter::once(first))
}

/// Reliability of `frame` by the twins and the network alone, and the depth that the next frame is compared with.
fn expected(inference: &mut Inference, frame: &RgbdFrame, before: &[f32]) -> (Vec<f32>, Vec<f32>) {
    let DepthSamples::Metres(samples) = &frame.depth.samples else { unreachable!() };
    let valid = |d: f32| d.is_finite() && (0.17..=10.0).contains(&d);
    let depth: Vec<f32> = samples.iter().map(|&d| if valid(d) { d } else { 0.0 }).collect();
    let pixels = frame.color.as_ref().unwrap().rgb.chunks_exact(3);
    let color: Vec<u32> = pixels.map(|p| u32::from_le_bytes([p[0], p[1], p[2], 255])).collect();
    let (planes, kept) = reference::drm::resize([120, 160], NATIVE_SIZE, &depth, &color, before, 10.0);
    let low = inference.run(&planes).unwrap().remove(0).values;
    (reference::drm::restore([120, 160], NATIVE_SIZE, &low, &depth), kept)
}

#[test]
fn reliability_is_the_networks() {
    if skipped() {
        return;
    }
    let size = NATIVE_SIZE.map(|extent| extent as u32);
    let mut alone = Inference::build(network(), size, false, Backend::of(&context()), &context()).unwrap();
    let mut pipeline = Pipeline::open(&config(), &frame(0), &options(&frame(0))).unwrap();
    let mut before = vec![0.0; NATIVE_SIZE[0] * NATIVE_SIZE[1]];
    for index in 0..3 {
        let out = step(&mut pipeline, &frame(index));
        let (want, kept) = expected(&mut alone, &frame(index), &before);
        before = kept;
        let images = out.images.unwrap();
        assert_close("reliability", &images.reliability, &want, ROUNDING);
        assert!(images.reliability[50 * 160 + 50] == 0.0 && images.reliability[..3] == [0.0; 3]);
        let spread = want.iter().fold((1.0_f32, 0.0_f32), |(a, b), &r| (a.min(r), b.max(r)));
        assert!(spread.1 > 0.3 && spread.0 == 0.0, "the random network says something: {spread:?}");
        let low = want.iter().filter(|&&r| r <= 0.3).count();
        assert!(
            out.counters.low_reliability.abs_diff(low as u32) <= 2,
            "{} {low}",
            out.counters.low_reliability
        );
        let share = f64::from(out.counters.low_reliability) / (160.0 * 120.0);
        assert_eq!(out.low_reliability_fraction, share);
        // Evidence is a mean of weights above tau.
        let evidence = out.layers.unwrap().evidence;
        assert!(evidence.iter().any(|&e| e > 0.3) && evidence.iter().all(|&e| e <= 1.0));
    }
}

#[test]
fn truth_depth_does_not_change_over_a_gap() {
    if skipped() {
        return;
    }
    let open = || Pipeline::open(&config(), &frame(0), &options(&frame(0))).unwrap();
    let reliability =
        |pipeline: &mut Pipeline, frame: &RgbdFrame| step(pipeline, frame).images.unwrap().reliability;
    let next = frame(1);
    let first = reliability(&mut open(), &next);
    let after = |gap_ns: u64, refused: Option<&RgbdFrame>| {
        let mut pipeline = open();
        let mut before = frame(0);
        before.depth.stamp_ns = next.depth.stamp_ns - gap_ns;
        step(&mut pipeline, &before);
        refused.into_iter().for_each(|frame| assert!(pipeline.submit(frame).is_err()));
        reliability(&mut pipeline, &next)
    };
    assert_ne!(after(33_000_000, None), first, "the control: the change is an input");
    assert_ne!(after(200_000_000, None), first);
    assert_eq!(after(201_000_000, None), first, "a gap");
    assert_eq!(after(33_000_000, Some(&RgbdFrame { color: None, ..frame(0) })), first, "one was refused");
}

#[test]
fn drm_wants_readable_weights_and_colour() {
    if skipped() {
        return;
    }
    let refused = |config: &Config, options: &Options, parts: &[&str]| {
        let reason = Pipeline::open(config, &frame(0), options).err().unwrap().to_string();
        assert!(parts.iter().all(|part| reason.contains(part)), "{reason}");
    };
    let missing = Config { weights: "no/such.safetensors".into(), ..config() };
    refused(&missing, &options(&frame(0)), &["no/such.safetensors"]);
    let broken = Config { weights: "Cargo.toml".into(), ..config() };
    refused(&broken, &options(&frame(0)), &["Cargo.toml", "safetensors"]);
    refused(&config(), &all(), &["drm needs colour images"]);
}

#[test]
fn auto_is_drm_where_there_is_colour_and_range_elsewhere() {
    assert_eq!(Config::default().method, Method::Auto);
    assert_eq!(Config::default().resolved(true).method, Method::Drm);
    assert_eq!(Config::default().resolved(false).method, Method::Range);
    let stated = Config { method: Method::Naive, ..Config::default() };
    assert_eq!(stated.resolved(true), stated);
    assert!(Network::shipped().unwrap().depth_scale_m > 0.0);
    if skipped() {
        return;
    }
    let shipped = Config { weights: String::new(), ..config() };
    let mut drm = Pipeline::open(&shipped, &frame(0), &options(&frame(0))).unwrap();
    let mut auto = Pipeline::open(&Config::default(), &frame(0), &options(&frame(0))).unwrap();
    assert_eq!(step(&mut auto, &frame(0)).images, step(&mut drm, &frame(0)).images);
    let mut range = Pipeline::open(&Config::default(), &frame(0), &all()).unwrap();
    let weights = step(&mut range, &frame(0)).images.unwrap().reliability;
    assert!(weights.iter().all(|&r| r == 0.0 || r == 1.0), "without colour: range");
}

#[test]
fn a_frame_without_colour_is_refused_and_the_map_stays() {
    if skipped() {
        return;
    }
    let mut pipeline = Pipeline::open(&config(), &frame(0), &options(&frame(0))).unwrap();
    let before = step(&mut pipeline, &frame(0));
    let mut blind = frame(1);
    blind.color = None;
    let mut nowhere = frame(1);
    nowhere.color_from_depth = None;
    for frame in [blind, nowhere] {
        let reason = pipeline.submit(&frame).unwrap_err().to_string();
        assert!(reason.contains("colour image") && reason.contains("method drm needs it"), "{reason}");
    }
    assert!(pipeline.receive().unwrap().is_none());
    let after = step(&mut pipeline, &frame(1));
    assert_eq!(after.counters.pixels, before.counters.pixels);
    assert!(after.counters.valid > 1000);
}

#[test]
fn truth_auto_fuses_frames_without_usable_colour_as_range_does() {
    if skipped() {
        return;
    }
    let auto = Config { method: Method::Auto, ..config() };
    let range = Config { method: Method::Range, ..config() };
    let blind = |mut frame: RgbdFrame| {
        (frame.color, frame.color_missing) = (None, Some("the lens cap is on".into()));
        frame
    };
    let nowhere = |frame: RgbdFrame| RgbdFrame { color_from_depth: None, ..frame };
    let other_size = |mut frame: RgbdFrame| {
        let camera = &mut frame.color.as_mut().unwrap().camera;
        (camera.width, camera.height) = (80, 240);
        frame
    };
    let unusable: [(&dyn Fn(RgbdFrame) -> RgbdFrame, &str); 3] = [
        (&blind, "the lens cap is on"),
        (&nowhere, "its place relative to depth is unknown"),
        (&other_size, "80x240 where the recording began"),
    ];
    let weights = |out: &FrameOutput| out.images.as_ref().unwrap().reliability.clone();
    for (spoil, reason) in unusable {
        let mut pipeline = Pipeline::open(&auto, &frame(0), &options(&frame(0))).unwrap();
        let mut alone = Pipeline::open(&range, &frame(0), &all()).unwrap();
        for index in 1..=9 {
            let spoilt = spoil(frame(index));
            let (got, want) = (step(&mut pipeline, &spoilt), step(&mut alone, &spoilt));
            let why = got.depth_alone.clone().unwrap_or_default();
            assert!(why.contains(reason), "{why}");
            assert_eq!(got.costmap, want.costmap);
            assert_eq!(got.counters.hit_cells, want.counters.hit_cells);
            assert_eq!(weights(&got), weights(&want));
            assert!(index < 9 || got.counters.occupied_cells > 20, "{:?}", got.counters);
        }
        // The next frame with colour is the network's again.
        let next = step(&mut pipeline, &frame(10));
        assert_eq!(next.depth_alone, None);
        assert!(weights(&next).iter().any(|&r| r > 0.0 && r < 1.0));
    }
}

#[test]
fn truth_depth_alone_between_frames_leaves_the_network_what_it_saw() {
    if skipped() {
        return;
    }
    // The depth of a frame by itself is what the next frame's change is measured from.
    let auto = Config { method: Method::Auto, ..config() };
    let reliability = |color: bool| {
        let mut pipeline = Pipeline::open(&auto, &frame(0), &options(&frame(0))).unwrap();
        let first = if color { frame(0) } else { RgbdFrame { color: None, ..frame(0) } };
        step(&mut pipeline, &first);
        step(&mut pipeline, &frame(1)).images.unwrap().reliability
    };
    assert_eq!(reliability(true), reliability(false));
}
