//! Whether a frame's colour is what the passes were built for.

use crate::sensor::{CameraModel, ColorImage, RgbdFrame};
use crate::stage::CameraJob;

/// The frame's colour, where its place relative to depth is known and it fits what the passes were built for.
///
/// # Errors
/// Why it cannot be used, in words.
pub(crate) fn usable_color<'a>(job: &CameraJob, frame: &'a RgbdFrame) -> Result<&'a ColorImage, String> {
    let missing = |what: &str| frame.color_missing.clone().unwrap_or_else(|| what.into());
    let color = frame.color.as_ref().ok_or_else(|| missing("the frame has none"))?;
    if frame.color_from_depth.is_none() {
        return Err(missing("its place relative to depth is unknown"));
    }
    let first = job.color.ok_or("the first frames had none")?;
    let (now, size) = (color.camera, |camera: &CameraModel| format!("{}x{}", camera.width, camera.height));
    if (now.width, now.height) != (first.width, first.height) {
        return Err(format!("it is {} where the recording began with {}", size(&now), size(&first)));
    }
    if now.distortion.is_fisheye() != first.distortion.is_fisheye() {
        return Err("its lens model changes between fisheye and others".into());
    }
    if job.color_aligned && !frame.color_is_aligned() {
        return Err("it leaves the depth grid on which it was when the recording began".into());
    }
    Ok(color)
}
