//! Do two cameras and a lidar keep 10 Hz of published maps?
//! `cargo bench --bench one_map -- CAMERA_RECORDING CONFIG.yaml LIDAR_RECORDING CONFIG.yaml [--camera-hz HZ] [--seconds S]`
//!
//! Two cameras, half a period apart, show the frames of one recording there and back, a lidar at 10 Hz those of another where the
//! first camera's base is, all in one map; method range. First as fast as the passes go: seconds of data in a second, and the
//! process's CPU time for a second of data (on a software adapter it includes the passes; below 2 s they fit two free cores). Then
//! every observation at its time, as on a robot: maps in a second; time from the submit of the newest observation in a map to that
//! map on the host; how late an observation was submitted because the passes were behind.

use std::collections::VecDeque;
use std::path::Path;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use glam::DVec3;
use limpid::base::Rigid;
use limpid::config::Method;
use limpid::input::open_source;
use limpid::map::Update;
use limpid::mapper::{Mapper, Options, SensorInfo, Submitted};
use limpid::offline::bench::{Stats, observations};
use limpid::sensor::{Observation, SensorData, SensorPose};
use limpid::{Config, Error, Result};

const FRAMES: usize = 100;
const SCANS: usize = 20;
const LIDAR_HZ: f64 = 10.0;
const MAP_HZ: f64 = 10.0;
/// The lidar above the base.
const LIDAR_HEIGHT_M: f64 = 1.0;

/// What the sensors show.
struct Data {
    frames: Vec<Observation>,
    scans: Vec<Observation>,
    sensors: [SensorInfo; 3],
    config: Config,
    camera_hz: f64,
    seconds: f64,
}

/// When a sensor shows what.
#[derive(Clone, Copy)]
struct Event {
    after_s: f64,
    sensor: usize,
    number: u32,
}

/// A recording's first observations, and its sensor.
fn read(path: &str, config: &Config, count: usize) -> Result<(Vec<Observation>, SensorInfo)> {
    let mut source = open_source(Path::new(path), config)?;
    let sensor = source.sensors().first().cloned();
    let sensor = sensor.ok_or_else(|| Error::Empty { reason: format!("{path} has no sensor") })?;
    Ok((observations(source.as_mut(), count)?, sensor))
}

/// Which of `count` comes as the one of this number, there and back.
fn there_and_back(number: u32, count: usize) -> usize {
    let turn = (2 * count).saturating_sub(2).max(1);
    let at = number as usize % turn;
    at.min(turn - at).min(count - 1)
}

impl Data {
    fn read(paths: [&str; 4], camera_hz: f64, seconds: f64) -> Result<Self> {
        let mut config = Config { method: Method::Range, ..Config::read(Path::new(paths[1]))? };
        config.change_all(|parameters| parameters.method = Method::Range);
        let (mut frames, camera) = read(paths[0], &config, FRAMES)?;
        for observation in &mut frames {
            if let SensorData::Frame(frame) = &mut observation.data {
                frame.color = None;
            }
        }
        let (scans, lidar) = read(paths[2], &Config::read(Path::new(paths[3]))?, SCANS)?;
        let named = |name: &str, sensor: &SensorInfo| SensorInfo {
            name: name.into(),
            config: Config { method: Method::Range, ..sensor.config.clone() },
            ..sensor.clone()
        };
        let sensors = [named("front", &camera), named("rear", &camera), named("top", &lidar)];
        Ok(Self { frames, scans, sensors, config, camera_hz, seconds })
    }

    /// In order of time.
    fn events(&self) -> Vec<Event> {
        let period_s = self.camera_hz.recip();
        let of = |sensor: usize, period_s: f64, offset_s: f64| {
            let at =
                move |number: u32| Event { after_s: offset_s + f64::from(number) * period_s, sensor, number };
            (0..).map(at).take_while(|event| event.after_s < self.seconds)
        };
        let cameras = of(0, period_s, 0.0).chain(of(1, period_s, period_s / 2.0));
        let mut events: Vec<_> = cameras.chain(of(2, LIDAR_HZ.recip(), 0.0)).collect();
        events.sort_by(|a, b| a.after_s.total_cmp(&b.after_s));
        events
    }

    fn observation(&self, event: Event, stamp_ns: u64) -> Observation {
        let frame = |number: u32| &self.frames[there_and_back(number, self.frames.len())];
        let list = if event.sensor == 2 { &self.scans } else { &self.frames };
        let mut observation = list[there_and_back(event.number, list.len())].clone();
        observation.sensor = event.sensor;
        match &mut observation.data {
            SensorData::Frame(frame) => frame.depth.stamp_ns = stamp_ns,
            SensorData::Scan(scan) => scan.stamp_ns = stamp_ns,
        }
        if event.sensor == 2 {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a few thousand frames"
            )]
            let at_frame = (event.after_s * self.camera_hz) as u32;
            let translation_m = DVec3::new(0.0, 0.0, LIDAR_HEIGHT_M);
            let base_from_sensor = Rigid { translation_m, ..Rigid::IDENTITY };
            let base = frame(at_frame).pose.map(|pose| pose.map_from_base);
            let place = |map_from_base| SensorPose { map_from_base, base_from_sensor, sweep: None };
            observation.pose = base.map(place);
            observation.map_frame.clone_from(&frame(0).map_frame);
        }
        observation
    }
}

