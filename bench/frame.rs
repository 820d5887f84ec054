//! How long does a frame take, by method? `cargo bench --bench frame [-- RECORDING]`
//!
//! Prints the tables of `limpid bench` for every method, all on the same frames in one run; drm where they have colour.

use std::path::PathBuf;

use limpid::config::Method;
use limpid::input::open_source;
use limpid::mapper::{Options, SensorInfo};
use limpid::offline::bench::{bench, observations};
use limpid::{Config, Result};

const SAMPLES: usize = 60;

fn main() -> Result<()> {
    let input = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let input = PathBuf::from(input.unwrap_or_else(|| "testdata/room.mcap".into()));
    let config = Config::default();
    let mut source = open_source(&input, &config)?;
    let sensors = source.sensors().to_vec();
    let frames = observations(source.as_mut(), SAMPLES)?;
    println!("{} frames of {}", frames.len(), input.display());
    let colored = |sensor: &SensorInfo| matches!(&sensor.model, limpid::sensor::SensorModel::Camera(info) if info.color.is_some());
    let drm = sensors.iter().all(colored).then_some(Method::Drm);
    for method in [Method::Range, Method::Naive, Method::Median, Method::Temporal].into_iter().chain(drm) {
        let config = Config { method, ..config.clone() };
        let of = |sensor: &SensorInfo| SensorInfo { config: config.clone(), ..sensor.clone() };
        let sensors: Vec<_> = sensors.iter().map(of).collect();
        println!("\n{}", bench(&config, &sensors, &Options::default(), &frames, SAMPLES)?.table());
    }
    Ok(())
}
