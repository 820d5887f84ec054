//! What the pipeline is asked for, and what it gives for one frame.

use crate::base::Rigid;
use crate::map::Grid;
use crate::sensor::CameraModel;
use crate::sensor::RgbdFrame;

/// What a pipeline runs on and what it reads back beside the costmap.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Part of the adapter's name; `None`: `LIMPID_ADAPTER`, else the best.
    pub adapter: Option<String>,
    /// Whether passes are timed.
    pub profiling: bool,
    /// Whether depth, reliability and colour images are read back.
    pub images: bool,
    /// Whether the grids beside the costmap are read back.
    pub layers: bool,
    /// Calibration of the colour images; used where images are read back, and by method drm.
    pub color: Option<CameraModel>,
    /// Whether these lie on the depth grid in every frame, which is faster; a frame of which it is not true
    /// is refused then.
    pub color_aligned: bool,
}

impl Options {
    /// With the colour calibration of the first of `frames` that has colour.
    pub fn with_color_of<'a>(self, mut frames: impl Iterator<Item = &'a RgbdFrame>) -> Self {
        let colored = frames.find(|frame| frame.color.is_some());
        let color = colored.and_then(|frame| frame.color.as_ref()).map(|color| color.camera);
        Self { color, color_aligned: colored.is_some_and(RgbdFrame::color_is_aligned), ..self }
    }
}

/// Counts of one frame, from the GPU.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Counters {
    /// Pixels of the depth image.
    pub pixels: u32,
    /// Pixels with a depth in the method's range.
    pub valid: u32,
    /// Pixels with reliability of at most tau, holes included.
    pub low_reliability: u32,
    /// Pixels that marked a cell.
    pub hits: u32,
    /// Cells marked.
    pub hit_cells: u32,
    /// Cells seen through.
    pub seen_through_cells: u32,
    /// Cells in the occupied state.
    pub occupied_cells: u32,
    /// Cells in the free state.
    pub free_cells: u32,
}

/// Images of one frame on the depth grid, row-major from the top left; read back on request.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameImages {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Metres; 0 where the method has no depth.
    pub depth_m: Vec<f32>,
    /// R in [0, 1]; 0 where there is no depth.
    pub reliability: Vec<f32>,
    /// RGB colour at the depth pixels, `3 * width * height` bytes; black where the colour camera does not see.
    pub color: Option<Vec<u8>>,
}

/// Grids of one frame, row 0 = smallest y; read back on request.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameLayers {
    /// e of spec 1 §3 in [0, 1]; -1 where the cell was not observed.
    pub evidence: Vec<f32>,
    /// p of spec 1 §3 in [0, 1]; 0 for cells never observed.
    pub occupancy: Vec<f32>,
    /// 1 in the occupied state, else 0.
    pub occupied: Vec<f32>,
    /// 1 in the free state, else 0.
    pub free: Vec<f32>,
}

/// One frame's result.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameOutput {
    /// Number of the depth image in the recording.
    pub index: u64,
    /// Stamp of the oldest sensor data used, nanoseconds.
    pub stamp_ns: u64,
    /// Robot base in the map.
    pub map_from_base: Rigid,
    /// Depth camera's optical frame in the base.
    pub base_from_camera: Rigid,
    /// Geometry of the grids.
    pub grid: Grid,
    /// Nav2 costs (0 free, 1..=252, 253 inscribed, 254 lethal, 255 unknown), row 0 = smallest y.
    pub costmap: Vec<u8>,
    /// Counts.
    pub counters: Counters,
    /// Share of pixels of low reliability (spec 1 §5).
    pub low_reliability_fraction: f64,
    /// Whether that share is above `degraded_fraction`.
    pub degraded: bool,
    /// Images, when they were asked for.
    pub images: Option<FrameImages>,
    /// Grids beside the costmap, when they were asked for.
    pub layers: Option<FrameLayers>,
    /// GPU time per pass in milliseconds, in order, when profiling.
    pub pass_ms: Vec<(String, f64)>,
    /// When each of these passes began, milliseconds on the GPU's own clock.
    pub pass_start_ms: Vec<f64>,
}
