//! The simulated camera on the GPU: rays, exposure, noise, stereo matching, in one submission a frame.

use glam::DVec3;

use super::frame::SimFrame;
use super::pack::SimScene;
use super::passes::{
    CENSUS, COST, DEPTH, EXPOSE, METER, SimCensusParams, SimCostParams, SimDepthParams, SimExposeParams,
    SimMeterParams, SimToneParams, SimTraceParams, SimWinnerParams, TONE, TRACE, WINNER,
};
use super::scene::Scene;
use super::trajectory::{poses, seconds_at, stamp_ns};
use super::written;
use crate::base::Rigid;
use crate::base::{Error, Result};
use crate::gpu::{Context, Executor, FrameInput, Invocations, Plan, Readback};
use crate::sensor::FramePose;
use crate::stage::single;

/// How far to the right of the left imager the projector lies, as a share of the baseline.
const PROJECTOR_SHARE: f64 = 0.58;

/// Half the projector's field, as x/z: a little more than the imagers'.
const PROJECTOR_FIELD: f64 = 1.05;

/// Bits of 5x5 signatures.
const WINDOW_BITS: f64 = 25.0 * 62.0;

/// Samples of auto exposure lie this far apart at full size, pixels.
const METER_STEP: u32 = 6;

/// Colour: mean that auto exposure brings the luminance to, largest gain, electrons at full scale.
const COLOR_MEAN: f32 = 0.28;
const COLOR_LARGEST_GAIN: f32 = 100.0;
const COLOR_ELECTRONS: f32 = 4000.0;

/// Which of the two imagers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Eye {
    Left,
    Right,
}

/// A scene with its camera, ready to be looked at from any pose.
pub struct Simulator {
    scene: Scene,
    packed: SimScene,
    executor: Executor,
    pass_ms: Vec<(String, f64)>,
}

/// The plan of a simulated frame for a scene's camera and matcher.
///
/// # Errors
/// [`Error::Plan`] or [`Error::Shader`] where a pass contradicts its shader.
pub fn plan(scene: &Scene) -> Result<Plan> {
    plan_with(scene, None)
}

/// As [`plan`], with the solids of `written` in the code.
fn plan_with(scene: &Scene, written: Option<&SimScene>) -> Result<Plan> {
    let mut plan = Plan::default();
    let (width, height) = (scene.camera.width, scene.camera.height);
    let pixels = u64::from(width) * u64::from(height);
    let disparity_words = scene.matcher.disparities_at(width) / 2;
    declare(&mut plan, pixels, u64::from(disparity_words))?;
    let area = Invocations::area(width, height);
    let crumples = scene.materials.values().any(|material| material.bump > 0.0);
    let count = width * height;
    for eye in [Eye::Left, Eye::Right] {
        let left = eye == Eye::Left;
        let [params, infrared, grey, signature] = match eye {
            Eye::Left => ["trace_left_params", "infrared_left", "grey_left", "left_signature"],
            Eye::Right => ["trace_right_params", "infrared_right", "grey_right", "right_signature"],
        };
        plan.step(written::text(TRACE, written), area, &[("trace_params", params), ("infrared", infrared)])?;
        plan.with(&[("left", left), ("vessels", !scene.vessels.is_empty()), ("sunny", scene.sun.is_some())])?;
        plan.with(&[("crumples", crumples)])?;
        // Both imagers share the exposure that the left one finds.
        if left {
            plan.step(METER, Invocations::line(1), &[("image", infrared)])?;
        }
        let expose = if left { "expose_left_params" } else { "expose_right_params" };
        let renamed = [("expose_params", expose), ("infrared", infrared), ("grey", grey)];
        plan.step(EXPOSE, Invocations::line(count / 4), &renamed)?;
        let renamed = [("grey", grey), ("signature", signature)];
        plan.step(CENSUS, Invocations::area(width / 4, height), &renamed)?;
        plan.with(&[("left", left)])?;
    }
    let color =
        [("meter_params", "color_meter_params"), ("image", "color_luminance"), ("gain", "color_gain")];
    plan.step(METER, Invocations::line(1), &color)?;
    plan.step(TONE, Invocations::line(count), &[("gain", "color_gain")])?;
    plan.step(COST, Invocations([width / 8, height, disparity_words / 4]), &[])?;
    for left in [true, false] {
        let disparity = if left { "left_disparity" } else { "right_disparity" };
        plan.step(WINNER, Invocations::area(width, height.div_ceil(4)), &[("disparity", disparity)])?;
        plan.with(&[("left", left)])?;
    }
    plan.step(DEPTH, Invocations::line(count), &[])?;
    for name in ["depth_mm", "color", "grey_left", "grey_right", "true_depth_m", "true_material"] {
        plan.read_back(name)?;
    }
    plan.check()?;
    Ok(plan)
}

