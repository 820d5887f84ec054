//! Readers against other programs' figures, hand-computed values and hostile input.

#![expect(clippy::unwrap_used, reason = "tests end on what they did not expect")]

mod real;

use limpid::recording::{ReadReport, Recording, RgbdFrame};

/// All frames of a recording and what its reader reported.
fn read_all(mut recording: impl Recording) -> limpid::Result<(Vec<RgbdFrame>, ReadReport)> {
    let mut frames = Vec::new();
    while let Some(frame) = recording.next_frame()? {
        frames.push(frame);
    }
    Ok((frames, recording.report().clone()))
}
