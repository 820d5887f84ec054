//! The simulated camera: rays, light, stereo, truth, scenes, recordings.

mod bad_input;
mod clear;
mod generate;
mod lidar;
mod light;
mod matching;
mod rays;
mod recording;
mod stereo;
mod sun;
mod truth;
mod walkers;
mod written;

use limpid::sensor::FramePose;
use limpid::sim::frame::SimFrame;
use limpid::sim::material::{Material, Pattern};
use limpid::sim::scene::{Ambient, Block, Room, Scene, Trajectory};
use limpid::sim::settings::{Camera, Imager, Matcher};
use limpid::sim::{Simulator, poses};

/// Walls with a fine pattern that both imagers see well.
pub(crate) fn textured(scale_m: f64) -> Material {
    Material {
        kind: limpid::sim::material::Kind::Textured,
        albedo: [0.8; 3],
        albedo_ir: 0.8,
        pattern: Pattern::Clouds,
        pattern_albedo: [0.1; 3],
        pattern_albedo_ir: 0.1,
        pattern_scale_m: scale_m,
        ..Material::default()
    }
}

/// A room from (-3, -2) to (3, 2), 128x96 pixels, the robot at the origin looking along x, level.
pub(crate) fn small_room() -> Scene {
    let (min_m, max_m) = ([-3.0, -2.0], [3.0, 2.0]);
    let trajectory = Trajectory {
        waypoints_m: vec![[0.0, 0.0]],
        yaw_rad: 0.0,
        step_m: 0.04,
        turn_rad: 0.05,
        rate_hz: 30.0,
        frames: 1,
        clearance_m: 0.3,
    };
    Scene {
        name: "small room".into(),
        seed: 1,
        materials: [
            ("walls".into(), textured(0.3)),
            ("floor".into(), textured(0.2)),
            ("plain".into(), Material::default()),
            ("mirror".into(), Material::mirror()),
            ("glass".into(), Material::glass()),
        ]
        .into(),
        floor: "floor".into(),
        ceiling: "plain".into(),
        ceiling_m: 2.5,
        rooms: vec![Room { min_m, max_m, walls: "walls".into() }],
        boxes: vec![],
        cylinders: vec![],
        walkers: vec![],
        panes: vec![],
        thickets: vec![],
        curtains: vec![],
        open_air: false,
        vessels: vec![],
        sun: None,
        lidar: None,
        lamps: vec![],
        windows: vec![],
        ambient: Ambient { color: [0.5; 3], infrared: 0.5 },
        trajectory,
        camera: Camera {
            width: 128,
            height: 96,
            height_m: 0.5,
            forward_m: 0.0,
            pitch_rad: 0.0,
            baseline_m: 0.05,
        },
        imager: Imager::default(),
        matcher: Matcher::default(),
    }
}

pub(crate) fn a_box(center_m: [f64; 3], size_m: [f64; 3]) -> Block {
    Block { center_m, size_m, yaw_rad: 0.0, material: "walls".into() }
}

/// The first pose of the scene's way.
fn first_pose(scene: &Scene) -> FramePose {
    poses(scene)[0]
}

/// The first frame of a scene.
fn look(scene: &Scene) -> SimFrame {
    let mut simulator = Simulator::open(scene, None, false).unwrap();
    simulator.frame(0, first_pose(scene)).unwrap()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Values of the pixels whose place (as shares of width and height) lies in the middle `share` of the image.
fn middle<T: Copy>(frame: &SimFrame, values: &[T], share: f64) -> Vec<T> {
    let (w, h) = (f64::from(frame.width), f64::from(frame.height));
    let inside = |i: u32| {
        let (x, y) = (f64::from(i % frame.width) + 0.5, f64::from(i / frame.width) + 0.5);
        (x / w - 0.5).abs() < share / 2.0 && (y / h - 0.5).abs() < share / 2.0
    };
    (0..frame.width * frame.height).filter(|&i| inside(i)).map(|i| values[i as usize]).collect()
}

/// Records a short drive through the small room with its truth; matt walls with a fine pattern, so that stereo sees them well.
pub(crate) fn record_small_room(path: &std::path::Path, frames: u32) {
    let mut scene = small_room();
    scene.trajectory.waypoints_m = vec![[-1.0, 0.0], [0.5, 0.3]];
    scene.trajectory.frames = frames;
    scene.camera.baseline_m = 0.3;
    let mut simulator = Simulator::open(&scene, None, false).unwrap();
    let mut recorder = limpid::sim::write::recorder(path, &scene, false).unwrap();
    let mut map = limpid::sim::truth::TrueMap::new(&scene, &limpid::Config::default());
    for (index, pose) in (0..).zip(simulator.poses()) {
        let frame = simulator.frame(index, pose).unwrap();
        map.observe(&frame, &scene.camera.model());
        recorder.write(&frame, &map.grid(), &map.cells()).unwrap();
    }
    recorder.finish().unwrap();
}
