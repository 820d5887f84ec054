//! `limpid run`.

use std::io::IsTerminal;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use limpid::frame::Options;
use limpid::input::Recording;
use limpid::output::{DumpSink, McapSink, PngSink, Sink, save_map};
use limpid::run::{RunReport, run};
use limpid::{Config, Result};

use super::{Common, parse_range, scans};

#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    /// MCAP file, ROS 1 bag, TUM folder or folder with a still pair; lidar: also pcap, PLY, PCD or a folder of these
    pub(super) input: PathBuf,
    #[command(flatten)]
    pub(super) common: Common,
    /// Which sensor of the recording; left out, all it has
    #[arg(long, value_enum)]
    sensor: Option<Sensor>,
    /// Write costmaps, reliability, filtered depth and transforms as MCAP
    #[arg(short, long, value_name = "MCAP")]
    pub(super) output: Option<PathBuf>,
    /// Write pictures of costmap and reliability per frame
    #[arg(long, value_name = "DIR")]
    pub(super) png: Option<PathBuf>,
    /// Write every buffer per frame as EXR, with frame.json; those of a lidar beside a camera go to DIR/lidar
    #[arg(long, value_name = "DIR")]
    pub(super) dump: Option<PathBuf>,
    /// Write the last map for nav2's map_server: STEM.pgm and STEM.yaml (a lidar's beside a camera's: STEM-plan)
    #[arg(long, value_name = "STEM")]
    pub(super) map: Option<PathBuf>,
    /// Only the depth images, or scans, numbered A to B - 1
    #[arg(long, value_name = "A..B", value_parser = parse_range)]
    pub(super) frames: Option<Range<u64>>,
    /// Lidar: find panes of glass, label points and put panes into the map
    #[arg(long)]
    pub(super) glass: bool,
    /// Lidar: write the panes that are known at the end, in the map frame; `glass_panes` reads them
    #[arg(long, value_name = "YAML", requires = "glass")]
    pub(super) panes: Option<PathBuf>,
    /// Time the passes too, for the dump and the diagnostics
    #[arg(long)]
    pub(super) timing: bool,
}

pub(crate) fn execute(arguments: &RunArguments) -> Result<()> {
    let mut config = arguments.common.config()?;
    config.change_all(|parameters| parameters.glass |= arguments.glass);
    let contents = limpid::input::contents(&arguments.input, &config)?;
    let lidar = match arguments.sensor {
        Some(sensor) => sensor == Sensor::Lidar,
        None => contents.lidar && !contents.camera,
    };
    if lidar {
        return scans::execute(arguments, &config, None);
    }
    if arguments.sensor.is_some() || !contents.lidar {
        return run_camera(arguments, &config, None);
    }
    let shared = arguments.output.as_deref().map(|path| McapSink::create(path, &config)).transpose()?;
    // Scans are worth having where the camera's frames could not be used, and the other way round.
    let camera = run_camera(arguments, &config, shared.clone());
    let scans = scans::execute(arguments, &config, Some(scans::BesideCamera { shared }));
    camera.and(scans)
}

/// Sensors of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Sensor {
    /// RGB-D frames: costmaps.
    Camera,
    /// Lidar scans: plan maps.
    Lidar,
}

fn run_camera(arguments: &RunArguments, config: &Config, shared: Option<McapSink>) -> Result<()> {
    let mut recording = limpid::input::open(&arguments.input, config)?;
    let outputs = Outputs {
        mcap: arguments.output.as_deref(),
        png: arguments.png.as_deref(),
        dump: arguments.dump.as_deref(),
        shared,
    };
    let options = Options {
        adapter: arguments.common.adapter.clone(),
        profiling: arguments.timing,
        images: outputs.mcap.is_some() || outputs.png.is_some() || outputs.dump.is_some(),
        // The saved map needs to know what is free under inflation.
        layers: outputs.dump.is_some() || arguments.map.is_some(),
        ..Options::default()
    };
    let range = arguments.frames.clone().unwrap_or(0..u64::MAX);
    let report = run_with_progress(recording.as_mut(), range, config, &options, &outputs)?;
    print_report(&report);
    if let (Some(stem), Some(last)) = (&arguments.map, &report.last) {
        let [image, yaml] = save_map(stem, last)?;
        println!("map: {} and {}", image.display(), yaml.display());
    }
    Ok(())
}

/// Where results go.
#[derive(Default)]
pub(super) struct Outputs<'a> {
    pub(super) mcap: Option<&'a Path>,
    pub(super) png: Option<&'a Path>,
    pub(super) dump: Option<&'a Path>,
    /// Takes the place of the file that `mcap` names.
    pub(super) shared: Option<McapSink>,
}

impl Outputs<'_> {
    fn sinks(&self, config: &Config) -> Result<Vec<Box<dyn Sink>>> {
        let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
        if let Some(shared) = &self.shared {
            sinks.push(Box::new(shared.clone()));
        } else if let Some(path) = self.mcap {
            sinks.push(Box::new(McapSink::create(path, config)?));
        }
        if let Some(path) = self.png {
            sinks.push(Box::new(PngSink::create(path, config)?));
        }
        if let Some(path) = self.dump {
            sinks.push(Box::new(DumpSink::create(path, config)?));
        }
        Ok(sinks)
    }
}

pub(super) fn run_with_progress(
    recording: &mut dyn Recording,
    range: Range<u64>,
    config: &Config,
    options: &Options,
    outputs: &Outputs<'_>,
) -> Result<RunReport> {
    let mut sinks = outputs.sinks(config)?;
    let total = recording.frame_count_hint().map(|count| range.end.min(count).saturating_sub(range.start));
    let bar = progress_bar(total);
    let report = run(recording, range, config, options, &mut sinks, &mut |output| {
        bar.inc(1);
        if output.degraded {
            bar.set_message("DEGRADED");
        } else {
            bar.set_message("");
        }
    });
    bar.finish_and_clear();
    report
}

/// On standard error, hidden where that is no terminal.
pub(super) fn progress_bar(total: Option<u64>) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let template = match total {
        Some(_) => "{bar:40} {pos}/{len} frames, {per_sec}, {eta} left {msg}",
        None => "{spinner} {pos} frames, {per_sec} {msg}",
    };
    let bar = total.map_or_else(ProgressBar::new_spinner, ProgressBar::new);
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

pub(super) fn print_report(report: &RunReport) {
    println!("adapter: {}", report.adapter);
    for note in report.method_note.iter().chain(&report.read.notes) {
        println!("note: {note}");
    }
    for skipped in &report.read.skipped {
        println!("skipped {} x {}: {}", skipped.count, skipped.source, skipped.reason);
    }
    if let Some(reason) = &report.first_unfit {
        println!("refused {} frames, the first: {reason}", report.unfit);
    }
    let seconds = report.elapsed.as_secs_f64();
    #[expect(clippy::cast_precision_loss, reason = "frames counted in a run fit in 53 bits")]
    let frames = report.frames as f64;
    println!(
        "{} frames in {seconds:.2} s ({:.1} ms a frame, reading and writing included), pipeline built in {:.0} ms",
        report.frames,
        seconds * 1e3 / frames.max(1.0),
        report.build.as_secs_f64() * 1e3,
    );
    println!("{} without a pose, {} degraded", report.without_pose, report.degraded);
    if let Some(last) = &report.last {
        let c = last.counters;
        println!(
            "last frame: {} hit and {} seen-through cells; map: {} occupied, {} free cells",
            c.hit_cells, c.seen_through_cells, c.occupied_cells, c.free_cells
        );
    }
}
