//! A recording through the pipeline into writers, with up to three frames under way.

use std::collections::VecDeque;
use std::ops::Range;
use std::time::{Duration, Instant};

use crate::base::{Error, Result};
use crate::config::{Config, Method};
use crate::frame::{FrameOutput, Options};
use crate::input::{ReadReport, Recording};
use crate::output::Sink;
use crate::pipeline::Pipeline;
use crate::sensor::RgbdFrame;

/// Frames read ahead to find the first with colour, whose calibration the pipeline is built for.
const LOOKAHEAD: usize = 8;

/// What a run did.
#[derive(Debug, Default)]
pub struct RunReport {
    /// Frames that went into the map.
    pub frames: u64,
    /// Frames without a pose, counted and passed over.
    pub without_pose: u64,
    /// Frames that did not fit the pipeline, with the first reason.
    pub unfit: u64,
    /// The first such reason.
    pub first_unfit: Option<String>,
    /// Frames that were DEGRADED.
    pub degraded: u64,
    /// Adapter and why it was chosen.
    pub adapter: String,
    /// Building the pipeline, compilation included.
    pub build: Duration,
    /// From the first frame in to the last result written.
    pub elapsed: Duration,
    /// Which method `auto` came to, and why.
    pub method_note: Option<String>,
    /// The last result.
    pub last: Option<FrameOutput>,
    /// What the reader met.
    pub read: ReadReport,
}

/// Runs the frames numbered in `range` of `recording` through a pipeline and gives every result to all
/// `sinks`, in order; `progress` is called after each.
///
/// Whatever ends the run, results that were under way are written and the sinks are finished first.
///
/// # Errors
/// [`Error::Empty`] where no frame could be used; errors of the reader, the GPU and the writers.
pub fn run(
    recording: &mut dyn Recording,
    range: Range<u64>,
    config: &Config,
    options: &Options,
    sinks: &mut [Box<dyn Sink>],
    progress: &mut dyn FnMut(&FrameOutput),
) -> Result<RunReport> {
    let mut run = Run {
        source: Source { recording, range, ahead: VecDeque::new(), without_pose: 0 },
        config,
        options,
        sinks,
        progress,
        under_way: VecDeque::new(),
        report: RunReport::default(),
    };
    let outcome = run.frames();
    let mut finished = Ok(());
    for sink in run.sinks.iter_mut() {
        finished = finished.and(sink.finish());
    }
    run.report.without_pose = run.source.without_pose;
    run.report.read = run.source.recording.report().clone();
    outcome.and(finished)?;
    if run.report.frames == 0 {
        return Err(Error::Empty { reason: nothing_used(&run.report) });
    }
    Ok(run.report)
}

/// Posed frames of the wanted range.
struct Source<'a> {
    recording: &'a mut dyn Recording,
    range: Range<u64>,
    ahead: VecDeque<RgbdFrame>,
    without_pose: u64,
}

impl Source<'_> {
    fn read(&mut self) -> Result<Option<RgbdFrame>> {
        while let Some(frame) = self.recording.next_frame()? {
            if frame.index >= self.range.end {
                return Ok(None);
            }
            if frame.index < self.range.start {
                continue;
            }
            if frame.pose.is_some() {
                return Ok(Some(frame));
            }
            self.without_pose += 1;
        }
        Ok(None)
    }

    fn next(&mut self) -> Result<Option<RgbdFrame>> {
        match self.ahead.pop_front() {
            Some(frame) => Ok(Some(frame)),
            None => self.read(),
        }
    }

    /// Fills the lookahead until a frame has colour, so that the pipeline can be built for it.
    fn look_ahead(&mut self) -> Result<()> {
        while self.ahead.len() < LOOKAHEAD && !self.ahead.iter().any(|frame| frame.color.is_some()) {
            let Some(frame) = self.read()? else { break };
            self.ahead.push_back(frame);
        }
        Ok(())
    }
}

struct Run<'a> {
    source: Source<'a>,
    config: &'a Config,
    options: &'a Options,
    sinks: &'a mut [Box<dyn Sink>],
    progress: &'a mut dyn FnMut(&FrameOutput),
    under_way: VecDeque<RgbdFrame>,
    report: RunReport,
}

impl Run<'_> {
    fn frames(&mut self) -> Result<()> {
        self.source.look_ahead()?;
        let Some(first) = self.source.ahead.front() else { return Ok(()) };
        let start = Instant::now();
        let options = self.options.clone().with_color_of(self.source.ahead.iter());
        if self.config.method == Method::Auto {
            self.report.method_note = Some(chosen(options.color.is_some()).into());
        }
        let mut pipeline = Pipeline::open(self.config, first, &options)?;
        self.report.build = start.elapsed();
        self.report.adapter = pipeline.executor().context().describe();
        let start = Instant::now();
        let outcome = self.feed(&mut pipeline);
        let drained = self.drain(&mut pipeline);
        self.report.elapsed = start.elapsed();
        outcome.and(drained)
    }

    fn feed(&mut self, pipeline: &mut Pipeline) -> Result<()> {
        while let Some(frame) = self.source.next()? {
            if pipeline.is_full() {
                self.take(pipeline)?;
            }
            match pipeline.submit(&frame) {
                Ok(()) => self.under_way.push_back(frame),
                Err(error @ (Error::Input { .. } | Error::Decode { .. })) => {
                    self.report.unfit += 1;
                    self.report.first_unfit.get_or_insert(format!("frame {}: {error}", frame.index));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn drain(&mut self, pipeline: &mut Pipeline) -> Result<()> {
        while !self.under_way.is_empty() {
            self.take(pipeline)?;
        }
        Ok(())
    }

    fn take(&mut self, pipeline: &mut Pipeline) -> Result<()> {
        let (Some(frame), Some(output)) = (self.under_way.pop_front(), pipeline.receive()?) else {
            return Ok(());
        };
        for sink in self.sinks.iter_mut() {
            sink.write(&frame, &output)?;
        }
        (self.progress)(&output);
        self.report.frames += 1;
        self.report.degraded += u64::from(output.degraded);
        self.report.last = Some(output);
        Ok(())
    }
}

/// What method `auto` comes to.
fn chosen(has_color: bool) -> &'static str {
    if has_color {
        "method drm: depth is weighed by DRM-Net, which needs colour in every frame (--method range does not)"
    } else {
        "method range: there is no colour with a calibration among the first frames, which method drm needs"
    }
}

/// Why no frame was used, from what was counted.
fn nothing_used(report: &RunReport) -> String {
    if let Some(reason) = &report.first_unfit {
        return reason.clone();
    }
    let skipped =
        report.read.skipped.iter().map(|s| format!("{}: {} ({} times)", s.source, s.reason, s.count));
    let reasons: Vec<_> = skipped.take(3).collect();
    match (report.read.depth_images, reasons.is_empty()) {
        (0, true) => "it holds no depth image".into(),
        (seen, true) => format!("none of its {seen} depth images lies in the wanted range"),
        (seen, false) => format!("{seen} depth images seen; {}", reasons.join("; ")),
    }
}
