//! How long from a depth image's arrival to the costmap's update at a peer, and does anything grow?
//!
//! `cargo bench --bench live -- latency RECORDING [--method range|drm] [--hz 10] [--frames 600]`
//! `cargo bench --bench live -- equal RECORDING [--method range] [--hz 10]`
//! `cargo bench --bench live -- load RECORDING [--minutes 30]`
//! `cargo bench --bench live -- loop RECORDING [--minutes 60]`
//!
//! The node is the program `limpid` (or `--program PATH`) as a process of its own; this process plays and listens, on the
//! loopback network. `latency` plays the recording over and over with stamps that go on, at so many frames a second. `equal`
//! compares every costmap with that of a replay. `load` has two cameras at 30 Hz, a lidar of 60,000 points at 10 Hz and tf at 200
//! Hz. `loop` plays the recording as `limpid play --loop` does. The last two print memory and counts every minute, and fail where
//! memory grows after the first tenth.

mod beside;
mod equal;
mod latency;
mod load;
mod recording;
mod soak;

use std::path::PathBuf;
use std::time::Duration;

use limpid::{Error, Result};

/// What the command line says.
struct Arguments {
    mode: String,
    recording: PathBuf,
    program: PathBuf,
    method: String,
    hz: f64,
    frames: u64,
    minutes: Option<f64>,
}

fn usage(reason: &str) -> Error {
    Error::Config { key: "bench live".into(), reason: reason.into() }
}

fn arguments() -> Result<Arguments> {
    let mut words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let mut option = |name: &str| {
        let at = words.iter().position(|word| word == name)?;
        let value = words.get(at + 1).cloned();
        words.drain(at..(at + 2).min(words.len()));
        value
    };
    let number = |text: Option<String>| {
        let parsed = text.map(|text| text.parse::<f64>().map_err(|_| usage("a number is needed")));
        parsed.transpose()
    };
    let hz = number(option("--hz"))?.unwrap_or(10.0);
    let frames = number(option("--frames"))?.unwrap_or(600.0);
    let minutes = number(option("--minutes"))?;
    let method = option("--method").unwrap_or_else(|| "range".into());
    let program = option("--program").unwrap_or_else(|| env!("CARGO_BIN_EXE_limpid").into()).into();
    let [mode, recording] = &words[..] else { return Err(usage("latency|equal|load|loop RECORDING")) };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
    let frames = frames as u64;
    Ok(Arguments { mode: mode.clone(), recording: recording.into(), program, method, hz, frames, minutes })
}

fn main() -> Result<()> {
    let arguments = arguments()?;
    let minutes =
        |usual: f64| Duration::from_secs_f64(60.0 * arguments.minutes.unwrap_or(usual).clamp(0.1, 1e4));
    match arguments.mode.as_str() {
        "latency" => latency::run(&arguments),
        "equal" => equal::run(&arguments),
        "load" => load::run(&arguments, minutes(30.0)),
        "loop" => soak::run(&arguments, minutes(60.0)),
        _ => Err(usage("latency|equal|load|loop RECORDING")),
    }
}
