//! Readers against other programs' figures, hand-computed values and hostile input.
#![expect(clippy::unwrap_used, reason = "tests end on what they did not expect")]

mod bag;
mod calibration;
mod containers;
mod damaged;
mod exr;
mod hostile;
mod lidar_topics;
mod memory;
mod messages;
mod pairing;
mod points;
mod poses;
mod real;
mod ros1;
mod several;
mod source;
pub(crate) mod synthetic;
mod trio;
mod tum;

use limpid::Config;
use limpid::input::{LogReader, ReadReport, Recording};
use limpid::sensor::RgbdFrame;

/// All frames of a recording and what its reader reported.
fn read_all(mut recording: impl Recording) -> limpid::Result<(Vec<RgbdFrame>, ReadReport)> {
    let mut frames = Vec::new();
    while let Some(frame) = recording.next_frame()? {
        frames.push(frame);
    }
    Ok((frames, recording.report().clone()))
}

/// As [`read_all`], of an MCAP file.
fn read_mcap(saved: &synthetic::Saved, config: &Config) -> limpid::Result<(Vec<RgbdFrame>, ReadReport)> {
    read_all(LogReader::mcap(&saved.path, config)?)
}

/// How many were skipped for a reason that contains `part`.
fn skipped(report: &ReadReport, part: &str) -> u64 {
    report.skipped.iter().filter(|skip| skip.reason.contains(part)).map(|skip| skip.count).sum()
}

/// Whether a note contains `part`.
fn noted(report: &ReadReport, part: &str) -> bool {
    report.notes.iter().any(|note| note.contains(part))
}
