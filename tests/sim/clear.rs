//! Clear bodies: vessels and boxes met from outside and inside, Snell's law, total reflection, fillings, crumples.

use glam::{DVec3, Vec4};
use limpid::gpu::{Invocations, ShaderSource};
use limpid::sim::SimScene;
use limpid::sim::material::{Kind, Material};
use limpid::sim::passes::{RANDOM_LIBRARY, SCENE_LIBRARY, SHADE_LIBRARY, SOLIDS_LIBRARY};
use limpid::sim::scene::{Scene, Window};
use limpid::sim::truth::{GLASS, TrueMap};
use limpid::sim::vessel::Vessel;

use super::{a_box, look, small_room};
use crate::reference::sim::nearest_hit;
use crate::support::compare::{Tolerance, assert_close, compare};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

/// Follows a ray through two surfaces: what it meets, and where it goes behind both.
const PROBE: ShaderSource = ShaderSource {
    name: "probe",
    parts: &[
        SCENE_LIBRARY,
        SOLIDS_LIBRARY,
        RANDOM_LIBRARY,
        SHADE_LIBRARY,
        "
@group(0) @binding(0) var<uniform> scene: SimScene;
@group(0) @binding(1) var<storage, read> rays: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> met: array<vec4<f32>>;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) / 2u {
        return;
    }
    var at = rays[id.x * 2u].xyz;
    var direction = rays[id.x * 2u + 1u].xyz;
    for (var k = 0u; k < 2u; k++) {
        let hit = nearest_hit(at, direction);
        at += hit.t * direction;
        let smooth_one = surface_at(hit, at, direction);
        let surface = crumpled(smooth_one, at, direction);
        let mirrored = interface_reflectance(surface.ratio, max(-dot(direction, surface.normal), 0.0));
        met[id.x * 4u + k] = vec4(surface.normal, hit.t);
        direction = select(refracted(direction, surface), reflect(direction, surface.normal), mirrored >= 1.0);
        met[id.x * 4u + 2u + k] = vec4(direction, mirrored);
    }
}
",
    ],
};

const SINGLE: Tolerance =
    Tolerance { absolute: 3e-4, reason: "single precision at a metre, indices in 1/16384" };

fn probed(scene: &Scene, rays: &[(DVec3, DVec3)]) -> Vec<f32> {
    let row = |v: DVec3| v.extend(0.0).as_vec4();
    let data: Vec<Vec4> = rays.iter().flat_map(|&(o, d)| [row(o), row(d.normalize())]).collect();
    Fragment::new()
        .params("scene", &SimScene::pack(scene))
        .input("rays", &data)
        .output("met", rays.len() * 16)
        .run(PROBE, Invocations::line(rays.len() as u32))
        .floats("met")
}

pub(crate) fn vessel(base_m: [f64; 3], profile_m: &[[f64; 2]], material: &str) -> Vessel {
    Vessel { base_m, profile_m: profile_m.to_vec(), material: material.into(), fill_m: None, contents: None }
}

fn drum(radius_m: f64, height_m: f64) -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [radius_m, 0.0], [radius_m, height_m], [0.0, height_m]]
}

/// A room with solid glass, a cone and a drum of it.
fn clear_room() -> Scene {
    let mut scene = small_room();
    scene.materials.insert("body".into(), Material::clear(1.5));
    scene.vessels.push(vessel([1.0, 0.0, 0.0], &drum(0.2, 1.0), "body"));
    scene.vessels.push(vessel([-1.0, 0.0, 0.5], &[[0.3, 0.0], [0.1, 0.4]], "glass"));
    scene
}

