//! `limpid trial`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use cpu_time::ProcessTime;
use limpid::gpu::Context;
use limpid::offline::trial::{CameraMode, Course, Record, Report, Scenario, Trial, picture, replay};
use limpid::sim::generate::Level;
use limpid::{Config, Error, Result};

use super::paths::{Paths, ends_in};
use super::run::progress_bar;
use super::stop::{STOPPED, is_stopped, listen};
use super::{save, tell};

/// Settings of a quick look: scenario, levels, methods.
type Setting = (Scenario, &'static [Level], &'static [&'static str]);
const QUICK: [Setting; 7] = [
    (Scenario::Glare, &[Level::L0, Level::L2], &["naive", "drm"]),
    (Scenario::Glass, &[], &["default"]),
    (Scenario::Curtain, &[], &["uniform", "default"]),
    (Scenario::Vegetation, &[], &["default"]),
    (Scenario::Thicket, &[], &["default"]),
    (Scenario::Both, &[], &["both"]),
    (Scenario::Dying, &[Level::L0], &["drm"]),
];

#[derive(Debug, Args)]
pub(crate) struct TrialArguments {
    /// Scenarios, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "glare")]
    scenario: Vec<Scenario>,
    /// Glare levels of scenarios that have them, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_value = "L0,L1,L2")]
    levels: Vec<Level>,
    /// Methods or set-ups by their names in the tables, separated by commas; none: all
    #[arg(long, value_delimiter = ',')]
    methods: Vec<String>,
    /// Trials of each setting
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..))]
    trials: u32,
    /// Seed of the first; training has those below 5000
    #[arg(long, value_name = "N", default_value_t = 6000)]
    first_seed: u64,
    /// The camera's images and rate
    #[arg(long, value_enum, default_value = "small")]
    camera: CameraMode,
    /// Deviation of the odometry's error, as a share of way and turns
    #[arg(long, value_name = "SHARE", default_value_t = 0.0)]
    drift: f64,
    /// Keep the record of every trial here, and take those that are there already
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Take the figures of trials from what --json wrote of other runs, and make the rest; these have no drives to draw
    #[arg(long, value_name = "FILE", num_args = 1..)]
    take: Vec<PathBuf>,
    /// Write the figures as JSON, of all and of each trial
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page that plays the drives from above
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Draw the drives of each world side by side, with their maps halfway: DIR/SCENARIO-LEVEL-SEED.png
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
    /// One trial of naive and drm at L0 and L2, and of the default in the other scenarios
    #[arg(long, conflicts_with_all = ["scenario", "levels", "methods", "trials"])]
    quick: bool,
    /// Parameters in YAML that all methods share
    #[arg(short, long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Weight file of DRM-Net (safetensors), in place of the configuration's
    #[arg(long, value_name = "FILE")]
    weights: Option<String>,
    /// Use the adapter whose name or driver contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

impl TrialArguments {
    fn course(&self) -> Result<Course> {
        let common = super::Common {
            config: self.config.clone(),
            method: None,
            weights: self.weights.clone(),
            port: None,
            adapter: self.adapter.clone(),
        };
        let mut course = Course::new(&common.config()?, self.camera, self.drift, self.keep.clone())?;
        self.take.iter().try_for_each(|path| course.take(path))?;
        Ok(course)
    }
}

impl TrialArguments {
    /// What is to be made, in order.
    fn trials(&self, course: &Course) -> Vec<Trial> {
        if self.quick {
            return QUICK
                .iter()
                .flat_map(|&(scenario, levels, methods)| {
                    let methods: Vec<String> = methods.iter().map(|&name| name.to_owned()).collect();
                    course.trials(scenario, levels, &methods, &[self.first_seed])
                })
                .collect();
        }
        let seeds: Vec<u64> = (self.first_seed..).take(self.trials as usize).collect();
        let of = |&scenario: &Scenario| course.trials(scenario, &self.levels, &self.methods, &seeds);
        self.scenario.iter().flat_map(of).collect()
    }

