//! Which keys there are, and where in a file each may stand.

use super::SensorKind;
use crate::base::nearest;

/// What a parameter belongs to. It says where the nested form takes the key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// The map: under `map`.
    Map,
    /// Cameras: in a camera's section.
    Camera,
    /// Lidars: in a lidar's section.
    Lidar,
    /// Every sensor: in any section.
    Sensor,
    /// The flat form alone: with several sensors the map's own size and resolution hold.
    Flat,
}

/// All keys of the flat form by what they belong to.
const KEYS: [(Scope, &[&str]); 5] = [
    (Scope::Map, MAP),
    (Scope::Camera, CAMERA),
    (Scope::Lidar, LIDAR),
    (Scope::Sensor, &["timeout_s", "transform_tolerance_s"]),
    (Scope::Flat, &["scan_map_size_m", "scan_resolution_m"]),
];

const MAP: &[&str] = &[
    "map_frame",
    "base_frame",
    "odometry_topic",
    "static_transforms",
    "map_size_m",
    "resolution_m",
    "publish_rate_hz",
    "order_window_s",
    "wait_s",
    "publish_deadline_s",
    "full_map_m",
    "use_sim_time",
    "reliable_sensors",
    "degraded_speed_percent",
    "cell_timeout_s",
    "ground",
    "ground_z_m",
    "ground_keep_s",
    "drop_m",
    "height_min_m",
    "height_max_m",
    "passable_over_camera",
    "lidar_clears_camera",
    "passable_cost",
    "inflation_law",
    "inflation_radius_m",
    "inscribed_radius_m",
    "cost_scaling_factor",
    "inflation_kernel",
    "inflation_length_m",
    "inflation_padding_cells",
    "inflation_side_m",
    "goal_topic",
    "goal_m",
];

const CAMERA: &[&str] = &[
    "method",
    "weights",
    "fusion",
    "evidence_exponent",
    "evidence_least_hits",
    "learned_bias",
    "learned_weights",
    "depth_topic",
    "depth_info_topic",
    "color_topic",
    "color_info_topic",
    "confidence_topic",
    "depth_file",
    "color_file",
    "camera_matrix",
    "distortion",
    "distortion_model",
    "camera_frame",
    "pair_tolerance_s",
    "depth_unit_m",
    "float_depth_unit_m",
    "depth_min_m",
    "depth_max_m",
    "range_gate_m",
    "mark_range_m",
    "tau",
    "lambda",
    "rate_independent",
    "occupied_threshold",
    "free_threshold",
    "confirmations",
    "min_hits",
    "temporal_window",
    "temporal_hits",
    "degraded_fraction",
    "cloud_stride",
];

const LIDAR: &[&str] = &[
    "scan_topic",
    "velodyne_model",
    "velodyne_port",
    "intensity_field",
    "return_codes",
    "lidar_frame",
    "max_points",
    "deskew",
    "pose_jump_m_s",
    "pose_jump_deg_s",
    "solidity",
    "intensity_full_scale",
    "intensity_percentile",
    "layer_heights_m",
    "plane_source",
    "plane_below_m",
    "plane_half_thickness_m",
    "layer_measure",
    "azimuth_step_deg",
    "elevation_step_deg",
    "elevation_range_deg",
    "min_returns",
    "gamma",
    "transparent_threshold",
    "transparent_decay_s",
    "transparent_clear",
    "glass",
    "glass_memory",
    "glass_mirrors",
    "glass_panes",
    "glass_seed",
    "glass_hypotheses",
    "glass_return_gap_m",
    "glass_min_inliers",
    "glass_min_behind",
    "glass_fit_tolerance_m",
    "glass_plane_tolerance_m",
    "glass_match_m",
    "glass_match_per_m",
    "glass_slack_deg",
    "glass_bright_ratio",
    "glass_lobe_deg",
    "glass_visible_deg",
];

/// Where a file states a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// At the top level.
    Top,
    /// Under `map`.
    Map,
    /// In the section of a sensor.
    Sensor(SensorKind),
}

impl Place {
    /// Short names of this place, and the flat keys that they stand for.
    fn short_names(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Top => &[],
            Self::Map => &[("frame", "map_frame"), ("size_m", "map_size_m")],
            Self::Sensor(SensorKind::Camera) => &[("frame", "camera_frame")],
            Self::Sensor(SensorKind::Lidar) => &[("topic", "scan_topic"), ("frame", "lidar_frame")],
        }
    }

    fn takes(self, scope: Scope) -> bool {
        match self {
            Self::Top => true,
            Self::Map => scope == Scope::Map,
            Self::Sensor(kind) => scope == Scope::Sensor || scope == kind.scope(),
        }
    }

    /// The flat key that `key` stands for here; an error's text where there is none.
    pub(super) fn flat_key(self, key: &str) -> Result<&'static str, String> {
        if let Some((_, flat)) = self.short_names().iter().find(|(short, _)| *short == key) {
            return Ok(flat);
        }
        match known(key) {
            Some((scope, flat)) if self.takes(scope) => Ok(flat),
            Some((scope, _)) => Err(self.misplaced(scope)),
            None => Err(format!("is unknown; the nearest key is `{}`", nearest(key, self.names()))),
        }
    }

    fn misplaced(self, scope: Scope) -> String {
        let place = match self {
            Self::Top => "the top level",
            Self::Map => "`map`",
            Self::Sensor(SensorKind::Camera) => "a camera",
            Self::Sensor(SensorKind::Lidar) => "a lidar",
        };
        match scope {
            Scope::Map => format!("belongs under `map`, not to {place}"),
            Scope::Camera => format!("is a camera's key, not one of {place}"),
            Scope::Lidar => format!("is a lidar's key, not one of {place}"),
            Scope::Sensor => format!("is a sensor's key, not one of {place}"),
            Scope::Flat => {
                "is of the flat form alone: the map's size and resolution hold for lidars too".into()
            }
        }
    }

    /// The flat keys that may stand here.
    pub(super) fn flat_keys(self) -> impl Iterator<Item = &'static str> {
        KEYS.iter().filter(move |(scope, _)| self.takes(*scope)).flat_map(|(_, keys)| *keys).copied()
    }

    /// Every key that may stand here.
    fn names(self) -> impl Iterator<Item = &'static str> {
        let own = match self {
            Self::Top => ["map", "sensors"].as_slice(),
            Self::Map => &[],
            Self::Sensor(_) => &["kind"],
        };
        let short = self.short_names().iter().map(|(short, _)| *short);
        own.iter().copied().chain(self.flat_keys()).chain(short)
    }
}

impl SensorKind {
    fn scope(self) -> Scope {
        match self {
            Self::Camera => Scope::Camera,
            Self::Lidar => Scope::Lidar,
        }
    }
}

/// What the flat key `key` belongs to; `None` where there is no such key.
pub fn scope_of(key: &str) -> Option<Scope> {
    known(key).map(|(scope, _)| scope)
}

fn known(key: &str) -> Option<(Scope, &'static str)> {
    KEYS.iter().find_map(|&(scope, keys)| keys.iter().find(|known| **known == key).map(|&flat| (scope, flat)))
}
