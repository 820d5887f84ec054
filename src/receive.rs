//! Around the pipeline: whether a frame fits it, and a frame's result out of its readback.

use std::sync::Arc;

use bytemuck::pod_read_unaligned;

use crate::base::Rigid;
use crate::base::{Error, Result};
use crate::config::{Config, Method};
use crate::frame::{Counters, FrameImages, FrameLayers, FrameOutput, Options};
use crate::gpu::{Context, Executor, FRAMES_IN_FLIGHT, Readback};
use crate::map::Grid;
use crate::network::Backend;
use crate::network::weights::Network;
use crate::pipeline::Pipeline;
use crate::sensor::{CameraModel, Distortion};
use crate::sensor::{DepthSamples, FramePose, RgbdFrame};
use crate::stage::Job;
use crate::stage::camera::drm::Drm;

/// States of a cell in bits 0-1, as in `shaders/lib/cell.wgsl`.
const FREE: u32 = 1;
const OCCUPIED: u32 = 2;

impl Options {
    /// What to build for frames like `first`.
    pub(crate) fn job(&self, config: &Config, first: &RgbdFrame, drm: Option<Drm>) -> Job {
        Job {
            config: config.clone(),
            depth: first.depth.camera,
            float_depth: matches!(first.depth.samples, DepthSamples::Metres(_)),
            color: self.color.filter(|_| self.images || drm.is_some()),
            color_aligned: self.color_aligned,
            confidence: !config.confidence_topic.is_empty() || first.confidence.is_some(),
            drm,
            images: self.images,
            layers: self.layers,
        }
    }
}

impl Pipeline {
    /// Waits for the oldest frame under way; `None` when there is none.
    ///
    /// # Errors
    /// [`crate::Error::Gpu`], [`crate::Error::DeviceLost`].
    pub fn receive(&mut self) -> Result<Option<FrameOutput>> {
        let Some(readback) = self.executor.receive()? else { return Ok(None) };
        let pending = self.pending.pop_front();
        pending.map(|pending| output(pending, &readback, &self.executor, &self.job)).transpose()
    }

    /// Whether as many frames are under way as may be.
    pub fn is_full(&self) -> bool {
        self.executor.in_flight() >= FRAMES_IN_FLIGHT
    }

    /// The plan as built, and the device it runs on.
    pub fn executor(&self) -> &Executor {
        &self.executor
    }
}

/// The network of method drm; `None` for the others.
///
/// # Errors
/// [`Error::Input`] without colour; those of reading weights.
pub(crate) fn load_drm(config: &Config, options: &Options, context: &Context) -> Result<Option<Drm>> {
    if config.method != Method::Drm {
        return Ok(None);
    }
    if options.color.is_none() {
        let reason =
            "none with a calibration among the first frames; method drm needs colour (method range does not)"
                .into();
        return Err(Error::Input { what: "colour image".into(), reason });
    }
    let network = match config.weights.as_str() {
        "" => Network::shipped()?,
        file => Network::read(std::path::Path::new(file))?,
    };
    Ok(Some(Drm { network: Arc::new(network), backend: Backend::of(context) }))
}

/// Refuses a pose with a NaN or an infinity, and a missing one.
///
/// # Errors
/// [`Error::Input`].
pub(crate) fn check_pose(frame: &RgbdFrame) -> Result<FramePose> {
    let bad = |reason: &str| Error::Input { what: "pose".into(), reason: reason.into() };
    let pose = frame.pose.ok_or_else(|| bad("no transform from map to camera"))?;
    let finite = |rigid: Rigid| rigid.rotation.is_finite() && rigid.translation_m.is_finite();
    if finite(pose.map_from_base) && finite(pose.base_from_camera) {
        Ok(pose)
    } else {
        Err(bad("is not finite"))
    }
}

/// Refuses a frame that does not fit what the pipeline was built for.
///
/// # Errors
/// [`Error::Input`] that names the image, [`Error::Decode`] for impossible intrinsics.
pub(crate) fn check_fit(job: &Job, frame: &RgbdFrame) -> Result<()> {
    let camera = frame.depth.camera.validate()?;
    let bad = |what: &str, reason: String| Err(Error::Input { what: what.into(), reason });
    let size = |c: &CameraModel| format!("{}x{}", c.width, c.height);
    if (camera.width, camera.height) != (job.depth.width, job.depth.height) {
        let reason = format!("{} where the first one had {}", size(&camera), size(&job.depth));
        return bad("depth image", reason);
    }
    let pixels = job.pixels() as usize;
    if frame.depth.samples.len() != pixels {
        let reason = format!("{} samples for {} pixels", frame.depth.samples.len(), size(&camera));
        return bad("depth image", reason);
    }
    if matches!(frame.depth.samples, DepthSamples::Metres(_)) != job.float_depth {
        return bad("depth image", "changes between integer and float samples".into());
    }
    if let DepthSamples::Integer { unit_m, .. } = &frame.depth.samples
        && !(unit_m.is_finite() && *unit_m > 0.0)
    {
        return bad("depth image", format!("a unit of {unit_m} m a count is not a positive number"));
    }
    if let Some(confidence) = frame.confidence.as_ref().filter(|c| c.len() != pixels) {
        return bad("confidence image", format!("{} values for {} pixels", confidence.len(), size(&camera)));
    }
    if let Some(color) = &frame.color {
        let bytes = color.camera.width as usize * color.camera.height as usize * 3;
        if color.rgb.len() != bytes {
            return bad("colour image", format!("{} bytes for {}", color.rgb.len(), size(&color.camera)));
        }
    }
    Ok(())
}

