//! Frames in, samples out, some frames later: a reference is drawn from frames before and after.

use std::collections::VecDeque;
use std::sync::Arc;

use bytemuck::{cast_slice, pod_read_unaligned};

use crate::base::Rigid;
use crate::base::seconds_between;
use crate::base::{Error, Refused, Result};
use crate::config::{Config, Method};
use crate::gpu::{Context, Executor, Invocations, Plan, Readback};
use crate::map::Window;
use crate::mapper::check_frame;
use crate::network::weights::{INPUT_CHANNELS, NATIVE_SIZE};
use crate::network::{Backend, INPUT};
use crate::offline::targets::Request;
use crate::offline::targets::sample::{Judged, Sample};
use crate::sensor::{CameraInfo, Observation, RgbdFrame, SensorPose};
use crate::sim::truth::TruthFrame;
use crate::stage::camera::align_color::ALIGN_COLOR;
use crate::stage::camera::back_project;
use crate::stage::camera::drm::{ResizeParams, resize};
use crate::stage::camera::ingest::{INGEST, Ingest};
use crate::stage::camera::register_color::REGISTER_COLOR;
use crate::stage::targets::{REACH, Rule, SLOTS, Targets, View};
use crate::stage::{CameraJob, MapJob, Moment, Stage, color_stage, single};

/// Metres that the network's depth is divided by (spec 1 §1).
const DEPTH_SCALE_M: f64 = 10.0;

/// A frame whose depth is in the window.
struct Kept {
    index: u64,
    stamp_ns: u64,
    slot: usize,
    map_from_camera: Rigid,
    input: Vec<f32>,
    truth: Option<TruthFrame>,
}

/// Makes samples of frames of one size and calibration.
pub struct Maker {
    job: Arc<CameraJob>,
    ingest: Ingest,
    color: Option<Box<dyn Stage>>,
    targets: Targets,
    every: u64,
    executor: Executor,
    kept: VecDeque<Kept>,
    pushed: u64,
    next: usize,
}

impl Maker {
    /// Builds the passes for frames like `first`; `truth`: they come with their truth.
    ///
    /// # Errors
    /// [`Error::Input`] without colour; [`Error::Decode`] for impossible intrinsics; [`Error::NoAdapter`], [`Error::Limit`], [`Error::Gpu`].
    pub fn open(first: &RgbdFrame, request: &Request, truth: bool) -> Result<Self> {
        first.depth.camera.validate()?;
        check_color(first)?;
        let config = Config { method: Method::Drm, ..Config::default() };
        let nothing = || Error::Input { what: "frame".into(), reason: "is missing".into() };
        let info = CameraInfo::of_frames([first]).ok_or_else(nothing)?;
        let job = Arc::new(CameraJob {
            depth: info.depth,
            float_depth: info.float_depth,
            color: info.color,
            color_aligned: info.color_aligned,
            confidence: info.confidence,
            drm: None,
            depth_alone: false,
            images: true,
            layers: false,
            cell_inputs: false,
            map: Arc::new(MapJob::of_camera(&config, config.cells_per_side()?)),
            sensor: 0,
            scope: String::new(),
            config,
        });
        let color = color_stage(&job);
        let targets = Targets { rule: request.rule, truth };
        let plan = plan(&job, &request.rule, truth)?;
        let context = Context::open(request.adapter.as_deref(), false)?;
        let executor = Executor::build(&context, plan)?;
        let every = request.every.max(1);
        Ok(Self {
            ingest: Ingest { job: Arc::clone(&job) },
            job,
            color,
            targets,
            every,
            executor,
            kept: VecDeque::new(),
            pushed: 0,
            next: 0,
        })
    }

    /// Adapter and driver.
    pub fn describe(&self) -> String {
        self.executor.context().describe()
    }

    /// Whether samples of frames that were pushed are still to come.
    pub fn is_pending(&self) -> bool {
        self.next < self.kept.len()
    }

