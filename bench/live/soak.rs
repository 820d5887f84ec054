//! Memory and counts of a node, minute by minute.

use std::time::{Duration, Instant};

use limpid::input::playback::Playback;
use limpid::live::{PlayOptions, Stop, play};
use limpid::ros2::Naming;
use limpid::{Config, Error, Result};

use crate::Arguments;
use crate::beside::{Beside, DIAGNOSTICS, RAW, said};

/// Growth of resident memory after the first tenth that counts as flat: allocators keep some pages back.
const FLAT_KIB: u64 = 16384;

/// Watches a node for so long; fails where its memory grows.
pub(crate) fn watch(beside: &Beside, length: Duration) -> Result<()> {
    println!("| minute | resident KiB | CPU s | maps received | state | counts |\n|---|---|---|---|---|---|");
    let (start, mut next, mut maps) = (Instant::now(), Instant::now() + Duration::from_secs(60), 0_u64);
    let (mut newest, mut settled_kib) = (None, None);
    while start.elapsed() < length {
        beside.inbox.wait(next.min(start + length));
        while let Some(parcel) = beside.inbox.take(None) {
            maps += u64::from(parcel.topic == RAW);
            if parcel.topic == DIAGNOSTICS {
                newest = Some(parcel.payload);
            }
        }
        if Instant::now() >= next {
            next += Duration::from_secs(60);
            print_row(beside, start, maps, newest.as_deref());
            if 10 * start.elapsed() >= length {
                settled_kib.get_or_insert(beside.resident_kib());
            }
        }
    }
    let end_kib = beside.resident_kib();
    let grown_kib = end_kib.saturating_sub(settled_kib.unwrap_or(end_kib));
    print_row(beside, start, maps, newest.as_deref());
    println!("resident memory grew by {grown_kib} KiB after the first tenth");
    if end_kib > 0 && grown_kib <= FLAT_KIB {
        return Ok(());
    }
    Err(Error::Empty { reason: "memory is not flat, or the node has ended".into() })
}

fn print_row(beside: &Beside, start: Instant, maps: u64, newest: Option<&[u8]>) {
    let (state, counts) = newest.and_then(said).unwrap_or_default();
    let told = |key: &str| {
        ["used", "refused", "latency_ms", "held_up", "restarts"].iter().any(|end| key.ends_with(end))
    };
    let counts: Vec<String> = counts
        .iter()
        .filter(|(key, _)| key.contains("/") || told(key))
        .map(|(key, value)| format!("{}: {value}", key.trim_start_matches("messages: ")))
        .collect();
    println!(
        "| {:.1} | {} | {:.0} | {maps} | {state} | {} |",
        start.elapsed().as_secs_f64() / 60.0,
        beside.resident_kib(),
        beside.cpu_s(),
        counts.join("; ")
    );
}

/// A recording in a loop.
pub(crate) fn run(arguments: &Arguments, length: Duration) -> Result<()> {
    // What cannot be played is told at once.
    Playback::open(&arguments.recording, &Config::default())?;
    let node: Vec<String> = ["--method".to_owned(), arguments.method.clone()].into();
    let beside = Beside::start(&arguments.program, &node)?;
    let (stop, path, environment) =
        (Stop::default(), arguments.recording.clone(), beside.environment.clone());
    let own = stop.clone();
    let player = std::thread::spawn(move || {
        let options = PlayOptions {
            rate: 1.0,
            again: true,
            clock_hz: None,
            start_s: 0.0,
            wait_s: 10.0,
            reliable: false,
            naming: Naming::new("play", "/", &[])?,
        };
        play(&path, &Config::default(), &options, &environment, &own, &mut |_| ())
    });
    let flat = watch(&beside, length);
    stop.set();
    let report = player.join().map_err(|_| Error::Empty { reason: "the player panicked".into() })??;
    println!("{} messages sent, played {} times to the end", report.sent, report.rounds);
    flat
}