#[test]
fn truth_of_rays_at_cones_and_discs_from_both_sides() {
    if skipped() {
        return;
    }
    let slope = 0.2_f64.atan2(0.4);
    let rays = [
        (DVec3::new(0.0, 0.0, 0.5), DVec3::X), // the drum's side, then through it
        (DVec3::new(1.1, 0.0, 2.0), -DVec3::Z), // its lid at z = 1, then its bottom
        (DVec3::new(0.0, 0.0, 0.7), -DVec3::X), // the cone at half its height, then its far wall from inside
        (DVec3::new(-1.0, 0.0, 0.6), DVec3::X), // the cone from inside, then the drum
        (DVec3::new(-1.05, 0.0, 2.0), -DVec3::Z), // into the open cone: the floor, then nothing but the floor's other side
    ];
    let got = probed(&clear_room(), &rays);
    let met = |ray: usize, hit: usize| -> Vec<f32> { got[16 * ray + 4 * hit..][..4].to_vec() };
    let out = [slope.cos(), 0.0, slope.sin()];
    let want: [(usize, usize, [f64; 4]); 8] = [
        (0, 0, [-1.0, 0.0, 0.0, 0.8]),
        (0, 1, [-1.0, 0.0, 0.0, 0.4]),
        (1, 0, [0.0, 0.0, 1.0, 1.0]),
        (1, 1, [0.0, 0.0, 1.0, 1.0]),
        (2, 0, [out[0], 0.0, out[2], 0.8]),
        (2, 1, [out[0], 0.0, -out[2], 0.4]),
        (3, 0, [-out[0], 0.0, -out[2], 0.25]),
        (4, 0, [0.0, 0.0, 1.0, 2.0]),
    ];
    for (ray, hit, row) in want {
        assert_close(&format!("ray {ray}, hit {hit}"), &met(ray, hit), &row, SINGLE);
    }
}

#[test]
fn twin_of_random_rays_at_vessels() {
    if skipped() {
        return;
    }
    let mut scene = small_room();
    let profile =
        [[0.0, 0.0], [0.3, 0.1], [0.5, 0.5], [0.2, 0.9], [0.2, 1.2], [0.15, 1.2], [0.15, 0.9], [0.0, 0.3]];
    scene.vessels.push(vessel([1.0, 0.2, 0.3], &profile, "glass"));
    scene.vessels.push(vessel([-0.7, -0.4, 0.2], &profile, "plain"));
    let mut random = Random(9);
    let mut within = |a: f64, b: f64| a + (b - a) * f64::from(random.unit());
    let rays: Vec<_> = (0..3000)
        .map(|_| {
            let origin = DVec3::new(within(-1.2, 1.4), within(-0.8, 0.8), within(0.1, 1.6));
            (origin, DVec3::new(within(-1.0, 1.0), within(-1.0, 1.0), within(-0.6, 0.6)).normalize())
        })
        .collect();
    let got = probed(&scene, &rays);
    let (mut kept, mut want) = (Vec::new(), Vec::new());
    for (hit, &(origin, direction)) in got.chunks_exact(16).zip(&rays) {
        let (t, normal) = nearest_hit(&scene, origin, direction).unwrap();
        // Within rounding of an edge either face may be met.
        let beside = |a: DVec3| nearest_hit(&scene, origin + 1e-4 * a, direction);
        let same = |other: Option<(f64, DVec3)>| {
            other.is_some_and(|(u, n)| (u - t).abs() < 3e-3 && n.distance(normal) < 0.02)
        };
        if [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z].map(beside).into_iter().all(same) {
            kept.extend_from_slice(&hit[..4]);
            want.extend([normal.x, normal.y, normal.z, t]);
        }
    }
    assert!(want.len() > 4 * 2000, "{} rays are far from edges", want.len() / 4);
    let grazing = Tolerance { absolute: 4e-3, reason: "curved normals in single precision" };
    assert_close("rays", &kept, &want, grazing);
    want[3] += 0.02;
    assert!(compare("rays", &kept, &want, grazing).is_err());
}

#[test]
fn truth_of_a_ray_through_a_solid_drum_by_snells_law() {
    if skipped() {
        return;
    }
    let (radius, index) = (0.2_f64, 1.5_f64);
    let offsets = [0.0, 0.02, -0.05, 0.1, -0.15, 0.19];
    let rays = offsets.map(|b| (DVec3::new(0.0, b, 0.5), DVec3::X));
    let got = probed(&clear_room(), &rays);
    for (ray, b) in offsets.into_iter().enumerate() {
        let turn = 2.0 * ((b / radius).asin() - (b / radius / index).asin());
        let want = [turn.cos(), -turn.sin(), 0.0];
        assert_close(&format!("offset {b}"), &got[16 * ray + 12..][..3], &want, SINGLE);
    }
    let straight: Vec<f64> = vec![1.0, 0.0, 0.0];
    assert!(compare("a drum bends", &got[16 * 3 + 12..][..3], &straight, SINGLE).is_err());
}

#[test]
fn an_empty_thin_wall_lets_rays_go_straight() {
    if skipped() {
        return;
    }
    let mut scene = clear_room();
    scene.vessels[0].material = "glass".into();
    let ray = (DVec3::new(0.0, 0.1, 0.5), DVec3::new(1.0, 0.03, 0.02));
    let got = probed(&scene, &[ray]);
    let want = ray.1.normalize().to_array();
    assert_close("behind both walls", &got[12..15], &want, SINGLE);
}

