//! A robot that stands still: cameras and lidars on it, observations of analytic scenes, and the map that is published.

use glam::{DMat3, DQuat, DVec3};
use limpid::Config;
use limpid::base::{Refused, Rigid};
use limpid::config::Solidity;
use limpid::map::{MapUpdate, Update, Verdict};
use limpid::mapper::{Mapper, Options, SensorInfo, Submitted};
use limpid::sensor::{
    CameraInfo, CameraModel, DepthImage, DepthSamples, Observation, RgbdFrame, Scan, SensorData, SensorPose,
};

use crate::support::camera_job::small_map;
use crate::support::gpu::context;
use crate::support::scan::{point, scan};
use crate::support::scene::{Block, Scene, small_camera};

/// Stamp of the first observation.
pub(crate) const START_NS: u64 = 1_700_000_000_000_000_000;

/// Frames of a still scene after which a cell with hits is occupied at the default lambda: the eighth is.
pub(crate) const FRAMES: u64 = 10;

/// Milliseconds from frame to frame, and from scan to scan.
pub(crate) const FRAME_MS: u64 = 33;

/// Height of cameras and lidars above the ground, metres.
pub(crate) const HEIGHT_M: f64 = 0.6;

/// Where the robot stands: off the borders of cells.
pub(crate) const BASE_M: DVec3 = DVec3::new(0.012, 0.023, 0.0);

/// The stamp so many milliseconds after the first.
pub(crate) fn at_ms(ms: u64) -> u64 {
    START_NS + ms * 1_000_000
}

/// A map of 6 m in which costs are those of verdicts: nothing is inflated; intensities are taken as they are.
pub(crate) fn config() -> Config {
    let solidity = Solidity::Intensity;
    Config { solidity, inflation_radius_m: 0.0, inscribed_radius_m: 0.0, ..small_map() }
}

/// A camera of that name for frames of that size, with the sensor's own confidence or without.
pub(crate) fn camera(name: &str, config: &Config, depth: CameraModel, confidence: bool) -> SensorInfo {
    let info = CameraInfo { depth, float_depth: true, color: None, color_aligned: false, confidence };
    SensorInfo { name: name.into(), ..SensorInfo::camera(config, info) }
}

/// 80x60 pixels, 57 degrees wide.
pub(crate) fn half_camera() -> CameraModel {
    CameraModel { width: 80, height: 60, fx: 73.0, fy: 73.0, cx: 39.5, cy: 29.5, ..small_camera() }
}

/// Two cameras of 160x120 pixels.
pub(crate) fn two_cameras(config: &Config) -> [SensorInfo; 2] {
    ["front", "rear"].map(|name| camera(name, config, small_camera(), false))
}

/// A camera of 160x120 pixels and a lidar.
pub(crate) fn camera_and_lidar(config: &Config) -> [SensorInfo; 2] {
    let lidar = SensorInfo::lidar(config, scan(0, Vec::new()));
    [camera("front", config, small_camera(), false), SensorInfo { name: "top".into(), ..lidar }]
}

/// A camera in the robot, turned by `yaw` and pitched down by `pitch`, radians.
pub(crate) fn mount(yaw: f64, pitch: f64) -> Rigid {
    let optical = DQuat::from_mat3(&DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X));
    let rotation = DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch) * optical;
    Rigid { rotation, translation_m: DVec3::Z * HEIGHT_M }
}

/// The robot at [`BASE_M`] with a sensor.
pub(crate) fn standing(base_from_sensor: Rigid) -> SensorPose {
    let map_from_base = Rigid { rotation: DQuat::IDENTITY, translation_m: BASE_M };
    SensorPose { map_from_base, base_from_sensor, sweep: None }
}

/// What camera `sensor` sees of a scene at that stamp.
pub(crate) fn frame(sensor: usize, ms: u64, scene: &Scene, depth: CameraModel, mount: Rigid) -> Observation {
    let samples = DepthSamples::Metres(scene.depth(&depth, standing(mount).map_from_sensor()));
    of_samples(sensor, ms, samples, depth, mount)
}

/// A frame of given samples.
pub(crate) fn of_samples(
    sensor: usize,
    ms: u64,
    samples: DepthSamples,
    depth: CameraModel,
    mount: Rigid,
) -> Observation {
    let frame_id = "camera".into();
    let image = DepthImage { stamp_ns: at_ms(ms), frame_id, camera: depth, samples };
    let (color, color_from_depth, confidence) = (None, None, None);
    let frame = RgbdFrame {
        index: ms,
        depth: image,
        color,
        color_from_depth,
        color_missing: None,
        confidence,
        pose: None,
    };
    Observation { pose: Some(standing(mount)), ..Observation::of_frame(sensor, "map", frame) }
}

/// The same with one confidence for all pixels.
pub(crate) fn confident(observation: Observation, confidence: f32) -> Observation {
    let SensorData::Frame(mut frame) = observation.data else { panic!("a scan") };
    frame.confidence = Some(vec![confidence; frame.depth.samples.len()]);
    Observation { data: SensorData::Frame(frame), ..observation }
}

/// Where a beam ended in the map, metres, and how bright the return is, of 255.
pub(crate) type Return = ([f64; 3], f64);

