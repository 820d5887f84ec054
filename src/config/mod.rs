//! Parameters: flat, with units in their names; read from YAML, checked as a whole.

use serde::{Deserialize, Serialize};

use crate::base::{Error, Result};
use crate::sensor::ReturnCodes;
use crate::sensor::VelodyneModel as Model;

mod defaults;
mod document;
mod glass;
mod keys;
mod lidar;
mod map;
mod parse;
mod read;
mod sensors;
mod set;
mod validate;

pub use crate::sensor::SensorKind;
pub use keys::{Scope, scope_of};
pub use lidar::{InflationKernel, LayerMeasure, MAX_TALL_LAYERS, PlaneSource, Solidity};
pub use map::{Fusion, GroundSource, InflationLaw, LidarClearsCamera, MAX_POINTS};
pub use sensors::{MAX_SENSORS, SensorConfig, SensorInfo};

/// Every parameter with its default, commented, as YAML.
pub const EXAMPLE: &str = include_str!("../../testdata/config/limpid.yaml");

/// A robot with two cameras and a lidar, commented, as YAML: a file to start from.
pub const ROBOT: &str = include_str!("../../testdata/config/robot.yaml");

/// How depth becomes evidence (spec 1 §4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// `Drm` where the first frames come with colour that can be used (calibrated, near in time, its place known), else
    /// `Range`; a run says which it was. Under `Drm` a frame whose colour cannot be used counts as under `Range`.
    Auto,
    /// Any depth above 0, weight 1.
    Naive,
    /// Depth in `[depth_min_m, range_gate_m]`, weight 1.
    Range,
    /// Median of the valid pixels in 5x5, then as naive.
    Median,
    /// As naive, but a cell marks only when hit in some of its last observed frames.
    Temporal,
    /// Depth in `[depth_min_m, depth_max_m]`, weighted by the reliability that DRM-Net predicts. Stated, it refuses frames
    /// whose colour cannot be used.
    Drm,
}

/// A transform that the recording lacks, stated by the user: pose of `child` in `parent`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StaticTransform {
    /// Parent frame.
    pub parent: String,
    /// Child frame.
    pub child: String,
    /// x, y, z in metres.
    pub translation_m: [f64; 3],
    /// Quaternion x, y, z, w.
    pub rotation_xyzw: [f64; 4],
}

