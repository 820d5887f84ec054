//! Recordings without ground truth: nothing can be scored, but it can be seen what methods make of them.

use crate::base::{Error, Result};
use crate::config::{Config, Method};
use crate::input::Recording;
use crate::offline::eval::contest::{Contest, Entry, contestants};
use crate::sensor::RgbdFrame;

/// The methods that a picture shows.
pub(crate) const DRAWN: [&str; 3] = ["naive", "range", "drm"];

/// The last frame of a recording that has a pose, and what methods made of the recording up to there.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// What the sensor gave.
    pub frame: RgbdFrame,
    /// Results by method.
    pub entries: Vec<Entry>,
    /// Frames that went through, those without a pose left out.
    pub frames: u64,
}

/// Puts all frames of a recording that have a pose through the methods of pictures; drm is none of them where the first has
/// no colour.
///
/// # Errors
/// Those of the reader and of the pipelines; [`Error::Empty`] where no frame has a pose.
pub fn show(recording: &mut dyn Recording, config: &Config, adapter: Option<&str>) -> Result<Shown> {
    let mut drawn = contestants(config);
    drawn.retain(|contestant| DRAWN.contains(&contestant.key));
    let mut contest = None;
    let mut last = None;
    let mut frames = 0;
    while let Some(frame) = recording.next_frame()? {
        if frame.pose.is_none() {
            continue;
        }
        let contest = match &mut contest {
            Some(contest) => contest,
            None => {
                drawn.retain(|contestant| contestant.config.method != Method::Drm || frame.color.is_some());
                contest.insert(Contest::open(&drawn, &frame, adapter)?)
            }
        };
        let entries = contest.step(&frame)?;
        frames += 1;
        last = Some((frame, entries));
    }
    let reason = || {
        let causes: Vec<_> = recording.report().causes().collect();
        Error::Empty { reason: format!("no frame with a pose to show; {}", causes.join("; ")) }
    };
    let (frame, entries) = last.ok_or_else(reason)?;
    Ok(Shown { frame, entries, frames })
}
