//! The calibrations that a recording has given so far, by topic, and those that were refused.

use std::collections::BTreeMap;

use crate::input::ReadReport;
use crate::input::calibration::{Calibration, Fitted, says_rectified};
use crate::sensor::CameraModel;

/// See the module.
#[derive(Default)]
pub(crate) struct Calibrations {
    by_topic: BTreeMap<String, CalibrationsOfTopic>,
    refused: BTreeMap<String, RefusedCalibration>,
}

/// The calibrations of a topic.
pub(crate) struct CalibrationsOfTopic {
    frame_id: String,
    newest: Calibration,
    /// The one before that, where it was another: images that wait may still be of it.
    before: Option<Calibration>,
}

impl CalibrationsOfTopic {
    /// The camera of images of a size on `topic`, by the calibration that fits best, the newest where they fit alike.
    pub(crate) fn camera(&self, size: [u32; 2], topic: &str) -> Result<Fitted, String> {
        let rectified = says_rectified(topic);
        let newest = self.newest.camera(size, rectified);
        let before = self.before.as_ref().and_then(|before| before.camera(size, rectified).ok());
        match (newest, before) {
            (Ok(newest), Some(before)) if before.fit < newest.fit => Ok(before),
            (Err(_), Some(before)) => Ok(before),
            (newest, _) => newest,
        }
    }
}

/// A calibration that was refused.
struct RefusedCalibration {
    frame_id: String,
    reason: String,
}

impl Calibrations {
    /// Takes in one that came, or why it was refused.
    pub(crate) fn take(&mut self, topic: String, frame_id: String, calibration: Result<Calibration, String>) {
        match calibration {
            Ok(newest) => {
                let old = self.by_topic.remove(&topic);
                let before = old.and_then(|old| Some(old.newest).filter(|was| *was != newest).or(old.before));
                self.by_topic.insert(topic, CalibrationsOfTopic { frame_id, newest, before });
            }
            Err(reason) => {
                self.refused.insert(topic, RefusedCalibration { frame_id, reason });
            }
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.by_topic.is_empty()
    }

    /// Those on `topic`, or without one those of the frame.
    pub(crate) fn of(&self, topic: Option<&str>, frame_id: &str) -> Option<&CalibrationsOfTopic> {
        match topic {
            Some(topic) => self.by_topic.get(topic),
            None => self.by_topic.values().find(|calibrations| calibrations.frame_id == frame_id),
        }
    }

    /// As [`Self::of`]; without a topic, the only ones there are serve too.
    pub(crate) fn of_or_only(&self, topic: Option<&str>, frame_id: &str) -> Option<&CalibrationsOfTopic> {
        let only = || match self.by_topic.values().collect::<Vec<_>>()[..] {
            [only] if topic.is_none() => Some(only),
            _ => None,
        };
        self.of(topic, frame_id).or_else(only)
    }

    /// Why the calibrations on a topic, or without one those of a frame, were refused, after a colon; empty where none were.
    pub(crate) fn why_refused(&self, topic: Option<&str>, frame_id: Option<&str>) -> String {
        let concerns = |at: &str, refused: &RefusedCalibration| match topic {
            Some(topic) => at == topic,
            None => frame_id.is_none_or(|frame_id| refused.frame_id == frame_id),
        };
        let refused = self.refused.iter().filter(|(at, refused)| concerns(at, refused));
        let reasons: Vec<_> =
            refused.map(|(at, refused)| format!("that on `{at}`: {}", refused.reason)).collect();
        if reasons.is_empty() { String::new() } else { format!(": {}", reasons.join("; ")) }
    }
}

/// A camera that a calibration gave, with its notes told once.
pub(crate) fn fitted(fitted: Fitted, info: &str, topic: &str, report: &mut ReadReport) -> CameraModel {
    for note in fitted.notes {
        report.note(format!("calibration {info} of `{topic}`: {note}"));
    }
    fitted.camera
}
