//! How long does a lidar scan take, beside NumPy doing the same sums? `cargo bench --bench scan -- RECORDING... [CONFIG.yaml] [--peer PYTHON]`
//!
//! Per recording: submit to plan map, upload and readback included, one scan at a time and three under way, then every pass by
//! timestamps in a pipeline of its own. With `--peer` the same first scan goes through bench/peers/lidar.py in the same run.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use cpu_time::ProcessTime;
use limpid::input::PosedScans;
use limpid::lidar::{ScanFrame, ScanOptions, ScanPipeline};
use limpid::offline::bench::Stats;
use limpid::output::save_scan;
use limpid::{Config, Error, Result};

const SAMPLES: usize = 100;
const WARM_UP: usize = 10;
const SCANS: usize = 8;

fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split(' ').next().unwrap_or("?").into()
}

/// The first whole scans: those with at least 0.9 times the points of the largest.
fn scans(path: &Path, config: &Config) -> Result<Vec<ScanFrame>> {
    let mut reader = PosedScans::open(path, config)?;
    let mut scans = Vec::new();
    while let Some(frame) = reader.next_frame()?.filter(|_| scans.len() < SCANS) {
        scans.push(frame);
    }
    let most = scans.iter().map(|frame| frame.scan.points.len()).max().unwrap_or(0);
    scans.retain(|frame| 10 * frame.scan.points.len() >= 9 * most);
    Ok(scans)
}

fn row(name: &str, samples: &[f64]) {
    if let Some(stats) = Stats::of(samples) {
        println!("| {name} | {:.3} | {:.3} | {:.3} |", stats.median_ms, stats.p95_ms, stats.min_ms);
    }
}

fn measure(scans: &[ScanFrame], config: &Config) -> Result<()> {
    let mut pipeline = ScanPipeline::open(config, &scans[0], &ScanOptions::default())?;
    let (mut wall, mut cpu) = (Vec::new(), Vec::new());
    for (number, frame) in scans.iter().cycle().take(WARM_UP + SAMPLES).enumerate() {
        let (start, busy) = (Instant::now(), ProcessTime::now());
        pipeline.submit(frame)?;
        pipeline.receive()?;
        if number >= WARM_UP {
            wall.push(start.elapsed().as_secs_f64() * 1e3);
            cpu.push(busy.elapsed().as_secs_f64() * 1e3);
        }
    }
    let start = Instant::now();
    for frame in scans.iter().cycle().take(SAMPLES) {
        if pipeline.is_full() {
            pipeline.receive()?;
        }
        pipeline.submit(frame)?;
    }
    while pipeline.receive()?.is_some() {}
    let pipelined_ms = start.elapsed().as_secs_f64() * 1e3 / SAMPLES as f64;
    row("**scan, wall**", &wall);
    row("**scan, CPU time**", &cpu);
    println!("| **scan, three under way** | {pipelined_ms:.3} | | |");
    passes(scans, config)
}

fn passes(scans: &[ScanFrame], config: &Config) -> Result<()> {
    let options = ScanOptions { profiling: true, ..ScanOptions::default() };
    let mut pipeline = ScanPipeline::open(config, &scans[0], &options)?;
    let mut times: Vec<(String, Vec<f64>)> = Vec::new();
    for (number, frame) in scans.iter().cycle().take(WARM_UP + SAMPLES).enumerate() {
        pipeline.submit(frame)?;
        let Some(output) = pipeline.receive()? else { continue };
        for (pass, ms) in output.pass_ms.into_iter().filter(|_| number >= WARM_UP) {
            match times.iter_mut().find(|(name, _)| *name == pass) {
                Some((_, samples)) => samples.push(ms),
                None => times.push((pass, vec![ms])),
            }
        }
    }
    times.iter().for_each(|(pass, samples)| row(pass, samples));
    Ok(())
}

/// The rows of the Python peer.
fn peer(python: &str, frame: &ScanFrame) -> Result<()> {
    let path = std::env::temp_dir().join(format!("limpid-scan-{}.ply", std::process::id()));
    save_scan(&path, &frame.scan)?;
    let ran = Command::new(python).arg("bench/peers/lidar.py").arg(&path).status();
    std::fs::remove_file(&path).map_err(Error::file(&path))?;
    ran.map_err(Error::file(python)).map(|_| ())
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let (mut recordings, mut config, mut python) = (Vec::new(), Config::default(), None);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--peer" => python = arguments.next(),
            other if other.starts_with("--") => {}
            yaml if yaml.ends_with(".yaml") => config = Config::read(Path::new(yaml))?,
            recording => recordings.push(PathBuf::from(recording)),
        }
    }
    for path in &recordings {
        let scans = scans(path, &config)?;
        let Some(first) = scans.first() else { continue };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let (points, side) = (first.scan.points.len(), config.scan_cells_per_side()?);
        println!("\n{name}: {points} points, {side}x{side} cells, load {}\n", load());
        println!("| | median ms | p95 ms | min ms |\n|---|---|---|---|");
        measure(&scans, &config)?;
        if let Some(python) = &python {
            peer(python, first)?;
        }
    }
    Ok(())
}
