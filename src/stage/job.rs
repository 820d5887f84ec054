//! What the stages of a sensor, and of the map, are built for.

use std::sync::Arc;

use crate::config::{Config, Fusion, InflationLaw, Method};
use crate::sensor::CameraModel;
use crate::stage::Moment;
use crate::stage::camera::back_project::STRIP;
use crate::stage::camera::drm::Drm;
use crate::stage::camera::map_reliability::MapReliability;
use crate::stage::glass::Glass;
use crate::stage::lidar::solidity::SolidityModel;
use crate::stage::map::layers::Layers;

/// What the stages of the map are built for, and what those of a sensor know of it.
#[derive(Debug, Clone, PartialEq)]
pub struct MapJob {
    /// Parameters; resolution and size are the map's for cameras and lidars alike.
    pub config: Config,
    /// Cells along one side.
    pub side: u32,
    /// Its layers.
    pub layers: Layers,
    /// Sensors, those that are missing too.
    pub sensors: usize,
    /// Cameras.
    pub cameras: u32,
    /// Lidars that search for glass.
    pub glass_lidars: u32,
    /// Whether its cameras' cells hold evidence for and against (`fusion: evidence` and `learned`), else p.
    pub evidence: bool,
    /// The network that says which cells are obstacles (`fusion: learned`).
    pub reliability: Option<Arc<MapReliability>>,
    /// Whether it is published apart from observations: it has several sensors.
    pub apart: bool,
    /// Whether what the rule says of each cell is read back.
    pub verdicts: bool,
}

impl MapJob {
    /// Of a camera alone.
    pub fn of_camera(config: &Config, side: u32) -> Self {
        let drops = config.marks_drops();
        let layers = Layers { cameras: true, drops, ..Layers::default() };
        Self {
            config: config.clone(),
            side,
            layers,
            sensors: 1,
            cameras: 1,
            glass_lidars: 0,
            evidence: config.fusion.counts_trust(),
            reliability: None,
            apart: false,
            verdicts: false,
        }
    }

    /// Of a lidar alone; `glass`: it searches for glass.
    pub fn of_lidar(config: &Config, side: u32, glass: bool) -> Self {
        let drops = config.marks_drops();
        let layers = Layers { lidars: true, panes: glass, drops, ..Layers::default() };
        Self {
            config: config.clone(),
            side,
            layers,
            sensors: 1,
            cameras: 0,
            glass_lidars: glass.into(),
            evidence: false,
            reliability: None,
            apart: false,
            verdicts: false,
        }
    }

    /// By which law lethal cells are inflated.
    pub fn law(&self) -> InflationLaw {
        self.config.inflation_law(self.layers.cameras)
    }
}

/// What the stages of a camera are built for: configuration, and the kind and size of its images.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraJob {
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
    pub drm: Option<Drm>,
    /// Whether a frame whose colour cannot be used is fused by depth alone (method auto), else refused by method drm.
    pub depth_alone: bool,
    /// Whether images (depth, reliability, colour) are read back.
    pub images: bool,
    /// Whether the grids beside the costmap are read back.
    pub layers: bool,
    /// Whether what map reliability judges cells by is read back.
    pub cell_inputs: bool,
    /// The map.
    pub map: Arc<MapJob>,
    /// Its number among the map's sensors, from 0.
    pub sensor: u32,
    /// Its name among several sensors; empty where it is alone.
    pub scope: String,
}

impl CameraJob {
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

    /// Whether cells hold evidence for and against, else p.
    pub fn counts_trust(&self) -> bool {
        self.map.evidence
    }

    /// Whether what cells keep counts less the longer ago it is, else by the number of looks.
    pub fn counts_by_time(&self) -> bool {
        self.config.rate_independent || self.map.cameras > 1
    }

    /// Whether back-projection keeps the lowest hits: for the heights at which looks through count, or for lidars that refute.
    pub fn keeps_lowest(&self) -> bool {
        self.counts_trust() || self.map.layers.lidars
    }

