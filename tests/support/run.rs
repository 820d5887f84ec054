//! Runs a mapper with one camera over frames, one at a time.

use limpid::base::Rigid;
use limpid::map::{Counters, FrameImages, FrameLayers, Grid, Update};
use limpid::mapper::{self, Mapper, SensorInfo, Submitted};
use limpid::sensor::{CameraInfo, CameraModel, FramePose, Observation, RgbdFrame};
use limpid::{Config, Error, Result};

use crate::support::scene::{Scene, small_camera};

/// What a mapper with one camera is asked for.
#[derive(Debug, Clone, Default)]
pub(crate) struct Options {
    pub(crate) adapter: Option<String>,
    pub(crate) profiling: bool,
    pub(crate) images: bool,
    pub(crate) layers: bool,
    /// Calibration of the colour images.
    pub(crate) color: Option<CameraModel>,
    pub(crate) color_aligned: bool,
}

impl Options {
    /// With the colour calibration of the first of `frames` that has colour.
    pub(crate) fn with_color_of<'a>(self, frames: impl Iterator<Item = &'a RgbdFrame>) -> Self {
        let info = CameraInfo::of_frames(frames);
        let color = info.and_then(|info| info.color);
        Self { color, color_aligned: info.is_some_and(|info| info.color_aligned), ..self }
    }
}

/// What came of a frame: the update of a camera and its map, side by side.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FrameOutput {
    pub(crate) index: u64,
    pub(crate) stamp_ns: u64,
    pub(crate) map_from_base: Rigid,
    pub(crate) base_from_camera: Rigid,
    pub(crate) grid: Grid,
    pub(crate) costmap: Vec<u8>,
    pub(crate) counters: Counters,
    pub(crate) low_reliability_fraction: f64,
    pub(crate) degraded: bool,
    pub(crate) depth_alone: Option<String>,
    pub(crate) images: Option<FrameImages>,
    pub(crate) layers: Option<FrameLayers>,
}

impl From<Update> for FrameOutput {
    fn from(update: Update) -> Self {
        let camera = update.camera().unwrap().clone();
        let map = update.map.unwrap();
        Self {
            index: update.index,
            stamp_ns: update.stamp_ns,
            map_from_base: update.map_from_base,
            base_from_camera: update.base_from_sensor,
            grid: map.grid,
            costmap: map.costmap,
            counters: camera.counters,
            low_reliability_fraction: camera.low_reliability_fraction,
            degraded: camera.degraded,
            depth_alone: camera.depth_alone,
            images: camera.images,
            layers: camera.layers,
        }
    }
}

/// A mapper with one camera.
pub(crate) struct Pipeline {
    pub(crate) mapper: Mapper,
}

impl Pipeline {
    pub(crate) fn open(config: &Config, first: &RgbdFrame, options: &Options) -> Result<Self> {
        let info = CameraInfo::of_frames([first]).unwrap();
        let info = CameraInfo { color: options.color, color_aligned: options.color_aligned, ..info };
        let asked = mapper::Options {
            adapter: options.adapter.clone(),
            profiling: options.profiling,
            images: options.images,
            layers: options.layers,
            verdicts: options.layers,
            solidity_inputs: false,
            cell_inputs: false,
            live: false,
        };
        let mapper = Mapper::open(config, &[SensorInfo::camera(config, info)], &asked)?;
        Ok(Self { mapper })
    }

    /// A refusal comes as an error of its text.
    pub(crate) fn submit(&mut self, frame: &RgbdFrame) -> Result<()> {
        submit(&mut self.mapper, &Observation::of_frame(0, "map", frame.clone()))
    }

    pub(crate) fn receive(&mut self) -> Result<Option<FrameOutput>> {
        Ok(self.mapper.wait()?.map(Into::into))
    }

    pub(crate) fn is_full(&self) -> bool {
        self.mapper.is_full(0)
    }

    pub(crate) fn executor(&self) -> &limpid::gpu::Executor {
        self.mapper.executor(0).unwrap()
    }
}

/// Submits an observation; a refusal comes as an error of its text.
pub(crate) fn submit(mapper: &mut Mapper, observation: &Observation) -> Result<()> {
    match mapper.submit(observation)? {
        Submitted::Taken => Ok(()),
        Submitted::Refused(reason) => {
            Err(Error::Input { what: "refused".into(), reason: reason.to_string() })
        }
    }
}

/// Everything but colour read back.
pub(crate) fn all() -> Options {
    Options { images: true, layers: true, ..Options::default() }
}

/// A mapper for frames like `first`.
pub(crate) fn open(config: &Config, first: &RgbdFrame) -> Pipeline {
    Pipeline::open(config, first, &all()).unwrap()
}

/// Submits a frame and waits for it.
pub(crate) fn step(pipeline: &mut Pipeline, frame: &RgbdFrame) -> FrameOutput {
    pipeline.submit(frame).unwrap();
    pipeline.receive().unwrap().unwrap()
}

/// The results of all frames.
pub(crate) fn run(config: &Config, frames: &[RgbdFrame]) -> Vec<FrameOutput> {
    let mut pipeline = open(config, &frames[0]);
    frames.iter().map(|frame| step(&mut pipeline, frame)).collect()
}

/// `count` equal frames of a scene.
pub(crate) fn still(scene: &Scene, pose: FramePose, count: u64) -> Vec<RgbdFrame> {
    (0..count).map(|index| scene.frame(index, small_camera(), pose)).collect()
}

/// Index of the cell at (x, y) in the map.
pub(crate) fn cell(out: &FrameOutput, x: f64, y: f64) -> usize {
    let at = |m: f64, origin: f64| ((m - origin) / out.grid.resolution_m).floor() as usize;
    at(y, out.grid.origin_y_m) * out.grid.width as usize + at(x, out.grid.origin_x_m)
}

/// Published state of a cell before inflation reaches it: occupied cells are lethal in every configuration.
pub(crate) fn lethal(out: &FrameOutput, x: f64, y: f64) -> bool {
    out.costmap[cell(out, x, y)] == 254
}

/// p of a cell.
pub(crate) fn occupancy(out: &FrameOutput, x: f64, y: f64) -> f32 {
    out.layers.as_ref().unwrap().occupancy[cell(out, x, y)]
}

/// e of a cell.
pub(crate) fn evidence(out: &FrameOutput, x: f64, y: f64) -> f32 {
    out.layers.as_ref().unwrap().evidence[cell(out, x, y)]
}
