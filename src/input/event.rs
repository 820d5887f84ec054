//! What a recording says, in a form that no longer depends on its messages.

use crate::base::Rigid;
use crate::input::calibration::Calibration;
use crate::input::image_message::ImageMessage;

/// What a recording says of a camera, one message at a time.
#[derive(Debug)]
pub(crate) enum Event {
    Depth(ImageMessage),
    Color(ImageMessage),
    Confidence(ImageMessage),
    Calibration {
        topic: String,
        frame_id: String,
        /// Or why it cannot be used.
        calibration: Result<Calibration, String>,
    },
}

/// The pose of a child frame in its parent.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TransformEvent {
    pub(crate) parent: String,
    pub(crate) child: String,
    pub(crate) stamp_ns: u64,
    /// For all time (`/tf_static`).
    pub(crate) fixed: bool,
    /// `None` where the message holds numbers that are no transform.
    pub(crate) parent_from_child: Option<Rigid>,
}

/// Topics as far as pairing needs them; empty or `None`: there is no such stream.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Streams {
    pub(crate) depth: String,
    pub(crate) color: Option<String>,
    pub(crate) confidence: Option<String>,
    /// `None`: the calibration with the image's frame, or the only one.
    pub(crate) depth_info: Option<String>,
    pub(crate) color_info: Option<String>,
    pub(crate) has_transforms: bool,
}
