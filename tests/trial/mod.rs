//! Navigation trials: ways, the robot, the loop in worlds where it is known what must happen, records, tables, the page.

mod course;
mod drives;
mod impossible;
mod parts;
mod tables;

use glam::DVec2;
use limpid::Config;
use limpid::config::{GroundSource, Method};
use limpid::offline::trial::{Label, Limits, Pose, Record, Setup, Terms, World, drive};
use limpid::sim::Scene;
use limpid::sim::scene::Room;

use crate::sim::small_room;

/// A hall from (-1, -2) to (7, 2) that a small camera with a wide baseline sees well.
fn hall() -> Scene {
    let mut scene = small_room();
    scene.rooms = vec![Room { min_m: [-1.0, -2.0], max_m: [7.0, 2.0], walls: "walls".into() }];
    scene.trajectory.rate_hz = 10.0;
    scene.camera.baseline_m = 0.3;
    scene.camera.pitch_rad = 0.3;
    scene
}

fn config() -> Config {
    let limits = Limits::default();
    Config {
        method: Method::Range,
        ground: GroundSource::Stated,
        inscribed_radius_m: limits.radius_m,
        rate_independent: true,
        ..Config::default()
    }
}

fn setup(config: Config) -> Setup {
    Setup { key: "range", camera: Some(config.clone()), lidar: None, one_ring: false, config }
}

/// From the origin, looking along x.
fn world(scene: &Scene, goal: [f64; 2]) -> World {
    let start = Pose { at: DVec2::ZERO, yaw: 0.0 };
    World::new(scene, start, DVec2::from_array(goal), &Limits::default(), &config()).unwrap()
}

fn label() -> Label {
    Label { scenario: "test".into(), level: "L0".into(), seed: 1 }
}

fn driven(world: &World, config: Config, terms: Terms) -> Record {
    let context = crate::support::gpu::context();
    drive(&context, world, &setup(config), &Limits::default(), terms, &label()).unwrap()
}
