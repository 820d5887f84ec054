//! `limpid run`.

use std::io::IsTerminal;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use limpid::config::SensorKind;
use limpid::input::{Source, open_source};
use limpid::map::glass::{LabelledScan, PointClass};
use limpid::map::pane_file::panes_to_yaml;
use limpid::map::{CellClass, MapUpdate, PaneSet, State, Update};
use limpid::mapper::{Options, SensorInfo};
use limpid::output::{DumpSink, McapSink, PngSink, Sink, free_path, map_files, save_map};
use limpid::run::{RunReport, SensorRun, run};
use limpid::{Config, Result};

use super::paths::{Paths, ends_in};
use super::stop::{STOPPED, Stoppable};
use super::{Common, parse_range, save};

#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    /// MCAP file, rosbag2 folder or .db3, ROS 1 bag, TUM folder or folder with a still pair; lidar: also pcap, pcapng, PLY, PCD or a folder of these
    pub(super) input: PathBuf,
    #[command(flatten)]
    pub(super) common: Common,
    /// Which sensor of the recording; left out, all it has
    #[arg(long, value_enum)]
    sensor: Option<Sensor>,
    /// Write maps, reliability, filtered depth, labelled clouds and transforms as MCAP
    #[arg(short, long, value_name = "MCAP")]
    pub(super) output: Option<PathBuf>,
    /// Write pictures of the map, of reliability and of glass
    #[arg(long, value_name = "DIR")]
    pub(super) png: Option<PathBuf>,
    /// Write every buffer as EXR, with frame.json; with several sensors in a folder for each, and one for the map
    #[arg(long, value_name = "DIR")]
    pub(super) dump: Option<PathBuf>,
    /// Write the last map for nav2's map_server: STEM.pgm and STEM.yaml
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

impl RunArguments {
    /// Everything that is read and written.
    fn paths<'a>(&'a self, config: &'a Config) -> Paths<'a> {
        let map = self.map.iter().flat_map(|stem| map_files(stem));
        let paths = self.common.paths(&self.input, config);
        map.fold(paths, |paths, file| paths.may_write("--map", Some(file)))
            .may_write("-o", self.output.as_deref())
            .may_write("--panes", self.panes.as_deref())
            .may_fill("--png", self.png.as_deref(), |path| ends_in(path, &["png"]))
            // A folder for each frame, and one above it for each sensor.
            .may_fill("--dump", self.dump.as_deref(), |path| {
                path.parent() != Some(Path::new("")) || ends_in(path, &["exr", "json"])
            })
    }
}

pub(crate) fn execute(arguments: &RunArguments) -> Result<ExitCode> {
    let mut config = arguments.common.config()?;
    config.change_all(|parameters| parameters.glass |= arguments.glass);
    let config = match arguments.sensor {
        Some(Sensor::Camera) => config.only(SensorKind::Camera)?,
        Some(Sensor::Lidar) => config.only(SensorKind::Lidar)?,
        None => config,
    };
    arguments.paths(&config).check()?;
    let mut source = open_source(&arguments.input, &config)?;
    let outputs = Outputs {
        mcap: arguments.output.as_deref(),
        png: arguments.png.as_deref(),
        dump: arguments.dump.as_deref(),
    };
    let written = outputs.mcap.is_some() || outputs.png.is_some() || outputs.dump.is_some();
    let options = Options {
        adapter: arguments.common.adapter.clone(),
        profiling: arguments.timing,
        images: written,
        layers: outputs.dump.is_some(),
        // The saved map asks them which inscribed cells are free.
        verdicts: written || arguments.map.is_some(),
        solidity_inputs: false,
        cell_inputs: false,
        live: false,
    };
    let range = arguments.frames.clone().unwrap_or(0..u64::MAX);
    let report = run_with_progress(source.as_mut(), range, &config, &options, &outputs)?;
    print_report(&report);
    save_ends(arguments, &report)?;
    Ok(end_of(&report))
}