    /// Takes a frame, and gives the sample of the frame [`REACH`] before it, where there is one.
    ///
    /// # Errors
    /// [`Error::Input`] that names the frame at fault; [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn push(&mut self, frame: &RgbdFrame, truth: Option<TruthFrame>) -> Result<Option<Sample>> {
        let named = |error: Error| match error {
            Error::Input { what, reason } => {
                Error::Input { what: format!("{what} of frame {}", frame.index), reason }
            }
            other => other,
        };
        let refused = |reason: Refused| Error::Input {
            what: format!("frame {}", frame.index),
            reason: reason.to_string(),
        };
        check_frame(&self.job, frame).map_err(refused)?;
        check_same(&self.job, frame).map_err(named)?;
        check_color(frame)?;
        let pose = frame.pose.ok_or_else(|| refused(Refused::NoPose))?;
        if !SensorPose::from(pose).is_finite() {
            return Err(refused(Refused::PoseNotFinite));
        }
        let slot = usize::try_from(self.pushed % SLOTS as u64).unwrap_or(0);
        self.pushed += 1;
        self.kept.push_back(Kept {
            index: frame.index,
            stamp_ns: frame.depth.stamp_ns,
            slot,
            map_from_camera: pose.map_from_base.then(pose.base_from_camera),
            input: Vec::new(),
            truth,
        });
        if self.kept.len() > SLOTS {
            self.kept.pop_front();
            self.next = self.next.saturating_sub(1);
        }
        let due = self.kept.len() > self.next + REACH;
        self.round(Some(frame), due)
    }

    /// Gives the next sample where no more frames come.
    ///
    /// # Errors
    /// As [`Maker::push`].
    pub fn flush(&mut self) -> Result<Option<Sample>> {
        self.round(None, true)
    }

    /// One submission: a frame in, a sample out, or either.
    fn round(&mut self, frame: Option<&RgbdFrame>, due: bool) -> Result<Option<Sample>> {
        let target = self.kept.get(self.next).filter(|_| due);
        let wanted = target.is_some_and(|kept| kept.index % self.every == 0);
        let views = if wanted { self.views() } else { Vec::new() };
        if let Some(target) = target.filter(|_| wanted) {
            check_views(target, views.len(), self.targets.rule.least_views)?;
        }
        let readback = self.submit(frame, &views)?;
        if frame.is_some()
            && let Some(newest) = self.kept.back_mut()
        {
            newest.input = planes(readback.bytes(self.executor.find(INPUT)?)?);
        }
        if !due {
            return Ok(None);
        }
        let sample = if wanted { Some(self.sample(&readback)?) } else { None };
        self.next += 1;
        Ok(sample)
    }

    /// The other frames within reach of the target.
    fn views(&self) -> Vec<View> {
        let Some(target) = self.kept.get(self.next) else { return Vec::new() };
        let target_from_map = target.map_from_camera.inverse();
        let near = |at: usize| at != self.next && at.abs_diff(self.next) <= REACH;
        let others = self.kept.iter().enumerate().filter(|(at, _)| near(*at)).map(|(_, kept)| kept);
        others
            .map(|kept| View {
                slot: kept.slot,
                target_from_view: target_from_map.then(kept.map_from_camera),
            })
            .collect()
    }

    fn submit(&mut self, frame: Option<&RgbdFrame>, views: &[View]) -> Result<Readback> {
        let (job, targets) = (&self.job, &self.targets);
        let mut input = self.executor.begin()?;
        match frame {
            Some(frame) => {
                let observation = Observation::of_frame(0, "", frame.clone());
                let moment = Moment::of(&observation, SensorPose::SENSOR, Window::default(), &job.config);
                self.ingest.write(&moment, &mut input)?;
                if let Some(color) = &self.color {
                    color.write(&moment, &mut input)?;
                }
                let before = self.kept.iter().rev().nth(1).map(|kept| kept.stamp_ns);
                let since_last_s = before.map(|before| seconds_between(before, frame.depth.stamp_ns));
                input.set("resize_params", &ResizeParams::new(DEPTH_SCALE_M, since_last_s))?;
            }
            None => {
                let color = if job.color_aligned { ALIGN_COLOR.name } else { REGISTER_COLOR.name };
                for pass in [INGEST.name, color, "net/resize"] {
                    input.limit(pass, Invocations::line(0))?;
                }
            }
        }
        let newest = frame.and_then(|_| self.kept.back()).map(|kept| kept.slot);
        targets.write_remember(job, newest, &mut input)?;
        let target = self.kept.get(self.next);
        targets.write_target(job, target.map_or(0, |kept| kept.slot), views, &mut input)?;
        if let Some(truth) = target.and_then(|kept| kept.truth.as_ref()).filter(|_| !views.is_empty()) {
            input.write("true_depth_m", cast_slice(&truth.depth_m))?;
        }
        input.submit()?;
        let nothing = || Error::Gpu { what: "targets".into(), reason: "nothing came back".into() };
        self.executor.receive()?.ok_or_else(nothing)
    }

    fn sample(&mut self, readback: &Readback) -> Result<Sample> {
        let bytes = |name: &str| readback.bytes(self.executor.find(name)?);
        let floats = |name: &str| -> Result<Vec<f32>> {
            Ok(bytes(name)?.chunks_exact(4).map(pod_read_unaligned).collect())
        };
        let quads = floats("targets")?;
        let measured = Judged::from_quads(&quads);
        let picked: Vec<u32> = bytes("picked")?.chunks_exact(4).map(pod_read_unaligned).collect();
        let true_quads = if self.targets.truth { floats("true_targets")? } else { Vec::new() };
        let nothing = || Error::Gpu { what: "targets".into(), reason: "there is no target".into() };
        let kept = self.kept.get_mut(self.next).ok_or_else(nothing)?;
        if measured.reference_m.iter().all(|&reference| reference == 0.0) {
            let reason =
                "no pixel of it is seen alike by enough of the frames around it; a reference cannot be built"
                    .into();
            return Err(Error::Input { what: format!("frame {}", kept.index), reason });
        }
        let truth = kept.truth.take().map(|truth| {
            let kind = |&at: &u32| truth.material.get(at as usize).copied().unwrap_or(0);
            (Judged::from_quads(&true_quads), picked.iter().map(kind).collect::<Vec<u8>>())
        });
        let (rule, camera) = (self.targets.rule, self.job.depth);
        let tolerance = |depth: &f32| single(rule.tolerance_m(&camera, f64::from(*depth)));
        let tolerance_m = truth.iter().flat_map(|(judged, _)| judged.reference_m.iter().map(tolerance));
        Ok(Sample {
            index: kept.index,
            stamp_ns: kept.stamp_ns,
            input: std::mem::take(&mut kept.input),
            depth_m: quads.chunks_exact(4).map(|quad| quad[3]).collect(),
            measured,
            tolerance_m: tolerance_m.collect(),
            truth,
        })
    }
}