/// Passes are compiled for a lens with distortion or without, so a new calibration may not change that.
///
/// # Errors
/// [`Error::Input`].
pub(crate) fn check_recalibration(job: &Job, frame: &RgbdFrame) -> Result<()> {
    let distorted = |camera: &CameraModel| camera.distortion != Distortion::None;
    if distorted(&job.depth) == distorted(&frame.depth.camera) {
        return Ok(());
    }
    let reason = "lens distortion appears or vanishes within the recording".into();
    Err(Error::Input { what: "depth calibration".into(), reason })
}

/// What is remembered of a frame while it is under way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pending {
    pub(crate) index: u64,
    pub(crate) stamp_ns: u64,
    pub(crate) pose: FramePose,
    pub(crate) grid: Grid,
}

impl Pending {
    /// Its stamp is that of the earliest image that `job` uses.
    pub(crate) fn new(job: &Job, frame: &RgbdFrame, pose: FramePose, grid: Grid) -> Self {
        let color = job.color.and(frame.color.as_ref());
        let color_ns = color.map_or(u64::MAX, |c| c.stamp_ns);
        Self { index: frame.index, stamp_ns: frame.depth.stamp_ns.min(color_ns), pose, grid }
    }
}

/// The result of a frame.
pub(crate) fn output(
    pending: Pending,
    readback: &Readback,
    executor: &Executor,
    job: &Job,
) -> Result<FrameOutput> {
    let reader = Reader { readback, executor };
    let counters = counters(&reader.words("counters")?, job);
    let low_reliability_fraction = f64::from(counters.low_reliability) / f64::from(job.pixels());
    let side = job.side() as usize;
    let rows = reader.bytes("costmap")?.chunks_exact(side.next_multiple_of(4));
    let costmap = rows.flat_map(|row| &row[..side]).copied().collect();
    Ok(FrameOutput {
        index: pending.index,
        stamp_ns: pending.stamp_ns,
        map_from_base: pending.pose.map_from_base,
        base_from_camera: pending.pose.base_from_camera,
        grid: pending.grid,
        costmap,
        counters,
        low_reliability_fraction,
        degraded: low_reliability_fraction > job.config.degraded_fraction,
        images: job.images.then(|| reader.images(job)).transpose()?,
        layers: job.layers.then(|| reader.layers()).transpose()?,
        pass_ms: readback
            .spans
            .iter()
            .map(|(name, span)| (name.to_string(), span.length_ns * 1e-6))
            .collect(),
        pass_start_ms: readback.spans.iter().map(|(_, span)| span.start_ns * 1e-6).collect(),
    })
}

fn counters(words: &[u32], job: &Job) -> Counters {
    let at = |index: usize| words.get(index).copied().unwrap_or(0);
    Counters {
        pixels: job.pixels(),
        valid: at(0),
        low_reliability: at(1),
        hits: at(2),
        hit_cells: at(3),
        seen_through_cells: at(4),
        occupied_cells: at(5),
        free_cells: at(6),
    }
}

struct Reader<'a> {
    readback: &'a Readback,
    executor: &'a Executor,
}

impl Reader<'_> {
    fn bytes(&self, name: &str) -> Result<&[u8]> {
        self.readback.bytes(self.executor.find(name)?)
    }

    fn words(&self, name: &str) -> Result<Vec<u32>> {
        Ok(self.bytes(name)?.chunks_exact(4).map(pod_read_unaligned).collect())
    }

    fn floats(&self, name: &str, count: usize) -> Result<Vec<f32>> {
        Ok(self.bytes(name)?.chunks_exact(4).take(count).map(pod_read_unaligned).collect())
    }

    fn images(&self, job: &Job) -> Result<FrameImages> {
        let pixels = job.pixels() as usize;
        let color = |_| -> Result<Vec<u8>> {
            let packed = self.bytes("color")?.chunks_exact(4).take(pixels);
            Ok(packed.flat_map(|rgba| [rgba[0], rgba[1], rgba[2]]).collect())
        };
        Ok(FrameImages {
            width: job.depth.width,
            height: job.depth.height,
            depth_m: self.floats(job.depth_buffer(), pixels)?,
            reliability: self.floats("reliability", pixels)?,
            color: job.color.map(color).transpose()?,
        })
    }

    fn layers(&self) -> Result<FrameLayers> {
        let state = self.words("state")?;
        let cells = state.len();
        let cells_in = |wanted: u32| state.iter().map(|&s| if s & 3 == wanted { 1.0 } else { 0.0 }).collect();
        Ok(FrameLayers {
            evidence: self.floats("evidence", cells)?,
            occupancy: self.floats("occupancy", cells)?,
            occupied: cells_in(OCCUPIED),
            free: cells_in(FREE),
        })
    }
}
