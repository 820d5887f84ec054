//! What the simulated camera gives for one frame.

use crate::sensor::FramePose;

/// Images of one frame, row-major from the top left, all on the left imager's grid.
#[derive(Debug, Clone, PartialEq)]
pub struct SimFrame {
    /// Number of the frame, from 0.
    pub index: u64,
    /// Nanoseconds since the Unix epoch.
    pub stamp_ns: u64,
    /// Where robot and camera were.
    pub pose: FramePose,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Depth by stereo matching, millimetres; 0: none.
    pub depth_mm: Vec<u16>,
    /// `3 * width * height` bytes.
    pub rgb: Vec<u8>,
    /// The left infrared image, 8 bits.
    pub infrared_left: Vec<u8>,
    /// The right infrared image, 8 bits.
    pub infrared_right: Vec<u8>,
    /// Depth of the first surface met (glass counts as one), metres; 0: none.
    pub true_depth_m: Vec<f32>,
    /// Its kind, see [`super::material::Kind::code`]; 0: none.
    pub material: Vec<u8>,
}
