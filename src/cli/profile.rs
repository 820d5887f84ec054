//! `limpid profile`.

use std::path::PathBuf;

use clap::Args;
use limpid::Result;
use limpid::frame::Options;
use limpid::offline::bench::{frames, trace};

use super::{Common, save};

#[derive(Debug, Args)]
pub(crate) struct ProfileArguments {
    /// MCAP file, ROS 1 bag, TUM folder or folder with a still pair
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
    let mut recording = limpid::input::open(&arguments.input, &config)?;
    let frames = frames(recording.as_mut(), arguments.samples)?;
    let options = Options { adapter: arguments.common.adapter.clone(), ..Options::default() };
    let options = options.with_color_of(frames.iter());
    let trace = trace(&config, &options, &frames, arguments.samples)?;
    save(&arguments.output, &trace.to_string())?;
    println!("trace: {} (open it at ui.perfetto.dev)", arguments.output.display());
    Ok(())
}
