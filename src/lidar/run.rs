//! The scans of a recording through the pipeline into writers, with up to three scans under way.

use std::collections::VecDeque;
use std::ops::Range;
use std::time::{Duration, Instant};

use super::{ScanFrame, ScanOptions, ScanOutput, ScanPipeline};
use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::PosedScans;
use crate::input::points::ScanReport;
use crate::output::Sink;

/// A writer of scans' results.
pub type ScanSink = dyn Sink<ScanFrame, ScanOutput>;

/// What a run over scans did.
#[derive(Debug, Default)]
pub struct ScanRunReport {
    /// Scans that went through.
    pub scans: u64,
    /// Scans without a pose, counted and passed over.
    pub without_pose: u64,
    /// Scans to whose pose the lidar jumped from the scan before.
    pub pose_jumps: u64,
    /// Scans that did not fit the pipeline, with the first reason.
    pub unfit: u64,
    /// The first such reason.
    pub first_unfit: Option<String>,
    /// Adapter and why it was chosen.
    pub adapter: String,
    /// What was chosen by the first scan: full scale and planes.
    pub chosen: Vec<String>,
    /// Building the pipeline, compilation included.
    pub build: Duration,
    /// From the first scan in to the last result written.
    pub elapsed: Duration,
    /// The last result.
    pub last: Option<ScanOutput>,
    /// What the reader met.
    pub read: ScanReport,
}

/// Runs the scans numbered in `range` through a pipeline and gives every result to all `sinks`, in order; `progress` is
/// called after each.
///
/// Whatever ends the run, results that were under way are written and the sinks are finished first.
///
/// # Errors
/// [`Error::Empty`] where no scan could be used; errors of the reader, the GPU and the writers.
pub fn run_scans(
    scans: &mut PosedScans,
    range: Range<u64>,
    config: &Config,
    options: &ScanOptions,
    sinks: &mut [Box<ScanSink>],
    progress: &mut dyn FnMut(&ScanOutput),
) -> Result<ScanRunReport> {
    let report = ScanRunReport::default();
    let mut run = ScanRun { scans, range, sinks, progress, under_way: VecDeque::new(), report };
    let outcome = run.all(config, options);
    let mut finished = Ok(());
    for sink in run.sinks.iter_mut() {
        finished = finished.and(sink.finish());
    }
    run.report.read = run.scans.report();
    outcome.and(finished)?;
    if run.report.scans == 0 {
        return Err(Error::Empty { reason: nothing_used(&run.report) });
    }
    Ok(run.report)
}

struct ScanRun<'a> {
    scans: &'a mut PosedScans,
    range: Range<u64>,
    sinks: &'a mut [Box<ScanSink>],
    progress: &'a mut dyn FnMut(&ScanOutput),
    under_way: VecDeque<ScanFrame>,
    report: ScanRunReport,
}

impl ScanRun<'_> {
    /// The next scan of the range that has a pose.
    fn next(&mut self) -> Result<Option<ScanFrame>> {
        while let Some(frame) = self.scans.next_frame()? {
            if frame.scan.index >= self.range.end {
                return Ok(None);
            }
            if frame.scan.index < self.range.start {
                continue;
            }
            if frame.pose.is_some() {
                return Ok(Some(frame));
            }
            self.report.without_pose += 1;
        }
        Ok(None)
    }

    fn all(&mut self, config: &Config, options: &ScanOptions) -> Result<()> {
        let Some(first) = self.next()? else { return Ok(()) };
        let start = Instant::now();
        let mut pipeline = ScanPipeline::open(config, &first, options)?;
        self.report.build = start.elapsed();
        self.report.adapter = pipeline.executor().context().describe();
        self.report.chosen = chosen(&pipeline);
        let start = Instant::now();
        let outcome = self.feed(&mut pipeline, first);
        let mut drained = Ok(());
        while drained.is_ok() && !self.under_way.is_empty() {
            drained = self.take(&mut pipeline);
        }
        self.report.elapsed = start.elapsed();
        outcome.and(drained)
    }

    fn feed(&mut self, pipeline: &mut ScanPipeline, first: ScanFrame) -> Result<()> {
        let mut next = Some(first);
        while let Some(frame) = next {
            if pipeline.is_full() {
                self.take(pipeline)?;
            }
            match pipeline.submit(&frame) {
                Ok(()) => self.under_way.push_back(frame),
                Err(error @ Error::Input { .. }) => {
                    self.report.unfit += 1;
                    self.report.first_unfit.get_or_insert(format!("scan {}: {error}", frame.scan.index));
                }
                Err(error) => return Err(error),
            }
            next = self.next()?;
        }
        Ok(())
    }

    fn take(&mut self, pipeline: &mut ScanPipeline) -> Result<()> {
        let (Some(frame), Some(output)) = (self.under_way.pop_front(), pipeline.receive()?) else {
            return Ok(());
        };
        for sink in self.sinks.iter_mut() {
            sink.write(&frame, &output)?;
        }
        (self.progress)(&output);
        self.report.scans += 1;
        self.report.pose_jumps += u64::from(output.pose_jumped);
        self.report.last = Some(output);
        Ok(())
    }
}

/// What the first scan decided, in words.
fn chosen(pipeline: &ScanPipeline) -> Vec<String> {
    let job = pipeline.job();
    let scale = if job.config.intensity_full_scale > 0.0 {
        format!("full scale of intensities: {} as configured", job.full_scale)
    } else {
        format!(
            "full scale of intensities: {} (percentile {} of the first scan)",
            job.full_scale, job.config.intensity_percentile
        )
    };
    let planes = match job.plane_rings {
        Some([plane, below]) => format!("planes z = 0 and below it: rings {plane} and {below}"),
        None => "planes z = 0 and below it: slabs".into(),
    };
    let deskew = if job.deskew {
        "points are placed by the poses at their own times, where there are poses"
    } else {
        "points are not deskewed"
    };
    vec![scale, planes, deskew.into()]
}

/// Why no scan was used, from what was counted.
fn nothing_used(report: &ScanRunReport) -> String {
    if let Some(reason) = &report.first_unfit {
        return reason.clone();
    }
    let skipped = report.read.read.skipped.iter();
    let reasons: Vec<_> =
        skipped.map(|s| format!("{}: {} ({} times)", s.source, s.reason, s.count)).take(3).collect();
    match (report.read.scans, reasons.is_empty()) {
        (0, true) => "it holds no scan with points".into(),
        (seen, true) => format!("none of its {seen} scans lies in the wanted range"),
        (seen, false) => format!("{seen} scans seen; {}", reasons.join("; ")),
    }
}