fn declare(plan: &mut Plan, pixels: u64, disparity_words: u64) -> Result<()> {
    plan.uniform::<SimScene>("scene")?;
    for name in ["trace_left_params", "trace_right_params"] {
        plan.uniform::<SimTraceParams>(name)?;
    }
    for name in ["meter_params", "color_meter_params"] {
        plan.uniform::<SimMeterParams>(name)?;
    }
    for name in ["expose_left_params", "expose_right_params"] {
        plan.uniform::<SimExposeParams>(name)?;
    }
    plan.uniform::<SimToneParams>("tone_params")?;
    plan.uniform::<SimCensusParams>("census_params")?;
    plan.uniform::<SimCostParams>("cost_params")?;
    plan.uniform::<SimWinnerParams>("winner_params")?;
    plan.uniform::<SimDepthParams>("depth_params")?;
    for name in ["infrared_left", "infrared_right", "color_luminance", "true_depth_m", "true_material"] {
        plan.scratch(name, pixels * 4)?;
    }
    for name in ["color", "texture", "left_disparity", "right_disparity", "depth_mm"] {
        plan.scratch(name, pixels * 4)?;
    }
    for name in ["color_light", "left_signature", "right_signature"] {
        plan.scratch(name, pixels * 8)?;
    }
    for name in ["grey_left", "grey_right"] {
        plan.scratch(name, pixels)?;
    }
    plan.scratch("gain", 4)?;
    plan.scratch("color_gain", 4)?;
    plan.scratch("volume", pixels * disparity_words * 4)?;
    Ok(())
}

impl Simulator {
    /// Checks the scene and builds its passes on the adapter of that name; `profiling`: they are timed.
    ///
    /// # Errors
    /// [`Error::Config`] with the key of the scene, [`Error::NoAdapter`], [`Error::Limit`], [`Error::Gpu`].
    pub fn open(scene: &Scene, adapter: Option<&str>, profiling: bool) -> Result<Self> {
        scene.validate()?;
        let context = Context::open(adapter, profiling)?;
        Self::with_context(scene, &context)
    }

    /// As [`Self::open`], on a device that is open already.
    ///
    /// # Errors
    /// As there.
    pub fn with_context(scene: &Scene, context: &Context) -> Result<Self> {
        Self::for_frames(scene, context, scene.trajectory.frames.into())
    }

    /// As [`Self::with_context`], for so many frames: what is compiled for many takes longer and runs faster. The frames are
    /// the same.
    ///
    /// # Errors
    /// As there.
    pub fn for_frames(scene: &Scene, context: &Context, frames: u64) -> Result<Self> {
        scene.validate()?;
        let packed = SimScene::pack(&scene.at(0.0));
        let rays = 2 * frames * u64::from(scene.camera.width) * u64::from(scene.camera.height);
        let written = written::is_worth_it(scene, context, rays).then_some(&packed);
        let executor = Executor::build(context, plan_with(scene, written)?)?;
        Ok(Self { packed, scene: scene.clone(), executor, pass_ms: Vec::new() })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The passes.
    pub fn executor(&self) -> &Executor {
        &self.executor
    }

    /// Milliseconds of each pass of the last frame, where passes are timed.
    pub fn pass_ms(&self) -> &[(String, f64)] {
        &self.pass_ms
    }

    /// Poses of all frames of the scene's way.
    pub fn poses(&self) -> Vec<FramePose> {
        poses(&self.scene)
    }

    /// What the camera gives at a pose as frame `index` of the recording.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn frame(&mut self, index: u64, pose: FramePose) -> Result<SimFrame> {
        if !self.scene.walkers.is_empty() {
            self.packed = SimScene::pack(&self.scene.at(seconds_at(stamp_ns(&self.scene, index))));
        }
        let (scene, packed) = (&self.scene, &self.packed);
        let mut input = self.executor.begin()?;
        write(&mut input, scene, packed, index, pose)?;
        input.submit()?;
        let received = self.executor.receive()?;
        let readback = received.ok_or_else(|| Error::Gpu {
            what: "simulated frame".into(),
            reason: "nothing came back".into(),
        })?;
        self.pass_ms =
            readback.spans.iter().map(|(name, span)| (name.to_string(), span.length_ns * 1e-6)).collect();
        self.take(&readback, index, pose)
    }

    fn take(&self, readback: &Readback, index: u64, pose: FramePose) -> Result<SimFrame> {
        let bytes = |name: &str| readback.bytes(self.executor.find(name)?);
        let words = |name: &str| -> Result<Vec<u32>> {
            Ok(bytes(name)?.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect())
        };
        Ok(SimFrame {
            index,
            stamp_ns: stamp_ns(&self.scene, index),
            pose,
            width: self.scene.camera.width,
            height: self.scene.camera.height,
            depth_mm: words("depth_mm")?.into_iter().map(|mm| u16::try_from(mm).unwrap_or(0)).collect(),
            rgb: bytes("color")?.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect(),
            infrared_left: bytes("grey_left")?.to_vec(),
            infrared_right: bytes("grey_right")?.to_vec(),
            true_depth_m: words("true_depth_m")?.into_iter().map(f32::from_bits).collect(),
            material: words("true_material")?.into_iter().map(|m| u8::try_from(m).unwrap_or(0)).collect(),
        })
    }
}