#[test]
fn truth_of_a_solid_block_it_shifts_rays_and_reflects_beyond_the_critical_angle() {
    if skipped() {
        return;
    }
    let mut scene = clear_room();
    scene.vessels.clear();
    let mut block = a_box([1.0, 0.0, 0.5], [0.4, 1.6, 0.9]);
    block.material = "body".into();
    scene.boxes.push(block);
    let angle = 0.6_f64;
    let inside = (angle.sin() / 1.5).asin();
    let rays = [
        (DVec3::new(0.0, -0.3, 0.5), DVec3::new(angle.cos(), angle.sin(), 0.0)),
        // From inside at 41 and 43 degrees off the normal; the critical angle is 41.8.
        (DVec3::new(1.0, 0.0, 0.5), DVec3::new(41_f64.to_radians().cos(), 41_f64.to_radians().sin(), 0.0)),
        (DVec3::new(1.0, 0.0, 0.5), DVec3::new(43_f64.to_radians().cos(), 43_f64.to_radians().sin(), 0.0)),
    ];
    let got = probed(&scene, &rays);
    assert_close("inside", &got[8..11], &[inside.cos(), inside.sin(), 0.0], SINGLE);
    assert_close("length inside", &got[7..8], &[0.4 / inside.cos()], SINGLE);
    assert_close("behind", &got[12..15], &[angle.cos(), angle.sin(), 0.0], SINGLE);
    let (below, above) = (got[16 + 11], got[32 + 11]);
    assert!(below > 0.1 && below < 1.0, "{below} at 41 degrees");
    assert!(above == 1.0 && got[32 + 8] < 0.0, "{above} at 43 degrees");
    // Head on both ways: ((n - 1) / (n + 1))^2.
    let got = probed(&scene, &[(DVec3::new(0.0, 0.0, 0.5), DVec3::X)]);
    assert_close("head on", &[got[11], got[15]], &[0.04, 0.04], SINGLE);
}

/// Brightness of each pixel of the middle row.
fn middle_row(scene: &Scene) -> Vec<u8> {
    let frame = look(scene);
    (0..128).map(|u| frame.rgb[3 * (48 * 128 + u) + 1]).collect()
}

#[test]
fn truth_of_a_window_seen_through_a_solid_drum() {
    if skipped() {
        return;
    }
    let mut scene = clear_room();
    scene.ambient.color = [0.1; 3];
    let center_m = [2.999, 0.5, 0.5];
    let yaw_rad = std::f64::consts::PI;
    let color = [30.0; 3];
    scene.windows.push(Window { center_m, width_m: 0.6, height_m: 0.9, yaw_rad, color, infrared: 1.0 });
    let bent = middle_row(&scene);
    scene.vessels[0].material = "glass".into();
    let straight = middle_row(&scene);
    let focal = 425.0 / 848.0 * 128.0;
    let (mut looked_at, mut lit) = (0, 0);
    for (u, (bent, straight)) in bent.into_iter().zip(straight).enumerate() {
        let angle = ((63.5 - u as f64) / focal).atan();
        let b = angle.sin();
        if b.abs() > 0.17 {
            continue;
        }
        // Where the ray meets the drum, how far it turns there, and where it ends on the wall.
        let turn = 2.0 * ((b / 0.2_f64).asin() - (b / 0.3_f64).asin());
        let out = angle - turn;
        // The ray that goes on keeps its distance b from the axis, on the other course.
        let foot = DVec3::new(1.0, 0.0, 0.0) + b * DVec3::new(-out.sin(), out.cos(), 0.0);
        let at_wall = foot.y + (2.999 - foot.x) * out.tan();
        let is_near_an_edge = ((at_wall - 0.5).abs() - 0.3).abs() < 0.06;
        if !is_near_an_edge {
            looked_at += 1;
            let wanted = (at_wall - 0.5).abs() < 0.3;
            lit += usize::from(wanted);
            assert_eq!(bent > 200, wanted, "column {u}: {bent}, the ray ends at y = {at_wall}");
        }
        let ends = 2.999 * angle.tan();
        if ((ends - 0.5_f64).abs() - 0.3).abs() > 0.06 {
            assert_eq!(straight > 200, (ends - 0.5).abs() < 0.3, "column {u} through thin walls");
        }
    }
    assert!(looked_at > 10 && lit >= 2 && lit < looked_at, "{lit} of {looked_at} columns");
}

