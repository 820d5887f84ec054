//! Parameters: flat, with units in their names; read from YAML, checked as a whole.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Every parameter with its default, commented, as YAML.
pub const EXAMPLE: &str = include_str!("../testdata/config/limpid.yaml");

/// How depth becomes evidence (spec 1 §4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Any depth above 0, weight 1.
    Naive,
    /// Depth in `[depth_min_m, range_gate_m]`, weight 1.
    Range,
    /// Median of the valid pixels in 5x5, then as naive.
    Median,
    /// As naive, but a cell marks only when hit in some of its last observed frames.
    Temporal,
    /// Depth in `[depth_min_m, depth_max_m]`, weighted by the reliability that DRM-Net predicts.
    Drm,
}

/// What a pixel of reliability R above tau counts (spec 1 §2, §3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fusion {
    /// R, as in the paper.
    Weight,
    /// 1.
    Gate,
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// How depth becomes evidence.
    pub method: Method,
    /// Weight file of DRM-Net (safetensors), for method drm.
    pub weights: String,
    /// What a pixel of reliability R above tau counts: R, or 1.
    pub fusion: Fusion,

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
    /// Intrinsics of a still pair, row-major 3x3, pixels.
    pub camera_matrix: [f64; 9],
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

    /// Height of the ground in the map frame, metres.
    pub ground_z_m: f64,
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
}

impl Default for Config {
    fn default() -> Self {
        Self {
            method: Method::Range,
            weights: String::new(),
            fusion: Fusion::Weight,
            depth_topic: String::new(),
            depth_info_topic: String::new(),
            color_topic: String::new(),
            color_info_topic: String::new(),
            confidence_topic: String::new(),
            depth_file: String::new(),
            color_file: String::new(),
            camera_matrix: [0.0; 9],
            odometry_topic: String::new(),
            map_frame: "map".into(),
            base_frame: "base_link".into(),
            camera_frame: String::new(),
            static_transforms: Vec::new(),
            pair_tolerance_s: 0.02,
            transform_tolerance_s: 0.0,
            depth_unit_m: 0.001,
            ground_z_m: 0.0,
            depth_min_m: 0.17,
            depth_max_m: 10.0,
            range_gate_m: 5.0,
            mark_range_m: 5.0,
            height_min_m: 0.1,
            height_max_m: 2.0,
            map_size_m: 12.0,
            resolution_m: 0.05,
            tau: 0.3,
            lambda: 0.85,
            rate_independent: false,
            occupied_threshold: 0.7,
            free_threshold: 0.5,
            confirmations: 1,
            min_hits: 1,
            temporal_window: 5,
            temporal_hits: 3,
            inflation_radius_m: 0.55,
            inscribed_radius_m: 0.1,
            cost_scaling_factor: 10.0,
            degraded_fraction: 0.5,
            cloud_stride: 2,
        }
    }
}

/// The ROS 2 parameter file shape around the same keys.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NodeFile {
    limpid: NodeParameters,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NodeParameters {
    #[serde(rename = "ros__parameters")]
    ros_parameters: Config,
}