/// A seed for one use of randomness.
fn seed(scene: &Scene, index: u64, purpose: u64) -> u32 {
    let mut random = super::generate::Random::new(scene.seed ^ (index << 20) ^ (purpose << 56));
    random.bits()
}

fn write(
    input: &mut FrameInput<'_>,
    scene: &Scene,
    packed: &SimScene,
    index: u64,
    pose: FramePose,
) -> Result<()> {
    input.set("scene", packed)?;
    let map_from_camera = pose.map_from_base.then(pose.base_from_camera);
    for (eye, name) in [(Eye::Left, "trace_left_params"), (Eye::Right, "trace_right_params")] {
        input.set(name, &trace_params(scene, eye, index, map_from_camera))?;
    }
    write_imaging(input, scene, index)?;
    write_matching(input, scene)
}

fn trace_params(scene: &Scene, eye: Eye, index: u64, map_from_camera: Rigid) -> SimTraceParams {
    let (camera, imager) = (&scene.camera, &scene.imager);
    let model = camera.model();
    let axes = map_from_camera.rotation_matrix();
    let beside = |share: f64| map_from_camera.transform_point(DVec3::X * camera.baseline_m * share);
    let (origin, purpose) = match eye {
        Eye::Left => (beside(0.0), 1),
        Eye::Right => (beside(1.0), 2),
    };
    let row = |v: DVec3, w: f64| v.extend(w).as_vec4();
    let dot = imager.speckle_px / model.fx;
    SimTraceParams {
        origin: row(origin, PROJECTOR_FIELD),
        right: row(axes.x_axis, model.fx),
        down: row(axes.y_axis, model.cx),
        forward: row(axes.z_axis, model.cy),
        projector: row(beside(PROJECTOR_SHARE), imager.projector),
        speckle: row(DVec3::new(dot, imager.speckle_contrast, 0.0), 0.0),
        width: camera.width,
        height: camera.height,
        speckle_seed: seed(scene, 0, 3),
        frame_seed: seed(scene, index, purpose),
    }
}

fn write_imaging(input: &mut FrameInput<'_>, scene: &Scene, index: u64) -> Result<()> {
    let (imager, width, height) = (&scene.imager, scene.camera.width, scene.camera.height);
    let meter = SimMeterParams {
        width,
        height,
        step: (METER_STEP * width / 848).max(1),
        wanted_mean: single(imager.exposure_mean),
        largest_gain: single(imager.largest_gain),
        bias: single(imager.exposure_bias),
        pad0: 0,
        pad1: 0,
    };
    input.set("meter_params", &meter)?;
    let color =
        SimMeterParams { wanted_mean: COLOR_MEAN, largest_gain: COLOR_LARGEST_GAIN, bias: 1.0, ..meter };
    input.set("color_meter_params", &color)?;
    for (name, purpose) in [("expose_left_params", 4), ("expose_right_params", 5)] {
        let expose = SimExposeParams {
            words: width * height / 4,
            seed: seed(scene, index, purpose),
            electrons: single(imager.electrons),
            read_noise: single(imager.read_noise / 255.0),
            full_gain: single(imager.full_gain),
            pad0: 0,
            pad1: 0,
            pad2: 0,
        };
        input.set(name, &expose)?;
    }
    let electrons = COLOR_ELECTRONS;
    let tone = SimToneParams { pixels: width * height, seed: seed(scene, index, 6), electrons, pad0: 0 };
    input.set("tone_params", &tone)
}

fn write_matching(input: &mut FrameInput<'_>, scene: &Scene) -> Result<()> {
    let (camera, matcher) = (&scene.camera, &scene.matcher);
    let (width, height) = (camera.width, camera.height);
    let disparities = matcher.disparities_at(width);
    let disparity_words = disparities / 2;
    input.set("census_params", &SimCensusParams { words: width / 4, height })?;
    input.set("cost_params", &SimCostParams { width, height, disparity_words })?;
    let winner = SimWinnerParams {
        width,
        height,
        disparity_words,
        uniqueness: single(matcher.uniqueness),
        largest_cost: single(matcher.largest_cost * WINDOW_BITS),
    };
    input.set("winner_params", &winner)?;
    let depth = SimDepthParams {
        width,
        height,
        focal_baseline_mm: single(camera.model().fx * camera.baseline_m * 1e3),
        left_right_px: single(matcher.left_right_px),
        texture: single(matcher.texture),
        step_px: single(matcher.step_px),
        largest_px: single(f64::from(disparities - 1)),
        pad0: 0,
    };
    input.set("depth_params", &depth)
}
