//! Measuring: latency, throughput, CPU time and GPU time per pass, and traces of both.

use std::fmt::Write as _;
use std::time::Instant;

use cpu_time::ProcessTime;
use serde::Serialize;
use serde_json::{Value, json};

use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::Source;
use crate::mapper::{Mapper, Options, SensorInfo, Submitted};
use crate::sensor::{CameraModel, Observation, SensorData, SensorModel};

/// Median and spread of samples, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stats {
    /// Smallest.
    pub min_ms: f64,
    /// Median.
    pub median_ms: f64,
    /// 95th percentile.
    pub p95_ms: f64,
    /// How many samples.
    pub samples: usize,
}

impl Stats {
    /// Of `samples` milliseconds; `None` of none.
    pub fn of(samples: &[f64]) -> Option<Self> {
        let mut sorted = samples.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |percent: usize| sorted.get((sorted.len() * percent / 100).min(sorted.len() - 1)).copied();
        Some(Self { min_ms: *sorted.first()?, median_ms: at(50)?, p95_ms: at(95)?, samples: sorted.len() })
    }
}

/// Figures of one benchmark.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BenchReport {
    /// limpid's version.
    pub version: &'static str,
    /// Adapter, driver and why it was chosen.
    pub adapter: String,
    /// Pixels of the depth image.
    pub width: u32,
    /// Pixels of the depth image.
    pub height: u32,
    /// Points of the first scan; 0 of a camera.
    pub points: usize,
    /// Method.
    pub method: String,
    /// Building the passes: device, allocation, compilation, first dispatches.
    pub build_ms: f64,
    /// From submit to result, one frame at a time: upload, all passes, readback.
    pub wall: Stats,
    /// CPU time of the whole process over the same span (on a software adapter it includes the passes).
    pub cpu: Stats,
    /// Per frame with three frames under way.
    pub pipelined_ms: f64,
    /// Sum of the passes on the GPU's clock; `None` without timestamps.
    pub gpu: Option<Stats>,
    /// Each pass on the GPU's clock, in order.
    pub passes: Vec<(String, Stats)>,
    /// One-minute load average before and after, where the system tells.
    pub load: [Option<f64>; 2],
}

/// The first `count` observations with a pose.
///
/// # Errors
/// Those of the source, and [`Error::Empty`] where there is none.
pub fn observations(source: &mut dyn Source, count: usize) -> Result<Vec<Observation>> {
    let mut observations = Vec::new();
    while observations.len() < count {
        let Some(observation) = source.next()? else { break };
        observations.extend(observation.pose.is_some().then_some(observation));
    }
    match observations.is_empty() {
        true => Err(source.report().nothing_used(source.sensors(), Vec::new())),
        false => Ok(observations),
    }
}

/// Measures `samples` observations of `sensors`, going round `observations`, after a fifth as many to warm up.
///
/// # Errors
/// Those of [`Mapper`], and [`Error::Empty`] without observations or samples.
pub fn bench(
    config: &Config,
    sensors: &[SensorInfo],
    options: &Options,
    observations: &[Observation],
    samples: usize,
) -> Result<BenchReport> {
    let first = observations.first().filter(|_| samples > 0);
    let first = first.ok_or_else(|| Error::Empty { reason: "nothing to measure".into() })?;
    let load_before = load_average();
    let start = Instant::now();
    let mut mapper = Mapper::open(config, sensors, &Options { profiling: false, ..options.clone() })?;
    let build_ms = ms_since(start);
    let round = || observations.iter().cycle();
    for observation in round().take(samples.div_ceil(5)) {
        mapper.step(observation)?;
    }
    let (mut wall, mut cpu) = (Vec::new(), Vec::new());
    for observation in round().take(samples) {
        let (start, cpu_start) = (Instant::now(), ProcessTime::now());
        mapper.step(observation)?;
        wall.push(ms_since(start));
        cpu.push(cpu_start.elapsed().as_secs_f64() * 1e3);
    }
    let pipelined_ms = pipelined(&mut mapper, observations, samples)?;
    let (gpu, passes) = passes(config, sensors, options, observations, samples)?;
    let empty = || Error::Empty { reason: "nothing measured".into() };
    let Subject { width, height, points, method } = Subject::of(first, sensors);
    Ok(BenchReport {
        version: env!("CARGO_PKG_VERSION"),
        adapter: mapper.context().describe(),
        width,
        height,
        points,
        method,
        build_ms,
        wall: Stats::of(&wall).ok_or_else(empty)?,
        cpu: Stats::of(&cpu).ok_or_else(empty)?,
        pipelined_ms,
        gpu,
        passes,
        load: [load_before, load_average()],
    })
}