impl Config {
    /// Reads a YAML file; see [`Config::from_yaml`].
    ///
    /// # Errors
    /// As [`Config::from_yaml`], and [`Error::File`].
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
        Self::from_yaml(&text)
    }

    /// From YAML text: the keys at the top level, or under `limpid: ros__parameters:` as ROS 2
    /// parameter files have them. Missing keys keep their defaults.
    ///
    /// # Errors
    /// [`Error::Yaml`] with line, column and snippet; it names unknown keys and the nearest known
    /// one. [`Error::Config`] from [`Config::validate`].
    pub fn from_yaml(text: &str) -> Result<Self> {
        let wrapped = text.lines().any(|line| line.trim_end() == "limpid:");
        let config = if text.lines().all(|line| line.trim().is_empty() || line.trim().starts_with('#')) {
            Self::default()
        } else if wrapped {
            serde_saphyr::from_str::<NodeFile>(text).map_err(yaml_error)?.limpid.ros_parameters
        } else {
            serde_saphyr::from_str(text).map_err(yaml_error)?
        };
        config.validate()?;
        Ok(config)
    }

    /// Cells along one side of the map.
    ///
    /// # Errors
    /// [`Error::Config`] where size and resolution give fewer than 8 or more than 4096 cells.
    pub fn cells_per_side(&self) -> Result<u32> {
        let cells = (self.map_size_m / self.resolution_m).round();
        if !(8.0..=4096.0).contains(&cells) {
            return Err(bad_key(
                "map_size_m",
                format!(
                    "{} m at {} m a cell gives {cells} cells a side; 8 to 4096 are supported",
                    self.map_size_m, self.resolution_m
                ),
            ));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked to lie in 8..=4096"
        )]
        Ok(cells as u32)
    }

    /// Checks every value and their relations.
    ///
    /// # Errors
    /// [`Error::Config`] for the first key at fault.
    pub fn validate(&self) -> Result<()> {
        self.positive()?;
        self.shares()?;
        self.orders()?;
        self.counts()?;
        if self.inflation_radius_m > 254.0 * self.resolution_m {
            let largest = 254.0 * self.resolution_m;
            return Err(bad_key("inflation_radius_m", format!("is above 254 cells ({largest} m)")));
        }
        self.cells_per_side().map(|_| ())
    }

    fn positive(&self) -> Result<()> {
        for (key, value) in [
            ("resolution_m", self.resolution_m),
            ("map_size_m", self.map_size_m),
            ("depth_unit_m", self.depth_unit_m),
            ("depth_max_m", self.depth_max_m),
            ("range_gate_m", self.range_gate_m),
            ("mark_range_m", self.mark_range_m),
            ("cost_scaling_factor", self.cost_scaling_factor),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(bad_key(key, format!("{value} is not a positive number")));
            }
        }
        for (key, value) in [
            ("pair_tolerance_s", self.pair_tolerance_s),
            ("transform_tolerance_s", self.transform_tolerance_s),
            ("depth_min_m", self.depth_min_m),
            ("inflation_radius_m", self.inflation_radius_m),
            ("inscribed_radius_m", self.inscribed_radius_m),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(bad_key(key, format!("{value} is not a number from 0 up")));
            }
        }
        if !self.ground_z_m.is_finite() {
            return Err(bad_key("ground_z_m", format!("{} is not finite", self.ground_z_m)));
        }
        Ok(())
    }

    fn shares(&self) -> Result<()> {
        for (key, value) in [
            ("tau", self.tau),
            ("lambda", self.lambda),
            ("occupied_threshold", self.occupied_threshold),
            ("free_threshold", self.free_threshold),
            ("degraded_fraction", self.degraded_fraction),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return Err(bad_key(key, format!("{value} is not in [0, 1]")));
            }
        }
        Ok(())
    }

    fn orders(&self) -> Result<()> {
        for (low_key, low, high_key, high) in [
            ("height_min_m", self.height_min_m, "height_max_m", self.height_max_m),
            ("depth_min_m", self.depth_min_m, "depth_max_m", self.depth_max_m),
            ("depth_min_m", self.depth_min_m, "range_gate_m", self.range_gate_m),
        ] {
            if low.partial_cmp(&high) != Some(std::cmp::Ordering::Less) {
                return Err(bad_key(low_key, format!("{low} is not below `{high_key}` = {high}")));
            }
        }
        if self.free_threshold > self.occupied_threshold {
            return Err(bad_key(
                "free_threshold",
                "is above `occupied_threshold`: the hysteresis would never settle".into(),
            ));
        }
        if self.inscribed_radius_m > self.inflation_radius_m {
            return Err(bad_key(
                "inscribed_radius_m",
                "is above `inflation_radius_m`: the robot would be larger than its safety margin".into(),
            ));
        }
        Ok(())
    }

    fn counts(&self) -> Result<()> {
        if self.cloud_stride > 1024 {
            return Err(bad_key("cloud_stride", format!("{} is not in 0..=1024", self.cloud_stride)));
        }
        for (key, value, max) in [
            ("confirmations", self.confirmations, 200),
            ("min_hits", self.min_hits, 1_000_000),
            ("temporal_window", self.temporal_window, 16),
            ("temporal_hits", self.temporal_hits, self.temporal_window),
        ] {
            if !(1..=max).contains(&value) {
                return Err(bad_key(key, format!("{value} is not in 1..={max}")));
            }
        }
        Ok(())
    }
}

fn bad_key(key: &str, reason: String) -> Error {
    Error::Config { key: key.into(), reason }
}

/// serde's text plus, for an unknown key, the known one that is nearest.
fn yaml_error(error: serde_saphyr::Error) -> Error {
    let text = error.to_string();
    let unknown = text.split("unknown field `").nth(1).and_then(|rest| rest.split('`').next());
    let nearest = unknown.and_then(|key| {
        known_keys()
            .into_iter()
            .map(|known| (strsim::jaro_winkler(key, &known), known))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    });
    Error::Yaml(match nearest {
        Some((_, known)) => format!("{text}\nhelp: the nearest key is `{known}`"),
        None => text,
    })
}

fn known_keys() -> Vec<String> {
    match serde_json::to_value(Config::default()) {
        Ok(serde_json::Value::Object(map)) => map.keys().cloned().collect(),
        _ => Vec::new(),
    }
}
