//! From the arrival of a depth image to the costmap's update at the peer.

use std::collections::HashMap;
use std::process::Command;
use std::time::{Duration, Instant};

use limpid::ros2::{Inbox, Quality};
use limpid::{Error, Result};

use crate::Arguments;
use crate::beside::{Beside, MAP, UPDATE, stamp_ns};
use crate::recording::Recording;

/// Number of the depth images.
const DEPTH: u32 = 9;

/// Frames before those that are measured, seconds.
const WARM_UP_S: f64 = 5.0;

pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let recording = Recording::read(&arguments.recording)?;
    let node: Vec<String> = ["--method", &arguments.method, "--ros-args", "-p", "reliable_sensors:=true"]
        .map(str::to_owned)
        .into();
    let beside = Beside::start(&arguments.program, &node)?;
    // What a subscriber on this machine sees of the images: when they arrive.
    let arrivals = Inbox::open()?;
    let depth = &recording.topics[recording.depth];
    let quality = Quality::Stream { depth: 100 };
    arrivals.add(DEPTH, beside.participant.subscribe(&depth.name, &depth.type_name, quality)?, 4096, false);
    let sent = play(arguments, &recording, &beside, &arrivals)?;
    println!("{}", row(arguments, sent));
    offline(arguments)
}

/// What was measured.
struct Measured {
    latencies_ms: Vec<f64>,
    sent: u64,
    cpu_share: f64,
}

/// Plays and collects; a frame's arrival is when this process's own subscriber has it.
fn play(arguments: &Arguments, recording: &Recording, beside: &Beside, arrivals: &Inbox) -> Result<Measured> {
    let player = limpid::ros2::Participant::join(&beside.environment)?;
    let publications = recording.publish(&player)?;
    std::thread::sleep(Duration::from_secs(3));
    #[expect(clippy::cast_precision_loss, reason = "seconds of a recording")]
    let pace = recording.frames as f64 / arguments.hz / (recording.span_ns as f64 * 1e-9);
    let (start, mut cpu) = (Instant::now(), None);
    let (mut arrived, mut latencies, mut sent) = (HashMap::new(), Vec::new(), 0);
    'rounds: for round in 0.. {
        for message in &recording.messages {
            let by_ns = round * recording.span_ns;
            let at_ns = message.at_ns - recording.messages[0].at_ns + by_ns;
            let due = start + Duration::from_nanos(at_ns).mul_f64(pace);
            collect(beside, arrivals, due, &mut arrived, &mut latencies);
            publications[message.topic].send(recording.later(message, by_ns)?)?;
            sent += u64::from(message.topic == recording.depth);
            if sent == arguments.frames {
                break 'rounds;
            }
        }
        if cpu.is_none() && start.elapsed().as_secs_f64() > WARM_UP_S {
            cpu = Some((Instant::now(), beside.cpu_s()));
        }
    }
    let cpu_share =
        cpu.map_or(f64::NAN, |(since, before_s)| (beside.cpu_s() - before_s) / since.elapsed().as_secs_f64());
    collect(beside, arrivals, Instant::now() + Duration::from_secs(2), &mut arrived, &mut latencies);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
    let warm_up = (WARM_UP_S * arguments.hz) as usize;
    let latencies_ms = latencies.into_iter().skip(warm_up).collect();
    Ok(Measured { latencies_ms, sent, cpu_share })
}

/// Takes what comes until then.
fn collect(
    beside: &Beside,
    arrivals: &Inbox,
    until: Instant,
    arrived: &mut HashMap<u64, Instant>,
    latencies: &mut Vec<f64>,
) {
    loop {
        while let Some(image) = arrivals.take(None) {
            arrived.extend(stamp_ns(&image.payload).map(|stamp| (stamp, image.arrived)));
        }
        while let Some(parcel) = beside.inbox.take(None) {
            let is_map = parcel.topic == MAP || parcel.topic == UPDATE;
            let since = stamp_ns(&parcel.payload).filter(|_| is_map).and_then(|stamp| arrived.remove(&stamp));
            latencies.extend(since.map(|since| (parcel.arrived - since).as_secs_f64() * 1e3));
        }
        if Instant::now() >= until {
            return;
        }
        beside.inbox.wait(until.min(Instant::now() + Duration::from_millis(5)));
    }
}

fn row(arguments: &Arguments, measured: Measured) -> String {
    let Measured { mut latencies_ms, sent, cpu_share } = measured;
    latencies_ms.sort_by(f64::total_cmp);
    let at = |share: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "an index"
        )]
        let index = (share * latencies_ms.len() as f64) as usize;
        latencies_ms.get(index).or(latencies_ms.last()).copied().unwrap_or(f64::NAN)
    };
    format!(
        "| method | Hz | frames sent | maps measured | median ms | p99 ms | CPU share |\n|---|---|---|---|---|---|---|\n\
         | {} | {} | {sent} | {} | {:.1} | {:.1} | {:.2} |",
        arguments.method,
        arguments.hz,
        latencies_ms.len(),
        at(0.5),
        at(0.99),
        cpu_share
    )
}

/// The same frames without a graph, in the same run.
fn offline(arguments: &Arguments) -> Result<()> {
    let output = Command::new(&arguments.program)
        .arg("bench")
        .arg(&arguments.recording)
        .args(["--method", &arguments.method, "--samples", "60"])
        .output()
        .map_err(Error::file(&arguments.program))?;
    println!("offline, `limpid bench --samples 60`:");
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .filter(|line| line.contains("wall") || line.contains("CPU"))
        .for_each(|line| println!("  {line}"));
    Ok(())
}
