//! `limpid targets`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use limpid::gpu::Context;
use limpid::offline::targets::{Distance, Request, SampleFile, make};
use limpid::offline::{cells as map_cells, solidity};
use limpid::stage::targets::Rule;
use limpid::{Config, Result};

use super::Common;
use super::paths::{Paths, ends_in};

#[derive(Debug, Args)]
pub(crate) struct TargetsArguments {
    /// Recordings with colour and poses: MCAP files, rosbag2 folders and .db3 files, ROS 1 bags, TUM folders
    #[arg(required_unless_present = "solidity")]
    inputs: Vec<PathBuf>,
    /// Instead, cells of simulated lidar scans for learned solidity: of the scenes of these seeds
    #[arg(long, value_name = "FIRST-LAST", value_parser = seeds, conflicts_with = "inputs")]
    solidity: Option<(u64, u64)>,
    /// Instead, cells of recordings with ground truth for map reliability: one file map-cells.safetensors
    #[arg(long, conflicts_with = "solidity")]
    map: bool,
    /// Cells of a scan that are kept, at most, with --solidity
    #[arg(long, value_name = "N", default_value_t = 400, requires = "solidity", value_parser = clap::value_parser!(u64).range(1..))]
    cells: u64,
    /// Write NAME.safetensors into this folder for each recording; with --solidity FIRST-LAST.safetensors, with --map
    /// map-cells.safetensors
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Parameters in YAML (topics, frames, transforms)
    #[arg(short, long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Refuse recordings without ground truth
    #[arg(long)]
    truth: bool,
    /// Make a sample of one in N frames; all serve as references
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Other frames that must agree on a reference
    #[arg(long, value_name = "N", default_value_t = Rule::default().least_views, value_parser = clap::value_parser!(u32).range(1..=16))]
    views: u32,
    /// Distance of the stereo camera's imagers in metres, for its noise
    #[arg(long, value_name = "M", default_value_t = Rule::default().baseline_m, value_parser = positive)]
    baseline: f64,
    /// Noise of the stereo matcher in pixels of disparity
    #[arg(long, value_name = "PX", default_value_t = Rule::default().noise_px, value_parser = positive)]
    noise: f64,
    /// Use the adapter whose name or driver contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

fn positive(text: &str) -> std::result::Result<f64, String> {
    let number = text.parse().ok().filter(|n: &f64| n.is_finite() && *n > 0.0);
    number.ok_or_else(|| format!("`{text}` is not a positive number"))
}

fn seeds(text: &str) -> std::result::Result<(u64, u64), String> {
    let wrong = || format!("`{text}` is not of the form FIRST-LAST, as in 30000-30999");
    let (first, last) = text.split_once('-').ok_or_else(wrong)?;
    let number = |text: &str| text.parse().map_err(|_| wrong());
    let (first, last) = (number(first)?, number(last)?);
    if first <= last { Ok((first, last)) } else { Err(wrong()) }
}

/// Cells for learned solidity.
fn cells((first, last): (u64, u64), config: Config, arguments: &TargetsArguments) -> Result<()> {
    let (start, mut file) = (Instant::now(), solidity::CellFile::default());
    let most_cells = usize::try_from(arguments.cells).unwrap_or(usize::MAX);
    let request = solidity::Request { config, most_cells };
    let context = Context::open(arguments.adapter.as_deref(), false)?;
    for seed in first..=last {
        for cells in solidity::make(seed, &request, &context)? {
            file.add(&cells);
        }
    }
    std::fs::create_dir_all(&arguments.output).map_err(limpid::Error::file(&arguments.output))?;
    let path = arguments.output.join(format!("{first}-{last}.safetensors"));
    file.save(&path)?;
    println!("{}", path.display());
    let (count, seconds) = (file.count(), start.elapsed().as_secs_f64());
    println!("{count} cells of {} scenes in {seconds:.1} s on {}", last - first + 1, context.describe());
    Ok(())
}

/// Cells for map reliability.
fn judged_cells(config: &Config, arguments: &TargetsArguments) -> Result<()> {
    let (start, mut file) = (Instant::now(), map_cells::CellFile::default());
    let context = Context::open(arguments.adapter.as_deref(), false)?;
    for input in &arguments.inputs {
        let cells = map_cells::make(input, config, arguments.every, &context)?;
        let name = input.file_stem().unwrap_or(input.as_os_str()).to_string_lossy();
        println!("{name}: {} cells", cells.len());
        file.add(&name, &cells);
    }
    std::fs::create_dir_all(&arguments.output).map_err(limpid::Error::file(&arguments.output))?;
    let path = arguments.output.join("map-cells.safetensors");
    file.save(&path)?;
    println!("{}", path.display());
    let (count, seconds) = (file.count(), start.elapsed().as_secs_f64());
    println!(
        "{count} cells of {} recordings in {seconds:.1} s on {}",
        arguments.inputs.len(),
        context.describe()
    );
    Ok(())
}

pub(crate) fn execute(arguments: &TargetsArguments) -> Result<()> {
    let common =
        Common { config: arguments.config.clone(), method: None, weights: None, port: None, adapter: None };
    let config = common.config()?;
    let inputs =
        arguments.inputs.iter().fold(Paths::default(), |paths, input| paths.reads("the recording", input));
    let paths = inputs.may_read("-c", arguments.config.as_deref()).reads_of(&config);
    paths.may_fill("-o", Some(&arguments.output), |path| ends_in(path, &["safetensors"])).check()?;
    if let Some(seeds) = arguments.solidity {
        return cells(seeds, config, arguments);
    }
    if arguments.map {
        return judged_cells(&config, arguments);
    }
    let rule = Rule {
        baseline_m: arguments.baseline,
        noise_px: arguments.noise,
        least_views: arguments.views,
        ..Rule::default()
    };
    let request = Request {
        rule,
        needs_truth: arguments.truth,
        every: arguments.every,
        adapter: arguments.adapter.clone(),
    };
    let mut all = Distance::default();
    for input in &arguments.inputs {
        all.merge(&one(input, &config, &request, &arguments.output)?);
    }
    if arguments.inputs.len() > 1 {
        println!("{} recordings\n{all}", arguments.inputs.len());
    }
    Ok(())
}

fn one(input: &Path, config: &Config, request: &Request, folder: &Path) -> Result<Distance> {
    let start = Instant::now();
    let mut recording = limpid::input::open(input, config)?;
    let mut file = SampleFile::create(folder, input)?;
    let report = make(input, recording.as_mut(), request, &mut |sample| file.add(sample))?;
    for note in &report.read.notes {
        println!("note: {note}");
    }
    for skipped in &report.read.skipped {
        println!("skipped {} x {}: {}", skipped.count, skipped.source, skipped.reason);
    }
    for path in file.finish()? {
        println!("{}", path.display());
    }
    println!(
        "{} samples in {:.1} s on {}; {} frames without a pose",
        report.samples,
        start.elapsed().as_secs_f64(),
        report.adapter,
        report.without_pose
    );
    println!("{}", report.distance);
    Ok(report.distance)
}