/// A scan of lidar `sensor` with these returns.
pub(crate) fn sweep(sensor: usize, ms: u64, returns: &[Return]) -> Observation {
    let lidar_m = BASE_M + DVec3::Z * HEIGHT_M;
    let local = |&(at, intensity): &Return| point((DVec3::from_array(at) - lidar_m).to_array(), intensity);
    let points = returns.iter().map(local).collect();
    let scan = Scan { stamp_ns: at_ms(ms), index: ms, ..scan(0, points) };
    let base_from_sensor = Rigid { rotation: DQuat::IDENTITY, translation_m: DVec3::Z * HEIGHT_M };
    Observation {
        sensor,
        pose: Some(standing(base_from_sensor)),
        map_frame: "map".into(),
        goal_m: None,
        data: SensorData::Scan(scan),
    }
}

/// A dim wall at `x_m` from `y_m` on by 1 cm, at the height `z_m`.
pub(crate) fn dim_wall(x_m: f64, y_m: std::ops::Range<f64>, z_m: f64) -> Vec<Return> {
    let steps = ((y_m.end - y_m.start) * 100.0).round() as u32;
    (0..steps).map(|step| ([x_m, y_m.start + 0.01 * f64::from(step), z_m], 40.0)).collect()
}

/// A wall 3.5 m ahead, behind and at each side, and boxes within.
pub(crate) fn room(blocks: &[Block]) -> Scene {
    let mut all = vec![
        Block::new([3.513, -3.6, 0.0], [3.6, 3.6, 2.5]),
        Block::new([-3.6, -3.6, 0.0], [-3.513, 3.6, 2.5]),
        Block::new([-3.6, 3.513, 0.0], [3.6, 3.6, 2.5]),
        Block::new([-3.6, -3.6, 0.0], [3.6, -3.513, 2.5]),
    ];
    all.extend(blocks);
    Scene { blocks: all }
}

/// A mapper, one observation under way at a time.
pub(crate) struct Rig {
    pub(crate) mapper: Mapper,
}

impl Rig {
    pub(crate) fn open(config: &Config, sensors: &[SensorInfo]) -> Self {
        Self { mapper: Mapper::on(&context(), config, sensors, &Options::default()).unwrap() }
    }

    /// Takes an observation into the map.
    #[track_caller]
    pub(crate) fn see(&mut self, observation: &Observation) -> Update {
        assert_eq!(self.mapper.submit(observation).unwrap(), Submitted::Taken);
        self.mapper.wait().unwrap().unwrap()
    }

    #[track_caller]
    pub(crate) fn refuse(&mut self, observation: &Observation) -> Refused {
        match self.mapper.submit(observation).unwrap() {
            Submitted::Refused(reason) => reason,
            Submitted::Taken => panic!("it was taken"),
        }
    }

    /// The map as it stands; `now_ms`: the time of a clock.
    #[track_caller]
    pub(crate) fn publish(&mut self, now_ms: Option<u64>) -> Published {
        assert!(self.mapper.publish(now_ms.map(at_ms)).unwrap());
        let update = self.mapper.wait().unwrap().unwrap();
        assert_eq!(update.sensor, None);
        Published { map: update.map.unwrap(), stamp_ns: update.stamp_ns }
    }
}

/// A map that was published.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Published {
    pub(crate) map: MapUpdate,
    pub(crate) stamp_ns: u64,
}

/// Row and cost of a verdict.
pub(crate) type Said = (u32, u8);

impl Published {
    pub(crate) fn cell(&self, [x_m, y_m]: [f64; 2]) -> usize {
        let grid = &self.map.grid;
        let at = |m: f64, origin_m: f64| ((m - origin_m) / grid.resolution_m).floor() as usize;
        at(y_m, grid.origin_y_m) * grid.width as usize + at(x_m, grid.origin_x_m)
    }

    /// Middle of a cell.
    pub(crate) fn centre(&self, cell: usize) -> [f64; 2] {
        let (grid, width) = (&self.map.grid, self.map.grid.width as usize);
        let at = |index: usize, origin_m: f64| origin_m + (index as f64 + 0.5) * grid.resolution_m;
        [at(cell % width, grid.origin_x_m), at(cell / width, grid.origin_y_m)]
    }

    pub(crate) fn verdict(&self, at: [f64; 2]) -> Verdict {
        self.map.verdicts[self.cell(at)]
    }

    /// Row and cost; the cost of the map, which nothing inflates here, is the verdict's.
    #[track_caller]
    pub(crate) fn said(&self, at: [f64; 2]) -> Said {
        let verdict = self.verdict(at);
        assert_eq!(self.map.costmap[self.cell(at)], verdict.cost(), "at {at:?}");
        (verdict.row(), verdict.cost())
    }

    /// Cells of a row that a sensor gave.
    pub(crate) fn of(&self, row: u32, sensor: usize) -> Vec<usize> {
        let is = |verdict: &Verdict| verdict.row() == row && verdict.sensor() == Some(sensor);
        (0..self.map.verdicts.len()).filter(|&cell| is(&self.map.verdicts[cell])).collect()
    }
}
