//! `limpid points`.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use limpid::input::points;
use limpid::input::points::{Options, ScanReport};
use limpid::output::save_scan;
use limpid::sensor::ReturnCodes;
use limpid::sensor::VelodyneModel as Model;
use limpid::{Error, Result};

use super::paths::{Paths, ends_in};

#[derive(Debug, Args)]
pub(crate) struct PointsArguments {
    /// MCAP file, rosbag2 folder or .db3, ROS 1 bag, Velodyne pcap or pcapng, PLY or PCD file, or a folder of PLY and PCD files
    input: PathBuf,
    /// Folder for the scans, NNNNNN.ply each; left out, scans are only decoded and counted
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Topic with the scans, in place of the one found by message type
    #[arg(long)]
    topic: Option<String>,
    /// Velodyne model, in place of what the packets say
    #[arg(long, value_enum)]
    model: Option<Model>,
    /// UDP port of a pcap's Velodyne packets (2368 where not stated)
    #[arg(long)]
    port: Option<u16>,
    /// Field of clouds that holds the intensity, in place of the one found by name
    #[arg(long, value_name = "FIELD")]
    intensity: Option<String>,
    /// What the numbers of a cloud's return_type field mean
    #[arg(long, value_enum, default_value = "first-last")]
    returns: ReturnCodes,
    /// Stop after this many scans
    #[arg(long, value_name = "N")]
    limit: Option<u64>,
}

pub(crate) fn execute(arguments: &PointsArguments) -> Result<()> {
    let writes = |path: &Path| ends_in(path, &["ply"]);
    let paths = Paths::default().reads("the recording", &arguments.input);
    paths.may_fill("-o", arguments.output.as_deref(), writes).check()?;
    let options = Options {
        topic: arguments.topic.clone(),
        model: arguments.model,
        return_codes: arguments.returns,
        port: arguments.port,
        intensity_field: arguments.intensity.clone(),
    };
    let mut scans = points::open(&arguments.input, &options)?;
    if let Some(dir) = &arguments.output {
        std::fs::create_dir_all(dir).map_err(Error::file(dir))?;
    }
    let mut times = Vec::new();
    while arguments.limit.is_none_or(|limit| scans.report().scans < limit) {
        let start = Instant::now();
        let Some(scan) = scans.next_scan()? else { break };
        times.push(start.elapsed());
        if let Some(dir) = &arguments.output {
            save_scan(&dir.join(format!("{:06}.ply", scan.index)), &scan)?;
        }
    }
    print_report(scans.report(), times);
    if scans.report().scans == 0 && arguments.limit != Some(0) {
        let reason = "no scan with points could be decoded; what was passed over is listed above".into();
        return Err(Error::Empty { reason });
    }
    Ok(())
}

fn print_report(report: &ScanReport, mut times: Vec<Duration>) {
    println!("{} scans, {} points", report.scans, report.points);
    for (reason, count) in report.dropped.reasons() {
        println!("dropped: {count} points: {}", reason.text());
    }
    for skip in &report.read.skipped {
        println!("skipped: {} x {}: {}", skip.count, skip.source, skip.reason);
    }
    for note in &report.read.notes {
        println!("note: {note}");
    }
    times.sort();
    if let (Some(median), Some(slowest)) = (times.get(times.len() / 2), times.last()) {
        let ms = |time: &Duration| time.as_secs_f64() * 1e3;
        println!(
            "read and decoded in {:.2} ms a scan (median), {:.2} ms the slowest",
            ms(median),
            ms(slowest)
        );
    }
}
