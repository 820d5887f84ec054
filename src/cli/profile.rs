//! `limpid profile`.

use std::path::PathBuf;

use clap::Args;
use limpid::Result;
use limpid::input::open_source;
use limpid::mapper::Options;
use limpid::offline::bench::{observations, trace};

use super::{Common, save};

#[derive(Debug, Args)]
pub(crate) struct ProfileArguments {
    /// MCAP file, rosbag2 folder or .db3, ROS 1 bag, TUM folder or folder with a still pair
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Frames to trace
    #[arg(long, default_value_t = 20)]
    samples: usize,
    /// Where the trace goes
    #[arg(short, long, default_value = "trace.json", value_name = "FILE")]
    output: PathBuf,
}

pub(crate) fn execute(arguments: &ProfileArguments) -> Result<()> {
    let config = arguments.common.config()?;
    let paths = arguments.common.paths(&arguments.input, &config);
    paths.may_write("-o", Some(&arguments.output)).check()?;
    let mut source = open_source(&arguments.input, &config)?;
    let sensors = source.sensors().to_vec();
    let frames = observations(source.as_mut(), arguments.samples)?;
    let options = Options { adapter: arguments.common.adapter.clone(), ..Options::default() };
    let trace = trace(&config, &sensors, &options, &frames, arguments.samples)?;
    save(&arguments.output, &trace.to_string())?;
    println!("trace: {} (open it at ui.perfetto.dev)", arguments.output.display());
    Ok(())
}
