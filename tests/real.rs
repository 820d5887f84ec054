//! A real recording: the cells that NumPy finds hit are the cells hit (tests/reference/back_projection.py).

use std::collections::BTreeSet;
use std::path::Path;

use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::sensor::{CameraModel, Distortion};
use limpid::sensor::{DepthSamples, FramePose, RgbdFrame};

use crate::support::data_dir;
use crate::support::gpu::skipped;
use crate::support::run::run;
use crate::support::scene::frame;

const GOLDEN: &str = include_str!("../testdata/reference/kitchen_hits.json");

/// What NumPy found for one frame.
#[derive(serde::Deserialize)]
struct Hits {
    stamp: String,
    /// Cells with a hit away from every edge.
    sure: BTreeSet<usize>,
    /// Cells that only points within 1e-4 m of an edge can hit.
    doubtful: BTreeSet<usize>,
}

fn golden() -> Vec<Hits> {
    serde_json::from_str(GOLDEN).unwrap()
}

fn pose(folder: &Path, stamp: &str) -> FramePose {
    let text = std::fs::read_to_string(folder.join("groundtruth.txt")).unwrap();
    let line = text.lines().find(|line| line.starts_with(stamp)).unwrap();
    let n: Vec<f64> = line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
    let map_from_camera = Rigid::new([n[0], n[1], n[2]], [n[3], n[4], n[5], n[6]]).unwrap();
    let map_from_base = Rigid { rotation: DQuat::IDENTITY, translation_m: DVec3::new(n[0], n[1], 0.0) };
    FramePose { map_from_base, base_from_camera: map_from_base.inverse().then(map_from_camera) }
}

fn load(folder: &Path, stamp: &str) -> RgbdFrame {
    let image = image::open(folder.join("depth").join(format!("{stamp}.png"))).unwrap().into_luma16();
    let camera = CameraModel {
        width: image.width(),
        height: image.height(),
        fx: 585.0,
        fy: 585.0,
        cx: 320.0,
        cy: 240.0,
        distortion: Distortion::None,
    };
    frame(
        0,
        camera,
        Some(pose(folder, stamp)),
        DepthSamples::Integer { raw: image.into_raw(), unit_m: 0.001 },
    )
}

#[test]
fn the_cells_hit_are_those_that_numpy_finds() {
    if skipped() {
        return;
    }
    let Some(folder) = data_dir("rgbd/kitchen-tum") else { return };
    let mut sure = 0;
    let mut doubtful = 0;
    for want in golden() {
        let out = &run(&Config::default(), &[load(&folder, &want.stamp)])[0];
        let evidence = &out.layers.as_ref().unwrap().evidence;
        let got: BTreeSet<usize> = (0..evidence.len()).filter(|&i| evidence[i] == 1.0).collect();
        let missed: Vec<_> = want.sure.difference(&got).collect();
        let invented: Vec<_> =
            got.iter().filter(|i| !want.sure.contains(i) && !want.doubtful.contains(i)).collect();
        assert!(
            missed.is_empty() && invented.is_empty(),
            "{}: missed {missed:?}, invented {invented:?}",
            want.stamp
        );
        (sure, doubtful) = (sure + want.sure.len(), doubtful + want.doubtful.len());
    }
    println!("{sure} cells agree, {doubtful} lie on an edge");
    assert!(sure > 1000 && doubtful * 50 < sure, "{doubtful} of {sure} lie on an edge");
}

#[test]
fn control_the_recording_a_cell_further_on_differs() {
    if skipped() {
        return;
    }
    let Some(folder) = data_dir("rgbd/kitchen-tum") else { return };
    let want = &golden()[0];
    let mut shifted = load(&folder, &want.stamp);
    shifted.pose.as_mut().unwrap().base_from_camera.translation_m.x += 0.05;
    let evidence = &run(&Config::default(), &[shifted])[0].layers.as_ref().unwrap().evidence.clone();
    assert!(want.sure.iter().any(|&i| evidence[i] != 1.0));
}
