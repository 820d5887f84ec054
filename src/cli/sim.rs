//! `limpid sim`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use limpid::gpu::Context;
use limpid::output::End;
use limpid::sim::generate::{Family, Level, add_walkers, generate, vary_sensor};
use limpid::sim::lidar::{Lidar, LidarModel, LidarSimulator, Returns};
use limpid::sim::rates::Rates;
use limpid::sim::truth::TrueMap;
use limpid::sim::write::Recorder;
use limpid::sim::{Scene, Simulator, Way, poses, stamp_ns, write};
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
    /// Let so many people walk past before the camera; fewer where there is no room
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(..=8))]
    walkers: u32,
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
    /// Put this lidar on the robot, in place of the scene's (MCAP only)
    #[arg(long, value_enum, value_name = "MODEL")]
    lidar: Option<LidarModel>,
    /// Which returns of a beam the lidar gives, in place of the scene's
    #[arg(long, value_enum, value_name = "RETURNS")]
    returns: Option<Returns>,
    /// Record the lidar's raw packets in place of its clouds (Velodynes)
    #[arg(long)]
    packets: bool,
    /// Leave the camera out: the lidar alone
    #[arg(long)]
    no_camera: bool,
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
        if let Some(model) = self.lidar {
            scene.lidar = Some(Lidar { model, ..scene.lidar.unwrap_or_default() });
        }
        if let (Some(lidar), Some(returns)) = (&mut scene.lidar, self.returns) {
            lidar.returns = returns;
        }
        match &mut scene.lidar {
            Some(lidar) => lidar.packets |= self.packets,
            None if self.packets => {
                let reason = "the scene has no lidar to send packets; see --lidar".into();
                return Err(Error::Config { key: "lidar".into(), reason });
            }
            None => {}
        }
        if self.no_camera && scene.lidar.is_none() {
            let reason = "the scene has none, and without the camera nothing is left; see --lidar".into();
            return Err(Error::Config { key: "lidar".into(), reason });
        }
        if self.vary_sensor {
            vary_sensor(&mut scene);
        }
        let found = add_walkers(&mut scene, self.walkers);
        if found < self.walkers {
            eprintln!("limpid: {found} of {} people found room in the scene", self.walkers);
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
    let mut sensors = Sensors::open(arguments, &scene)?;
    let mut recorder = match &arguments.output {
        Some(path) => Some(write::recorder(path, &scene, arguments.infrared)?),
        None => None,
    };
    listen();
    let simulated = simulate(&scene, &mut sensors, &mut recorder);
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

/// What the robot carries.
struct Sensors {
    camera: Option<Simulator>,
    lidar: Option<LidarSimulator>,
}

impl Sensors {
    fn open(arguments: &SimArguments, scene: &Scene) -> Result<Self> {
        let context = Context::open(arguments.adapter.as_deref(), arguments.timing)?;
        println!("adapter: {}", context.describe());
        let camera = if arguments.no_camera { None } else { Some(Simulator::with_context(scene, &context)?) };
        let lidar = match &scene.lidar {
            Some(_) => Some(LidarSimulator::with_context(scene, &context)?),
            None => None,
        };
        Ok(Self { camera, lidar })
    }

    fn print_passes(&self) {
        let camera = self.camera.iter().flat_map(Simulator::pass_ms);
        for (pass, ms) in camera.chain(self.lidar.iter().flat_map(LidarSimulator::pass_ms)) {
            println!("{pass:12} {ms:8.2} ms");
        }
    }
}

/// What came of a simulation.
#[derive(Default)]
struct Tally {
    rates: Rates,
    frames: u32,
    camera_s: f64,
    scans: u32,
    beams: u64,
    points: u64,
    lidar_s: f64,
}

impl Tally {
    fn print(&self, scene: &Scene, all_s: f64) {
        if self.frames > 0 {
            println!("all         {}", self.rates);
            println!(
                "{} frames of {}x{} in {all_s:.1} s, of which {:.0} ms a frame are the camera's",
                self.frames,
                scene.camera.width,
                scene.camera.height,
                1e3 * self.camera_s / f64::from(self.frames)
            );
        }
        if self.scans > 0 {
            let scans = f64::from(self.scans);
            println!(
                "{} scans of {} beams and {:.0} points, {:.0} ms each",
                self.scans,
                self.beams / u64::from(self.scans),
                self.points as f64 / scans,
                1e3 * self.lidar_s / scans
            );
        }
    }
}

/// Makes frames and scans in the order of their ends, up to where the user stops it, and prints what is measured on them.
fn simulate(scene: &Scene, sensors: &mut Sensors, recorder: &mut Option<Box<dyn Recorder>>) -> Result<()> {
    let (camera, way) = (scene.camera.model(), Way::of(scene));
    let mut map = TrueMap::new(scene, &Config::default());
    let (start, mut tally) = (Instant::now(), Tally::default());
    for (index, pose) in (0_u64..).zip(poses(scene)) {
        if is_stopped() {
            break;
        }
        let at_ns = stamp_ns(scene, index);
        scan_until(at_ns, &way, sensors, recorder, &mut tally)?;
        let Some(simulator) = &mut sensors.camera else {
            recorder.iter_mut().try_for_each(|recorder| recorder.write_pose(at_ns, pose.map_from_base))?;
            continue;
        };
        let before = Instant::now();
        let frame = simulator.frame(index, pose)?;
        tally.camera_s += before.elapsed().as_secs_f64();
        let rates = Rates::of(&frame);
        println!("frame {index:4}  {rates}");
        tally.rates.add(&rates);
        tally.frames += 1;
        map.observe(&frame, &camera);
        if let Some(recorder) = recorder {
            recorder.write(&frame, &map.grid(), &map.cells())?;
        }
    }
    sensors.print_passes();
    tally.print(scene, start.elapsed().as_secs_f64());
    Ok(())
}

/// The scans that end by `at_ns`.
fn scan_until(
    at_ns: u64,
    way: &Way,
    sensors: &mut Sensors,
    recorder: &mut Option<Box<dyn Recorder>>,
    tally: &mut Tally,
) -> Result<()> {
    let Some(lidar) = &mut sensors.lidar else { return Ok(()) };
    loop {
        let before = Instant::now();
        let Some((scan, end_ns)) = lidar.next_on(way, at_ns)? else { return Ok(()) };
        tally.lidar_s += before.elapsed().as_secs_f64();
        tally.scans += 1;
        tally.beams += u64::from(scan.beams);
        tally.points += scan.truth.len() as u64;
        recorder.iter_mut().try_for_each(|recorder| recorder.write_scan(&scan, end_ns))?;
    }
}
