//! What surfaces do with light: Fresnel, panes, exposure, noise.

use limpid::gpu::{Invocations, ShaderSource};
use limpid::sim::SimScene;
use limpid::sim::passes::{
    EXPOSE, METER, RANDOM_LIBRARY, SCENE_LIBRARY, SHADE_LIBRARY, SOLIDS_LIBRARY, SimExposeParams,
    SimMeterParams,
};
use limpid::sim::scene::{Lamp, Window};

use super::{look, small_room};
use crate::support::compare::{Tolerance, assert_close, compare};
use crate::support::gpu::{Fragment, skipped};

const PROBE: ShaderSource = ShaderSource {
    name: "probe",
    parts: &[
        SCENE_LIBRARY,
        SOLIDS_LIBRARY,
        RANDOM_LIBRARY,
        SHADE_LIBRARY,
        "
@group(0) @binding(0) var<uniform> scene: SimScene;
@group(0) @binding(1) var<storage, read> cosines: array<f32>;
@group(0) @binding(2) var<storage, read_write> shares: array<vec4<f32>>;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&cosines) {
        let glass = fresnel(0.04, cosines[id.x]);
        let lamp = lamp_light(0u, vec3(0.0, cosines[id.x], 0.0), vec3(0.0, 0.0, 1.0));
        shares[id.x] = vec4(glass, fresnel(0.15, cosines[id.x]), pane_reflectance(glass), lamp.w);
    }
}
",
    ],
};

const SINGLE: Tolerance = Tolerance { absolute: 1e-5, reason: "a few operations in single precision" };

#[test]
fn truth_of_fresnel_panes_and_lamps() {
    if skipped() {
        return;
    }
    let mut scene = small_room();
    let center_m = [0.0, 0.0, 2.0];
    scene.lamps.push(Lamp { center_m, size_m: [0.2, 0.5], color: [1.0; 3], infrared: 8.0 });
    let cosines = [1.0_f32, 0.866_025_4, 0.5, 0.173_648_2, 0.0];
    let got = Fragment::new()
        .params("scene", &SimScene::pack(&scene))
        .input("cosines", &cosines)
        .output("shares", 4 * cosines.len())
        .run(PROBE, Invocations::line(cosines.len() as u32))
        .floats("shares");
    let want: Vec<f64> = cosines
        .iter()
        .flat_map(|&cosine| {
            let schlick = |f0: f64| f0 + (1.0 - f0) * (1.0 - f64::from(cosine)).powi(5);
            let glass = schlick(0.04);
            // Light goes to and fro between the faces: a geometric series.
            let pane = (0..200).map(|k| (1.0 - glass).powi(2) * glass.powi(2 * k + 1)).sum::<f64>() + glass;
            let squared = 4.0 + f64::from(cosine).powi(2);
            let area = 0.1 / std::f64::consts::PI;
            [glass, schlick(0.15), pane, 8.0 * area * (4.0 / squared) / (squared + area)]
        })
        .collect();
    assert_close("light", &got, &want, SINGLE);
    assert!((want[2] - 2.0 * 0.04 / 1.04).abs() < 1e-9, "both faces of a pane");
    let mut wrong = want.clone();
    wrong[0] = 0.05;
    assert!(compare("light", &got, &wrong, SINGLE).is_err());
}

fn exposure(image: &[f32], wanted_mean: f32) -> f32 {
    let params = SimMeterParams {
        width: 16,
        height: 8,
        step: 1,
        wanted_mean,
        largest_gain: 50.0,
        bias: 1.0,
        pad0: 0,
        pad1: 0,
    };
    let fragment = Fragment::new().params("meter_params", &params).input("image", image).output("gain", 1);
    fragment.run(METER, Invocations::line(1)).floats("gain")[0]
}

