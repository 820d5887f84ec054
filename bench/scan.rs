//! How long does a lidar scan take, beside NumPy doing the same sums? `cargo bench --bench scan -- RECORDING... [CONFIG.yaml] [--peer PYTHON]`
//!
//! Per recording: submit to plan map, upload and readback included, one scan at a time and three under way, then every pass by
//! timestamps in a pipeline of its own. With `--peer` the same first scan goes through bench/peers/lidar.py in the same run.

use std::path::{Path, PathBuf};
use std::process::Command;

use limpid::input::PosedScans;
use limpid::mapper::{Options, SensorInfo};
use limpid::offline::bench::bench;
use limpid::output::save_scan;
use limpid::sensor::{Observation, Scan};
use limpid::{Config, Error, Result};

const SAMPLES: usize = 100;
const SCANS: usize = 8;

/// The first whole scans: those with at least 0.9 times the points of the largest.
fn scans(path: &Path, config: &Config) -> Result<Vec<Observation>> {
    let mut reader = PosedScans::open(path, config)?;
    let mut scans = Vec::new();
    while let Some(frame) = reader.next_observation()?.filter(|_| scans.len() < SCANS) {
        scans.push(frame);
    }
    let points = |scan: &Observation| scan.scan().map_or(0, |scan| scan.points.len());
    let most = scans.iter().map(points).max().unwrap_or(0);
    scans.retain(|scan| 10 * points(scan) >= 9 * most);
    Ok(scans)
}

/// The rows of the Python peer.
fn peer(python: &str, scan: &Scan) -> Result<()> {
    let path = std::env::temp_dir().join(format!("limpid-scan-{}.ply", std::process::id()));
    save_scan(&path, scan)?;
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
        let Some(first) = scans.first().and_then(Observation::scan) else { continue };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let side = config.scan_cells_per_side()?;
        println!("\n{name}: {side}x{side} cells\n");
        let sensors = [SensorInfo::lidar(&config, first.clone())];
        println!("{}", bench(&config, &sensors, &Options::default(), &scans, SAMPLES)?.table());
        if let Some(python) = &python {
            peer(python, first)?;
        }
    }
    Ok(())
}
