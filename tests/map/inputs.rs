//! Colour, calibrations and sizes that frames bring.

use crate::support::run::Pipeline;
use crate::support::run::{FrameOutput, Options};
use limpid::base::Rigid;
use limpid::sensor::CameraModel;
use limpid::sensor::{ColorImage, RgbdFrame};
use limpid::{Config, Error};

use crate::support::camera_job::{small_map, tiny_camera};
use crate::support::gpu::skipped;
use crate::support::run::{all, open, run, step};
use crate::support::scene::{Block, Scene, pose};

fn frame(index: u64, camera: CameraModel) -> RgbdFrame {
    let scene = Scene::of(&[Block::new([1.53, -1.0, 0.0], [1.7, 1.0, 1.5])]);
    scene.frame(index, camera, pose(0.01, 0.02, 0.0, 0.6, 0.2))
}

fn colored(index: u64, camera: CameraModel) -> RgbdFrame {
    let bytes = camera.width * camera.height * 3;
    let rgb = (0..bytes).map(|i| (i * 7 + index as u32) as u8).collect();
    let color = Some(ColorImage { stamp_ns: 5, camera, rgb });
    RgbdFrame { color, color_from_depth: Some(Rigid::IDENTITY), ..frame(index, tiny_camera()) }
}

fn color_of(out: &FrameOutput) -> &[u8] {
    out.images.as_ref().unwrap().color.as_ref().unwrap()
}

#[test]
fn colour_on_the_depth_grid_comes_back_as_it_went_in() {
    if skipped() {
        return;
    }
    let first = colored(0, tiny_camera());
    let derived = all().with_color_of([frame(9, tiny_camera()), first.clone()].iter());
    assert!(derived.color_aligned && derived.color == Some(tiny_camera()));
    for options in [derived.clone(), Options { color_aligned: false, ..derived }] {
        colour_comes_back(&options);
    }
}

#[test]
fn the_stamp_is_that_of_the_earliest_image_that_is_used() {
    if skipped() {
        return;
    }
    let first = colored(0, tiny_camera());
    let config = Config { method: limpid::config::Method::Range, ..small_map() };
    let stamp_ns = |images: bool| {
        let options = Options { images, ..all().with_color_of(std::iter::once(&first)) };
        step(&mut Pipeline::open(&config, &first, &options).unwrap(), &first).stamp_ns
    };
    assert_eq!(stamp_ns(true), 5, "colour is read back");
    assert_eq!(stamp_ns(false), first.depth.stamp_ns, "no pass reads colour");
}

fn colour_comes_back(options: &Options) {
    let first = colored(0, tiny_camera());
    // Method drm, which frames with colour have by default, takes no frame without.
    let config = limpid::Config { method: limpid::config::Method::Range, ..small_map() };
    let mut pipeline = Pipeline::open(&config, &first, options).unwrap();
    let out = step(&mut pipeline, &first);
    assert_eq!((color_of(&out), out.stamp_ns), (first.color.as_ref().unwrap().rgb.as_slice(), 5));
    let absent = step(&mut pipeline, &frame(1, tiny_camera()));
    assert!(color_of(&absent).iter().all(|&byte| byte == 0), "the frame before does not shine through");
    let unplaced = RgbdFrame { color_from_depth: None, ..colored(2, tiny_camera()) };
    assert!(color_of(&step(&mut pipeline, &unplaced)).iter().all(|&byte| byte == 0));
    // What cannot be shown is left out, and depth counts all the same.
    let other_size = step(&mut pipeline, &colored(3, CameraModel { width: 81, ..tiny_camera() }));
    assert!(color_of(&other_size).iter().all(|&byte| byte == 0));
    assert_eq!(other_size.counters.valid, out.counters.valid);
    let moved = Rigid { translation_m: glam::DVec3::X, ..Rigid::IDENTITY };
    let elsewhere = RgbdFrame { color_from_depth: Some(moved), ..colored(3, tiny_camera()) };
    let elsewhere = step(&mut pipeline, &elsewhere);
    assert_eq!(color_of(&elsewhere).iter().all(|&byte| byte == 0), options.color_aligned);
    let after = step(&mut pipeline, &colored(4, tiny_camera()));
    assert_eq!(color_of(&after), colored(4, tiny_camera()).color.unwrap().rgb);
}

