//! `limpid demo`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use limpid::input::open_source;
use limpid::mapper::Options;
use limpid::offline::bench::{bench, observations};
use limpid::offline::eval::{Generated, contestants, evaluate, picture};
use limpid::output::save_file;
use limpid::sim::Scene;
use limpid::{Config, Error, Result};

use super::run::{Outputs, end_of, print_report, run_with_progress, save_last};
use super::save;

/// The recording that `testdata/README.md` describes.
const ROOM: &[u8] = include_bytes!("../../testdata/room.mcap");

/// Samples of the timing table: short, since it is a demonstration.
const SAMPLES: usize = 50;

/// The corridor with glare, as `testdata/README.md` describes it.
const CORRIDOR: &str = include_str!("../../testdata/corridor.yaml");

#[derive(Debug, Args)]
pub(crate) struct DemoArguments {
    /// Folder for everything the demo leaves
    #[arg(short, long, default_value = "demo", value_name = "DIR")]
    output: PathBuf,
    /// Use the adapter whose name or driver contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Live instead: play the recording into a ROS 2 node on this machine, and leave a picture and a table of latencies
    #[cfg(feature = "ros2")]
    #[arg(long)]
    live: bool,
}

pub(crate) fn execute(arguments: &DemoArguments) -> Result<ExitCode> {
    let dir = &arguments.output;
    std::fs::create_dir_all(dir).map_err(Error::file(dir))?;
    let [input, mcap, png, timing, map] =
        ["room.mcap", "costmap.mcap", "pictures", "timing.md", "map"].map(|name| dir.join(name));
    save_file(&input, ROOM)?;
    #[cfg(feature = "ros2")]
    if arguments.live {
        return show_live(arguments, &input);
    }
    let config = Config::default();
    let adapter = arguments.adapter.clone();
    let options = Options { adapter, images: true, verdicts: true, ..Options::default() };
    let outputs = Outputs { mcap: Some(&mcap), png: Some(&png), dump: None };
    let mut room = open_source(&input, &config)?;
    let report = run_with_progress(room.as_mut(), 0..u64::MAX, &config, &options, &outputs)?;
    print_report(&report);
    if report.stopped {
        return Ok(end_of(&report));
    }
    if let Some(last) = report.last() {
        save_last(&map, last)?;
    }
    let mut room = open_source(&input, &config)?;
    let sensors = room.sensors().to_vec();
    let frames = observations(room.as_mut(), SAMPLES)?;
    let options = Options { images: false, verdicts: false, ..options };
    let table = bench(&config, &sensors, &options, &frames, SAMPLES)?.table();
    save(&timing, &table)?;
    println!("\n{table}");
    let glare = dir.join("glare.png");
    show_glare(&config, arguments.adapter.as_deref(), &glare)?;
    println!("recording   {}  (input; open it beside the output)", input.display());
    println!("costmap     {}  (open it in Foxglove)", mcap.display());
    println!("pictures    {}", png.display());
    println!("map         {}.pgm and .yaml  (for nav2's map_server)", map.display());
    println!("timing      {}", timing.display());
    println!(
        "glare       {}  (a simulated corridor with a polished floor: maps without and with reliability, and the truth)",
        glare.display()
    );
    Ok(ExitCode::SUCCESS)
}

/// A node, a player and a listener on the loopback network; in the domain that `ROS_DOMAIN_ID` names.
#[cfg(feature = "ros2")]
fn show_live(arguments: &DemoArguments, input: &Path) -> Result<ExitCode> {
    use limpid::live::try_node;
    use limpid::ros2::Environment;

    let dir = &arguments.output;
    let [picture, latency] = ["costmap.png", "latency.md"].map(|name| dir.join(name));
    let environment = Environment { localhost_only: true, ..Environment::read()? };
    let config = Config { reliable_sensors: true, wait_s: 1.0, publish_deadline_s: 0.0, ..Config::default() };
    let with = (&config, arguments.adapter.as_deref());
    let trial = try_node(input, with, &environment, &picture, &mut |line| println!("{line}"))?;
    save(&latency, &trial.table())?;
    println!("\n{}", trial.table());
    println!("recording   {}  (`limpid play` plays it again)", input.display());
    println!("picture     {}  (the last map that the node published)", picture.display());
    println!("latency     {}", latency.display());
    Ok(ExitCode::SUCCESS)
}

/// Drives along a simulated corridor with strong glare and draws what methods make of it beside the truth.
fn show_glare(config: &Config, adapter: Option<&str>, path: &Path) -> Result<()> {
    let scene = Scene::from_yaml(CORRIDOR)?;
    let mut source = Generated::open(&scene, config, adapter)?;
    let shown =
        contestants(config).into_iter().filter(|method| ["naive", "range", "drm"].contains(&method.key));
    let (_, last) = evaluate(&mut source, &shown.collect::<Vec<_>>(), config, adapter)?;
    picture::save(&last, path)
}
