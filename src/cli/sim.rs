//! `limpid sim`.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use limpid::sim::generate::{Family, Level, generate, vary_sensor};
use limpid::sim::rates::Rates;
use limpid::sim::truth::TrueMap;
use limpid::sim::{Scene, Simulator, write};
use limpid::{Config, Error, Result};

use super::save;

/// Frames of a generated scene unless asked for otherwise.
const FRAMES: u32 = 60;

#[derive(Debug, Args)]
pub(crate) struct SimArguments {
    /// Scene in YAML; `--seed N --save-scene FILE` makes one to start from
    #[arg(required_unless_present = "seed", conflicts_with_all = ["seed", "level", "family"])]
    scene: Option<PathBuf>,
    /// Generate the scene of this number
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Glare of the generated scene
    #[arg(long, value_enum, default_value = "L1", requires = "seed")]
    level: Level,
    /// Which generator; held-out scenes are for evaluation only
    #[arg(long, value_enum, default_value = "train", requires = "seed")]
    family: Family,
    /// Draw imager, projector and matcher settings from the seed
    #[arg(long)]
    vary_sensor: bool,
    /// Frames, in place of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Size of the images, a multiple of 8 pixels wide
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: Option<(u32, u32)>,
    /// Write the recording with its ground truth: an MCAP file, or a TUM RGB-D folder
    #[arg(short, long, value_name = "OUT.mcap|DIR")]
    output: Option<PathBuf>,
    /// Write the scene as YAML
    #[arg(long, value_name = "FILE")]
    save_scene: Option<PathBuf>,
    /// Record both infrared images too
    #[arg(long)]
    infrared: bool,
    /// Print the time of each pass in the last frame
    #[arg(long)]
    timing: bool,
    /// Use the adapter whose name or driver contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

pub(super) fn parse_size(text: &str) -> std::result::Result<(u32, u32), String> {
    let wrong = || format!("`{text}` is not of the form WxH, as in 848x480");
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    let number = |text: &str| text.parse().map_err(|_| wrong());
    Ok((number(width)?, number(height)?))
}

impl SimArguments {
    fn scene(&self) -> Result<Scene> {
        let mut scene = match (&self.scene, self.seed) {
            (Some(path), _) => Scene::read(path)?,
            (None, Some(seed)) => generate(self.family, self.level, seed, self.frames.unwrap_or(FRAMES))?,
            (None, None) => return Err(Error::Yaml("neither a scene nor a seed is given".into())),
        };
        if let Some((width, height)) = self.size {
            (scene.camera.width, scene.camera.height) = (width, height);
        }
        scene.trajectory.frames = self.frames.unwrap_or(scene.trajectory.frames);
        if self.vary_sensor {
            vary_sensor(&mut scene);
        }
        scene.validate()?;
        Ok(scene)
    }
}

pub(crate) fn execute(arguments: &SimArguments) -> Result<()> {
    let scene = arguments.scene()?;
    if let Some(path) = &arguments.save_scene {
        save(path, &scene.to_yaml()?)?;
    }
    let mut simulator = Simulator::open(&scene, arguments.adapter.as_deref(), arguments.timing)?;
    println!("adapter: {}", simulator.executor().context().describe());
    let mut recorder = match &arguments.output {
        Some(path) => Some(write::recorder(path, &scene, arguments.infrared)?),
        None => None,
    };
    let camera = scene.camera.model();
    let mut map = TrueMap::new(&scene, &Config::default());
    let mut total = Rates::default();
    let start = Instant::now();
    let mut camera_s = 0.0;
    let poses = simulator.poses();
    for (index, pose) in (0_u64..).zip(&poses) {
        let before = Instant::now();
        let frame = simulator.frame(index, *pose)?;
        camera_s += before.elapsed().as_secs_f64();
        let rates = Rates::of(&frame);
        println!("frame {index:4}  {rates}");
        total.add(&rates);
        map.observe(&frame, &camera);
        if let Some(recorder) = &mut recorder {
            recorder.write(&frame, &map.grid(), &map.cells())?;
        }
    }
    if let Some(recorder) = &mut recorder {
        recorder.finish()?;
    }
    println!("all         {total}");
    for (pass, ms) in simulator.pass_ms() {
        println!("{pass:12} {ms:8.2} ms");
    }
    let frames = u32::try_from(poses.len()).map_or(f64::INFINITY, f64::from);
    println!(
        "{frames} frames of {}x{} in {:.1} s, of which {:.0} ms a frame are the camera's",
        camera.width,
        camera.height,
        start.elapsed().as_secs_f64(),
        1e3 * camera_s / frames
    );
    Ok(())
}