#[test]
fn exposure_brings_the_clipped_mean_to_what_is_wanted() {
    if skipped() {
        return;
    }
    // Half at 0.1, half far beyond saturation at any gain that matters: 0.5 + 0.5 * 0.1 g = 0.75.
    let image: Vec<f32> = (0..128).map(|i| if i % 2 == 0 { 0.1 } else { 100.0 }).collect();
    let gain = exposure(&image, 0.75);
    assert!((gain - 5.0).abs() < 0.05, "{gain}");
    let gain = exposure(&[0.1; 128], 0.3);
    assert!((gain - 3.0).abs() < 0.03, "{gain}");
    assert_eq!(exposure(&[0.0; 128], 0.3), 50.0, "darkness gets all the gain there is");
    let poisoned = exposure(&[f32::MAX; 128], 0.3);
    assert!(poisoned.is_finite() && poisoned >= 0.0, "{poisoned}");
}

#[test]
fn noise_has_the_deviation_of_its_electrons_and_saturation_clips() {
    if skipped() {
        return;
    }
    let levels = |signal: f32, electrons: f32, full_gain: f32| -> Vec<f64> {
        let words = 2048;
        let read_noise = 0.0;
        let params =
            SimExposeParams { words, seed: 7, electrons, read_noise, full_gain, pad0: 0, pad1: 0, pad2: 0 };
        let out = Fragment::new()
            .params("expose_params", &params)
            .input("infrared", &vec![signal; 4 * words as usize])
            .input("gain", &[2.0_f32])
            .output("grey", words as usize)
            .run(EXPOSE, Invocations::line(words));
        out.words("grey").iter().flat_map(|word| word.to_le_bytes()).map(f64::from).collect()
    };
    let moments = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
        (mean, variance.sqrt())
    };
    // Half of full scale; shot noise sqrt(0.5 / 1000) of it, and rounding of 1/sqrt(12) level.
    let (mean, deviation) = moments(&levels(0.25, 1000.0, 10.0));
    let want = (0.5_f64 / 1000.0).sqrt() * 255.0;
    assert!((mean - 127.5).abs() < 0.3, "{mean}");
    assert!((deviation / want - 1.0).abs() < 0.03, "{deviation} for {want}");
    // Amplified twice beyond full exposure: half the electrons.
    let (_, amplified) = moments(&levels(0.25, 1000.0, 1.0));
    assert!((amplified / want - 2.0_f64.sqrt()).abs() < 0.05, "{amplified}");
    assert!(levels(5.0, 1000.0, 10.0).iter().all(|&level| level == 255.0));
}

#[test]
fn lamps_cast_shadows_and_windows_saturate() {
    if skipped() {
        return;
    }
    let mut scene = small_room();
    scene.materials.insert("floor".into(), limpid::sim::material::Material::diffuse([0.5; 3], 0.5));
    scene.ambient.color = [0.02; 3];
    scene.camera.pitch_rad = 0.4;
    let center_m = [1.5, 0.0, 2.4];
    scene.lamps.push(Lamp { center_m, size_m: [0.3, 0.3], color: [20.0; 3], infrared: 1.0 });
    let lit = look(&scene);
    scene.boxes.push(super::a_box([1.5, 0.0, 1.2], [0.8, 0.8, 0.04]));
    let shaded = look(&scene);
    let at = (45 * 128 + 64) * 3;
    // Exposure differs: compare the floor under the board with the floor beside it.
    let beside = (45 * 128 + 4) * 3;
    let ratio =
        |frame: &limpid::sim::frame::SimFrame| f64::from(frame.rgb[at]) / f64::from(frame.rgb[beside]);
    assert!(ratio(&lit) > 1.0 && ratio(&shaded) < 0.7, "{} {}", ratio(&lit), ratio(&shaded));

    let mut scene = small_room();
    let center_m = [2.99, 0.0, 0.5];
    let color = [30.0; 3];
    let yaw_rad = std::f64::consts::PI;
    scene.windows.push(Window { center_m, width_m: 0.8, height_m: 0.8, yaw_rad, color, infrared: 40.0 });
    let frame = look(&scene);
    let center = 48 * 128 + 64;
    assert_eq!(frame.infrared_left[center], 255);
    assert_eq!(frame.rgb[3 * center..3 * center + 3], [255; 3]);
    assert_eq!(frame.material[center], limpid::sim::material::Kind::Window.code());
    assert_eq!(frame.depth_mm[center], 0, "nothing to match in a saturated window");
}
