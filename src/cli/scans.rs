//! `limpid run` on lidar scans.

use std::path::{Path, PathBuf};

use limpid::input::PosedScans;
use limpid::lidar::{CellClass, ScanOptions, ScanRunReport, ScanSink, run_scans};
use limpid::map::PaneSet;
use limpid::map::glass::PointClass;
use limpid::map::pane_file::panes_to_yaml;
use limpid::output::{McapSink, ScanDumpSink, ScanMcapSink, ScanPngSink, save_plan};
use limpid::{Config, Result};

use super::run::{RunArguments, progress_bar};
use super::save;

/// What the frames of a camera in the same recording were written to, before its scans.
#[derive(Default)]
pub(super) struct BesideCamera {
    /// The output file, with those frames in it.
    pub(super) shared: Option<McapSink>,
}

/// Runs the scans of the input. Beside a camera, what would take the names of its files gets others: `DIR/lidar` for the
/// dump, `STEM-plan` for the map.
pub(super) fn execute(arguments: &RunArguments, config: &Config, beside: Option<BesideCamera>) -> Result<()> {
    let both = beside.is_some();
    let mut scans = PosedScans::open(&arguments.input, config)?;
    let mut sinks: Vec<Box<ScanSink>> = Vec::new();
    if let Some(shared) = beside.unwrap_or_default().shared {
        sinks.push(Box::new(ScanMcapSink::beside(shared, config)));
    } else if let Some(path) = &arguments.output {
        sinks.push(Box::new(ScanMcapSink::create(path, config)?));
    }
    if let Some(folder) = &arguments.png {
        sinks.push(Box::new(ScanPngSink::create(folder, config)?));
    }
    if let Some(folder) = &arguments.dump {
        let folder = if both { folder.join("lidar") } else { folder.clone() };
        sinks.push(Box::new(ScanDumpSink::create(&folder, config)?));
    }
    let options = ScanOptions {
        adapter: arguments.common.adapter.clone(),
        profiling: arguments.timing,
        layers: arguments.dump.is_some(),
    };
    let range = arguments.frames.clone().unwrap_or(0..u64::MAX);
    let total = scans.scan_count_hint().map(|count| range.end.min(count).saturating_sub(range.start));
    let bar = progress_bar(total);
    let report = run_scans(&mut scans, range, config, &options, &mut sinks, &mut |_| bar.inc(1));
    bar.finish_and_clear();
    let report = report?;
    print_report(&report);
    if let (Some(path), Some(last)) = (&arguments.panes, &report.last) {
        let map_from_lidar = last.map_from_base.then(last.base_from_lidar);
        let panes = last.glass.iter().flat_map(|glass| &glass.panes);
        let panes: Vec<_> = panes.copied().collect();
        save(path, &panes_to_yaml(&PaneSet::of_scan(&panes, map_from_lidar)))?;
        println!("panes: {}", path.display());
    }
    if let (Some(stem), Some(last)) = (&arguments.map, &report.last) {
        let [image, yaml] = save_plan(&if both { beside_stem(stem) } else { stem.clone() }, last)?;
        println!("map: {} and {}", image.display(), yaml.display());
    }
    Ok(())
}

/// Where the plan map goes when `stem` is the costmap's.
fn beside_stem(stem: &Path) -> PathBuf {
    let mut name = if stem.is_dir() { stem.join("map") } else { stem.to_owned() }.into_os_string();
    name.push("-plan");
    name.into()
}

fn print_report(report: &ScanRunReport) {
    println!("adapter: {}", report.adapter);
    for note in report.read.read.notes.iter().chain(&report.chosen) {
        println!("note: {note}");
    }
    for (reason, count) in report.read.dropped.reasons() {
        println!("dropped: {count} points: {}", reason.text());
    }
    for skipped in &report.read.read.skipped {
        println!("skipped {} x {}: {}", skipped.count, skipped.source, skipped.reason);
    }
    if let Some(reason) = &report.first_unfit {
        println!("refused {} scans, the first: {reason}", report.unfit);
    }
    let seconds = report.elapsed.as_secs_f64();
    #[expect(clippy::cast_precision_loss, reason = "scans counted in a run fit in 53 bits")]
    let scans = report.scans as f64;
    println!(
        "{} scans in {seconds:.2} s ({:.1} ms a scan, reading and writing included), pipeline built in {:.0} ms",
        report.scans,
        seconds * 1e3 / scans.max(1.0),
        report.build.as_secs_f64() * 1e3,
    );
    if report.without_pose > 0 {
        println!("{} without a pose", report.without_pose);
    }
    if report.pose_jumps > 0 {
        println!(
            "{} times the pose jumped; cells and panes kept from before stay where they were",
            report.pose_jumps
        );
    }
    if let Some(last) = &report.last {
        let cells = CellClass::ALL.map(|class| format!("{} {}", last.count(class), class.name()));
        println!("last scan: {} points; cells: {}", last.points, cells.join(", "));
        if let Some(glass) = &last.glass {
            let classes = PointClass::ALL.iter().zip(glass.counters.classes);
            let classes: Vec<_> = classes.map(|(class, count)| format!("{count} {}", class.name())).collect();
            println!("glass: {} panes; points: {}", glass.panes.len(), classes.join(", "));
        }
    }
}
