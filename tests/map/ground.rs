//! The ground and its edges, through the whole pipeline, on analytic scenes whose truth is known.

use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::config::{GroundSource, Method};
use limpid::map::{GroundFrom, Update};
use limpid::mapper::{Mapper, Options, SensorInfo};
use limpid::sensor::{
    CameraInfo, Columns, Dropped, FramePose, Observation, Point, ReturnType, RgbdFrame, Scan, SensorData,
    SensorPose, Strength,
};

use crate::support::gpu::skipped;
use crate::support::run::submit;
use crate::support::scene::{Block, Scene, frame, pose, small_camera};

pub(super) const DROP: u32 = 12;

pub(super) fn config() -> Config {
    Config { method: Method::Range, ..Config::default() }
}

pub(super) fn camera_mapper(config: &Config, first: &RgbdFrame) -> Mapper {
    let sensor = SensorInfo::camera(config, CameraInfo::of_frames([first]).unwrap());
    Mapper::open(config, &[sensor], &Options { layers: true, verdicts: true, ..Options::default() }).unwrap()
}

pub(super) fn updates(config: &Config, frames: &[RgbdFrame]) -> Vec<Update> {
    let mut mapper = camera_mapper(config, &frames[0]);
    let step = |frame: &RgbdFrame| {
        submit(&mut mapper, &Observation::of_frame(0, "map", frame.clone())).unwrap();
        mapper.wait().unwrap().unwrap()
    };
    frames.iter().map(step).collect()
}

/// Row of the rule at a place.
pub(super) fn row_at(update: &Update, x_m: f64, y_m: f64) -> u32 {
    let map = update.map.as_ref().unwrap();
    let [x, y] = map.grid.cell_at(x_m, y_m).unwrap();
    map.verdicts[(y * map.grid.width + x) as usize].row()
}

pub(super) fn drops(update: &Update) -> Vec<[f64; 2]> {
    let map = update.map.as_ref().unwrap();
    let cells = (0..map.grid.height).flat_map(|y| (0..map.grid.width).map(move |x| (x, y)));
    let drop = |&(x, y): &(u32, u32)| map.verdicts[(y * map.grid.width + x) as usize].row() == DROP;
    cells.filter(drop).map(|(x, y)| map.grid.centre_m(x, y)).collect()
}

/// Frames of a camera that stands still at `truly` and is placed at `told`.
pub(super) fn frames(scene: &Scene, truly: FramePose, told: FramePose, count: u64) -> Vec<RgbdFrame> {
    let seen = scene.frame(0, small_camera(), truly);
    (0..count).map(|index| frame(index, small_camera(), Some(told), seen.depth.samples.clone())).collect()
}

/// A camera 0.5 m above a base at (x, 0, z), that looks along +x and down.
pub(super) fn camera_at(x: f64, z: f64, pitch: f64) -> FramePose {
    let standing = pose(x, 0.0, 0.0, 0.5, pitch);
    FramePose {
        map_from_base: Rigid { translation_m: DVec3::new(x, 0.0, z), ..standing.map_from_base },
        ..standing
    }
}

/// A floor of height `z` as far as x = `edge`, a lower one at z = 0 beyond.
pub(super) fn platform(edge: f64, z: f64) -> Vec<Block> {
    vec![Block::new([-9.0, -9.0, -1.0], [edge, 9.0, z])]
}

#[test]
fn a_tilted_mount_leaves_the_floor_free_and_a_box_in_the_way() {
    if skipped() {
        return;
    }
    let scene = Scene::of(&[Block::new([2.0, -0.3, 0.0], [2.4, 0.3, 0.5])]);
    let truly = camera_at(0.0, 0.0, 0.3);
    let turn = DQuat::from_rotation_y(5.0_f64.to_radians());
    let base_from_camera = Rigid {
        rotation: turn * truly.base_from_camera.rotation,
        translation_m: truly.base_from_camera.translation_m,
    };
    let told = FramePose { base_from_camera, ..truly };
    let lethal_floor = |update: &Update| {
        let cells = (0..20).map(|k| row_at(update, 1.0 + 0.04 * f64::from(k), 0.3));
        cells.filter(|row| *row == 6 || *row == DROP).count() + drops(update).len()
    };
    let of = |ground: GroundSource| updates(&Config { ground, ..config() }, &frames(&scene, truly, told, 12));
    let estimated = of(GroundSource::Estimate);
    let last = estimated.last().unwrap();
    let ground = last.ground.unwrap();
    let plane = ground.plane.unwrap();
    assert!((plane.tilt_deg() - 5.0).abs() < 0.1 && (plane.below_m - 0.5).abs() < 5e-3, "{ground:?}");
    assert_eq!(
        (ground.from, ground.agrees, ground.seen, plane.messages),
        (GroundFrom::Seen, false, true, 12)
    );
    assert_eq!(lethal_floor(last), 0);
    let box_rows: Vec<u32> = (0..16).map(|k| row_at(last, 1.8 + 0.025 * f64::from(k), 0.05)).collect();
    assert!(box_rows.contains(&6), "the box stays in the way: {box_rows:?}");
    // Told as level, the far floor stands up as a wall, or lies too deep: the test can fail.
    let stated = of(GroundSource::Stated);
    let last = stated.last().unwrap();
    assert_eq!(last.ground, None);
    assert!(drops(last).is_empty(), "a stated ground has no drops");
    let map = last.map.as_ref().unwrap();
    let free = |update: &Update| {
        update.map.as_ref().unwrap().verdicts.iter().filter(|verdict| verdict.row() == 9).count()
    };
    assert!(map.verdicts.iter().any(|verdict| verdict.row() == 6) || free(last) < free(&estimated[11]));
}

