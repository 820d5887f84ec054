//! `limpid bench`.

use std::path::PathBuf;

use clap::Args;
use limpid::input::open_source;
use limpid::mapper::Options;
use limpid::offline::bench::{bench, observations};
use limpid::{Error, Result};

use super::{Common, save};

#[derive(Debug, Args)]
pub(crate) struct BenchArguments {
    /// MCAP file, rosbag2 folder or .db3, ROS 1 bag, TUM folder or folder with a still pair; frames are read into memory first
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Frames to measure, after a fifth as many to warm up
    #[arg(long, default_value_t = 100)]
    samples: usize,
    /// Read back depth, reliability and colour images too, as `run` does for its outputs
    #[arg(long)]
    images: bool,
    /// Write the figures as JSON too
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Frames held in memory; more samples go round them.
const FRAMES: usize = 100;

pub(crate) fn execute(arguments: &BenchArguments) -> Result<()> {
    let config = arguments.common.config()?;
    let paths = arguments.common.paths(&arguments.input, &config);
    paths.may_write("--json", arguments.json.as_deref()).check()?;
    let mut source = open_source(&arguments.input, &config)?;
    let sensors = source.sensors().to_vec();
    let frames = observations(source.as_mut(), FRAMES.min(arguments.samples))?;
    let options =
        Options { adapter: arguments.common.adapter.clone(), images: arguments.images, ..Options::default() };
    let report = bench(&config, &sensors, &options, &frames, arguments.samples)?;
    print!("{}", report.table());
    if let Some(path) = &arguments.json {
        let unwritable = |e: serde_json::Error| Error::Encode { path: path.clone(), reason: e.to_string() };
        save(path, &serde_json::to_string_pretty(&report).map_err(unwritable)?)?;
    }
    Ok(())
}
