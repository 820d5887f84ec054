//! Sunlight through a window: a patch where geometry says, shadowed by what stands in its way.

use glam::DVec3;
use limpid::sim::frame::SimFrame;
use limpid::sim::material::Material;
use limpid::sim::scene::{Pane, Scene, Window};
use limpid::sim::sun::Sun;

use super::{a_box, look, small_room};
use crate::support::gpu::skipped;

const YAW_RAD: f64 = 0.35;
const ELEVATION_RAD: f64 = 0.6;

/// A grey room with a dim window ahead, the sun behind it, and the camera looking at the floor.
fn sunny_room() -> Scene {
    let mut scene = small_room();
    for name in ["floor", "walls"] {
        scene.materials.insert(name.into(), Material::diffuse([0.5; 3], 0.5));
    }
    scene.ambient.color = [0.1; 3];
    scene.camera.pitch_rad = 0.5;
    scene.camera.height_m = 1.2;
    let center_m = [2.996, 0.8, 1.2];
    let (yaw_rad, color) = (std::f64::consts::PI, [0.1; 3]);
    scene.windows.push(Window { center_m, width_m: 0.8, height_m: 0.8, yaw_rad, color, infrared: 0.1 });
    let (yaw_rad, elevation_rad) = (YAW_RAD, ELEVATION_RAD);
    scene.sun = Some(Sun { yaw_rad, elevation_rad, color: [3.0; 3], infrared: 3.0 });
    scene
}

/// Places of the pixels that see the floor, with their brightness.
fn floor(scene: &Scene, frame: &SimFrame) -> Vec<(DVec3, u8)> {
    let model = scene.camera.model();
    let axes = frame.pose.map_from_base.then(frame.pose.base_from_camera);
    let place = |i: usize| {
        let (u, v) = ((i % 128) as f64, (i / 128) as f64);
        let ray = DVec3::new((u - model.cx) / model.fx, (v - model.cy) / model.fy, 1.0);
        axes.transform_point(ray * f64::from(frame.true_depth_m[i]))
    };
    let all = (0..frame.material.len()).map(|i| (place(i), frame.rgb[3 * i + 1]));
    all.filter(|(at, _)| at.z.abs() < 1e-3).collect()
}

/// How far inside the window (negative: outside) the sun's ray to a place passes, metres.
fn depth_in_window(at: DVec3) -> f64 {
    let (sine, cosine) = ELEVATION_RAD.sin_cos();
    let sun = DVec3::new(YAW_RAD.cos() * cosine, YAW_RAD.sin() * cosine, sine);
    let through = at + sun * ((2.996 - at.x) / sun.x);
    (0.4 - (through.y - 0.8).abs()).min(0.4 - (through.z - 1.2).abs())
}

#[test]
fn truth_of_a_sun_patch() {
    if skipped() {
        return;
    }
    let mut scene = sunny_room();
    let sunny = floor(&scene, &look(&scene));
    let (mut lit, mut dark) = (0, 0);
    for (at, value) in &sunny {
        let depth_m = depth_in_window(*at);
        if depth_m.abs() > 0.04 {
            assert_eq!(*value > 150, depth_m > 0.0, "{value} at {at}, {depth_m} m inside");
            (lit, dark) = (lit + usize::from(depth_m > 0.0), dark + usize::from(depth_m < 0.0));
        }
    }
    assert!(lit > 100 && dark > 1000, "{lit} pixels in the patch, {dark} outside");
    // A board takes the patch away, a pane does not.
    let before = |scene: &Scene| floor(scene, &look(scene)).iter().filter(|(_, value)| *value > 150).count();
    let center_m = [2.9, 0.8, 1.2];
    let yaw_rad = std::f64::consts::PI;
    let pane =
        |material: &str| Pane { center_m, width_m: 2.0, height_m: 2.0, yaw_rad, material: material.into() };
    scene.panes.push(pane("glass"));
    assert!(before(&scene) > 100, "{} pixels behind a pane", before(&scene));
    scene.panes[0] = pane("plain");
    let sun = scene.sun.take();
    let shade = look(&scene);
    scene.sun = sun;
    assert_eq!(look(&scene).rgb, shade.rgb, "a board before the window");
}

#[test]
fn the_sun_of_the_open_sky_shines_everywhere_but_in_shadows() {
    if skipped() {
        return;
    }
    let mut scene = sunny_room();
    scene.windows.clear();
    scene.open_air = true;
    scene.boxes.push(a_box([1.6, 0.0, 0.6], [0.1, 0.3, 0.1]));
    let values = floor(&scene, &look(&scene));
    // The box' shadow falls towards the robot.
    let (sine, cosine) = ELEVATION_RAD.sin_cos();
    let reach = 0.6 * cosine / sine;
    let shadow = DVec3::new(1.6 - YAW_RAD.cos() * reach, -YAW_RAD.sin() * reach, 0.0);
    let mean = |near: bool| {
        let some = values
            .iter()
            .filter(|(at, _)| if near { at.distance(shadow) < 0.06 } else { at.distance(shadow) > 0.6 });
        let some: Vec<f64> = some.map(|(_, value)| f64::from(*value)).collect();
        some.iter().sum::<f64>() / some.len() as f64
    };
    assert!(mean(true) < 0.5 * mean(false), "{} in the shadow, {} beside", mean(true), mean(false));
}