/// What is measured.
struct Subject {
    width: u32,
    height: u32,
    points: usize,
    method: String,
}

impl Subject {
    fn of(first: &Observation, sensors: &[SensorInfo]) -> Self {
        match (&first.data, sensors.get(first.sensor)) {
            (SensorData::Frame(frame), Some(SensorInfo { config, model: SensorModel::Camera(info), .. })) => {
                let method = config.resolved(info.color.is_some()).method;
                let CameraModel { width, height, .. } = frame.depth.camera;
                Self { width, height, points: 0, method: format!("{method:?}").to_lowercase() }
            }
            (SensorData::Scan(scan), Some(SensorInfo { config, .. })) => {
                let method = if config.glass { "lidar with glass" } else { "lidar" };
                Self { width: 0, height: 0, points: scan.points.len(), method: method.into() }
            }
            _ => Self { width: 0, height: 0, points: 0, method: String::new() },
        }
    }
}

fn pipelined(mapper: &mut Mapper, observations: &[Observation], samples: usize) -> Result<f64> {
    let start = Instant::now();
    for observation in observations.iter().cycle().take(samples) {
        submit(mapper, observation, |mapper| mapper.wait().map(|_| ()))?;
    }
    while mapper.wait()?.is_some() {}
    let frames = u32::try_from(samples).unwrap_or(u32::MAX);
    Ok(ms_since(start) / f64::from(frames))
}

/// Submits as soon as there is room; `take` takes a result where there is none.
fn submit(
    mapper: &mut Mapper,
    observation: &Observation,
    mut take: impl FnMut(&mut Mapper) -> Result<()>,
) -> Result<()> {
    while mapper.is_full(observation.sensor) {
        take(mapper)?;
    }
    match mapper.submit(observation)? {
        Submitted::Taken => Ok(()),
        Submitted::Refused(reason) => {
            Err(Error::Input { what: "observation".into(), reason: reason.to_string() })
        }
    }
}

type PassStats = (Option<Stats>, Vec<(String, Stats)>);

/// GPU time by pass, in a mapper of its own: timestamps split the frame's one compute pass.
fn passes(
    config: &Config,
    sensors: &[SensorInfo],
    options: &Options,
    observations: &[Observation],
    samples: usize,
) -> Result<PassStats> {
    let mut mapper = Mapper::open(config, sensors, &Options { profiling: true, ..options.clone() })?;
    let mut sums = Vec::new();
    let mut by_pass: Vec<(String, Vec<f64>)> = Vec::new();
    for observation in observations.iter().cycle().take(samples) {
        let output = mapper.step(observation)?;
        sums.push(output.pass_ms.iter().map(|(_, ms)| ms).sum());
        for (index, (name, ms)) in output.pass_ms.into_iter().enumerate() {
            if by_pass.len() == index {
                by_pass.push((name.to_string(), Vec::new()));
            }
            by_pass[index].1.push(ms);
        }
    }
    let passes: Vec<_> = by_pass.into_iter().filter_map(|(name, ms)| Some((name, Stats::of(&ms)?))).collect();
    Ok((Stats::of(&sums).filter(|_| !passes.is_empty()), passes))
}

