//! The stages of a frame, one file each: what it declares and appends to the plan, and its
//! parameters for one frame. `pipeline.rs` lists them in order.

pub mod camera;
pub mod glass;
pub mod lidar;
pub mod map;
pub mod targets;

use glam::{DVec3, Vec4};

use crate::base::Result;
use crate::base::Rigid;
use crate::config::{Config, Fusion, Method};
use crate::gpu::{FrameInput, Plan};
use crate::map::Window;
use crate::sensor::CameraModel;
use crate::sensor::RgbdFrame;

/// What a pipeline is built for: configuration, and the kind and size of its images.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Parameters.
    pub config: Config,
    /// Calibration of the depth images.
    pub depth: CameraModel,
    /// Whether depth comes as float metres (else as 16-bit counts).
    pub float_depth: bool,
    /// Calibration of the colour images, where colour is wanted and there is some.
    pub color: Option<CameraModel>,
    /// Whether colour lies on the depth grid in every frame.
    pub color_aligned: bool,
    /// Whether frames carry the sensor's own confidence.
    pub confidence: bool,
    /// The network that weighs pixels, for method drm.
    pub drm: Option<camera::drm::Drm>,
    /// Whether images (depth, reliability, colour) are read back.
    pub images: bool,
    /// Whether the grids beside the costmap are read back.
    pub layers: bool,
}

impl Job {
    /// Pixels of a depth image.
    pub fn pixels(&self) -> u32 {
        self.depth.width * self.depth.height
    }

    /// Whether pixels carry weights of their own.
    pub fn weighted(&self) -> bool {
        self.confidence || self.drm.is_some()
    }

    /// Whether weights above tau count fully.
    pub fn gated(&self) -> bool {
        self.config.fusion == Fusion::Gate
    }

    /// The buffer that back-projection and clearing take their depth from.
    pub fn depth_buffer(&self) -> &'static str {
        if self.config.method == Method::Median { "depth_median_m" } else { "depth_m" }
    }

    /// Strips of pixels down the columns that back-projection counts in.
    pub fn strips(&self) -> u32 {
        self.depth.width * self.depth.height.div_ceil(camera::back_project::STRIP)
    }

    /// Words of four pixels that cover a depth image.
    pub fn pixel_words(&self) -> u32 {
        self.pixels().div_ceil(4)
    }

    /// Bytes of a buffer with `bytes` for each depth pixel, padded to words of four pixels.
    pub fn image_bytes(&self, bytes: u64) -> u64 {
        u64::from(self.pixel_words()) * 4 * bytes
    }

    /// Cells along one side of the map.
    pub fn side(&self) -> u32 {
        self.config.cells_per_side().unwrap_or(8)
    }

    /// Bytes of a buffer with `bytes` for each cell.
    pub fn grid_bytes(&self, bytes: u64) -> u64 {
        u64::from(self.side()) * u64::from(self.side()) * bytes
    }

    /// Fixed-point one of weight sums: the most fraction bits with which all pixels fit in 32 bits
    /// (13 for 848x480; spec 1 §3).
    pub fn weight_scale(&self) -> f32 {
        f32::from(1_u16 << (u32::MAX / self.pixels().max(1)).ilog2().min(13))
    }
}

/// What the stages take their parameters of one frame from.
#[derive(Debug)]
pub struct Moment<'a> {
    /// What the pipeline was built for.
    pub job: &'a Job,
    /// The input.
    pub frame: &'a RgbdFrame,
    /// The window.
    pub window: Window,
    /// Camera in window coordinates: metres from the corner of cell (0, 0), z = 0 on the ground.
    pub window_from_camera: Rigid,
    /// Seconds since the frame before; `None` for the first.
    pub since_last_s: Option<f64>,
    /// Whether no frame was refused between the frame before and this one.
    pub follows: bool,
}

impl<'a> Moment<'a> {
    /// For a frame at `map_from_camera`.
    pub fn new(
        job: &'a Job,
        frame: &'a RgbdFrame,
        window: Window,
        map_from_camera: Rigid,
        since_last_s: Option<f64>,
    ) -> Self {
        let grid = window.grid(job.config.resolution_m, job.side());
        let origin_m = DVec3::new(grid.origin_x_m, grid.origin_y_m, job.config.ground_z_m);
        let translation_m = map_from_camera.translation_m - origin_m;
        let window_from_camera = Rigid { translation_m, ..map_from_camera };
        Self { job, frame, window, window_from_camera, since_last_s, follows: since_last_s.is_some() }
    }
}

/// A stage of the method.
pub trait Stage: std::fmt::Debug {
    /// Declares its buffers and appends its passes.
    ///
    /// # Errors
    /// From the plan: a name taken, a buffer missing, a shader that does not parse.
    fn append(&self, plan: &mut Plan, job: &Job) -> Result<()>;

    /// Writes its parameters and data for one frame.
    ///
    /// # Errors
    /// [`crate::Error::Input`] where data do not fit their buffer.
    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()>;
}

/// What brings colour onto the depth grid, where colour is wanted and there is some.
pub(crate) fn color_stage(job: &Job) -> Option<Box<dyn Stage>> {
    job.color.map(|camera| -> Box<dyn Stage> {
        match job.color_aligned {
            true => Box::new(camera::align_color::AlignColor { camera }),
            false => Box::new(camera::register_color::RegisterColor { camera }),
        }
    })
}

/// The rows of a transform as shaders take them: rotation in x, y, z, translation in w.
pub fn rows(transform: Rigid) -> [Vec4; 3] {
    let rotation = transform.rotation_matrix().transpose();
    let translation = transform.translation_m.to_array();
    let row = |axis: usize| rotation.col(axis).extend(translation[axis]).as_vec4();
    [row(0), row(1), row(2)]
}

/// f64 parameters as the f32 that shaders take.
#[expect(clippy::cast_possible_truncation, reason = "f32 is the precision of the shaders")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}