    /// The buffer that back-projection and clearing take their depth from.
    pub fn depth_buffer(&self) -> &'static str {
        if self.config.method == Method::Median { "depth_median_m" } else { "depth_m" }
    }

    /// The buffer that holds depths that end at known panes.
    pub fn clipped_depth(&self) -> &'static str {
        if self.map.layers.panes { "depth_clipped_m" } else { self.depth_buffer() }
    }

    /// Strips of pixels down the columns that back-projection counts in.
    pub fn strips(&self) -> u32 {
        self.depth.width * self.depth.height.div_ceil(STRIP)
    }

    /// Words of four pixels that cover a depth image.
    pub fn pixel_words(&self) -> u32 {
        self.pixels().div_ceil(4)
    }

    /// Bytes of a buffer with `bytes` for each depth pixel, padded to words of four pixels.
    pub fn image_bytes(&self, bytes: u64) -> u64 {
        u64::from(self.pixel_words()) * 4 * bytes
    }

    /// Bytes of a buffer with `bytes` for each cell.
    pub fn grid_bytes(&self, bytes: u64) -> u64 {
        u64::from(self.map.side) * u64::from(self.map.side) * bytes
    }

    /// Fixed-point one of weight sums: the most fraction bits with which all pixels fit in 32 bits
    /// (13 for 848x480; spec 1 §3).
    pub fn weight_scale(&self) -> f32 {
        f32::from(1_u16 << (u32::MAX / self.pixels().max(1)).ilog2().min(13))
    }
}

/// What the stages of a lidar are built for.
#[derive(Debug, Clone, PartialEq)]
pub struct LidarJob {
    /// Parameters.
    pub config: Config,
    /// Most points of a scan.
    pub capacity: u32,
    /// R: intensity of full scale, in the sensor's unit.
    pub full_scale: f64,
    /// Rings of the planes z = 0 and z = -epsilon; `None`: slabs.
    pub plane_rings: Option<[u16; 2]>,
    /// Whether points are placed by the pose at their own times.
    pub deskew: bool,
    /// Whether the grids beside the plan map are read back.
    pub layers: bool,
    /// The model of learned solidity, where that is asked for.
    pub solidity: Option<Arc<SolidityModel>>,
    /// Whether its inputs are read back.
    pub solidity_inputs: bool,
    /// The grid of beams and the panes to begin with, where glass is searched for.
    pub glass: Option<Glass>,
    /// The map.
    pub map: Arc<MapJob>,
    /// Its number among the map's sensors, from 0.
    pub sensor: u32,
    /// Its name among several sensors; empty where it is alone.
    pub scope: String,
    /// Its number among the lidars that search for glass, from 0.
    pub glass_number: u32,
}

impl LidarJob {
    /// Cells of the map.
    pub fn cells(&self) -> u32 {
        self.map.side * self.map.side
    }

    /// Bytes of a buffer with `bytes` for each cell.
    pub fn grid_bytes(&self, bytes: u64) -> u64 {
        u64::from(self.cells()) * bytes
    }

    /// Tall layers: those between two of `layer_heights_m`.
    pub fn tall_layers(&self) -> u32 {
        u32::try_from(self.config.layer_heights_m.len()).unwrap_or(u32::MAX).saturating_sub(1)
    }

    /// m: the tall layers from the lowest, then the planes z = 0 and z = -epsilon.
    pub fn layer_count(&self) -> u32 {
        self.tall_layers() + 2
    }

    /// Names of the layers in that order.
    pub fn layer_names(&self) -> Vec<String> {
        let tall = (0..self.tall_layers()).map(|layer| layer.to_string());
        tall.chain(["plane".into(), "below".into()]).collect()
    }
}

/// What a stage that sensors of both kinds have is built for.
#[derive(Debug, Clone)]
pub(crate) enum SensorJob {
    /// For a camera.
    Camera(Arc<CameraJob>),
    /// For a lidar.
    Lidar(Arc<LidarJob>),
}

impl SensorJob {
    /// Parameters of the sensor.
    pub(crate) fn config(&self) -> &Config {
        match self {
            Self::Camera(job) => &job.config,
            Self::Lidar(job) => &job.config,
        }
    }

    /// The map.
    pub(crate) fn map(&self) -> &MapJob {
        match self {
            Self::Camera(job) => &job.map,
            Self::Lidar(job) => &job.map,
        }
    }

    /// Its number among the map's sensors, from 0.
    pub(crate) fn sensor(&self) -> u32 {
        match self {
            Self::Camera(job) => job.sensor,
            Self::Lidar(job) => job.sensor,
        }
    }

    /// Height in the map from which its passes count z: the stated ground, or a lidar's own height.
    pub(crate) fn zero_z_m(&self, moment: &Moment<'_>) -> f64 {
        match self {
            Self::Camera(job) => job.config.ground_z_m,
            Self::Lidar(_) => moment.pose.map_from_sensor().translation_m.z,
        }
    }
}
