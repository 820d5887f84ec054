//! Runs a pipeline over frames, one at a time.

use limpid::Config;
use limpid::frame::{FrameOutput, Options};
use limpid::pipeline::Pipeline;
use limpid::sensor::{FramePose, RgbdFrame};

use crate::support::scene::{Scene, small_camera};

/// Everything but colour read back.
pub(crate) fn all() -> Options {
    Options { images: true, layers: true, ..Options::default() }
}

/// A pipeline for frames like `first`.
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
