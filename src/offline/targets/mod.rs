//! Training samples from recordings (spec 1 §2): the network's input as the GPU makes it, and what it should say.

mod distance;
mod file;
mod maker;
mod sample;
mod truth;

pub use distance::Distance;
pub use file::SampleFile;
pub use maker::{Maker, plan};
pub use sample::{Judged, Sample};
pub use truth::TruthSource;

use std::path::Path;

use crate::base::{Error, Result};
use crate::input::{ReadReport, Recording};
use crate::stage::targets::Rule;

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// When measurements agree.
    pub rule: Rule,
    /// Whether a recording without ground truth is refused.
    pub needs_truth: bool,
    /// Of so many frames one becomes a sample; all of them serve as references.
    pub every: u64,
    /// Part of the adapter's name.
    pub adapter: Option<String>,
}

impl Default for Request {
    fn default() -> Self {
        Self { rule: Rule::default(), needs_truth: false, every: 1, adapter: None }
    }
}

/// What became of a recording.
#[derive(Debug, Default)]
pub struct Report {
    /// Samples given out.
    pub samples: u64,
    /// Frames without a pose, which were passed over.
    pub without_pose: u64,
    /// How far reference depth is from the truth, and how much it covers.
    pub distance: Distance,
    /// Adapter and driver.
    pub adapter: String,
    /// What the reader met.
    pub read: ReadReport,
}

/// Makes the samples of a recording and gives each to `sink`, in order.
///
/// # Errors
/// [`Error::Input`] that names the frame: colour, or other frames that see the same, are missing; its truth is. [`Error::Empty`]
/// without a frame that has a pose; [`Error::Format`] where truth is needed and there is none; those of reader, GPU and sink.
pub fn make(
    path: &Path,
    recording: &mut dyn Recording,
    request: &Request,
    sink: &mut dyn FnMut(&Sample) -> Result<()>,
) -> Result<Report> {
    let mut truth = TruthSource::open(path)?;
    if truth.is_none() && request.needs_truth {
        return Err(Error::Format { path: path.into(), reason: "holds no ground truth".into() });
    }
    let mut maker: Option<Maker> = None;
    let mut report = Report::default();
    let mut take = |sample: &Sample, report: &mut Report| {
        report.samples += 1;
        report.distance.add(sample);
        sink(sample)
    };
    while let Some(frame) = recording.next_frame()? {
        if frame.pose.is_none() {
            report.without_pose += 1;
            continue;
        }
        let maker = match &mut maker {
            Some(maker) => maker,
            none => none.insert(Maker::open(&frame, request, truth.is_some())?),
        };
        let true_frame = truth.as_mut().map(|truth| truth.of(&frame)).transpose()?;
        if let Some(sample) = maker.push(&frame, true_frame)? {
            take(&sample, &mut report)?;
        }
    }
    report.read = recording.report().clone();
    let Some(mut maker) = maker else { return Err(Error::Empty { reason: why_empty(&report) }) };
    while maker.is_pending() {
        if let Some(sample) = maker.flush()? {
            take(&sample, &mut report)?;
        }
    }
    report.adapter = maker.describe();
    Ok(report)
}

fn why_empty(report: &Report) -> String {
    if report.without_pose > 0 {
        return format!(
            "none of its {} frames has a pose, and a reference is drawn from frames seen from known places (tf, odometry, or \
             `static_transforms` for a camera that stands)",
            report.without_pose
        );
    }
    format!("{} depth images seen", report.read.depth_images)
}
