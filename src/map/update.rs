//! What the mapper gives: what came of an observation, and the map.

use std::sync::Arc;

use glam::DVec2;

use crate::base::Rigid;
use crate::map::glass::LabelledScan;
use crate::map::{CellClass, Grid, Ground, State, Verdict};

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
    /// e of spec 1 §3 in [0, 1], with fusion evidence a of §9; -1 where the cell was not observed.
    pub evidence: Vec<f32>,
    /// p of spec 1 §3 in [0, 1], with fusion evidence A / (A + B) of §9; 0 for cells never observed.
    pub occupancy: Vec<f32>,
    /// 1 in the occupied state, else 0.
    pub occupied: Vec<f32>,
    /// 1 in the free state, else 0.
    pub free: Vec<f32>,
}

/// Grids beside the plan map, row 0 = smallest y: name and one value a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanLayers {
    /// `intensity_<layer>`, `true_positive`, `false_positive`, `false_negative`, and `inflated` and `plan` where a lidar
    /// alone is inflated away from the goal: values in the unit of `layer_measure`; 0 where there is nothing.
    pub grids: Vec<(String, Vec<f32>)>,
}

/// What came of a camera's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraUpdate {
    /// Counts.
    pub counters: Counters,
    /// Share of pixels of low reliability (spec 1 §5).
    pub low_reliability_fraction: f64,
    /// Whether that share is above `degraded_fraction`.
    pub degraded: bool,
    /// Why the frame was fused by depth alone, as method range does it, where method auto is drm and its colour could not be used.
    pub depth_alone: Option<String>,
    /// Images, when they were asked for.
    pub images: Option<FrameImages>,
    /// Grids beside the costmap, when they were asked for.
    pub layers: Option<FrameLayers>,
    /// What map reliability judges the cells of the window by, when it was asked for: of each cell the numbers that
    /// [`INPUTS`](crate::stage::camera::map_reliability::INPUTS) names; 0 where the frame did not judge it. Else empty.
    pub cell_inputs: Vec<f32>,
}

/// What came of a lidar's scan.
#[derive(Debug, Clone, PartialEq)]
pub struct LidarUpdate {
    /// Points of the scan.
    pub points: usize,
    /// Whether the lidar's pose jumped since the scan before (`pose_jump_m_s`, `pose_jump_deg_s`); what is kept from scans
    /// before stays where it was in the map.
    pub pose_jumped: bool,
    /// Labels and panes, where glass is searched for.
    pub glass: Option<LabelledScan>,
    /// Grids beside the map, when they were asked for.
    pub layers: Option<ScanLayers>,
    /// What learned solidity judges the cells of the window by, when it was asked for: of each cell the numbers that
    /// [`INPUTS`](crate::stage::lidar::solidity::INPUTS) names; only where something stands do they mean anything. Else empty.
    pub solidity_inputs: Vec<f32>,
}

/// What came of an observation, by the kind of its sensor.
#[derive(Debug, Clone, PartialEq)]
pub enum Seen {
    /// Of a camera.
    Camera(CameraUpdate),
    /// Of a lidar.
    Lidar(LidarUpdate),
}

impl Seen {
    /// What a camera's frame says of its camera's state; a scan says nothing.
    pub fn state(&self) -> Option<State> {
        match self {
            Self::Camera(camera) if camera.degraded => Some(State::Degraded),
            Self::Camera(_) => Some(State::Ok),
            Self::Lidar(_) => None,
        }
    }
}