/// Writes what is known at the end. Of a run that was stopped it takes no older file's place.
fn save_ends(arguments: &RunArguments, report: &RunReport) -> Result<()> {
    let is_free = |path: &Path| !report.stopped || !path.exists();
    if let Some(path) = &arguments.panes {
        let path = free_path(path, is_free);
        save(&path, &panes_to_yaml(&known_panes(report)))?;
        println!("panes: {}", path.display());
    }
    if let (Some(stem), Some(last)) = (&arguments.map, report.last()) {
        let stem = free_path(stem, |stem| map_files(stem).iter().all(|file| is_free(file)));
        let [image, yaml] = save_last(&stem, last)?;
        println!("map: {} and {}", image.display(), yaml.display());
    }
    Ok(())
}

/// Says where a run that was stopped left its results.
pub(super) fn end_of(report: &RunReport) -> ExitCode {
    if !report.stopped {
        return ExitCode::SUCCESS;
    }
    eprintln!("limpid: stopped before the end of the recording");
    for path in &report.kept {
        eprintln!("limpid: what was written up to there is in {}", path.display());
    }
    ExitCode::from(STOPPED)
}

/// Sensors of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Sensor {
    /// RGB-D frames.
    Camera,
    /// Lidar scans.
    Lidar,
}

/// The panes that are known at the end, of the last lidar that searched for them.
fn known_panes(report: &RunReport) -> PaneSet {
    let labelled = report.sensors.iter().rev().filter_map(|sensor| {
        let update = sensor.last.as_ref()?;
        Some((update, update.lidar()?.glass.as_ref()?))
    });
    let known = |(update, glass): (&Update, &LabelledScan)| {
        PaneSet::of_scan(&glass.panes, update.map_from_base.then(update.base_from_sensor))
    };
    labelled.map(known).next().unwrap_or_default()
}

/// Saves the map of an update.
pub(super) fn save_last(stem: &Path, last: &Update) -> Result<[PathBuf; 2]> {
    let nothing = || limpid::Error::Empty { reason: "no map was made".into() };
    save_map(stem, last.map.as_ref().ok_or_else(nothing)?)
}

/// Where results go.
#[derive(Default)]
pub(super) struct Outputs<'a> {
    pub(super) mcap: Option<&'a Path>,
    pub(super) png: Option<&'a Path>,
    pub(super) dump: Option<&'a Path>,
}

impl Outputs<'_> {
    fn sinks(&self, config: &Config, sensors: &[SensorInfo]) -> Result<Vec<Box<dyn Sink>>> {
        let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
        if let Some(path) = self.mcap {
            sinks.push(Box::new(McapSink::create(path, config, sensors)?));
        }
        if let Some(path) = self.png {
            sinks.push(Box::new(PngSink::create(path, config, sensors)?));
        }
        if let Some(path) = self.dump {
            sinks.push(Box::new(DumpSink::create(path, config, sensors)?));
        }
        Ok(sinks)
    }
}

