//! What is compared: scenarios, and in each the methods or sensors that map it (spec 7 §2 to §4).

use crate::config::{Config, Fusion, GroundSource, InflationKernel, LayerMeasure, Method, Solidity};
use crate::sim::generate::{Family, Level};

/// Worlds and what they ask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Scenario {
    /// Glare on corridors, halls and glass fronts, a camera (Tables V and VI)
    Glare,
    /// Indoor glass, walls, pillars, a lidar (scenario 1 of Table I)
    Glass,
    /// A curtain in a narrow passage (scenario 2)
    Curtain,
    /// Grass, bushes, trees apart (scenario 3)
    Vegetation,
    /// Grass, bushes, trees intertwined (scenario 4)
    Thicket,
    /// A hall with a polished floor, a glass front, a string curtain and furniture: camera and lidar (scenario 5)
    Both,
    /// A camera that dies on the way: STALE must stop the robot
    Dying,
}

impl Scenario {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Glare, Self::Glass, Self::Curtain, Self::Vegetation, Self::Thicket, Self::Both, Self::Dying];

    /// Its name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Glare => "glare",
            Self::Glass => "glass",
            Self::Curtain => "curtain",
            Self::Vegetation => "vegetation",
            Self::Thicket => "thicket",
            Self::Both => "both",
            Self::Dying => "dying",
        }
    }

    /// Where its worlds come from.
    pub fn family(self) -> Family {
        match self {
            Self::Glare | Self::Dying => Family::Drive,
            Self::Glass => Family::Glass,
            Self::Curtain => Family::Curtain,
            Self::Vegetation => Family::Vegetation,
            Self::Thicket => Family::Thicket,
            Self::Both => Family::Mixed,
        }
    }

    /// Whether its worlds differ by glare level.
    pub fn has_levels(self) -> bool {
        matches!(self, Self::Glare | Self::Dying)
    }

    /// The glare level of worlds that have none to choose from: scenario 5 has a polished floor.
    pub fn own_level(self) -> Level {
        if self == Self::Both { Level::L2 } else { Level::L0 }
    }

    /// What is compared in it, the default last.
    pub fn setups(self, base: &Config) -> Vec<Setup> {
        match self {
            Self::Glare => glare(base),
            Self::Glass | Self::Curtain | Self::Vegetation | Self::Thicket => lidar(base),
            Self::Both => both(base),
            Self::Dying => glare(base).into_iter().filter(|setup| setup.key == "drm").collect(),
        }
    }
}

/// Sensors with their parameters, and those of their map.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Its name in tables.
    pub key: &'static str,
    /// The map's.
    pub config: Config,
    /// The camera's, where there is one.
    pub camera: Option<Config>,
    /// The lidar's, where there is one.
    pub lidar: Option<Config>,
    /// Whether of the lidar only the ring nearest to the horizontal is left.
    pub one_ring: bool,
}

impl Setup {
    fn camera(key: &'static str, config: Config) -> Self {
        Self { key, camera: Some(config.clone()), lidar: None, one_ring: false, config }
    }

    /// Its cells are larger than a camera's, and round off more of the robot's radius.
    fn lidar(key: &'static str, mut config: Config) -> Self {
        config.inscribed_radius_m +=
            half_diagonal(config.scan_resolution_m) - half_diagonal(config.resolution_m);
        Self { key, camera: None, lidar: Some(config.clone()), one_ring: false, config }
    }
}

/// How far a point may lie from the centre of its cell.
pub fn half_diagonal(cell_m: f64) -> f64 {
    cell_m * std::f64::consts::FRAC_1_SQRT_2
}

/// The five methods of the glare paper. The baselines have its fusion and its fixed height band: they know the floor, and mark
/// no drops.
fn glare(base: &Config) -> Vec<Setup> {
    let paper = Config { fusion: Fusion::Weight, ground: GroundSource::Stated, ..base.clone() };
    let with = |key, method| Setup::camera(key, Config { method, ..paper.clone() });
    vec![
        with("naive", Method::Naive),
        with("range", Method::Range),
        with("median", Method::Median),
        with("temporal", Method::Temporal),
        Setup::camera("drm", Config { method: Method::Drm, ..base.clone() }),
    ]
}

/// The methods of the intensity paper, and the default with panes.
fn lidar(base: &Config) -> Vec<Setup> {
    let standing = Config { solidity: Solidity::Standing, ..base.clone() };
    let paper = Config {
        solidity: Solidity::Intensity,
        layer_measure: LayerMeasure::Mean,
        ground: GroundSource::Stated,
        ..base.clone()
    };
    let inflated = |key, inflation_kernel| Setup::lidar(key, Config { inflation_kernel, ..paper.clone() });
    vec![
        Setup { one_ring: true, ..Setup::lidar("laser_scan", standing.clone()) },
        Setup::lidar("occupancy", standing),
        inflated("uniform", InflationKernel::Uniform),
        inflated("adaptive", InflationKernel::Adaptive),
        Setup::lidar("default", Config { glass: true, ..base.clone() }),
    ]
}

/// Either sensor alone, and both in one map.
fn both(base: &Config) -> Vec<Setup> {
    let config = Config { glass: true, ..base.clone() };
    let camera = Config { method: Method::Drm, ..config.clone() };
    vec![
        Setup::camera("camera", camera.clone()),
        Setup::lidar("lidar", config.clone()),
        Setup { key: "both", camera: Some(camera), lidar: Some(config.clone()), one_ring: false, config },
    ]
}
