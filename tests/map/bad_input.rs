//! Each bad input has its own error, and the map stays as it was and usable.

use crate::support::run::Options;
use crate::support::run::Pipeline;
use glam::DVec3;
use limpid::sensor::CameraModel;
use limpid::sensor::{ColorImage, DepthSamples, RgbdFrame};
use limpid::{Config, Error};

use crate::support::gpu::skipped;
use crate::support::run::{open, run, step};
use crate::support::scene::{Block, Scene, pose, small_camera};

fn frame(index: u64) -> RgbdFrame {
    let scene = Scene::of(&[Block::new([1.53, -1.0, 0.0], [1.7, 1.0, 1.5])]);
    let mut frame = scene.frame(index, small_camera(), pose(0.01, 0.02, 0.0, 0.6, 0.2));
    frame.confidence = Some(vec![1.0; 160 * 120]);
    frame
}

fn spoilt(spoil: impl Fn(&mut RgbdFrame)) -> RgbdFrame {
    let mut bad = frame(1);
    spoil(&mut bad);
    bad
}

fn lens(change: impl Fn(&mut CameraModel)) -> RgbdFrame {
    spoilt(|f| change(&mut f.depth.camera))
}

fn moved(to: DVec3) -> RgbdFrame {
    spoilt(|f| f.pose.as_mut().unwrap().map_from_base.translation_m = to)
}

/// Bad frames, each with a part of its error.
fn bad_frames() -> Vec<(RgbdFrame, &'static str)> {
    let integer = |unit_m: f64| DepthSamples::Integer { raw: vec![1000; 160 * 120], unit_m };
    let color = ColorImage { stamp_ns: 0, camera: small_camera(), rgb: vec![0; 5] };
    vec![
        (spoilt(|f| f.depth.samples = DepthSamples::Metres(vec![1.0; 7])), "7 samples for 160x120"),
        (spoilt(|f| f.depth.samples = DepthSamples::Metres(Vec::new())), "0 samples for 160x120"),
        (lens(|c| c.width = 80), "80x120 where the first one had 160x120"),
        (lens(|c| c.height = 0), "image size is 160x0"),
        (spoilt(|f| f.depth.samples = integer(0.001)), "between integer and float"),
        (spoilt(|f| f.pose = None), "no transform from map to sensor"),
        (lens(|c| c.fx = 0.0), "fx = 0"),
        (lens(|c| c.fy = f64::NAN), "fy = NaN"),
        (lens(|c| c.cx = f64::INFINITY), "principal point"),
        (spoilt(|f| f.confidence = Some(vec![1.0; 3])), "3 values for 160x120"),
        (spoilt(|f| f.color = Some(color.clone())), "5 bytes for 160x120"),
        (moved(DVec3::new(f64::NAN, 0.0, 0.0)), "not finite"),
        (moved(DVec3::new(0.0, f64::INFINITY, 0.0)), "not finite"),
    ]
}

#[test]
fn each_bad_frame_has_its_error_and_leaves_the_map_alone() {
    if skipped() {
        return;
    }
    let mut pipeline = open(&Config::default(), &frame(0));
    let mut outs = vec![step(&mut pipeline, &frame(0))];
    for (bad, part) in bad_frames() {
        let reason = pipeline.submit(&bad).unwrap_err().to_string();
        assert!(reason.contains(part), "`{reason}` where `{part}` is wanted");
        assert!(pipeline.receive().unwrap().is_none());
    }
    outs.push(step(&mut pipeline, &frame(1)));
    assert!(outs == run(&Config::default(), &[frame(0), frame(1)]), "the refused frames changed the map");
}

#[test]
fn an_impossible_unit_is_refused() {
    if skipped() {
        return;
    }
    let with_unit =
        |unit_m| spoilt(|f| f.depth.samples = DepthSamples::Integer { raw: vec![1000; 160 * 120], unit_m });
    let mut pipeline = open(&Config::default(), &with_unit(0.001));
    for unit_m in [0.0, -0.001, f64::NAN, f64::INFINITY] {
        let reason = pipeline.submit(&with_unit(unit_m)).unwrap_err().to_string();
        assert!(reason.contains("unit"), "{reason}");
    }
    let samples = step(&mut pipeline, &with_unit(0.001)).images.unwrap().depth_m;
    assert!(samples.iter().all(|&d| (d - 1.0).abs() < 1e-6));
}

#[test]
fn poison_depth_never_reaches_the_map() {
    if skipped() {
        return;
    }
    let poison = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, -0.0, f32::MAX, 1e30, 65.535];
    for method in
        [limpid::config::Method::Naive, limpid::config::Method::Median, limpid::config::Method::Range]
    {
        let samples = (0..160 * 120).map(|i| poison[i % poison.len()]).collect();
        let bad = spoilt(|f| f.depth.samples = DepthSamples::Metres(Clone::clone(&samples)));
        let out = &run(&Config { method, ..Config::default() }, &[bad])[0];
        assert_eq!(out.counters.hits, 0, "{method:?}");
        let layers = out.layers.as_ref().unwrap();
        assert!(layers.evidence.iter().all(|&e| e == -1.0 || e == 0.0));
        assert!(layers.occupancy.iter().all(|&p| p == 0.0));
        assert!(out.images.as_ref().unwrap().depth_m.iter().all(|d| d.is_finite() && *d >= 0.0));
    }
}

#[test]
fn bad_first_frames_and_configurations_are_refused_at_opening() {
    let refused =
        |config: &Config, first: &RgbdFrame| match Pipeline::open(config, first, &Options::default()) {
            Ok(_) => panic!("opened"),
            Err(error) => error.to_string(),
        };
    assert!(refused(&Config::default(), &lens(|c| c.fx = f64::NAN)).contains("fx = NaN"));
    assert!(refused(&Config::default(), &lens(|c| c.width = 0)).contains("0x120"));
    assert!(refused(&Config { lambda: f64::NAN, ..Config::default() }, &frame(0)).contains("lambda"));
}

#[test]
fn a_lost_device_is_an_error_and_not_a_hang() {
    if skipped() {
        return;
    }
    let mut pipeline = open(&Config::default(), &frame(0));
    pipeline.submit(&frame(0)).unwrap();
    pipeline.executor().context().destroy();
    let received = pipeline.receive();
    assert!(matches!(&received, Ok(Some(_)) | Err(Error::DeviceLost(_))), "{:?}", received.map(|_| ()));
    for index in 1..5 {
        let submitted = pipeline.submit(&frame(index));
        assert!(matches!(submitted, Err(Error::DeviceLost(_))), "{submitted:?}");
    }
    assert!(!matches!(pipeline.receive(), Ok(Some(_))));
}

#[test]
fn an_adapter_that_is_not_there_is_named_with_what_is() {
    if skipped() {
        return;
    }
    let options = Options { adapter: Some("no such adapter".into()), ..Options::default() };
    let error = Pipeline::open(&Config::default(), &frame(0), &options).err().unwrap();
    let reason = error.to_string();
    assert!(matches!(error, Error::NoAdapter { .. }));
    for part in ["named `no such adapter`", "Found: ", "mesa-vulkan-drivers"] {
        assert!(reason.contains(part), "{reason}");
    }
    let there = limpid::gpu::adapters(None).unwrap();
    assert!(there.iter().all(|adapter| reason.contains(&adapter.info.name)), "{reason}");
}
