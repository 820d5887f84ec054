//! Scans of analytic scenes, and a scan pipeline that runs them one at a time.

use glam::DVec2;
use limpid::base::Rigid;
use limpid::config::Solidity;
use limpid::map::glass::LabelledScan;
use limpid::map::{CellClass, Grid, MapUpdate, ScanLayers, Update};
use limpid::mapper::{self, Mapper, SensorInfo};
use limpid::sensor::{
    Columns, Dropped, Observation, Point, ReturnType, Scan, SensorData, SensorPose, Strength,
};
use limpid::{Config, Result};

use crate::support::run::submit;

/// The defaults, with cells solid by intensity alone: a test's few points do not bear its scale out.
pub(crate) fn by_intensity() -> Config {
    Config { solidity: Solidity::Intensity, ..Config::default() }
}

/// A point with neither ring nor time.
pub(crate) fn point([x, y, z]: [f64; 3], intensity: f64) -> Point {
    Point {
        x_m: x as f32,
        y_m: y as f32,
        z_m: z as f32,
        intensity: intensity as f32,
        time_s: 0.0,
        ring: Point::UNKNOWN,
        column: Point::UNKNOWN,
        return_type: ReturnType::Single,
        strength: Strength::Unknown,
        reserved: 0,
        label: Point::UNLABELLED,
    }
}

/// Scan `index` of 10 Hz.
pub(crate) fn scan(index: u64, points: Vec<Point>) -> Scan {
    let columns = Columns { ring: points.iter().any(|p| p.ring != Point::UNKNOWN), ..Columns::default() };
    Scan {
        index,
        stamp_ns: 1_700_000_000_000_000_000 + index * 100_000_000,
        frame_id: "lidar".into(),
        points,
        columns,
        dropped: Dropped::default(),
    }
}

/// A scan with what a source says of the robot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ScanFrame {
    pub(crate) scan: Scan,
    pub(crate) map_frame: String,
    pub(crate) pose: Option<SensorPose>,
    pub(crate) goal_m: Option<DVec2>,
}

impl From<Observation> for ScanFrame {
    fn from(observation: Observation) -> Self {
        let Observation { pose, map_frame, goal_m, data, .. } = observation;
        let SensorData::Scan(scan) = data else { panic!("a frame in place of a scan") };
        Self { scan, map_frame, pose, goal_m }
    }
}

impl ScanFrame {
    pub(crate) fn observation(&self) -> Observation {
        let Self { scan, map_frame, pose, goal_m } = self.clone();
        Observation { sensor: 0, pose, map_frame, goal_m, data: SensorData::Scan(scan) }
    }
}

/// What came of a scan: the update of a lidar and its map, side by side.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ScanOutput {
    pub(crate) index: u64,
    pub(crate) stamp_ns: u64,
    pub(crate) map_frame: String,
    pub(crate) map_from_base: Rigid,
    pub(crate) base_from_sensor: Rigid,
    pub(crate) towards_goal: Option<DVec2>,
    pub(crate) grid: Grid,
    pub(crate) costmap: Vec<u8>,
    pub(crate) classes: Vec<u8>,
    pub(crate) pose_jumped: bool,
    pub(crate) points: usize,
    pub(crate) glass: Option<LabelledScan>,
    pub(crate) layers: Option<ScanLayers>,
    pub(crate) map: MapUpdate,
    pub(crate) update: Update,
}

impl From<Update> for ScanOutput {
    fn from(update: Update) -> Self {
        let lidar = update.lidar().unwrap().clone();
        let map = update.map.clone().unwrap();
        Self {
            update: update.clone(),
            index: update.index,
            stamp_ns: update.stamp_ns,
            map_frame: update.map_frame,
            map_from_base: update.map_from_base,
            base_from_sensor: update.base_from_sensor,
            towards_goal: map.towards_goal,
            grid: map.grid,
            costmap: map.costmap.clone(),
            classes: map.classes.clone(),
            pose_jumped: lidar.pose_jumped,
            points: lidar.points,
            glass: lidar.glass,
            layers: lidar.layers,
            map,
        }
    }
}

impl ScanOutput {
    pub(crate) fn count(&self, class: CellClass) -> usize {
        self.map.count(class)
    }
}

/// What a mapper with one lidar is asked for.
#[derive(Debug, Clone, Default)]
pub(crate) struct ScanOptions {
    pub(crate) layers: bool,
}

/// A mapper with one lidar.
pub(crate) struct ScanPipeline {
    pub(crate) mapper: Mapper,
}

impl ScanPipeline {
    pub(crate) fn open(config: &Config, first: &ScanFrame, options: &ScanOptions) -> Result<Self> {
        let asked = mapper::Options { layers: options.layers, ..mapper::Options::default() };
        let mapper = Mapper::open(config, &[SensorInfo::lidar(config, first.scan.clone())], &asked)?;
        Ok(Self { mapper })
    }

    /// A refusal comes as an error of its text.
    pub(crate) fn submit(&mut self, frame: &ScanFrame) -> Result<()> {
        submit(&mut self.mapper, &frame.observation())
    }

    pub(crate) fn receive(&mut self) -> Result<Option<ScanOutput>> {
        Ok(self.mapper.wait()?.map(Into::into))
    }
}

/// With the map in the lidar's own frame.
pub(crate) fn still(scan: Scan) -> ScanFrame {
    ScanFrame { scan, map_frame: "lidar".into(), pose: Some(SensorPose::SENSOR), goal_m: None }
}

/// With the lidar at `pose`.
pub(crate) fn posed(scan: Scan, pose: SensorPose) -> ScanFrame {
    ScanFrame { scan, map_frame: "map".into(), pose: Some(pose), goal_m: None }
}

/// Everything read back.
pub(crate) fn open(config: &Config, first: &ScanFrame) -> ScanPipeline {
    ScanPipeline::open(config, first, &ScanOptions { layers: true }).unwrap()
}

/// Submits a scan and waits for it.
pub(crate) fn step(pipeline: &mut ScanPipeline, frame: &ScanFrame) -> ScanOutput {
    pipeline.submit(frame).unwrap();
    pipeline.receive().unwrap().unwrap()
}

/// The result of one scan.
pub(crate) fn run_one(config: &Config, frame: &ScanFrame) -> ScanOutput {
    step(&mut open(config, frame), frame)
}

/// Index of the cell at (x, y) in the map.
pub(crate) fn cell(out: &ScanOutput, x: f64, y: f64) -> usize {
    let at = |m: f64, origin: f64| ((m - origin) / out.grid.resolution_m).floor() as usize;
    at(y, out.grid.origin_y_m) * out.grid.width as usize + at(x, out.grid.origin_x_m)
}

/// A grid beside the plan map.
pub(crate) fn grid<'a>(out: &'a ScanOutput, name: &str) -> &'a [f32] {
    &out.layers.as_ref().unwrap().grids.iter().find(|(known, _)| known == name).unwrap().1
}