#[test]
fn a_ramp_ahead_does_not_become_the_ground() {
    if skipped() {
        return;
    }
    // Steps too low to tell from a ramp of 9 degrees, from x = 1.6 on, that fill most of the view.
    let ramp: Vec<Block> = (0..80)
        .map(|k| {
            let x = 1.6 + 0.05 * f64::from(k);
            Block::new([x, -9.0, 0.0], [x + 6.0, 9.0, 0.16 * (x - 1.6) + 0.002])
        })
        .collect();
    let at = camera_at(0.0, 0.0, 0.2);
    let updates = updates(&config(), &frames(&Scene::of(&ramp), at, at, 6));
    let plane = updates[5].ground.unwrap().plane.expect("the floor before the ramp is seen");
    assert!(plane.tilt_deg() < 2.0 && (plane.below_m - 0.5).abs() < 0.04, "{plane:?}");
}

/// A spinning lidar of 32 rings, 1.2 m above a floor, tilted about x.
fn tilted_scan(index: u64, tilt: DQuat) -> Scan {
    scan(index, tilt, f64::INFINITY)
}

/// The same above a floor that ends at x = `edge`, with another 0.6 m below it beyond.
pub(super) fn scan(index: u64, tilt: DQuat, edge: f64) -> Scan {
    let walls = 6.0;
    let mut points = Vec::new();
    for column in 0..720_u16 {
        for ring in 0..32_u16 {
            let azimuth = f64::from(column).to_radians() / 2.0;
            let elevation = (-25.0 + 1.5 * f64::from(ring)).to_radians();
            let beam =
                DVec3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin());
            let way = tilt * beam;
            let at_height = |z: f64| if way.z < 0.0 { z / way.z } else { f64::INFINITY };
            let floor = if at_height(-1.2) * way.x < edge { at_height(-1.2) } else { at_height(-1.8) };
            let wall = walls / way.x.abs().max(way.y.abs());
            let at = beam * floor.min(wall);
            points.push(Point {
                x_m: at.x as f32,
                y_m: at.y as f32,
                z_m: at.z as f32,
                intensity: 200.0,
                time_s: 0.0,
                ring,
                column,
                return_type: ReturnType::Single,
                strength: Strength::Unknown,
                reserved: 0,
                label: Point::UNLABELLED,
            });
        }
    }
    let columns = Columns { ring: true, ..Columns::default() };
    Scan {
        index,
        stamp_ns: 1_000_000_000 + index * 100_000_000,
        frame_id: "top".into(),
        points,
        columns,
        dropped: Dropped::default(),
    }
}

#[test]
fn a_tilted_lidar_without_poses_sees_no_stripes_of_solid_floor() {
    if skipped() {
        return;
    }
    let tilt = DQuat::from_rotation_x(7.0_f64.to_radians());
    let solid_inside = |ground: GroundSource| {
        let config = Config {
            ground,
            scan_map_size_m: 16.0,
            layer_heights_m: vec![-0.9, 0.0, 0.5],
            ..Config::default()
        };
        let mut mapper = Mapper::open(
            &config,
            &[SensorInfo::lidar(&config, tilted_scan(0, tilt))],
            &Options { verdicts: true, ..Options::default() },
        )
        .unwrap();
        let mut last = None;
        for index in 0..3 {
            let scan = SensorData::Scan(tilted_scan(index, tilt));
            let seen = Observation {
                sensor: 0,
                pose: Some(SensorPose::SENSOR),
                map_frame: "top".into(),
                goal_m: None,
                data: scan,
            };
            submit(&mut mapper, &seen).unwrap();
            last = mapper.wait().unwrap();
        }
        let update = last.unwrap();
        let map = update.map.as_ref().unwrap();
        let at = |cell: usize| map.grid.centre_m(cell as u32 % map.grid.width, cell as u32 / map.grid.width);
        let inside = (0..map.verdicts.len()).filter(|cell| at(*cell).iter().all(|m| m.abs() < 5.6));
        let solid = inside.filter(|cell| map.verdicts[*cell].cost() == 254).count();
        let walls = (0..map.verdicts.len()).filter(|cell| map.verdicts[*cell].row() == 2).count();
        (solid, walls, update.ground)
    };
    let (solid, walls, ground) = solid_inside(GroundSource::Estimate);
    let plane = ground.unwrap().plane.unwrap();
    assert!((plane.tilt_deg() - 7.0).abs() < 0.1 && (plane.below_m - 1.2).abs() < 0.01, "{plane:?}");
    assert_eq!(solid, 0, "nothing stands within the walls");
    assert!(walls > 200, "the walls are solid: {walls}");
    let (solid, _, ground) = solid_inside(GroundSource::Stated);
    assert!(ground.is_none() && solid > 100, "the test can fail: {solid} cells of floor");
}
