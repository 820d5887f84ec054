//! Counting what a reader passes over.

use crate::input::log::Told;
use crate::input::{ReadReport, Skipped};

/// Most different reasons and notes kept apart; hostile files could make up any number.
const MAX_ENTRIES: usize = 256;

impl ReadReport {
    /// Counts something passed over, together with others of the same source and reason.
    pub(crate) fn skip(&mut self, source: &str, reason: impl Into<String>, stamp_ns: u64) {
        let mut reason = reason.into();
        if self.skipped.len() >= MAX_ENTRIES {
            let known = |entry: &Skipped| entry.source == source && entry.reason == reason;
            if !self.skipped.iter().any(known) {
                reason = "further reasons".into();
            }
        }
        let known = self.skipped.iter_mut().find(|known| known.source == source && known.reason == reason);
        if let Some(known) = known {
            known.count += 1;
        } else if self.skipped.len() <= MAX_ENTRIES {
            self.skipped.push(Skipped { source: source.into(), reason, first_stamp_ns: stamp_ns, count: 1 });
        }
    }

    /// Adds a note unless there is one that begins with the same `what`.
    pub(crate) fn note_once(&mut self, what: &str, rest: &str) {
        if !self.notes.iter().any(|note| note.starts_with(what)) {
            self.note(format!("{what}{rest}"));
        }
    }

    /// Adds why a sensor has no poses unless that is there.
    pub(crate) fn tell_frames(&mut self, told: String) {
        if self.frames.len() < MAX_ENTRIES && !self.frames.contains(&told) {
            self.frames.push(told);
        }
    }

    /// Adds damage of the recording's files, which is a note too.
    pub(crate) fn tell_damage(&mut self, told: String) {
        if self.damage.len() < MAX_ENTRIES && !self.damage.contains(&told) {
            self.damage.push(told.clone());
        }
        self.note(told);
    }

    /// Adds what is to be told of a recording's files.
    pub(in crate::input) fn tell_files(&mut self, told: &Told) {
        told.notes.iter().for_each(|note| self.note(note));
        told.lost.iter().for_each(|lost| self.tell_damage(lost.clone()));
    }

    /// Adds a note unless it is there.
    pub(crate) fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if self.notes.len() < MAX_ENTRIES && !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }
}

/// Adds what another report of the same recording counted.
pub(crate) fn merge(report: &mut ReadReport, other: &ReadReport) {
    report.skipped.extend(other.skipped.iter().cloned());
    other.damage.iter().for_each(|told| report.tell_damage(told.clone()));
    other.notes.iter().for_each(|note| report.note(note));
    for told in &other.frames {
        report.tell_frames(told.clone());
    }
}