#[test]
fn truth_of_a_filled_vessel() {
    if skipped() {
        return;
    }
    let mut scene = clear_room();
    scene.materials.insert("water".into(), Material::clear(1.33));
    let vessel = &mut scene.vessels[0];
    vessel.profile_m.pop();
    (vessel.material, vessel.fill_m, vessel.contents) = ("glass".into(), Some(0.6), Some("water".into()));
    scene.validate().unwrap();
    let slant = DVec3::new(0.1, 0.0, -1.0).normalize();
    let rays = [
        (DVec3::new(0.95, 0.0, 2.0), slant), // through the open top onto the water
        (DVec3::new(0.0, 0.1, 0.3), DVec3::X), // through the water
        (DVec3::new(0.0, 0.1, 0.8), DVec3::X), // above it
    ];
    let got = probed(&scene, &rays);
    assert_close("onto water", &got[..4], &[0.0, 0.0, 1.0, 1.4 / -slant.z], SINGLE);
    let sine = slant.x / 1.33;
    assert_close("in water", &got[8..11], &[sine, 0.0, -(1.0 - sine * sine).sqrt()], SINGLE);
    let turn = 2.0 * (0.5_f64.asin() - (0.5_f64 / 1.33).asin());
    assert_close("through water", &got[16 + 12..][..3], &[turn.cos(), -turn.sin(), 0.0], SINGLE);
    assert_close("above water", &got[32 + 12..][..3], &[1.0, 0.0, 0.0], SINGLE);
    // What is not clear shows through a thin wall.
    scene.vessels[0].contents = Some("plain".into());
    let frame = look(&scene);
    assert_eq!(frame.material[48 * 128 + 64], Kind::Diffuse.code());
}

#[test]
fn a_vessel_is_glass_in_truth_and_in_the_true_map() {
    if skipped() {
        return;
    }
    let mut scene = clear_room();
    scene.vessels.pop();
    let frame = look(&scene);
    assert_eq!(frame.material[48 * 128 + 64], Kind::Glass.code());
    assert!((frame.true_depth_m[48 * 128 + 64] - 0.8).abs() < 0.01, "{}", frame.true_depth_m[48 * 128 + 64]);
    let mut map = TrueMap::new(&scene, &limpid::Config::default());
    map.observe(&frame, &scene.camera.model());
    let grid = map.grid();
    let cell = |x_m: f64, y_m: f64| {
        let [x, y] =
            [(x_m - grid.origin_x_m) / grid.resolution_m, (y_m - grid.origin_y_m) / grid.resolution_m];
        map.all_cells()[y as usize * grid.width as usize + x as usize]
    };
    assert_eq!([cell(1.0, 0.0), cell(1.17, 0.0), cell(1.0, 0.4)], [GLASS, GLASS, limpid::sim::truth::FREE]);
}

#[test]
fn crumples_have_the_stated_slopes_and_stay_where_they_are() {
    if skipped() {
        return;
    }
    let mut scene = small_room();
    let bump = 0.2;
    scene.materials.insert("foil".into(), Material { bump, ..Material::foil() });
    scene.rooms[0].walls = "foil".into();
    let target = |k: u32| DVec3::new(3.0, -0.9 + 0.0037 * f64::from(k), 0.2 + 0.0023 * f64::from(k));
    let from = |origin: DVec3| -> Vec<_> { (0..480).map(|k| (origin, target(k) - origin)).collect() };
    let near = probed(&scene, &from(DVec3::new(0.5, 0.0, 0.7)));
    let far = probed(&scene, &from(DVec3::new(-0.5, 0.3, 0.9)));
    let slopes = |met: &[f32]| -> Vec<f64> {
        let slope = |m: &[f32]| [f64::from(m[1] / -m[0]), f64::from(m[2] / -m[0])];
        met.chunks_exact(16).flat_map(slope).collect()
    };
    let (a, b) = (slopes(&near), slopes(&far));
    let deviation = (a.iter().map(|s| s * s).sum::<f64>() / a.len() as f64).sqrt();
    assert!((deviation / bump - 1.0).abs() < 0.25, "{deviation}");
    let apart = a.iter().zip(&b).filter(|(a, b)| (*a - *b).abs() > 0.02).count();
    assert!(apart < a.len() / 50, "{apart} of {} slopes differ between two views", a.len());
}
