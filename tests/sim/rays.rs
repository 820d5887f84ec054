//! Where rays meet planes, boxes and cylinders.

use glam::{DVec3, Vec4};
use limpid::gpu::{Invocations, ShaderSource};
use limpid::sim::passes::{SCENE_LIBRARY, SOLIDS_LIBRARY};
use limpid::sim::scene::{Cylinder, Pane, Scene};
use limpid::sim::{SimScene, generate};

use super::{a_box, small_room};
use crate::reference::sim::nearest_hit;
use crate::support::compare::{Tolerance, assert_close, compare};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const PROBE: ShaderSource = ShaderSource {
    name: "probe",
    parts: &[
        SCENE_LIBRARY,
        SOLIDS_LIBRARY,
        "
@group(0) @binding(0) var<uniform> scene: SimScene;
@group(0) @binding(1) var<storage, read> rays: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> hits: array<vec4<f32>>;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) / 2u {
        return;
    }
    let origin = rays[id.x * 2u].xyz;
    let direction = rays[id.x * 2u + 1u].xyz;
    let hit = nearest_hit(origin, direction);
    let surface = surface_at(hit, origin + hit.t * direction, direction);
    hits[id.x] = vec4(surface.normal, hit.t);
}
",
    ],
};

const SINGLE: Tolerance =
    Tolerance { absolute: 2e-4, reason: "single precision over several metres, grazing rays included" };

/// Normal and distance along each ray.
fn hits(scene: &Scene, rays: &[(DVec3, DVec3)]) -> Vec<f32> {
    let row = |v: DVec3| v.extend(0.0).as_vec4();
    let data: Vec<Vec4> = rays.iter().flat_map(|&(o, d)| [row(o), row(d.normalize())]).collect();
    Fragment::new()
        .params("scene", &SimScene::pack(scene))
        .input("rays", &data)
        .output("hits", rays.len() * 4)
        .run(PROBE, Invocations::line(rays.len() as u32))
        .floats("hits")
}

/// A box ahead, a cylinder to the left, a pane to the right.
fn solids() -> Scene {
    let mut scene = small_room();
    scene.boxes.push(a_box([2.0, 0.0, 0.5], [0.5, 1.0, 1.0]));
    let base_m = [0.0, 1.5, 0.25];
    scene.cylinders.push(Cylinder { base_m, radius_m: 0.25, height_m: 0.5, material: "plain".into() });
    let center_m = [0.0, -1.5, 1.0];
    let yaw_rad = std::f64::consts::FRAC_PI_2;
    scene.panes.push(Pane { center_m, width_m: 1.0, height_m: 1.0, yaw_rad, material: "glass".into() });
    scene
}

#[test]
fn truth_of_rays_at_each_kind_of_solid() {
    if skipped() {
        return;
    }
    let from = DVec3::new(0.0, 0.0, 0.5);
    let rays = [
        (from, DVec3::X),                                        // the box's face at x = 1.75
        (from, DVec3::Y),                                        // the cylinder's side at y = 1.25
        (DVec3::new(0.0, 0.0, 1.0), -DVec3::Y),                  // the pane at y = -1.5
        (from, -DVec3::X),                                       // the wall at x = -3
        (from, -DVec3::Z),                                       // the floor
        (from, DVec3::Z),                                        // the ceiling
        (DVec3::new(0.1, 1.5, 2.0), -DVec3::Z),                  // the cylinder's upper cap at z = 0.75
        (DVec3::new(0.1, 1.5, 0.05), DVec3::Z),                  // its lower cap at z = 0.25
        (DVec3::new(2.0, 0.0, 2.0), -DVec3::Z),                  // the box's top at z = 1
        (DVec3::new(0.0, 0.0, 1.6), DVec3::new(0.0, -3.0, 0.4)), // over the pane, at the wall at y = -2
    ];
    let slant = DVec3::new(0.0, -3.0, 0.4).length() * 2.0 / 3.0;
    let want = [
        [-1.0, 0.0, 0.0, 1.75],
        [0.0, -1.0, 0.0, 1.25],
        [0.0, 1.0, 0.0, 1.5],
        [1.0, 0.0, 0.0, 3.0],
        [0.0, 0.0, 1.0, 0.5],
        [0.0, 0.0, -1.0, 2.0],
        [0.0, 0.0, 1.0, 1.25],
        [0.0, 0.0, -1.0, 0.2],
        [0.0, 0.0, 1.0, 1.0],
        [0.0, 1.0, 0.0, slant],
    ];
    assert_close("hits", &hits(&solids(), &rays), want.as_flattened(), SINGLE);
}

