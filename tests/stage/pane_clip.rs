//! Depths that end at panes.

use glam::{DVec3, Vec4};
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::map::Pane;
use limpid::sensor::{CameraModel, Distortion};
use limpid::stage::camera::back_project::rays;
use limpid::stage::camera::pane_clip::{PANE_CLIP, params};

use super::pane_cells::pane;
use crate::reference::pane_cells::Corners;
use crate::reference::pane_clip::clipped_m;
use crate::support::camera_job::tiny_camera;
use crate::support::compare::{Tolerance, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;
use crate::support::scene::pose;

const DEPTH: Tolerance =
    Tolerance { absolute: 1e-4, reason: "f32 at ten metres, divided by the cosine to the pane" };

fn run(
    camera: &CameraModel,
    local_from_camera: Rigid,
    panes: &[Pane],
    depth_m: &[f32],
    distorted: bool,
) -> Vec<f32> {
    let mut all = panes.to_vec();
    all.resize(32, Pane::default());
    let out = Fragment::new()
        .params("pane_clip_params", &params(camera, local_from_camera, 2))
        .input("depth_m", depth_m)
        .input("rays", &rays(camera))
        .input("map_panes", &all)
        .output("depth_clipped_m", depth_m.len())
        .constants(&[("distorted", distorted)])
        .run(PANE_CLIP, Invocations::line(depth_m.len() as u32));
    out.floats("depth_clipped_m")
}

fn one_pixel() -> CameraModel {
    CameraModel { width: 1, height: 1, fx: 100.0, fy: 100.0, cx: 0.0, cy: 0.0, distortion: Distortion::None }
}

/// A camera 1 m up that looks along +x.
fn ahead() -> Rigid {
    let pose = pose(0.0, 0.0, 0.0, 1.0, 0.0);
    pose.map_from_base.then(pose.base_from_camera)
}

/// Across the way at `x`, from y = -1 to `right` and z = 0 to 2.
fn across(x: f64, right: f64) -> Corners {
    let at = |y: f64, z: f64| DVec3::new(x, y, z);
    Corners { low_left: at(-1.0, 0.0), low_right: at(right, 0.0), high_left: at(-1.0, 2.0) }
}

#[test]
fn truth_a_ray_ends_at_the_first_pane_before_its_end() {
    if skipped() {
        return;
    }
    let near = pane(&across(2.0, 1.0));
    let far = pane(&across(3.0, 1.0));
    let beside = pane(&across(1.0, -0.1));
    let behind = pane(&across(-1.0, 1.0));
    let depth = |panes: &[Pane], depth: f32| run(&one_pixel(), ahead(), panes, &[depth], false)[0];
    assert_eq!(depth(&[], 4.0), 4.0);
    assert_close("depth", &[depth(&[far, near], 4.0)], &[-2.0], DEPTH);
    assert_close("depth", &[depth(&[far], 4.0)], &[-3.0], DEPTH);
    assert_eq!(depth(&[near], 1.9), 1.9, "it ends before the pane");
    assert_eq!(depth(&[beside, behind], 4.0), 4.0);
    assert_eq!(depth(&[near], 0.0), 0.0, "no depth");
    let turned = Pane { normal: -near.normal, ..near };
    let extent = turned.extent_m;
    let turned = Pane { extent_m: Vec4::new(extent.x, extent.y, -extent.w, -extent.z), ..turned };
    assert_close("from its other side", &[depth(&[turned], 4.0)], &[-2.0], DEPTH);
    assert_eq!(depth(&[Pane { id: 0, ..near }], 4.0), 4.0);
}

#[test]
fn twin_on_random_panes() {
    if skipped() {
        return;
    }
    let lens =
        CameraModel { distortion: Distortion::PlumbBob([0.1, -0.05, 1e-3, 2e-3, 0.01]), ..tiny_camera() };
    let mut random = Random(41);
    for (camera, distorted) in [(tiny_camera(), false), (tiny_camera(), true), (lens, true)] {
        let mut within = |low: f64, high: f64| low + (high - low) * f64::from(random.unit());
        let panes: Vec<Corners> = (0..12)
            .map(|_| {
                let low_left = DVec3::new(within(0.5, 4.0), within(-2.0, 1.0), within(-0.5, 0.5));
                let along = DVec3::new(within(-1.0, 1.0), within(0.5, 2.0), 0.0);
                let up = DVec3::Z * within(0.5, 2.0);
                Corners { low_left, low_right: low_left + along, high_left: low_left + up }
            })
            .collect();
        let local_from_camera = Rigid { translation_m: DVec3::new(-0.2, 0.3, 0.9), ..ahead() };
        let depth_m: Vec<f32> = (0..80 * 60).map(|_| within(0.0, 6.0) as f32).collect();
        let shader: Vec<Pane> = panes.iter().map(pane).collect();
        let got = run(&camera, local_from_camera, &shader, &depth_m, distorted);
        let (mut sure, mut want, mut clipped) = (Vec::new(), Vec::new(), 0);
        for (pixel, (&got, &depth)) in got.iter().zip(&depth_m).enumerate() {
            let [x, y] = camera.ray((pixel % 80) as f64, (pixel / 80) as f64).unwrap();
            let end = local_from_camera.transform_point(DVec3::new(x, y, 1.0) * f64::from(depth));
            let eye = local_from_camera.translation_m;
            let Some(twin) = clipped_m(&panes, eye, end, depth.into(), 1e-3) else { continue };
            sure.push(got);
            want.push(twin);
            clipped += usize::from(twin < 0.0);
        }
        assert!(
            sure.len() > 4500 && clipped > 400 && clipped + 400 < sure.len(),
            "{clipped} of {}",
            sure.len()
        );
        assert_close("depth", &sure, &want, DEPTH);
    }
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    let near = pane(&across(2.0, 1.0));
    for width in [1, 63, 64, 65] {
        let camera = CameraModel { width, fx: 1e4, ..one_pixel() };
        let got = run(&camera, ahead(), &[near], &vec![4.0; width as usize], false);
        assert_close("depth", &got, &vec![-2.0; width as usize], DEPTH);
    }
}

#[test]
fn poison_leaves_depths_as_they_are() {
    if skipped() {
        return;
    }
    let near = pane(&across(2.0, 1.0));
    let poison = [
        Pane { normal: Vec4::NAN, ..near },
        Pane { level: Vec4::INFINITY, ..near },
        Pane { extent_m: Vec4::NAN, ..near },
        Pane { normal: Vec4::ZERO, ..near },
        Pane { normal: Vec4::new(0.0, 1.0, 0.0, 0.5), ..near },
        Pane { extent_m: Vec4::new(1.0, -1.0, 1.0, -1.0), ..near },
    ];
    let camera = CameraModel { width: 4, ..one_pixel() };
    let depth_m = [4.0, 1e-30, 65.535, 0.0];
    assert_eq!(run(&camera, ahead(), &poison, &depth_m, true), depth_m);
}
