//! Whether an observation fits what the mapper was built for.

use super::Mapper;
use crate::base::Refused;
use crate::sensor::{CameraModel, DepthSamples, Distortion, Observation, RgbdFrame, SensorPose};
use crate::stage::CameraJob;

type Fits = Result<(), Refused>;

impl Mapper {
    /// The pose of an observation that fits.
    pub(super) fn checked(&mut self, observation: &Observation) -> Result<SensorPose, Refused> {
        let sensor = observation.sensor;
        let channel = self.channels.get_mut(sensor).filter(|_| sensor < self.said.len());
        let channel = channel.ok_or_else(|| Refused::Sensor(format!("no sensor {sensor}")))?;
        channel.check(observation)?;
        let pose = pose(observation)?;
        match self.clock.ahead_s(sensor, observation.stamp_ns()) {
            Some(ahead_s) => Err(Refused::Ahead { ahead_s }),
            None => Ok(pose),
        }
    }
}

/// The pose, unless it is missing, or has a NaN or an infinity.
pub(super) fn pose(observation: &Observation) -> Result<SensorPose, Refused> {
    let pose = observation.pose.ok_or(Refused::NoPose)?;
    if pose.is_finite() { Ok(pose) } else { Err(Refused::PoseNotFinite) }
}

/// Size, encoding and numbers of samples of a frame.
pub(crate) fn frame(job: &CameraJob, frame: &RgbdFrame) -> Fits {
    let invalid = |error: crate::Error| Refused::Calibration { what: "depth", reason: error.to_string() };
    let camera = frame.depth.camera.validate().map_err(invalid)?;
    let bad = |what: &'static str, reason: String| Err(Refused::Image { what, reason });
    let size = |c: &CameraModel| format!("{}x{}", c.width, c.height);
    if (camera.width, camera.height) != (job.depth.width, job.depth.height) {
        let reason = format!("{} where the first one had {}", size(&camera), size(&job.depth));
        return bad("depth", reason);
    }
    let pixels = job.pixels() as usize;
    if frame.depth.samples.len() != pixels {
        let reason = format!("{} samples for {} pixels", frame.depth.samples.len(), size(&camera));
        return bad("depth", reason);
    }
    if matches!(frame.depth.samples, DepthSamples::Metres(_)) != job.float_depth {
        return bad("depth", "changes between integer and float samples".into());
    }
    if let DepthSamples::Integer { unit_m, .. } = &frame.depth.samples
        && !(unit_m.is_finite() && *unit_m > 0.0)
    {
        return bad("depth", format!("a unit of {unit_m} m a count is not a positive number"));
    }
    if let Some(confidence) = frame.confidence.as_ref().filter(|c| c.len() != pixels) {
        return bad("confidence", format!("{} values for {} pixels", confidence.len(), size(&camera)));
    }
    if let Some(color) = &frame.color {
        let bytes = color.camera.width as usize * color.camera.height as usize * 3;
        if color.rgb.len() != bytes {
            return bad("colour", format!("{} bytes for {}", color.rgb.len(), size(&color.camera)));
        }
    }
    same_lens(job, frame)
}

/// Passes are compiled for a lens without distortion, with a polynomial, or for a fisheye, so a new calibration may not change that.
fn same_lens(job: &CameraJob, frame: &RgbdFrame) -> Fits {
    let kind = |camera: &CameraModel| (camera.distortion != Distortion::None, camera.distortion.is_fisheye());
    if kind(&job.depth) == kind(&frame.depth.camera) {
        return Ok(());
    }
    let reason = "lens distortion appears, vanishes or changes its model within the recording".into();
    Err(Refused::Calibration { what: "depth", reason })
}