#[test]
fn twin_of_random_rays_through_turned_solids() {
    if skipped() {
        return;
    }
    let mut scene = solids();
    scene.boxes[0].yaw_rad = 0.7;
    scene.boxes.push(a_box([-1.5, 0.9, 0.3], [0.4, 0.3, 0.6]));
    scene.panes[0].yaw_rad = 1.1;
    for k in 0..9 {
        let turn = f64::from(k) * 0.7;
        let mut block = a_box([-2.2 + 0.5 * f64::from(k), -1.2, 1.5], [0.2, 0.3, 0.4]);
        block.yaw_rad = turn;
        scene.boxes.push(block);
    }
    let mut random = Random(5);
    let mut within = |a: f64, b: f64| a + (b - a) * f64::from(random.unit());
    let rays: Vec<_> = (0..2000)
        .map(|_| {
            let origin = DVec3::new(within(-0.6, 0.6), within(-0.5, 0.5), within(0.1, 1.1));
            let direction = DVec3::new(within(-1.0, 1.0), within(-1.0, 1.0), within(-0.6, 0.6));
            (origin, direction.normalize())
        })
        .collect();
    let got = hits(&scene, &rays);
    let (mut kept, mut want) = (Vec::new(), Vec::new());
    for (hit, &(origin, direction)) in got.chunks_exact(4).zip(&rays) {
        let (t, normal) = nearest_hit(&scene, origin, direction).unwrap();
        // Within rounding of an edge either face may be met.
        let beside = |a: DVec3| nearest_hit(&scene, origin + 1e-4 * a, direction).map(|(_, n)| n);
        if [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z]
            .map(beside)
            .iter()
            .all(|n| *n == Some(normal))
            || t > 1e3
        {
            kept.extend_from_slice(hit);
            want.extend([normal.x, normal.y, normal.z, t]);
        }
    }
    assert!(want.len() > 4 * 1500, "{} rays are far from edges", want.len() / 4);
    let grazing = Tolerance { absolute: 2e-3, reason: "curved normals in single precision" };
    assert_close("rays", &kept, &want, grazing);
    want[7] += 0.01;
    assert!(compare("rays", &kept, &want, grazing).is_err());
}

#[test]
fn edge_sizes_and_rays_along_the_axes() {
    if skipped() {
        return;
    }
    for count in [1, 63, 64, 65] {
        let rays = vec![(DVec3::new(0.0, 0.0, 0.5), DVec3::X); count];
        let want = [-1.0, 0.0, 0.0, 1.75].repeat(count);
        assert_close("equal rays", &hits(&solids(), &rays), &want, SINGLE);
    }
}

#[test]
fn poison_rays_end_as_numbers() {
    if skipped() {
        return;
    }
    // Inside a box, in a wall's plane, along an edge: whatever they meet, no pixel may be poisoned.
    let rays = [
        (DVec3::new(2.0, 0.0, 0.5), DVec3::X),
        (DVec3::new(3.0, 0.0, 0.5), DVec3::Y),
        (DVec3::new(0.0, 0.0, 0.0), DVec3::X),
        (DVec3::new(1.75, 0.5, 0.2), DVec3::Z),
    ];
    assert!(hits(&solids(), &rays).iter().all(|value| value.is_finite()));
}

#[test]
fn groups_hide_nothing() {
    if skipped() {
        return;
    }
    // A generated room has many groups; floor and furniture must be met as the plain list of solids has it.
    let level = generate::Level::L0;
    let mut scene = generate::generate(generate::Family::Train, level, 3, 2).unwrap();
    scene.lamps.clear();
    scene.ceiling_m = 2.5;
    scene.rooms.truncate(1);
    let room = &scene.rooms[0];
    let middle =
        DVec3::new((room.min_m[0] + room.max_m[0]) / 2.0, (room.min_m[1] + room.max_m[1]) / 2.0, 1.9);
    let rays: Vec<_> = (0..500)
        .map(|k| {
            (
                middle,
                DVec3::new(
                    (f64::from(k) * 0.37).cos(),
                    (f64::from(k) * 0.37).sin(),
                    -0.001 * f64::from(k) - 0.2,
                ),
            )
        })
        .map(|(o, d)| (o, d.normalize()))
        .collect();
    let got: Vec<f32> = hits(&scene, &rays).chunks_exact(4).map(|hit| hit[3]).collect();
    let want: Vec<f64> = rays.iter().map(|&(o, d)| nearest_hit(&scene, o, d).unwrap().0).collect();
    let near = got.iter().zip(&want).filter(|(g, w)| (f64::from(**g) - *w).abs() < 1e-3).count();
    assert!(near >= 495, "{near} of 500 rays end where the list of solids says");
}