/// What came of it.
struct Outcome {
    elapsed_s: f64,
    /// Of the whole process.
    cpu_s: f64,
    maps: u32,
    /// From the newest observation's submit to its map.
    latencies_ms: Vec<f64>,
    /// Longest time that an observation was submitted after it was there.
    late_ms: f64,
    /// Submits of the newest observations in the maps under way.
    asked: VecDeque<Instant>,
}

impl Outcome {
    fn count(&mut self, update: Option<Update>) {
        if update.is_some_and(|update| update.map.is_some())
            && let Some(submitted) = self.asked.pop_front()
        {
            self.maps += 1;
            self.latencies_ms.push(submitted.elapsed().as_secs_f64() * 1e3);
        }
    }
}

/// Waits for the time of an observation, and takes the results that come meanwhile.
fn wait_until(mapper: &mut Mapper, outcome: &mut Outcome, due: Instant) -> Result<()> {
    while Instant::now() < due {
        match mapper.poll()? {
            None => std::thread::sleep(Duration::from_micros(500).min(due - Instant::now().min(due))),
            update => outcome.count(update),
        }
    }
    outcome.late_ms = outcome.late_ms.max(due.elapsed().as_secs_f64() * 1e3);
    Ok(())
}

/// Gives the mapper all observations, stamped from `start_ns` on: at their times where `paced`, else as fast as it takes them.
fn feed(mapper: &mut Mapper, data: &Data, start_ns: u64, paced: bool) -> Result<Outcome> {
    let (asked, latencies_ms) = (VecDeque::new(), Vec::new());
    let mut outcome = Outcome { elapsed_s: 0.0, cpu_s: 0.0, maps: 0, latencies_ms, late_ms: 0.0, asked };
    let (start, cpu_start, mut next_map_s) = (Instant::now(), ProcessTime::now(), 0.0);
    for event in data.events() {
        let after = Duration::from_secs_f64(event.after_s);
        let stamp_ns = start_ns + u64::try_from(after.as_nanos()).unwrap_or(u64::MAX);
        let observation = data.observation(event, stamp_ns);
        while mapper.is_full(event.sensor) {
            outcome.count(mapper.wait()?);
        }
        if paced {
            wait_until(mapper, &mut outcome, start + after)?;
        }
        let submitted = Instant::now();
        if let Submitted::Refused(reason) = mapper.submit(&observation)? {
            return Err(Error::Input { what: "observation".into(), reason: reason.to_string() });
        }
        if event.after_s + 1e-9 >= next_map_s {
            while mapper.is_publishing_full() {
                outcome.count(mapper.wait()?);
            }
            mapper.publish(None)?;
            outcome.asked.push_back(submitted);
            next_map_s += MAP_HZ.recip();
        }
    }
    while let Some(update) = mapper.wait()? {
        outcome.count(Some(update));
    }
    outcome.elapsed_s = start.elapsed().as_secs_f64();
    outcome.cpu_s = cpu_start.elapsed().as_secs_f64();
    Ok(outcome)
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let number = |name: &str, otherwise: f64| {
        let at = arguments.iter().position(|argument| argument == name);
        at.and_then(|at| arguments.get(at + 1)?.parse().ok()).unwrap_or(otherwise)
    };
    let (camera_hz, seconds) = (number("--camera-hz", 15.0), number("--seconds", 20.0));
    let Some(paths) = arguments.first_chunk::<4>() else {
        println!("skipped: it takes a recording and a configuration of a camera, then those of a lidar");
        return Ok(());
    };
    let data = Data::read(paths.each_ref().map(String::as_str), camera_hz, seconds)?;
    let mut mapper = Mapper::open(&data.config, &data.sensors, &Options::default())?;
    let (start_ns, length_ns) =
        (data.frames[0].stamp_ns(), Duration::from_secs_f64(seconds + 1.0).as_nanos());
    let fast = feed(&mut mapper, &data, start_ns, false)?;
    let paced_ns = start_ns + u64::try_from(length_ns).unwrap_or(0);
    let paced = feed(&mut mapper, &data, paced_ns, true)?;
    let points = data.scans[0].scan().map_or(0, |scan| scan.points.len());
    let stats = Stats::of(&paced.latencies_ms).ok_or(Error::Empty { reason: "no map came".into() })?;
    let worst_ms = paced.latencies_ms.iter().copied().fold(0.0, f64::max);
    println!("{}", mapper.context().describe());
    println!(
        "| cameras | lidar | data a second, s | CPU for a second of data, s | maps a second | median ms | p95 ms | worst ms | latest ms |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    println!(
        "| 2 at {camera_hz} Hz | {points} points at {LIDAR_HZ} Hz | {:.2} | {:.2} | {:.2} | {:.1} | {:.1} | {worst_ms:.1} | {:.1} |",
        seconds / fast.elapsed_s,
        fast.cpu_s / seconds,
        f64::from(paced.maps) / paced.elapsed_s,
        stats.median_ms,
        stats.p95_ms,
        paced.late_ms,
    );
    Ok(())
}
