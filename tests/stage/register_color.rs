//! Colour at the depth camera's pixels.

use glam::{DQuat, DVec3, Vec2, Vec4};
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::sensor::{CameraModel, Distortion};
use limpid::stage::camera::back_project::rays;
use limpid::stage::camera::register_color::{REGISTER_COLOR, RegisterColorParams};
use limpid::stage::rows;

use crate::reference::register_color::{Source, source};
use crate::support::camera_job::tiny_camera;
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

struct View<'a> {
    depth_camera: CameraModel,
    color_camera: CameraModel,
    color_from_depth: Rigid,
    depth_m: &'a [f32],
    rgb: &'a [u8],
    aligned: bool,
    present: bool,
}

impl View<'_> {
    fn params(&self) -> RegisterColorParams {
        let [x, y, z] = rows(self.color_from_depth);
        let k = self.color_camera.distortion.coefficients().map(|k| k as f32);
        let CameraModel { fx, fy, cx, cy, .. } = self.color_camera;
        RegisterColorParams {
            color_from_depth_x: x,
            color_from_depth_y: y,
            color_from_depth_z: z,
            lens_a: Vec4::new(k[0], k[1], k[2], k[3]),
            lens_b: Vec4::new(k[4], k[5], k[6], k[7]),
            focal_px: Vec2::new(fx as f32, fy as f32),
            centre_px: Vec2::new(cx as f32, cy as f32),
            color_width: self.color_camera.width,
            color_height: self.color_camera.height,
            pixels: self.depth_m.len() as u32,
            aligned: self.aligned.into(),
            present: self.present.into(),
            pad0: 0,
            pad1: 0,
            pad2: 0,
        }
    }

    fn fragment(&self) -> Fragment {
        let mut rgb = self.rgb.to_vec();
        rgb.resize(rgb.len().next_multiple_of(4), 0);
        Fragment::new()
            .constants(&[("fisheye", self.color_camera.distortion.is_fisheye())])
            .params("register_color_params", &self.params())
            .input("depth_m", self.depth_m)
            .input("rays", &rays(&self.depth_camera))
            .input("color_raw", &rgb)
            .output("color", self.depth_m.len())
    }

    fn run(&self) -> Vec<u32> {
        self.fragment()
            .run(REGISTER_COLOR, Invocations::line(self.depth_m.len() as u32))
            .words("color")
            .to_vec()
    }

    fn rgba(&self, x: u32, y: u32) -> u32 {
        let i = 3 * (y * self.color_camera.width + x) as usize;
        u32::from_le_bytes([self.rgb[i], self.rgb[i + 1], self.rgb[i + 2], 255])
    }
}

fn noise(camera: &CameraModel, seed: u64) -> Vec<u8> {
    let mut random = Random(seed);
    (0..camera.width * camera.height * 3).map(|_| random.next() as u8).collect()
}

fn aligned<'a>(camera: CameraModel, depth_m: &'a [f32], rgb: &'a [u8]) -> View<'a> {
    let color_from_depth = Rigid::IDENTITY;
    View {
        depth_camera: camera,
        color_camera: camera,
        color_from_depth,
        depth_m,
        rgb,
        aligned: true,
        present: true,
    }
}

#[test]
fn truth_aligned_colour_is_copied_and_absent_colour_is_black() {
    if skipped() {
        return;
    }
    let camera = CameraModel { width: 7, height: 5, ..tiny_camera() };
    let (rgb, depth) = (noise(&camera, 1), [0.0; 35]);
    let view = aligned(camera, &depth, &rgb);
    let want: Vec<u32> = (0..35).map(|i| view.rgba(i % 7, i / 7)).collect();
    assert_eq!(view.run(), want, "holes have colour too");
    assert_eq!(View { present: false, ..view }.run(), [0; 35]);
}

#[test]
fn truth_a_baseline_shifts_by_the_disparity() {
    if skipped() {
        return;
    }
    let camera = CameraModel { cx: 39.0, cy: 29.0, ..tiny_camera() };
    let (rgb, depth) = (noise(&camera, 2), vec![1.46; 80 * 60]);
    // 0.06 m at 1.46 m and 73 px: 3 px.
    let color_from_depth = Rigid { rotation: DQuat::IDENTITY, translation_m: DVec3::new(0.06, 0.0, 0.0) };
    let view = View { color_from_depth, aligned: false, ..aligned(camera, &depth, &rgb) };
    let want = |i: u32| if i % 80 < 77 { view.rgba(i % 80 + 3, i / 80) } else { 0 };
    assert_eq!(view.run(), (0..80 * 60).map(want).collect::<Vec<u32>>());
}

