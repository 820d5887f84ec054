//! The simulated lidar: rays and echoes, thin things, families, recordings.

mod bad_input;
mod echo;
mod families;
mod glass;
mod packets;
mod recording;
mod thin;
mod walls;

use glam::{DQuat, DVec3};
use limpid::base::Rigid;
use limpid::sensor::Point;
use limpid::sim::Scene;
use limpid::sim::lidar::{Lidar, LidarModel, LidarSimulator, PointTruth, SimScan};
use limpid::sim::material::Material;

use super::small_room;
use crate::support::gpu::context;

/// The small room with plain walls that return half the light, and a lidar of 452 columns in its middle, 0.6 m up.
fn room_with_lidar() -> Scene {
    let mut scene = small_room();
    for name in ["walls", "floor", "plain"] {
        scene.materials.insert(name.into(), Material::diffuse([0.5; 3], 0.5));
    }
    scene.lidar = Some(Lidar { model: LidarModel::Vlp16, rate_hz: 40.0, ..Lidar::default() });
    scene
}

/// The robot at a place of the map, facing `yaw_rad`.
fn robot(x_m: f64, y_m: f64, yaw_rad: f64) -> Rigid {
    Rigid { rotation: DQuat::from_rotation_z(yaw_rad), translation_m: DVec3::new(x_m, y_m, 0.0) }
}

/// A scan of a robot that stands at the origin.
fn scan_of(scene: &Scene) -> SimScan {
    scan_from(scene, robot(0.0, 0.0, 0.0))
}

fn scan_from(scene: &Scene, pose: Rigid) -> SimScan {
    let mut simulator = LidarSimulator::with_context(scene, &context()).unwrap();
    simulator.scan(0, 1_000, |_| pose).unwrap()
}

/// Points with their truth.
fn pairs(scan: &SimScan) -> impl Iterator<Item = (&Point, &PointTruth)> {
    assert_eq!(scan.scan.points.len(), scan.truth.len());
    scan.scan.points.iter().zip(&scan.truth)
}

/// Where a point lies in the map, by the sensor's pose.
fn in_map(scene: &Scene, pose: Rigid, point: &Point) -> DVec3 {
    let mount = scene.lidar.as_ref().unwrap().base_from_lidar();
    pose.then(mount).transform_point(DVec3::from_array(point.position_m().map(f64::from)))
}
