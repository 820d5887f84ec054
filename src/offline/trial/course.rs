//! A series of trials: every set-up on the same worlds, seed by seed, kept in a folder so that a run can go on.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::drive::{Label, Terms, drive};
use super::record::Record;
use super::robot::Limits;
use super::setup::{Scenario, Setup, half_diagonal};
use super::world::World;
use crate::base::{Error, Result};
use crate::config::{Config, Method};
use crate::gpu::Context;
use crate::mapper::weight_files;
use crate::output::save_file;
use crate::sim::generate::Level;
use crate::sim::lidar::Lidar;

/// Image and rate of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum CameraMode {
    /// 424x240 at 10 Hz
    #[default]
    Small,
    /// 848x480 at 30 Hz, for a GPU
    Full,
}

impl CameraMode {
    fn numbers(self) -> ([u32; 2], f64) {
        match self {
            Self::Small => ([424, 240], 10.0),
            Self::Full => ([848, 480], 30.0),
        }
    }
}

/// Raised whenever the same settings give another trial.
const EDITION: u32 = 6;

/// Where sensors die in scenario `dying`, seconds after the robot was sent.
const DIES_S: f64 = 6.0;

/// What all trials of a series have in common.
#[derive(Debug, Clone)]
pub struct Course {
    /// Of all maps, before methods change it.
    pub config: Config,
    /// The camera.
    pub camera: CameraMode,
    /// Deviation of the odometry's error; 0: perfect.
    pub drift: f64,
    /// Of the robot.
    pub limits: Limits,
    /// Where records are kept; `None`: nowhere.
    pub keep: Option<PathBuf>,
    /// The weight files, in the order of [`weight_files`].
    weights: Vec<u64>,
    /// Records of earlier series, of which those that were made with the same settings are not made again.
    taken: Vec<Record>,
}

/// One trial to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Where and why.
    pub scenario: Scenario,
    /// How much glare.
    pub level: Level,
    /// What maps it.
    pub setup: Setup,
    /// Of world and task.
    pub seed: u64,
}

/// What [`Course::take`] needs of a file.
#[derive(Deserialize)]
struct Series {
    trials: Vec<Record>,
}

#[derive(Serialize, Deserialize)]
struct Kept {
    settings: String,
    record: Record,
}

impl Course {
    /// With a user's configuration: the robot's radius, with half a cell's diagonal for what cells round off, and forgetting by time in
    /// place of frames are the trials' own.
    ///
    /// # Errors
    /// [`Error::File`] where its weights cannot be read, [`Error::Config`].
    pub fn new(config: &Config, camera: CameraMode, drift: f64, keep: Option<PathBuf>) -> Result<Self> {
        let limits = Limits::default();
        let inscribed_radius_m = limits.radius_m + half_diagonal(config.resolution_m);
        let config = Config { inscribed_radius_m, rate_independent: true, ..config.clone() };
        config.validate()?;
        if !(0.0..=0.5).contains(&drift) {
            return Err(Error::Config { key: "drift".into(), reason: format!("{drift} is not in [0, 0.5]") });
        }
        let weights = weight_files(&config)?.iter().map(fingerprint).collect();
        if let Some(folder) = &keep {
            std::fs::create_dir_all(folder).map_err(Error::file(folder))?;
        }
        Ok(Self { config, camera, drift, limits, keep, weights, taken: Vec::new() })
    }