    fn paths<'a>(&'a self, config: &'a Config) -> Paths<'a> {
        self.take
            .iter()
            .fold(Paths::default(), |paths, path| paths.may_read("--take", Some(path)))
            .may_read("-c", self.config.as_deref())
            .reads_of(config)
            .may_write("--json", self.json.as_deref())
            .may_write("--html", self.html.as_deref())
            .may_fill("--png", self.png.as_deref(), |path| ends_in(path, &["png"]))
            .may_fill("--keep", self.keep.as_deref(), |path| ends_in(path, &["json"]))
    }
}

pub(crate) fn execute(arguments: &TrialArguments) -> Result<ExitCode> {
    let course = arguments.course()?;
    arguments.paths(&course.config).check()?;
    let trials = arguments.trials(&course);
    if trials.is_empty() {
        let known = |scenario: &Scenario| {
            scenario.setups(&course.config).iter().map(|setup| setup.key).collect::<Vec<_>>().join(", ")
        };
        let known: Vec<String> = arguments.scenario.iter().map(known).collect();
        let reason = format!("{} is not among them: {}", arguments.methods.join(", "), known.join("; "));
        return Err(Error::Config { key: "methods".into(), reason });
    }
    let context = Context::open(arguments.adapter.as_deref(), false)?;
    println!("adapter: {}", context.describe());
    if let Some(folder) = &arguments.png {
        std::fs::create_dir_all(folder).map_err(Error::file(folder))?;
    }
    let (records, failed) = make(&course, &context, &trials)?;
    let report = Report { records };
    print!("{}", report.text());
    if let Some(path) = &arguments.json {
        save(path, &format!("{:#}\n", report.json()))?;
    }
    if let Some(path) = &arguments.html {
        save(path, &replay::page(&report))?;
        println!("page: {}", path.display());
    }
    if let Some(folder) = &arguments.png {
        draw(&report.records, folder)?;
    }
    Ok(ExitCode::from(match (is_stopped(), failed) {
        (true, _) => STOPPED,
        (false, 0) => 0,
        _ => 1,
    }))
}

/// A picture for each world.
fn draw(records: &[Record], folder: &Path) -> Result<()> {
    let world = |record: &Record| format!("{}-{}-{}", record.scenario, record.level, record.seed);
    let mut worlds: BTreeMap<String, Vec<&Record>> = BTreeMap::new();
    for record in records.iter().filter(|record| record.has_drive()) {
        worlds.entry(world(record)).or_default().push(record);
    }
    worlds.iter().try_for_each(|(name, records)| picture::save(records, &folder.join(format!("{name}.png"))))
}

/// Makes the trials, or takes what is kept of them, up to where the user stops it; how many the GPU failed, which the next run makes.
fn make(course: &Course, context: &Context, trials: &[Trial]) -> Result<(Vec<Record>, u32)> {
    listen();
    let bar = progress_bar(Some(trials.len() as u64));
    let (mut records, mut made, mut failed) = (Vec::new(), 0_u32, 0_u32);
    let (begun, cpu) = (Instant::now(), ProcessTime::try_now().ok());
    for trial in trials {
        if is_stopped() {
            break;
        }
        let (record, is_new) = match course.run(context, trial) {
            Err(error @ Error::Gpu { .. }) => {
                bar.suspend(|| tell(&error));
                failed += 1;
                continue;
            }
            result => result?,
        };
        bar.suspend(|| eprintln!("{}", record.line()));
        bar.inc(1);
        made += u32::from(is_new);
        records.push(record);
    }
    bar.finish_and_clear();
    let cpu_s = cpu.and_then(|cpu| cpu.try_elapsed().ok()).map_or(0.0, |cpu| cpu.as_secs_f64());
    let minutes = begun.elapsed().as_secs_f64() / 60.0;
    println!(
        "{made} trials made in {minutes:.1} minutes, {:.0} a core-hour",
        f64::from(made) * 3600.0 / cpu_s.max(1e-3)
    );
    if failed > 0 {
        println!("{failed} trials failed on the GPU; run again to make them");
    }
    Ok((records, failed))
}