/// All parameters of a run. `Config::default()` is what `limpid run` uses without a file.
///
/// ```
/// let robot = limpid::Config::from_yaml(
///     "
/// map: {frame: odom, size_m: 12.0, publish_rate_hz: 10.0}
/// sensors: [front, top]
/// front: {kind: camera, depth_topic: /front/depth/image_raw, method: range}
/// top: {kind: lidar, topic: /points, glass: true, timeout_s: 0.3}
/// ",
/// )?;
/// assert_eq!(robot.map_frame, "odom");
/// assert_eq!((robot.sensors[1].name.as_str(), robot.sensors[1].timeout_s), ("top", 0.3));
/// assert!(robot.sensors[1].parameters.glass);
/// # Ok::<(), limpid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// How depth becomes evidence.
    pub method: Method,
    /// Weight file of DRM-Net (safetensors), for method drm; empty: the weights that limpid comes with.
    pub weights: String,
    /// How pixels of reliability R above tau change a cell.
    pub fusion: Fusion,
    /// Fusion evidence: how much less hits count the lower their mean R is; the higher, the fewer false obstacles and the fewer
    /// obstacles at all.
    pub evidence_exponent: f64,
    /// Fusion evidence: sum of R in one frame from which a far cell's hits count fully.
    pub evidence_least_hits: f64,
    /// Fusion learned: added to the network's sum, of which 0 and more is an obstacle; higher: more obstacles, and more false ones.
    pub learned_bias: f64,
    /// Fusion learned: weight file of map reliability (safetensors); empty: the weights that limpid comes with.
    pub learned_weights: String,

    /// Depth image topic; empty: found by message type and name.
    pub depth_topic: String,
    /// Calibration topic of the depth image; empty: the one beside the depth topic.
    pub depth_info_topic: String,
    /// Colour image topic; empty: found by message type and name.
    pub color_topic: String,
    /// Calibration topic of the colour image; empty: the one beside the colour topic.
    pub color_info_topic: String,
    /// Confidence image topic (mono8 0..255 or 32FC1 0..1 on the depth grid); empty: none.
    pub confidence_topic: String,
    /// Depth image (16-bit PNG, or EXR in metres) of a folder with a still pair; empty: the folder is none.
    pub depth_file: String,
    /// Colour image (JPEG or PNG) of a still pair, aligned to depth; empty: none.
    pub color_file: String,
    /// Intrinsics of the depth images, row-major 3x3, pixels: of a still pair, and of a recording in place of its calibration;
    /// zeros: none are stated.
    pub camera_matrix: [f64; 9],
    /// Lens coefficients that go with `camera_matrix`, in ROS's order; empty: none.
    pub distortion: Vec<f64>,
    /// Lens model of `distortion`: `plumb_bob`, `rational_polynomial` or `equidistant`.
    pub distortion_model: String,
    /// Odometry topic used instead of tf for `map_frame` from `base_frame`; empty: tf.
    pub odometry_topic: String,
    /// Fixed frame of the costmap (REP 105: map or odom).
    pub map_frame: String,
    /// Robot base frame.
    pub base_frame: String,
    /// Optical frame of the depth camera; empty: the image's own `frame_id`.
    pub camera_frame: String,
    /// Transforms that the recording lacks.
    pub static_transforms: Vec<StaticTransform>,
    /// Largest difference of the stamps of a colour and a depth image that belong together, seconds.
    pub pair_tolerance_s: f64,
    /// How far past the newest transform a stamp may lie and still take it, seconds.
    pub transform_tolerance_s: f64,
    /// Metres per count of integer depth images (0.001: millimetres).
    pub depth_unit_m: f64,
    /// Metres per unit of float depth images (1: metres).
    pub float_depth_unit_m: f64,

    /// Where the ground is taken from.
    pub ground: GroundSource,
    /// Height of the ground in the map frame, metres; where it is estimated, what is taken until it was seen.
    pub ground_z_m: f64,
    /// How long an estimated ground is believed that is not seen any more, seconds.
    pub ground_keep_s: f64,
    /// Depth below an estimated ground from which a place is a drop, metres; 0: none is.
    pub drop_m: f64,
    /// Smallest depth taken as measured, metres (all methods but naive, median and temporal).
    pub depth_min_m: f64,
    /// Largest depth taken as measured, metres (same methods).
    pub depth_max_m: f64,
    /// Largest depth that range gating lets through, metres.
    pub range_gate_m: f64,
    /// Largest horizontal distance from the camera at which cells are marked and cleared, metres.
    pub mark_range_m: f64,
    /// Lower edge of the obstacle height band above the ground, metres.
    pub height_min_m: f64,
    /// Upper edge of the obstacle height band above the ground, metres.
    pub height_max_m: f64,

    /// Side of the rolling map, metres.
    pub map_size_m: f64,
    /// Side of a cell, metres.
    pub resolution_m: f64,
    /// tau: pixels of weight up to this neither mark nor clear.
    pub tau: f64,
    /// lambda: share of the old occupancy kept by an observation.
    pub lambda: f64,
    /// Use lambda^(dt 30 Hz) in place of lambda, so that forgetting does not depend on the frame rate.
    pub rate_independent: bool,
    /// Occupancy at which a cell becomes occupied.
    pub occupied_threshold: f64,
    /// Occupancy under which a cell stops being occupied and may become free.
    pub free_threshold: f64,
    /// K: consecutive observed frames with hits before a cell may become occupied.
    pub confirmations: u32,
    /// Pixels that a cell needs in one frame to count as hit.
    pub min_hits: u32,
    /// Temporal rejection: how many of the last observed frames are looked at (1..=16).
    pub temporal_window: u32,
    /// Temporal rejection: in how many of them a cell must be hit to mark.
    pub temporal_hits: u32,

    /// Distance from an obstacle up to which costs reach, metres.
    pub inflation_radius_m: f64,
    /// Radius of the robot's inscribed circle, metres.
    pub inscribed_radius_m: f64,
    /// How fast costs fall with distance, 1/m.
    pub cost_scaling_factor: f64,
    /// Share of low-reliability pixels above which a frame is DEGRADED.
    pub degraded_fraction: f64,
    /// The cloud of trusted points holds every n-th pixel along rows and columns; 0: no cloud is written.
    pub cloud_stride: u32,

    /// How often the map of several sensors is published, Hz.
    pub publish_rate_hz: f64,
    /// Time without data after which a sensor is stale, seconds; 0: never. The default of every sensor.
    pub timeout_s: f64,
    /// Age of its last evidence from which a free or passable cell is unknown again, seconds; 0: never.
    pub cell_timeout_s: f64,
    /// How long a message of one of several sensors waits for earlier ones of the others, seconds.
    pub order_window_s: f64,
    /// Live: how long a depth image or a scan waits at most for what belongs to it, seconds.
    pub wait_s: f64,
    /// Live: time from a sensor's data to the map after which the map is not sent any more, seconds; 0: never.
    pub publish_deadline_s: f64,
    /// Live: width of the unknown margin around the window, metres: the grid's origin holds while the window moves inside.
    pub full_map_m: f64,
    /// Live: whether time is that of `/clock`.
    pub use_sim_time: bool,
    /// Live: whether sensor data are asked for reliably where all who publish them offer it.
    pub reliable_sensors: bool,
    /// Live: the speed limit while the map is not OK, percent of the largest speed.
    pub degraded_speed_percent: f64,
    /// Whether a cell that lidars call passable and cameras occupied is passable; otherwise it is occupied.
    pub passable_over_camera: bool,
    /// Which occupied cells of the cameras a lidar may refute by beams that crossed them.
    pub lidar_clears_camera: LidarClearsCamera,
    /// How costs fall around lethal cells; [`Config::inflation_law`] resolves it.
    pub inflation_law: InflationLaw,

    /// Topic with lidar scans; empty: found by message type, packets before clouds.
    pub scan_topic: String,
    /// Model of a Velodyne sensor; none: from the packets.
    pub velodyne_model: Option<Model>,
    /// UDP port of the data packets in a capture.
    pub velodyne_port: u16,
    /// Field of clouds that holds the intensity; empty: found by name.
    pub intensity_field: String,
    /// Meaning of the numbers in a cloud's `return_type` field.
    pub return_codes: ReturnCodes,
    /// Frame of the lidar; empty: the scan's own `frame_id`.
    pub lidar_frame: String,
    /// Most points of a scan that the lidar's passes are built for; a larger first scan raises it.
    pub max_points: u32,
    /// Topic with the robot's goal (`geometry_msgs/PoseStamped`); empty: none.
    pub goal_topic: String,
    /// The goal, x and y in the map frame, metres, until one comes on the topic; empty: straight ahead.
    pub goal_m: Vec<f64>,
    /// Side of the lidar map, metres.
    pub scan_map_size_m: f64,
    /// g: side of a cell of the lidar map, metres.
    pub scan_resolution_m: f64,
    /// Whether the points of a revolution are placed by the pose at their own times.
    pub deskew: bool,
    /// Speed from one scan to the next above which the lidar's pose counts as having jumped, m/s; 0: none does.
    pub pose_jump_m_s: f64,
    /// Rate of turning above which it does, degrees per second; 0: none does.
    pub pose_jump_deg_s: f64,
    /// What makes a lidar's cell solid: bright returns, shape and beams that end there, or any return above the ground.
    pub solidity: Solidity,
    /// R: intensity of full scale, in the sensor's unit; 0: `intensity_percentile` of the first scan.
    pub intensity_full_scale: f64,
    /// Percentile of the first scan's intensities that is taken as full scale.
    pub intensity_percentile: f64,
    /// Bounds of the tall layers above the sensor, ascending, metres: one layer between two.
    pub layer_heights_m: Vec<f64>,
    /// Where the planes z = 0 and z = -epsilon come from.
    pub plane_source: PlaneSource,
    /// epsilon: depth of the lower plane below the sensor where slabs are taken, metres.
    pub plane_below_m: f64,
    /// Half the thickness of these slabs, metres.
    pub plane_half_thickness_m: f64,
    /// What a layer's value is made of.
    pub layer_measure: LayerMeasure,
    /// Angle between two firings, degrees, for the expected number of beams.
    pub azimuth_step_deg: f64,
    /// Angle between two rings, degrees, for the same.
    pub elevation_step_deg: f64,
    /// The lowest and the highest ring, degrees above the horizontal, for the same.
    pub elevation_range_deg: [f64; 2],
    /// Returns under which a cell stays undecided (unknown).
    pub min_returns: u32,
    /// Gamma: a cell none of whose layers is above it is passable; in the unit of `layer_measure`. `None`: 0.5 where intensity is
    /// asked for ([`Config::gamma_or_default`]), and `solidity: auto` is learned.
    pub gamma: Option<f64>,
    /// Excess of the plane z = 0 over the plane below it from which a cell counts as transparent; same unit.
    pub transparent_threshold: f64,
    /// Time in which a transparent cell's value falls to 1/e, seconds; 0: never.
    pub transparent_decay_s: f64,
    /// Share of full scale from which a return clears the transparent cells before it; 0: never.
    pub transparent_clear: f64,
    /// Shape of the inflation of solid and transparent cells.
    pub inflation_kernel: InflationKernel,
    /// How far it reaches, metres.
    pub inflation_length_m: f64,
    /// Cells on each side of the line along the goal's direction.
    pub inflation_padding_cells: u32,
    /// How far it reaches in all other directions, metres.
    pub inflation_side_m: f64,
    /// Cost of a passable cell, 0 to 252.
    pub passable_cost: u32,

    /// Whether panes of glass are searched for in lidar scans (spec 3).
    pub glass: bool,
    /// Whether panes are kept from scan to scan.
    pub glass_memory: bool,
    /// Whether mirrors are searched for too, where the lidar gives two returns.
    pub glass_mirrors: bool,
    /// YAML file with panes to begin with; empty: none.
    pub glass_panes: String,
    /// Seed of the draws of hypotheses.
    pub glass_seed: u32,
    /// Hypotheses for each plane, 32 to 512.
    pub glass_hypotheses: u32,
    /// Returns of a beam differ when they are farther apart than this, metres.
    pub glass_return_gap_m: f64,
    /// Candidates that a pane needs in one scan.
    pub glass_min_inliers: u32,
    /// Beams that must go on behind a pane.
    pub glass_min_behind: u32,
    /// Distance from a plane at which a candidate fits it, metres.
    pub glass_fit_tolerance_m: f64,
    /// Distance from a pane's plane at which a return lies on it, metres.
    pub glass_plane_tolerance_m: f64,
    /// Difference of ranges at which a mirrored and a measured surface are one, metres.
    pub glass_match_m: f64,
    /// Its growth per metre of range.
    pub glass_match_per_m: f64,
    /// Angle within which mirrored surfaces count as around a beam, degrees.
    pub glass_slack_deg: f64,
    /// How many times brighter than the lower quartile of its candidates a return on a pane is frame and no glass.
    pub glass_bright_ratio: f64,
    /// Angle from head on within which glass shines as bright as anything, degrees.
    pub glass_lobe_deg: f64,
    /// Angle from head on within which glass always returns a beam, degrees.
    pub glass_visible_deg: f64,

    /// The sensors that the nested form names; empty: they are found in the recording. Not a key of the flat form.
    #[serde(skip)]
    pub sensors: Vec<SensorConfig>,
}

impl Config {
    /// With a method in place of [`Method::Auto`]: drm where there is colour that can be used, else range.
    pub fn resolved(&self, has_color: bool) -> Self {
        let method = match self.method {
            Method::Auto if has_color => Method::Drm,
            Method::Auto => Method::Range,
            stated => stated,
        };
        Self { method, ..self.clone() }
    }

    /// Cells along one side of the map.
    ///
    /// # Errors
    /// [`Error::Config`] where size and resolution give fewer than 8 or more than 4096 cells.
    pub fn cells_per_side(&self) -> Result<u32> {
        cells("map_size_m", self.map_size_m, self.resolution_m)
    }
}

/// Cells of `resolution_m` along `size_m`.
fn cells(key: &str, size_m: f64, resolution_m: f64) -> Result<u32> {
    let cells = (size_m / resolution_m).round();
    if !(8.0..=4096.0).contains(&cells) {
        let reason = format!(
            "{size_m} m at {resolution_m} m a cell gives {cells} cells a side; 8 to 4096 are supported"
        );
        return Err(bad_key(key, reason));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to lie in 8..=4096")]
    Ok(cells as u32)
}

pub(crate) fn bad_key(key: &str, reason: String) -> Error {
    Error::Config { key: key.into(), reason }
}
