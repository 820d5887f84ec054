//! How long does a frame take, by method? `cargo bench --bench frame [-- RECORDING]`
//!
//! Prints the tables of `limpid bench` for every method, all on the same frames in one run; drm where they have colour.

use std::path::PathBuf;

use limpid::config::Method;
use limpid::frame::Options;
use limpid::offline::bench::{bench, frames};
use limpid::{Config, Result};

const SAMPLES: usize = 60;

fn main() -> Result<()> {
    let input = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let input = PathBuf::from(input.unwrap_or_else(|| "testdata/room.mcap".into()));
    let config = Config::default();
    let frames = frames(limpid::input::open(&input, &config)?.as_mut(), SAMPLES)?;
    println!("{} frames of {}", frames.len(), input.display());
    let options = Options::default().with_color_of(frames.iter());
    let drm = options.color.map(|_| Method::Drm);
    for method in [Method::Range, Method::Naive, Method::Median, Method::Temporal].into_iter().chain(drm) {
        let config = Config { method, ..config.clone() };
        println!("\n{}", bench(&config, &options, &frames, SAMPLES)?.table());
    }
    Ok(())
}
