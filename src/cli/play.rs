//! `limpid play`.

use std::path::PathBuf;

use clap::Args;
use limpid::live::{PlayOptions, Stop, play};
use limpid::ros2::Environment;
use limpid::{Config, Result};

use super::ros_args::RosArgs;

#[derive(Debug, Args)]
pub(crate) struct PlayArguments {
    /// MCAP file, rosbag2 folder, .db3, ROS 1 bag, TUM folder, folder with a still pair, pcap, PLY, PCD or a folder of these
    input: PathBuf,
    /// Parameters in YAML, for recordings other than logs of messages
    #[arg(short, long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Times the recording's own pace
    #[arg(short, long, default_value_t = 1.0, value_parser = positive)]
    rate: f64,
    /// Again from the start, until Ctrl-C
    #[arg(short, long = "loop")]
    again: bool,
    /// Tell the recording's time on /clock, so often a second
    #[arg(long, value_name = "HZ", num_args = 0..=1, default_missing_value = "40", value_parser = positive)]
    clock: Option<f64>,
    /// Leave out so many seconds at the start; fixed transforms are sent all the same
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = from_0_up)]
    start: f64,
    /// Wait for somebody who listens to a sensor before the start, at most so long
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = from_0_up)]
    wait: f64,
    /// Send sensor data reliably too: what is lost is sent again (drivers of sensors send with best effort)
    #[arg(long)]
    reliable: bool,
    /// ROS 2 arguments come after `--ros-args`: -r FROM:=TO, -r __node:=NAME, -r __ns:=NAMESPACE
    #[arg(skip)]
    pub(super) ros: RosArgs,
}

fn number(text: &str) -> std::result::Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| value.is_finite())
        .ok_or_else(|| format!("`{text}` is not a number"))
}

fn positive(text: &str) -> std::result::Result<f64, String> {
    let value = number(text)?;
    if value > 0.0 { Ok(value) } else { Err(format!("`{text}` is not above 0")) }
}

fn from_0_up(text: &str) -> std::result::Result<f64, String> {
    let value = number(text)?;
    if (0.0..=1e6).contains(&value) { Ok(value) } else { Err(format!("`{text}` is not in 0..=1000000")) }
}

pub(crate) fn execute(arguments: &PlayArguments) -> Result<()> {
    let environment = Environment::read()?;
    let config = match &arguments.config {
        Some(path) => Config::read(path)?,
        None => Config::default(),
    };
    let options = PlayOptions {
        rate: arguments.rate,
        again: arguments.again,
        clock_hz: arguments.clock,
        start_s: arguments.start,
        wait_s: arguments.wait,
        reliable: arguments.reliable,
        naming: arguments.ros.naming("limpid_play")?,
    };
    arguments.ros.notes.iter().for_each(|note| println!("note: {note}"));
    let stop = Stop::on_signals()?;
    let report =
        play(&arguments.input, &config, &options, &environment, &stop, &mut |line| println!("{line}"))?;
    for note in &report.read.notes {
        println!("note: {note}");
    }
    for skipped in &report.read.skipped {
        println!("skipped {} x {}: {}", skipped.count, skipped.source, skipped.reason);
    }
    if report.rejoined > 0 {
        eprintln!(
            "limpid: joined the domain again {} times, as DDS had ended: the process was stopped, or the computer slept",
            report.rejoined
        );
    }
    if report.held_up > 0 {
        println!(
            "held up: {} messages were not sent, as a reliable subscriber did not answer",
            report.held_up
        );
    }
    println!("{} messages sent, played {} times to the end", report.sent, report.rounds);
    Ok(())
}
