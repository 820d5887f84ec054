//! Once a mapper is open nothing is allocated or compiled, by wgpu's own counts.

use std::ops::Range;
use std::sync::Arc;

use limpid::base::Refused;
use limpid::config::Config;
use limpid::gpu::{Context, Executor};
use limpid::mapper::{self, Mapper, SensorInfo, Submitted};
use limpid::sensor::{CameraInfo, Observation, RgbdFrame, SensorData, SensorPose};

use crate::support::camera_job::{job, small_map, tiny_camera};
use crate::support::glass_room::GlassRoom;
use crate::support::gpu::skipped;
use crate::support::run::{open, step, submit};
use crate::support::scene::{Scene, pose};

/// wgpu's counts of objects and memory: buffers, their bytes, bind groups, pipelines, modules, query sets, allocations.
fn objects(context: &Context) -> [isize; 8] {
    let hal = context.counters().hal;
    [
        hal.buffers.read(),
        hal.buffer_memory.read(),
        hal.bind_groups.read(),
        hal.bind_group_layouts.read(),
        hal.compute_pipelines.read(),
        hal.shader_modules.read(),
        hal.query_sets.read(),
        hal.memory_allocations.read(),
    ]
}

/// A camera's frame of that number, at 30 Hz, 0.01 m on from the one before.
fn camera_frame(index: u64) -> RgbdFrame {
    Scene::default().frame(index, tiny_camera(), pose(0.01 * index as f64, 0.0, 0.0, 0.6, 0.3))
}

#[test]
fn frames_allocate_nothing() {
    if skipped() {
        return;
    }
    let mut pipeline = open(&small_map(), &camera_frame(0));
    (0..4).for_each(|index| drop(step(&mut pipeline, &camera_frame(index))));
    let before = objects(pipeline.mapper.context());
    assert!(before[0] > 5 && before[1] > 100_000 && before[4] >= 9, "{before:?}");
    (4..54).for_each(|index| drop(step(&mut pipeline, &camera_frame(index))));
    assert_eq!(objects(pipeline.mapper.context()), before);
    // The control: a second executor on the same device shows in buffers and bind groups; its programs are those that there are.
    let job = job(&small_map(), tiny_camera());
    let job = Arc::new(job);
    let plan = mapper::camera_plan(&job, &mapper::camera_stages(&job)).unwrap();
    let second = Executor::build(pipeline.mapper.context(), plan).unwrap();
    let after = objects(second.context());
    assert!([0, 1, 2].iter().all(|&i| after[i] > before[i]), "{before:?} {after:?}");
    assert_eq!(after[4], before[4], "compiled once");
}

/// Points of a scan that the lidar's passes are built for; the first has fewer.
const MAX_POINTS: usize = 40_000;

/// Two cameras and a lidar that searches for glass.
fn two_cameras_and_a_lidar() -> (Config, [SensorInfo; 3]) {
    let max_points = MAX_POINTS as u32;
    let config = Config { glass: true, deskew: false, max_points, ..small_map() };
    let camera = |name: &str| {
        let info = CameraInfo::of_frames([&camera_frame(0)]).unwrap();
        SensorInfo { name: name.into(), ..SensorInfo::camera(&config, info) }
    };
    let lidar = SensorInfo::lidar(&config, GlassRoom::default().scan().0);
    (config.clone(), [camera("front"), camera("rear"), lidar])
}

/// The lidar's scan at the time of a camera frame; `None`: as many points as the room gives.
fn lidar_scan(index: u64, points: Option<usize>) -> Observation {
    let (mut scan, _) = GlassRoom::default().scan();
    scan.stamp_ns = camera_frame(index).depth.stamp_ns;
    let (last, own) = (*scan.points.last().unwrap(), scan.points.len());
    scan.points.resize(points.unwrap_or(own), last);
    let map_from_base = camera_frame(index).pose.unwrap().map_from_base;
    let pose = Some(SensorPose { map_from_base, ..SensorPose::SENSOR });
    Observation { sensor: 2, pose, map_frame: "map".into(), goal_m: None, data: SensorData::Scan(scan) }
}

/// Frames of both cameras, with every third a scan and a map; how many maps came.
fn drive(mapper: &mut Mapper, indices: Range<u64>, points: Option<usize>) -> usize {
    let mut maps = 0;
    for index in indices {
        for camera in 0..2 {
            submit(mapper, &Observation::of_frame(camera, "map", camera_frame(index))).unwrap();
        }
        if index % 3 == 0 {
            submit(mapper, &lidar_scan(index, points)).unwrap();
            assert!(mapper.publish(None).unwrap());
        }
        while let Some(update) = mapper.wait().unwrap() {
            maps += usize::from(update.map.is_some());
        }
    }
    maps
}

#[test]
fn a_map_of_several_sensors_allocates_and_compiles_nothing_once_it_is_open() {
    if skipped() {
        return;
    }
    let (config, sensors) = two_cameras_and_a_lidar();
    let mut mapper = Mapper::open(&config, &sensors, &mapper::Options::default()).unwrap();
    let opened = objects(mapper.context());
    assert!(opened[0] > 20 && opened[4] >= 25, "{opened:?}");
    let mut maps = drive(&mut mapper, 0..3, None);
    // What the buffers' first contents were staged in goes with the first submission; nothing comes.
    let settled = objects(mapper.context());
    assert!(settled.iter().zip(&opened).all(|(now, then)| now <= then), "{opened:?} {settled:?}");
    assert_eq!(settled[2..], opened[2..], "the first frames, scan and map");
    maps += drive(&mut mapper, 3..6, None);
    maps += drive(&mut mapper, 6..9, Some(30_000));
    maps += drive(&mut mapper, 9..12, Some(MAX_POINTS));
    assert_eq!(objects(mapper.context()), settled, "scans larger than the first");
    let refused = mapper.submit(&lidar_scan(12, Some(MAX_POINTS + 1))).unwrap();
    let too_many = Refused::TooManyPoints { points: MAX_POINTS + 1, most: MAX_POINTS };
    assert_eq!(refused, Submitted::Refused(too_many));
    maps += drive(&mut mapper, 12..15, None);
    assert_eq!(objects(mapper.context()), settled, "after a scan that was refused");
    assert_eq!(maps, 5);
    // The control: another mapper on the device shows in all but what is compiled.
    let second = Mapper::on(mapper.context(), &config, &sensors, &mapper::Options::default()).unwrap();
    let after = objects(second.context());
    assert!([0, 1, 2].iter().all(|&i| after[i] > settled[i]), "{settled:?} {after:?}");
    assert_eq!(after[4], settled[4], "compiled once");
}
