//! `limpid sim`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use limpid::output::End;
use limpid::sim::generate::{Family, Level, generate, vary_sensor};
use limpid::sim::rates::Rates;
use limpid::sim::truth::TrueMap;
use limpid::sim::write::Recorder;
use limpid::sim::{Scene, Simulator, write};
use limpid::{Config, Error, Result};

use super::paths::Paths;
use super::save;
use super::stop::{STOPPED, is_stopped, listen};

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

impl SimArguments {
    /// Everything that is read and written.
    fn paths(&self) -> Paths<'_> {
        let paths = Paths::default().may_read("the scene", self.scene.as_deref());
        let paths = paths.may_write("--save-scene", self.save_scene.as_deref());
        match self.output.as_deref() {
            Some(path) if write::is_mcap(path) => paths.may_write("-o", Some(path)),
            folder => paths.may_fill("-o", folder, |_| true),
        }
    }
}

pub(crate) fn execute(arguments: &SimArguments) -> Result<ExitCode> {
    arguments.paths().check()?;
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
    listen();
    let simulated = simulate(&scene, &mut simulator, &mut recorder);
    let Some(recorder) = &mut recorder else { return simulated.map(|()| code()) };
    match simulated {
        Ok(()) if !is_stopped() => recorder.finish()?,
        Ok(()) => {
            eprintln!("limpid: stopped before the last frame");
            if let Some(path) = recorder.abandon(End::Stopped)? {
                eprintln!("limpid: what was written up to there is in {}", path.display());
            }
        }
        Err(cause) => {
            // What cannot be closed after a failure is not told: the failure is.
            let kept = recorder.abandon(End::Failed).unwrap_or_default();
            return Err(match kept {
                Some(path) => Error::Partial { cause: Box::new(cause), kept: vec![path] },
                None => cause,
            });
        }
    }
    Ok(code())
}

fn code() -> ExitCode {
    ExitCode::from(if is_stopped() { STOPPED } else { 0 })
}

/// Makes the frames, up to where the user stops it, and prints what is measured on them.
fn simulate(
    scene: &Scene,
    simulator: &mut Simulator,
    recorder: &mut Option<Box<dyn Recorder>>,
) -> Result<()> {
    let camera = scene.camera.model();
    let mut map = TrueMap::new(scene, &Config::default());
    let mut total = Rates::default();
    let (start, mut camera_s, mut frames) = (Instant::now(), 0.0, 0_u32);
    for (index, pose) in (0_u64..).zip(simulator.poses()) {
        if is_stopped() {
            break;
        }
        let before = Instant::now();
        let frame = simulator.frame(index, pose)?;
        camera_s += before.elapsed().as_secs_f64();
        let rates = Rates::of(&frame);
        println!("frame {index:4}  {rates}");
        total.add(&rates);
        map.observe(&frame, &camera);
        if let Some(recorder) = recorder {
            recorder.write(&frame, &map.grid(), &map.cells())?;
        }
        frames += 1;
    }
    println!("all         {total}");
    for (pass, ms) in simulator.pass_ms() {
        println!("{pass:12} {ms:8.2} ms");
    }
    println!(
        "{frames} frames of {}x{} in {:.1} s, of which {:.0} ms a frame are the camera's",
        camera.width,
        camera.height,
        start.elapsed().as_secs_f64(),
        1e3 * camera_s / f64::from(frames.max(1))
    );
    Ok(())
}
