//! `limpid eval`: what is scored depends on the kind of input.

mod glass;
mod glass_scenes;
mod pairs;
mod scenes;
mod shown;

use std::path::{Path, PathBuf};

use clap::Args;
use limpid::config::Config;
use limpid::sim::generate::{Family, Level};
use limpid::{Error, Result};
use serde_json::Value;

use self::shown::ToShow;
use super::paths::{Paths, ends_in};
use super::save;

#[derive(Debug, Args)]
pub(crate) struct EvalArguments {
    /// Labelled lidar scans (a PLY file or a folder of them), or recordings with ground truth (as `limpid sim` writes them), or with --pairs one folder of still pairs; none: scenes are
    /// generated
    inputs: Vec<PathBuf>,
    /// Score still pairs (colour, depth, reference, mask) that this YAML file lists
    #[arg(long, value_name = "FILE", requires = "inputs")]
    pairs: Option<PathBuf>,
    /// Poses of the lidar in the map, lines `t x y z qx qy qz qw`, for labelled scans
    #[arg(long, value_name = "FILE", requires = "inputs")]
    poses: Option<PathBuf>,
    /// Whether panes of glass are kept from one labelled scan to the next
    #[arg(long, value_enum, default_value = "on")]
    memory: Memory,
    /// Score labels and panes on this many simulated drives past glass (HDL-32E, dual return), from --first-seed on
    #[arg(long, value_name = "N", conflicts_with_all = ["inputs", "html", "keep"], value_parser = clap::value_parser!(u32).range(1..))]
    glass_scenes: Option<u32>,
    /// Scans of each of these drives
    #[arg(long, value_name = "N", default_value_t = 100, requires = "glass_scenes", value_parser = clap::value_parser!(u32).range(1..))]
    scans: u32,
    /// How much their floors mirror: L0 not at all
    #[arg(long, value_enum, value_name = "LEVEL", default_value = "L0", requires = "glass_scenes")]
    floor: Level,
    /// Take all panes and mirrors out of these rooms: what is found is false
    #[arg(long, requires = "glass_scenes")]
    without_glass: bool,
    /// Keep the counts of every scene or recording here, and take those that are there already
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Score drm's fusion at other points of its frontier between false obstacles and missed ones too
    #[arg(long)]
    frontier: bool,
    #[command(flatten)]
    scenes: SceneArguments,
    /// Parameters in YAML that all methods share; `fusion` and `weights` are those of drm
    #[arg(short, long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Weight file of DRM-Net (safetensors), in place of the configuration's
    #[arg(long, value_name = "FILE")]
    weights: Option<String>,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with tables and pictures: DIR/index.html
    #[arg(long, value_name = "DIR")]
    html: Option<PathBuf>,
    /// Show a recording without ground truth on the page too: its last frame and the maps up to there; repeat for more
    #[arg(long, value_name = "RECORDING[,CONFIG]", requires = "html")]
    show: Vec<ToShow>,
    /// Use the adapter whose name or driver contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Whether panes are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Memory {
    /// From scan to scan, where there are poses
    On,
    /// Every scan by itself
    Off,
}

/// Which scenes are generated.
#[derive(Debug, Args)]
#[group(id = "generated", multiple = true, conflicts_with = "inputs")]
struct SceneArguments {
    /// Scenes of each level
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    scenes: u32,
    /// Three scenes of each level, 24 frames each
    #[arg(long, conflicts_with = "scenes")]
    quick: bool,
    /// Frames of each scene, of which the first ten are not scored [default: 30]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(11..))]
    frames: Option<u32>,
    /// Which generator; no scene of held-out is ever trained on
    #[arg(long, value_enum, default_value = "train")]
    family: Family,
    /// Levels, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "L0,L1,L2")]
    levels: Vec<Level>,
    /// Seed of the first scene; training has those below 5000
    #[arg(long, value_name = "N", default_value_t = 5000)]
    first_seed: u64,
    /// Size of the images, a multiple of 8 pixels wide [default: 848x480]
    #[arg(long, value_name = "WxH", value_parser = super::sim::parse_size)]
    size: Option<(u32, u32)>,
    /// Draw imager, projector and matcher settings from the seed, as in training
    #[arg(long)]
    vary_sensor: bool,
    /// Let so many people walk past before the camera in every scene
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=8))]
    walkers: u32,
}

impl SceneArguments {
    /// Scenes of each level.
    fn count(&self) -> u32 {
        if self.quick { 3 } else { self.scenes }
    }

    fn frames(&self) -> u32 {
        self.frames.unwrap_or(if self.quick { 24 } else { 30 })
    }
}

impl EvalArguments {
    /// The configuration alone.
    fn base_config(&self) -> Result<Config> {
        let common = super::Common {
            config: self.config.clone(),
            method: None,
            weights: self.weights.clone(),
            port: None,
            adapter: self.adapter.clone(),
        };
        common.config()
    }

    fn config(&self) -> Result<Config> {
        self.base_config()
    }

    /// Figures and page to where they were asked for.
    fn write(&self, json: &Value, page: &str) -> Result<()> {
        if let Some(path) = &self.json {
            save(path, &format!("{json:#}\n"))?;
        }
        if let Some(folder) = &self.html {
            let path = folder.join("index.html");
            save(&path, page)?;
            println!("page: {}", path.display());
        }
        Ok(())
    }
}

impl EvalArguments {
    /// Everything that is read and written.
    fn paths<'a>(&'a self, config: &'a Config) -> Paths<'a> {
        let inputs = self.inputs.iter().map(PathBuf::as_path).chain(self.show.iter().flat_map(ToShow::paths));
        let paths = inputs.fold(Paths::default(), |paths, input| paths.reads("the recording", input));
        paths
            .may_read("-c", self.config.as_deref())
            .may_read("--pairs", self.pairs.as_deref())
            .may_read("--poses", self.poses.as_deref())
            .reads_of(config)
            .may_write("--json", self.json.as_deref())
            .may_fill("--html", self.html.as_deref(), |path| ends_in(path, &["html", "png"]))
            .may_fill("--keep", self.keep.as_deref(), |path| ends_in(path, &["json"]))
    }
}

pub(crate) fn execute(arguments: &EvalArguments) -> Result<()> {
    arguments.paths(&arguments.base_config()?).check()?;
    if let Some(folder) = &arguments.html {
        make_folder(folder)?;
    }
    if let Some(scenes) = arguments.glass_scenes {
        return glass_scenes::execute(arguments, scenes);
    }
    match (&arguments.pairs, arguments.inputs.as_slice()) {
        (Some(list), [folder]) => pairs::execute(arguments, list, folder),
        (Some(_), _) => Err(Error::Yaml("--pairs goes with one folder".into())),
        (None, [path]) if glass::is_scans(path) => glass::execute(arguments, path),
        (None, []) => scenes::generated(arguments),
        (None, recordings) => scenes::recorded(arguments, recordings),
    }
}

fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(Error::file(path))
}
