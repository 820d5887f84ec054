//! Ground truth beside the frames of a recording.

use std::path::Path;

use crate::base::{Error, Result};
use crate::sensor::RgbdFrame;
use crate::sim::truth::{TruthFrame, TruthReader};

/// The truth of a recording, asked for frame by frame in its order.
pub struct TruthSource {
    reader: TruthReader,
    next: Option<TruthFrame>,
}

impl TruthSource {
    /// `None` where the recording holds none.
    ///
    /// # Errors
    /// Those of [`TruthReader`].
    pub fn open(path: &Path) -> Result<Option<Self>> {
        let is_mcap = path.extension().is_some_and(|extension| extension == "mcap");
        if !is_mcap && !path.join("truth.txt").is_file() {
            return Ok(None);
        }
        let mut reader = TruthReader::open(path)?;
        let next = reader.next_frame()?;
        Ok(next.map(|next| Self { reader, next: Some(next) }))
    }

    /// The truth of a frame.
    ///
    /// # Errors
    /// [`Error::Input`] with the frame's number where there is none of its stamp, or of another size.
    pub fn of(&mut self, frame: &RgbdFrame) -> Result<TruthFrame> {
        while let Some(truth) = self.next.take_if(|truth| truth.stamp_ns <= frame.depth.stamp_ns) {
            self.next = self.reader.next_frame()?;
            if truth.stamp_ns < frame.depth.stamp_ns {
                continue;
            }
            let camera = &frame.depth.camera;
            if (truth.width, truth.height) == (camera.width, camera.height) {
                return Ok(truth);
            }
            let reason = format!("has {}x{} pixels, its depth another size", truth.width, truth.height);
            return Err(Error::Input { what: format!("truth of frame {}", frame.index), reason });
        }
        let reason = format!("there is none of stamp {}", frame.depth.stamp_ns);
        Err(Error::Input { what: format!("truth of frame {}", frame.index), reason })
    }
}