/// A published map.
///
/// ```
/// use limpid::{MapUpdate, map::Grid};
///
/// /// Cost at a place in the map; `None` outside of it.
/// fn cost_at(map: &MapUpdate, x_m: f64, y_m: f64) -> Option<u8> {
///     let [column, row] = map.grid.cell_at(x_m, y_m)?;
///     map.costmap.get(row as usize * map.grid.width as usize + column as usize).copied()
/// }
/// # let grid = Grid { origin_x_m: -1.0, origin_y_m: 0.0, resolution_m: 0.5, width: 4, height: 2 };
/// # let (verdicts, classes, sensors, state) = (Vec::new(), Vec::new(), Vec::new(), limpid::State::Ok);
/// # let costmap = vec![0, 0, 0, 0, 255, 254, 0, 0];
/// # let map = MapUpdate { grid, costmap, verdicts, classes, towards_goal: None, state, sensors };
/// # assert_eq!([cost_at(&map, -0.4, 0.6), cost_at(&map, -0.6, 0.6)], [Some(254), Some(255)]);
/// # assert_eq!([cost_at(&map, 1.1, 0.6), cost_at(&map, 0.9, 0.4)], [None, Some(0)]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct MapUpdate {
    /// Geometry of the grids.
    pub grid: Grid,
    /// Nav2 costs (0 free, 1..=252, 253 inscribed, 254 lethal, 255 unknown), row 0 = smallest y.
    pub costmap: Vec<u8>,
    /// What the rule says of each cell before inflation, row 0 = smallest y; empty where it was not asked for.
    pub verdicts: Vec<Verdict>,
    /// [`CellClass`] of each cell, as its number; empty where it was not asked for.
    pub classes: Vec<u8>,
    /// Direction from the robot to its goal in the map, of length 1; `None` at the goal.
    pub towards_goal: Option<DVec2>,
    /// The worst of the sensors' states.
    pub state: State,
    /// States of the sensors, as they are counted.
    pub sensors: Vec<State>,
}

impl MapUpdate {
    /// Cells of a class.
    pub fn count(&self, class: CellClass) -> usize {
        self.classes.iter().filter(|&&c| c == class as u8).count()
    }
}

/// What the mapper gives, in the order in which it was asked for: of an observation, of a published map, or of both in one,
/// where the map has one sensor.
///
/// ```
/// /// What to log of a result.
/// fn line(update: &limpid::Update) -> String {
///     let state = update.map.as_ref().map_or("no map yet", |map| map.state.name());
///     match (update.camera(), update.lidar()) {
///         (Some(camera), _) => format!("frame {}: {} hits, {state}", update.index, camera.counters.hits),
///         (_, Some(lidar)) => format!("scan {}: {} points, {state}", update.index, lidar.points),
///         (None, None) => format!("map {}: {state}", update.index),
///     }
/// }
/// # use limpid::config::Method;
/// # if let Err(limpid::Error::NoAdapter { .. }) = limpid::gpu::adapters(None) { return Ok(()) }
/// # let config = limpid::Config { method: Method::Range, ..Default::default() };
/// # let mut room = limpid::open_source("testdata/room.mcap".as_ref(), &config)?;
/// # let mut mapper = limpid::Mapper::open(&config, room.sensors(), &Default::default())?;
/// # let Some(frame) = room.next()? else { panic!("no frame") };
/// # let said = line(&mapper.step(&frame)?);
/// # assert!(said.starts_with("frame 0: ") && said.ends_with(" hits, OK"), "{said}");
/// # Ok::<(), limpid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Update {
    /// Which sensor's observation, as they are counted; `None`: a published map.
    pub sensor: Option<usize>,
    /// Number of the observation in its source; of a published map, counted from 0.
    pub index: u64,
    /// Stamp of the oldest sensor data used, nanoseconds.
    pub stamp_ns: u64,
    /// Frame of the map.
    pub map_frame: String,
    /// Robot base in the map.
    pub map_from_base: Rigid,
    /// The sensor in the base; identity for a published map.
    pub base_from_sensor: Rigid,
    /// What came of the observation.
    pub seen: Option<Seen>,
    /// The ground as the sensor knows it; `None` where it is stated, and for a published map.
    pub ground: Option<Ground>,
    /// The map.
    pub map: Option<MapUpdate>,
    /// GPU time per pass in milliseconds, in order, when profiling.
    pub pass_ms: Vec<(Arc<str>, f64)>,
    /// When each of these passes began, milliseconds on the GPU's own clock.
    pub pass_start_ms: Vec<f64>,
}

impl Update {
    /// What came of a camera's frame, where it is one.
    pub fn camera(&self) -> Option<&CameraUpdate> {
        match &self.seen {
            Some(Seen::Camera(camera)) => Some(camera),
            _ => None,
        }
    }

    /// What came of a lidar's scan, where it is one.
    pub fn lidar(&self) -> Option<&LidarUpdate> {
        match &self.seen {
            Some(Seen::Lidar(lidar)) => Some(lidar),
            _ => None,
        }
    }
}