#[test]
fn twin_with_lenses_and_a_turned_camera() {
    if skipped() {
        return;
    }
    for lens in [
        Distortion::RationalPolynomial([0.2, -0.1, 1e-3, -5e-4, 0.02, 0.15, -0.05, 0.01]),
        Distortion::Fisheye([-0.03, 0.05, -0.02, 0.004]),
    ] {
        twin_with_lens(lens);
    }
}

fn twin_with_lens(lens: Distortion) {
    let color =
        CameraModel { width: 97, height: 51, fx: 80.0, fy: 82.0, cx: 47.0, cy: 26.0, distortion: lens };
    let depth_camera =
        CameraModel { distortion: Distortion::PlumbBob([0.05, -0.02, 0.0, 1e-3, 0.0]), ..tiny_camera() };
    let mut random = Random(3);
    let depth: Vec<f32> =
        (0..80 * 60).map(|_| if random.chance(0.1) { 0.0 } else { 0.2 + 5.0 * random.unit() }).collect();
    let rgb = noise(&color, 4);
    let color_from_depth = Rigid::new([0.015, -0.01, 0.1], [0.02, -0.05, 0.01, 1.0]).unwrap();
    let view = View {
        depth_camera,
        color_camera: color,
        color_from_depth,
        depth_m: &depth,
        rgb: &rgb,
        aligned: false,
        present: true,
    };
    let (mut sure, mut seen) = (0, 0);
    for (i, got) in (0..).zip(view.run()) {
        let want = match source(&depth_camera, &color, color_from_depth, i % 80, i / 80, depth[i as usize]) {
            Source::Pixel(x, y) => view.rgba(x, y),
            Source::Nowhere => 0,
            Source::Doubtful => continue,
        };
        assert_eq!(got, want, "pixel {i}, {lens:?}");
        (sure, seen) = (sure + 1, seen + u32::from(want != 0));
    }
    assert!(sure > 4750 && seen > 2000 && seen < sure, "{sure} sure, {seen} seen");
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    aligned(CameraModel { width: 1, height: 1, ..tiny_camera() }, &[1.0], &[1, 2, 3])
        .fragment()
        .refuses_nothing(REGISTER_COLOR);
    for width in [1, 63, 64, 65, 129] {
        let camera = CameraModel { width, height: 1, ..tiny_camera() };
        let (rgb, depth) = (noise(&camera, 5), vec![1.0; width as usize]);
        let view = aligned(camera, &depth, &rgb);
        assert_eq!(view.run(), (0..width).map(|x| view.rgba(x, 0)).collect::<Vec<u32>>());
    }
}

#[test]
fn poison_depth_and_rays_have_no_colour() {
    if skipped() {
        return;
    }
    let camera = CameraModel { width: 6, height: 1, ..tiny_camera() };
    let rgb = noise(&camera, 6);
    let depth = [0.0, -1.0, f32::NEG_INFINITY, f32::MAX, 1e30, -0.0];
    let away = Rigid { rotation: DQuat::from_rotation_y(1.5), translation_m: DVec3::ZERO };
    let view = View { color_from_depth: away, aligned: false, ..aligned(camera, &depth, &rgb) };
    assert_eq!(view.run(), [0; 6]);
    let blind = CameraModel { distortion: Distortion::PlumbBob([-9.0, 50.0, 0.0, 0.0, -400.0]), ..camera };
    let rays_outside = (0..6).filter(|&u| blind.ray(f64::from(u), 0.0).is_none()).count();
    assert!(rays_outside > 0, "the lens is meant to have no ray for some pixels");
    let view = View { depth_camera: blind, aligned: false, ..aligned(camera, &[1.0; 6], &rgb) };
    for (u, got) in (0..).zip(view.run()) {
        assert!(
            blind.ray(f64::from(u), 0.0).is_some() || got == 0,
            "pixel {u} has no ray and colour {got:x}"
        );
    }
}
