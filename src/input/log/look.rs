//! What the first messages of a log's images and calibrations show, read before its sensors are chosen: encodings and frames,
//! which the channels do not tell.

use crate::input::image_message::Shows;
use crate::input::log::decode;
use crate::input::log::topics::Kind;

/// What the first message of a topic shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Look {
    pub(super) frame_id: String,
    /// Of an image; `None` of a calibration.
    pub(super) shows: Option<Shows>,
}

/// What a message of an image or a calibration shows. What is wrong with it is told when it is read; the next may be better.
pub(super) fn look_of(kind: Kind, payload: &[u8]) -> Option<Look> {
    if kind.is_image() {
        let image = decode::image(kind, None, payload).ok()?;
        return Some(Look { shows: Some(image.shows()), frame_id: image.frame_id });
    }
    let message = decode::calibration(kind, payload).ok()?;
    Some(Look { frame_id: message.frame_id, shows: None })
}