fn check_color(frame: &RgbdFrame) -> Result<()> {
    if frame.color.is_some() && frame.color_from_depth.is_some() {
        return Ok(());
    }
    let reason = "is missing, or its place relative to depth is; the network's input needs it".into();
    Err(Error::Input { what: format!("colour image of frame {}", frame.index), reason })
}

/// Rays and window are those of one calibration.
fn check_same(job: &Arc<CameraJob>, frame: &RgbdFrame) -> Result<()> {
    if frame.depth.camera == job.depth {
        return Ok(());
    }
    let reason = "changes within the recording".into();
    Err(Error::Input { what: "depth calibration".into(), reason })
}

fn check_views(target: &Kept, views: usize, least: u32) -> Result<()> {
    if views >= least as usize {
        return Ok(());
    }
    let reason = format!(
        "{views} other frames with a pose lie within {REACH} of it, and {least} are needed; a reference cannot be built"
    );
    Err(Error::Input { what: format!("frame {}", target.index), reason })
}

/// The plan of a frame; `truth`: true depth comes with it.
///
/// # Errors
/// [`Error::Plan`] or [`Error::Shader`] where a pass contradicts its shader.
pub fn plan(job: &Arc<CameraJob>, rule: &Rule, truth: bool) -> Result<Plan> {
    let mut plan = Plan::default();
    plan.fixed("rays", back_project::rays(&job.depth))?;
    Ingest { job: Arc::clone(job) }.append(&mut plan)?;
    if let Some(color) = color_stage(job) {
        color.append(&mut plan)?;
    }
    let size = NATIVE_SIZE.map(|extent| u32::try_from(extent).unwrap_or(0));
    let low = u64::from(size[0]) * u64::from(size[1]);
    plan.uniform::<ResizeParams>("resize_params")?;
    plan.state("depth_before", low * 4)?;
    plan.scratch(INPUT, low * 32)?;
    // Tensors in buffers, on every adapter, so that they can be read back; the numbers are the same.
    let backend = Backend { textures: false, subgroups: false };
    let (text, invocations) = resize([job.depth.height, job.depth.width], size, backend);
    plan.step(text, invocations, &[("sink", INPUT)])?;
    plan.read_back(INPUT)?;
    Targets { rule: *rule, truth }.append(&mut plan, job)?;
    plan.check()?;
    Ok(plan)
}

/// Two planes of quads to the planes of the channels that are inputs.
fn planes(bytes: &[u8]) -> Vec<f32> {
    let pixels = NATIVE_SIZE[0] * NATIVE_SIZE[1];
    let value = |at: usize| bytes.get(4 * at..4 * at + 4).map_or(0.0, pod_read_unaligned::<f32>);
    let channel = |c: usize| (0..pixels).map(move |pixel| (c / 4 * pixels + pixel) * 4 + c % 4);
    (0..INPUT_CHANNELS).flat_map(channel).map(value).collect()
}