    /// Takes the figures of trials that another series left in a JSON file ([`Report::json`](super::Report::json)).
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Input`] where it is none.
    pub fn take(&mut self, path: &Path) -> Result<()> {
        let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
        let bad = |reason: String| Error::Input { what: path.display().to_string(), reason };
        let series: Series = serde_json::from_str(&text).map_err(|error| bad(error.to_string()))?;
        self.taken.extend(series.trials);
        Ok(())
    }

    /// All trials of a scenario, those of a seed together.
    pub fn trials(
        &self,
        scenario: Scenario,
        levels: &[Level],
        methods: &[String],
        seeds: &[u64],
    ) -> Vec<Trial> {
        let levels = if scenario.has_levels() { levels } else { &[scenario.own_level()] };
        let wanted = |setup: &Setup| methods.is_empty() || methods.iter().any(|name| name == setup.key);
        let setups: Vec<Setup> = scenario.setups(&self.config).into_iter().filter(wanted).collect();
        let mut trials = Vec::new();
        for &seed in seeds {
            for &level in levels {
                trials.extend(setups.iter().cloned().map(|setup| Trial { scenario, level, setup, seed }));
            }
        }
        trials
    }

    /// The world of a trial, the same for all its set-ups.
    ///
    /// # Errors
    /// Those of [`World::generated`].
    pub fn world(&self, trial: &Trial) -> Result<World> {
        let (family, level) = (trial.scenario.family(), trial.level);
        let mut world = World::generated(family, level, trial.seed, &self.limits, &self.config)?;
        let ([width, height], rate_hz) = self.camera.numbers();
        world.scene.camera.width = width;
        world.scene.camera.height = height;
        world.scene.trajectory.rate_hz = if trial.setup.camera.is_some() { rate_hz } else { 10.0 };
        if trial.setup.lidar.is_some() {
            world.scene.lidar = Some(Lidar { rate_hz: 10.0, ..Lidar::default() });
        }
        Ok(world)
    }

    /// Makes a trial, or takes what is kept of it; whether it was made.
    ///
    /// # Errors
    /// Those of [`drive`]; [`Error::File`] where its record cannot be kept.
    pub fn run(&self, context: &Context, trial: &Trial) -> Result<(Record, bool)> {
        let path = self.path(trial);
        let settings = self.settings(trial);
        let print = format!("{:016x}", fingerprint(&settings));
        let is_it = |record: &&Record| {
            let names = [&record.scenario, &record.level, &record.method];
            let wanted = [trial.scenario.name(), &format!("{:?}", trial.level), trial.setup.key];
            names.iter().zip(wanted).all(|(name, wanted)| *name == wanted)
                && (record.seed, &record.settings) == (trial.seed, &print)
        };
        let kept = path.as_deref().and_then(|path| kept(path, &settings));
        if let Some(record) = kept.or_else(|| self.taken.iter().find(is_it).cloned()) {
            return Ok((record, false));
        }
        let world = self.world(trial)?;
        let label = Label {
            scenario: trial.scenario.name().into(),
            level: format!("{:?}", trial.level),
            seed: trial.seed,
        };
        let dies_at_s = (trial.scenario == Scenario::Dying).then_some(DIES_S);
        let terms = Terms { drift: self.drift, dies_at_s, ..Terms::default() };
        let mut record = drive(context, &world, &trial.setup, &self.limits, terms, &label)?;
        record.settings = print;
        if let Some(path) = path {
            let kept = Kept { settings, record: record.clone() };
            let bad =
                |error: serde_json::Error| Error::Encode { path: path.clone(), reason: error.to_string() };
            save_file(&path, serde_json::to_string(&kept).map_err(bad)?.as_bytes())?;
        }
        Ok((record, true))
    }

    fn path(&self, trial: &Trial) -> Option<PathBuf> {
        let Trial { scenario, level, setup, seed } = trial;
        let name = format!("{}-{level:?}-{}-{seed}.json", scenario.name(), setup.key);
        Some(self.keep.as_ref()?.join(name))
    }

    /// Changes with whatever changes a trial, so that kept ones are used only where they still hold.
    fn settings(&self, trial: &Trial) -> String {
        let Self { camera, drift, limits, .. } = self;
        let (version, setup) = (env!("CARGO_PKG_VERSION"), &trial.setup);
        let has_network =
            setup.camera.as_ref().is_some_and(|camera| matches!(camera.method, Method::Drm | Method::Auto));
        // Those of the camera's network, of its map's reliability, of the lidar's solidity.
        let runs = [has_network, has_network, setup.lidar.is_some()];
        let weights: Vec<u64> =
            self.weights.iter().zip(runs).filter_map(|(&weights, runs)| runs.then_some(weights)).collect();
        let Setup { key, config, camera: of_camera, lidar, one_ring } = setup;
        let [of_map, of_camera, of_lidar] = [Some(config), of_camera.as_ref(), lidar.as_ref()].map(changed);
        format!(
            "{version} edition {EDITION} {camera:?} {drift} {limits:?} weights {weights:x?} {key} map {of_map} camera {of_camera} \
             lidar {of_lidar} one ring {one_ring}"
        )
    }
}

/// The keys of a configuration that differ from the default, so that trials hold when others come to be; `null` for none.
fn changed(config: Option<&Config>) -> Value {
    let keys = |config: &Config| match serde_json::to_value(config) {
        Ok(Value::Object(keys)) => keys,
        _ => Map::default(),
    };
    let Some(config) = config else { return Value::Null };
    let default = keys(&Config::default());
    keys(config).into_iter().filter(|(key, value)| default.get(key) != Some(value)).collect()
}

fn fingerprint(of: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    of.hash(&mut hasher);
    hasher.finish()
}

/// A kept record that was made with the same settings.
fn kept(path: &Path, settings: &str) -> Option<Record> {
    let text = std::fs::read_to_string(path).ok()?;
    let kept: Kept = serde_json::from_str(&text).ok()?;
    (kept.settings == settings).then_some(kept.record)
}