#[test]
fn a_new_calibration_holds_from_its_frame_on_with_frames_in_flight() {
    if skipped() {
        return;
    }
    let wide = CameraModel { fx: 50.0, fy: 50.0, ..tiny_camera() };
    let frames = [tiny_camera(), wide, tiny_camera()].map(|camera| frame(0, camera));
    let alone: Vec<FrameOutput> =
        frames.iter().map(|frame| run(&small_map(), std::slice::from_ref(frame)).remove(0)).collect();
    assert_ne!(alone[0].counters.hit_cells, alone[1].counters.hit_cells);
    let mut pipeline = open(&small_map(), &frames[0]);
    frames.iter().for_each(|frame| pipeline.submit(frame).unwrap());
    for want in &alone {
        let got = pipeline.receive().unwrap().unwrap();
        assert_eq!(
            (got.counters.hits, got.counters.hit_cells),
            (want.counters.hits, want.counters.hit_cells)
        );
    }
}

#[test]
fn a_map_too_large_for_the_adapter_is_an_error_that_says_so() {
    if skipped() {
        return;
    }
    let huge = Config { map_size_m: 204.8, ..Config::default() };
    assert_eq!(huge.cells_per_side().unwrap(), 4096);
    let error = Pipeline::open(&huge, &frame(0, tiny_camera()), &all()).err().unwrap();
    assert!(
        matches!(error, Error::Limit { .. }) && error.to_string().contains("smaller image or map"),
        "{error}"
    );
}

#[test]
fn one_pixel_and_odd_widths_run() {
    if skipped() {
        return;
    }
    for (width, height) in [(1, 1), (3, 1), (1, 5), (63, 3), (65, 17), (127, 2)] {
        let camera = CameraModel {
            width,
            height,
            cx: f64::from(width) / 2.0,
            cy: f64::from(height) / 2.0,
            ..tiny_camera()
        };
        let out = &run(&small_map(), &[frame(0, camera)])[0];
        assert_eq!(
            (out.counters.pixels, out.images.as_ref().unwrap().depth_m.len()),
            (width * height, (width * height) as usize)
        );
        assert!(out.counters.valid > 0 && out.counters.valid <= out.counters.pixels, "{width}x{height}");
        let evidence = &out.layers.as_ref().unwrap().evidence;
        let marked = evidence.iter().filter(|&&e| e == 1.0).count();
        assert_eq!(marked, out.counters.hit_cells as usize, "{width}x{height}");
    }
}

#[test]
fn images_that_nobody_wants_stay_on_the_gpu_and_come_back_once_wanted() {
    if skipped() {
        return;
    }
    let frames: Vec<_> = (0..4).map(|index| colored(index, tiny_camera())).collect();
    let config = small_map();
    let options = all().with_color_of(frames.iter());
    let open = || Pipeline::open(&config, &frames[0], &options).unwrap();
    let (mut always, mut at_times) = (open(), open());
    for (frame, wanted) in frames.iter().zip([true, false, false, true]) {
        at_times.mapper.want_images(0, wanted);
        let (mut whole, mut some) = (step(&mut always, frame), step(&mut at_times, frame));
        assert!(whole.images.is_some());
        assert_eq!(some.images.is_some(), wanted);
        if !wanted {
            (whole.images, some.images) = (None, None);
        }
        assert!(whole == some, "frame {}", frame.index);
    }
    // With frames under way: each has what was wanted when it was given.
    for (frame, wanted) in frames.iter().zip([false, true]) {
        at_times.mapper.want_images(0, wanted);
        at_times.submit(frame).unwrap();
    }
    assert!(at_times.receive().unwrap().unwrap().images.is_none());
    assert!(at_times.receive().unwrap().unwrap().images.is_some());
}
