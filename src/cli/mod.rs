//! The verbs of the command line, a file each.

#[macro_use]
mod print;

mod bench;
mod config;
mod demo;
mod eval;
mod info;
mod net;
#[cfg(feature = "ros2")]
mod node;
mod paths;
#[cfg(feature = "ros2")]
mod play;
mod points;
mod profile;
#[cfg(feature = "ros2")]
mod ros_args;
mod run;
mod score;
mod sim;
mod stop;
mod targets;
mod trial;
mod why;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use limpid::config::Method;
use limpid::output::save_file;
use limpid::{Config, Error, Result};

use self::paths::Paths;

/// Navigation costmaps that can be trusted around glare, glass and grass.
#[derive(Debug, Parser)]
#[command(version, about)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Turn a recording into costmaps
    Run(run::RunArguments),
    /// Run on a small built-in recording and leave everything limpid writes in a folder
    Demo(demo::DemoArguments),
    /// List GPU adapters, and which would be used and why
    Info(info::InfoArguments),
    /// Be a ROS 2 node: the map of what a robot's sensors see
    #[cfg(feature = "ros2")]
    Node(node::NodeArguments),
    /// Publish a recording into a ROS 2 graph, at its own pace
    #[cfg(feature = "ros2")]
    Play(play::PlayArguments),
    /// Print every parameter with its default, as a file to start from
    Config(config::ConfigArguments),
    /// Check a weight file and print weights, biases and multiply-accumulates by block
    Net(net::NetArguments),
    /// Decode the scans of a lidar recording and write each as a PLY file
    Points(points::PointsArguments),
    /// Say why a cell of the map is what it is
    Why(why::WhyArguments),
    /// Score velocities on the plan map of a lidar recording
    Score(score::ScoreArguments),
    /// Make a ray-traced recording with ground truth, from a scene or a seed
    Sim(sim::SimArguments),
    /// Write training samples: the network's inputs, reference depth and targets
    Targets(targets::TargetsArguments),
    /// Score all methods against ground truth: on scenes that it makes, on recordings, on still pairs
    Eval(eval::EvalArguments),
    /// Drive a simulated robot through simulated worlds with the map in the loop
    Trial(trial::TrialArguments),
    /// Measure time per pass and per frame
    Bench(bench::BenchArguments),
    /// Write a trace of frames and passes that Perfetto (ui.perfetto.dev) opens
    Profile(profile::ProfileArguments),
}

/// What every verb that runs frames takes.
#[derive(Debug, Args)]
struct Common {
    /// Parameters in YAML; `limpid config` prints them all
    #[arg(short, long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// How depth becomes evidence, in place of the configuration's method
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// Weight file of DRM-Net (safetensors), for method drm, in place of the configuration's
    #[arg(long, value_name = "FILE")]
    weights: Option<String>,
    /// UDP port of a pcap's Velodyne packets, in place of the configuration's velodyne_port (2368)
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Use the adapter whose name or driver contains this (else LIMPID_ADAPTER, else the best)
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

impl Common {
    /// The paths of a command that reads a recording and a configuration.
    fn paths<'a>(&'a self, input: &'a Path, config: &'a Config) -> Paths<'a> {
        Paths::default().reads("the recording", input).may_read("-c", self.config.as_deref()).reads_of(config)
    }

    fn config(&self) -> Result<Config> {
        self.config_of(self.config.as_deref(), "limpid")
    }

    /// The parameters that a file has for a node, with what the command line states.
    fn config_of(&self, file: Option<&Path>, node: &str) -> Result<Config> {
        // A file that is not there is wrong usage, as wrong content is.
        let as_usage = |error| match error {
            Error::File { .. } => Error::Yaml(error.to_string()),
            other => other,
        };
        let mut config = match file {
            Some(path) => Config::read_for(path, node).map_err(as_usage)?,
            None => Config::default(),
        };
        config.change_all(|parameters| {
            parameters.method = self.method.unwrap_or(parameters.method);
            parameters.velodyne_port = self.port.unwrap_or(parameters.velodyne_port);
            if let Some(weights) = &self.weights {
                parameters.weights.clone_from(weights);
            }
        });
        config.validate()?;
        Ok(config)
    }
}

/// Runs the command line; wrong usage ends the process, as clap does.
#[cfg(feature = "ros2")]
pub(crate) fn run(line: Vec<String>) -> Result<ExitCode> {
    let (own, ros) = ros_args::RosArgs::split(line)?;
    let mut arguments = Arguments::parse_from(own);
    match &mut arguments.verb {
        Verb::Play(arguments) => arguments.ros = ros,
        Verb::Node(arguments) => arguments.ros = ros,
        _ if ros != ros_args::RosArgs::default() => {
            let reason = "is for `limpid node` and `limpid play` alone".into();
            return Err(Error::Config { key: "--ros-args".into(), reason });
        }
        _ => {}
    }
    execute(arguments)
}

/// Runs the command line; wrong usage ends the process, as clap does.
#[cfg(not(feature = "ros2"))]
pub(crate) fn run(line: Vec<String>) -> Result<ExitCode> {
    execute(Arguments::parse_from(line))
}

fn execute(arguments: Arguments) -> Result<ExitCode> {
    match arguments.verb {
        Verb::Run(arguments) => return run::execute(&arguments),
        Verb::Sim(arguments) => return sim::execute(&arguments),
        Verb::Trial(arguments) => return trial::execute(&arguments),
        Verb::Demo(arguments) => return demo::execute(&arguments),
        #[cfg(feature = "ros2")]
        Verb::Node(arguments) => node::execute(&arguments)?,
        #[cfg(feature = "ros2")]
        Verb::Play(arguments) => play::execute(&arguments)?,
        Verb::Info(arguments) => info::execute(&arguments)?,
        Verb::Config(arguments) => config::execute(&arguments),
        Verb::Net(arguments) => net::execute(&arguments)?,
        Verb::Points(arguments) => points::execute(&arguments)?,
        Verb::Why(arguments) => why::execute(&arguments)?,
        Verb::Score(arguments) => score::execute(&arguments)?,
        Verb::Targets(arguments) => targets::execute(&arguments)?,
        Verb::Eval(arguments) => eval::execute(&arguments)?,
        Verb::Bench(arguments) => bench::execute(&arguments)?,
        Verb::Profile(arguments) => profile::execute(&arguments)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Tells on standard error what went wrong.
pub(crate) fn tell(error: &Error) {
    eprintln!("limpid: {error}");
}

/// `A..B` (B left out: to the end), by the numbers of the depth images.
fn parse_range(text: &str) -> std::result::Result<Range<u64>, String> {
    let wrong = || format!("`{text}` is not of the form A..B, A.. or ..B with A below B");
    let (start, end) = text.split_once("..").ok_or_else(wrong)?;
    let number = |text: &str, absent: u64| match text {
        "" => Ok(absent),
        digits => digits.parse().map_err(|_| wrong()),
    };
    let range = number(start, 0)?..number(end, u64::MAX)?;
    if range.is_empty() { Err(wrong()) } else { Ok(range) }
}

/// Writes `text` to the file.
fn save(path: &Path, text: &str) -> Result<()> {
    save_file(path, text.as_bytes())
}
