//! Does a revolution of lidar packets decode in 2 ms on one core? `cargo bench --bench points -- RECORDING...`
//!
//! Every recording is read ten times after a warm-up; the time is that from one scan to the next, reading and unpacking
//! included. Only whole revolutions count: those with at least 0.9 times the points of the largest.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use limpid::Result;
use limpid::input::points::{Options, open};

const PASSES: usize = 10;

/// Points and time of each scan.
fn pass(path: &Path) -> Result<Vec<(usize, Duration)>> {
    let mut scans = open(path, &Options::default())?;
    let mut times = Vec::new();
    loop {
        let start = Instant::now();
        let Some(scan) = scans.next_scan()? else { return Ok(times) };
        times.push((scan.points.len(), start.elapsed()));
    }
}

fn main() -> Result<()> {
    println!(
        "| recording | revolutions | points each | median ms | p95 ms | ns a point |\n|---|---|---|---|---|---|"
    );
    for path in std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).map(PathBuf::from) {
        pass(&path)?;
        let mut scans = Vec::new();
        for _ in 0..PASSES {
            scans.extend(pass(&path)?);
        }
        let most = scans.iter().map(|(points, _)| *points).max().unwrap_or(0);
        scans.retain(|(points, _)| 10 * points >= 9 * most);
        scans.sort_by_key(|(_, time)| *time);
        let ms = |at: usize| scans[at].1.as_secs_f64() * 1e3;
        let (median, p95) = (ms(scans.len() / 2), ms(scans.len() * 95 / 100));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let ns = median * 1e6 / most as f64;
        println!("| {name} | {} | {most} | {median:.3} | {p95:.3} | {ns:.0} |", scans.len());
    }
    Ok(())
}
