//! Measuring: latency, throughput, CPU time and GPU time per pass, and traces of both.

use std::fmt::Write as _;
use std::time::Instant;

use cpu_time::ProcessTime;
use serde::Serialize;
use serde_json::{Value, json};

use crate::base::{Error, Result};
use crate::config::Config;
use crate::frame::{FrameOutput, Options};
use crate::input::Recording;
use crate::pipeline::Pipeline;
use crate::sensor::RgbdFrame;

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
    /// Method.
    pub method: String,
    /// Building the pipeline: device, allocation, compilation, first dispatches.
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

/// The first `count` frames with a pose.
///
/// # Errors
/// Those of the reader, and [`Error::Empty`] where there is none.
pub fn frames(recording: &mut dyn Recording, count: usize) -> Result<Vec<RgbdFrame>> {
    let mut frames = Vec::new();
    while frames.len() < count {
        let Some(frame) = recording.next_frame()? else { break };
        frames.extend(frame.pose.is_some().then_some(frame));
    }
    match frames.is_empty() {
        true => Err(Error::Empty { reason: "no frame with a pose".into() }),
        false => Ok(frames),
    }
}

/// Measures `samples` frames, going round `frames`, after a fifth as many to warm up.
///
/// # Errors
/// Those of [`Pipeline`], and [`Error::Empty`] without frames or samples.
pub fn bench(
    config: &Config,
    options: &Options,
    frames: &[RgbdFrame],
    samples: usize,
) -> Result<BenchReport> {
    let first = frames.first().filter(|_| samples > 0);
    let first = first.ok_or_else(|| Error::Empty { reason: "nothing to measure".into() })?;
    let load_before = load_average();
    let start = Instant::now();
    let mut pipeline = Pipeline::open(config, first, &Options { profiling: false, ..options.clone() })?;
    let build_ms = ms_since(start);
    let round = || frames.iter().cycle();
    for frame in round().take(samples.div_ceil(5)) {
        process(&mut pipeline, frame)?;
    }
    let (mut wall, mut cpu) = (Vec::new(), Vec::new());
    for frame in round().take(samples) {
        let (start, cpu_start) = (Instant::now(), ProcessTime::now());
        process(&mut pipeline, frame)?;
        wall.push(ms_since(start));
        cpu.push(cpu_start.elapsed().as_secs_f64() * 1e3);
    }
    let pipelined_ms = pipelined(&mut pipeline, frames, samples)?;
    let (gpu, passes) = passes(config, options, frames, samples)?;
    let empty = || Error::Empty { reason: "nothing measured".into() };
    Ok(BenchReport {
        version: env!("CARGO_PKG_VERSION"),
        adapter: pipeline.executor().context().describe(),
        width: first.depth.camera.width,
        height: first.depth.camera.height,
        method: format!("{:?}", config.resolved(options.color.is_some()).method).to_lowercase(),
        build_ms,
        wall: Stats::of(&wall).ok_or_else(empty)?,
        cpu: Stats::of(&cpu).ok_or_else(empty)?,
        pipelined_ms,
        gpu,
        passes,
        load: [load_before, load_average()],
    })
}

fn process(pipeline: &mut Pipeline, frame: &RgbdFrame) -> Result<Option<FrameOutput>> {
    pipeline.submit(frame)?;
    pipeline.receive()
}

fn pipelined(pipeline: &mut Pipeline, frames: &[RgbdFrame], samples: usize) -> Result<f64> {
    let start = Instant::now();
    for frame in frames.iter().cycle().take(samples) {
        if pipeline.is_full() {
            pipeline.receive()?;
        }
        pipeline.submit(frame)?;
    }
    while pipeline.receive()?.is_some() {}
    let frames = u32::try_from(samples).unwrap_or(u32::MAX);
    Ok(ms_since(start) / f64::from(frames))
}

type PassStats = (Option<Stats>, Vec<(String, Stats)>);

/// GPU time by pass, in a pipeline of its own: timestamps split the frame's one compute pass.
fn passes(config: &Config, options: &Options, frames: &[RgbdFrame], samples: usize) -> Result<PassStats> {
    let mut pipeline = Pipeline::open(config, &frames[0], &Options { profiling: true, ..options.clone() })?;
    let mut sums = Vec::new();
    let mut by_pass: Vec<(String, Vec<f64>)> = Vec::new();
    for frame in frames.iter().cycle().take(samples) {
        let Some(output) = process(&mut pipeline, frame)? else { continue };
        sums.push(output.pass_ms.iter().map(|(_, ms)| ms).sum());
        for (index, (name, ms)) in output.pass_ms.into_iter().enumerate() {
            if by_pass.len() == index {
                by_pass.push((name, Vec::new()));
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
        let Self { version, adapter, width, height, method, build_ms, .. } = self;
        let mut text = format!(
            "limpid {version}, {adapter}\n{width}x{height}, method {method}, built in {build_ms:.0} ms"
        );
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

/// A Chrome trace (Perfetto opens it) of `samples` frames: the passes on the GPU's clock, set beside the
/// host's by the first frame's submit, and what the host did meanwhile.
///
/// # Errors
/// Those of [`Pipeline`]; [`Error::Gpu`] where the adapter has no timestamps.
pub fn trace(config: &Config, options: &Options, frames: &[RgbdFrame], samples: usize) -> Result<Value> {
    let first = frames.first().ok_or_else(|| Error::Empty { reason: "nothing to trace".into() })?;
    let mut pipeline = Pipeline::open(config, first, &Options { profiling: true, ..options.clone() })?;
    let mut trace = Trace::new(&pipeline.executor().context().describe());
    let mut number = 0;
    for frame in frames.iter().cycle().take(samples) {
        if pipeline.is_full() {
            trace.receive(&mut pipeline, number)?;
            number += 1;
        }
        trace.host("submit", |_| pipeline.submit(frame))?;
    }
    for number in number..samples {
        trace.receive(&mut pipeline, number)?;
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

    fn receive(&mut self, pipeline: &mut Pipeline, number: usize) -> Result<()> {
        let Some(output) = self.host("receive", |_| pipeline.receive())? else { return Ok(()) };
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