impl BenchReport {
    /// A Markdown table: a row per pass, then the frame.
    pub fn table(&self) -> String {
        let Self { version, adapter, width, height, points, method, build_ms, .. } = self;
        let size = if *points > 0 { format!("{points} points") } else { format!("{width}x{height}") };
        let mut text =
            format!("limpid {version}, {adapter}\n{size}, method {method}, built in {build_ms:.0} ms");
        if let [Some(before), Some(after)] = self.load {
            let _ = write!(text, ", load {before:.1} to {after:.1}");
        }
        text += "\n\n| | median ms | p95 ms | min ms | samples |\n|---|---|---|---|---|\n";
        let passes = self.passes.iter().map(|(name, stats)| (name.as_str(), stats));
        let gpu = self.gpu.as_ref().map(|stats| ("**all passes, GPU**", stats));
        let frame = [("**frame, wall**", &self.wall), ("**frame, CPU time**", &self.cpu)];
        for (name, s) in passes.chain(gpu).chain(frame) {
            let _ = writeln!(
                text,
                "| {name} | {:.3} | {:.3} | {:.3} | {} |",
                s.median_ms, s.p95_ms, s.min_ms, s.samples
            );
        }
        let _ = writeln!(
            text,
            "| **frame, three under way** | {:.3} | | | {} |",
            self.pipelined_ms, self.wall.samples
        );
        text
    }
}

/// A Chrome trace (Perfetto opens it) of `samples` observations: the passes on the GPU's clock, set beside the
/// host's by the first frame's submit, and what the host did meanwhile.
///
/// # Errors
/// Those of [`Mapper`]; [`Error::Gpu`] where the adapter has no timestamps.
pub fn trace(
    config: &Config,
    sensors: &[SensorInfo],
    options: &Options,
    observations: &[Observation],
    samples: usize,
) -> Result<Value> {
    let mut mapper = Mapper::open(config, sensors, &Options { profiling: true, ..options.clone() })?;
    let mut trace = Trace::new(&mapper.context().describe());
    let mut number = 0;
    for observation in observations.iter().cycle().take(samples) {
        while mapper.is_full(observation.sensor) {
            trace.receive(&mut mapper, number)?;
            number += 1;
        }
        trace.host("submit", |_| submit(&mut mapper, observation, |_| Ok(())))?;
    }
    for number in number..samples {
        trace.receive(&mut mapper, number)?;
    }
    match trace.gpu_offset_us {
        Some(_) => Ok(json!({ "traceEvents": trace.events, "displayTimeUnit": "ms" })),
        None => {
            Err(Error::Gpu { what: "profile".into(), reason: "the adapter has no timestamp queries".into() })
        }
    }
}

struct Trace {
    events: Vec<Value>,
    start: Instant,
    submitted_us: Option<f64>,
    gpu_offset_us: Option<f64>,
}

const HOST: u32 = 1;
const GPU: u32 = 2;

impl Trace {
    fn new(adapter: &str) -> Self {
        let name = |pid: u32, name: &str| json!({ "ph": "M", "pid": pid, "tid": 1, "name": "process_name", "args": { "name": name } });
        let events = vec![name(HOST, "host"), name(GPU, adapter)];
        Self { events, start: Instant::now(), submitted_us: None, gpu_offset_us: None }
    }

    fn span(&mut self, pid: u32, name: &str, start_us: f64, length_us: f64, frame: Option<usize>) {
        self.events.push(json!({
            "ph": "X", "pid": pid, "tid": 1, "name": name, "ts": start_us, "dur": length_us, "args": { "frame": frame },
        }));
    }

    fn host<T>(&mut self, name: &str, work: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let start_us = ms_since(self.start) * 1e3;
        let result = work(self);
        let end_us = ms_since(self.start) * 1e3;
        self.submitted_us.get_or_insert(end_us);
        self.span(HOST, name, start_us, end_us - start_us, None);
        result
    }

    fn receive(&mut self, mapper: &mut Mapper, number: usize) -> Result<()> {
        let Some(output) = self.host("receive", |_| mapper.wait())? else { return Ok(()) };
        let starts = output.pass_start_ms.iter().map(|ms| ms * 1e3);
        for ((name, ms), start_us) in output.pass_ms.iter().zip(starts) {
            let submitted_us = self.submitted_us.unwrap_or(0.0);
            let offset_us = *self.gpu_offset_us.get_or_insert(submitted_us - start_us);
            self.span(GPU, name, start_us + offset_us, ms * 1e3, Some(number));
        }
        Ok(())
    }
}

fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

fn load_average() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split(' ').next()?.parse().ok()
}