pub(super) fn run_with_progress(
    source: &mut dyn Source,
    range: Range<u64>,
    config: &Config,
    options: &Options,
    outputs: &Outputs<'_>,
) -> Result<RunReport> {
    let mut sinks = outputs.sinks(config, source.sensors())?;
    let total = source.count_hint().map(|count| range.end.min(count).saturating_sub(range.start));
    let bar = progress_bar(total);
    let mut source = Stoppable::new(source);
    let report = run(&mut source, range, config, options, &mut sinks, &mut |update| {
        bar.inc(1);
        bar.set_message(if update.camera().is_some_and(|camera| camera.degraded) { "DEGRADED" } else { "" });
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
    for note in report.notes.iter().chain(&report.read.read.notes) {
        println!("note: {note}");
    }
    for warning in &report.warnings {
        println!("warning: {warning}");
    }
    for told in &report.read.read.frames {
        println!("frames: {told}");
    }
    for (reason, count) in report.read.sensors.iter().flat_map(|sensor| sensor.dropped.reasons()) {
        println!("dropped: {count} points: {}", reason.text());
    }
    for skipped in &report.read.read.skipped {
        println!("skipped {} x {}: {}", skipped.count, skipped.source, skipped.reason);
    }
    for sensor in &report.sensors {
        print_sensor(sensor);
    }
    let seconds = report.elapsed.as_secs_f64();
    #[expect(clippy::cast_precision_loss, reason = "frames counted in a run fit in 53 bits")]
    let taken = report.taken() as f64;
    println!(
        "{} frames and scans in {seconds:.2} s ({:.1} ms each, reading and writing included), passes built in {:.0} ms",
        report.taken(),
        seconds * 1e3 / taken.max(1.0),
        report.build.as_secs_f64() * 1e3,
    );
    if let Some(map) = report.last().and_then(|last| last.map.as_ref()) {
        print_map(map, &report.sensors);
    }
}

fn print_sensor(sensor: &SensorRun) {
    let SensorRun { name, taken, without_pose, refused, degraded, pose_jumps, .. } = sensor;
    if let Some(reason) = &sensor.first_refused {
        println!("{name}: refused {refused}, the first: {reason}");
    }
    println!("{name}: {taken} used, {without_pose} without a pose, {degraded} degraded");
    if !sensor.depth_alone.is_empty() {
        let alone: u64 = sensor.depth_alone.values().sum();
        let reasons: Vec<_> =
            sensor.depth_alone.iter().map(|(reason, count)| format!("{count} x {reason}")).collect();
        println!("{name}: {alone} of {taken} by depth alone, as method range does: {}", reasons.join("; "));
    }
    if *pose_jumps > 0 {
        println!(
            "{name}: {pose_jumps} times the pose jumped; cells and panes kept from before stay where they were"
        );
    }
    let Some(last) = &sensor.last else { return };
    let kind = if last.camera().is_some() { "camera" } else { "lidar" };
    if let Some(text) = sensor.ground.text(kind) {
        println!("{name}: {text}");
    }
    if let Some(camera) = last.camera() {
        let c = camera.counters;
        println!(
            "{name}: last frame: {} hit and {} seen-through cells; {} occupied, {} free cells",
            c.hit_cells, c.seen_through_cells, c.occupied_cells, c.free_cells
        );
    }
    let Some(lidar) = last.lidar() else { return };
    println!("{name}: last scan: {} points", lidar.points);
    if let Some(glass) = &lidar.glass {
        let classes = PointClass::ALL.iter().zip(glass.counters.classes);
        let classes: Vec<_> = classes.map(|(class, count)| format!("{count} {}", class.name())).collect();
        println!("{name}: glass: {} panes; points: {}", glass.panes.len(), classes.join(", "));
    }
}

fn print_map(map: &MapUpdate, sensors: &[SensorRun]) {
    let cells: Vec<_> = if map.classes.is_empty() {
        let of =
            |costs: std::ops::RangeInclusive<u8>| map.costmap.iter().filter(|c| costs.contains(c)).count();
        let names = [
            ("free", 0..=0),
            ("inflated", 1..=252),
            ("inscribed", 253..=253),
            ("lethal", 254..=254),
            ("unknown", 255..=255),
        ];
        names.map(|(name, costs)| format!("{} {name}", of(costs))).into()
    } else {
        CellClass::ALL.map(|class| format!("{} {}", map.count(class), class.name())).into()
    };
    let states = sensors.iter().zip(&map.sensors).filter(|(_, state)| **state != State::Ok);
    let states: Vec<_> = states.map(|(sensor, state)| format!("{} {}", sensor.name, state.name())).collect();
    let of = if states.is_empty() { String::new() } else { format!(" ({})", states.join(", ")) };
    println!("map: {}{of}; cells: {}", map.state.name(), cells.join(", "));
}
