//! Reference depth from the frames around a frame, and training targets at the network's size (spec 1 §2).
//!
//! Depth of every frame is remembered in one of [`SLOTS`] slots. For one frame at a time the others are reprojected into its camera;
//! where enough of them agree, their mean is the reference depth, and the frame's own depth is judged by it.

use glam::{UVec4, Vec2, Vec4};

use crate::base::Result;
use crate::base::Rigid;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::network::weights::NATIVE_SIZE;
use crate::sensor::CameraModel;
use crate::stage::camera::drm;
use crate::stage::camera::see_through::{field, lens, pinhole};
use crate::stage::{CameraJob, rows, single};

const TOLERANCE: &str = include_str!("../../shaders/lib/targets/tolerance.wgsl");
const NEARNESS: &str = include_str!("../../shaders/lib/targets/nearness.wgsl");

/// Depth into the window.
pub const REMEMBER: ShaderSource =
    ShaderSource { name: "targets/remember", parts: &[include_str!("../../shaders/targets/remember.wgsl")] };

/// Other frames as the target's camera would have seen them.
pub const REPROJECT: ShaderSource = ShaderSource {
    name: "targets/reproject",
    parts: &[
        include_str!("../../shaders/lib/lens.wgsl"),
        NEARNESS,
        include_str!("../../shaders/targets/reproject.wgsl"),
    ],
};

/// Reference depth.
pub const AGREE: ShaderSource = ShaderSource {
    name: "targets/agree",
    parts: &[TOLERANCE, NEARNESS, include_str!("../../shaders/targets/agree.wgsl")],
};

/// Targets.
pub const JUDGE: ShaderSource = ShaderSource {
    name: "targets/judge",
    parts: &[
        include_str!("../../shaders/lib/numbers.wgsl"),
        TOLERANCE,
        include_str!("../../shaders/targets/judge.wgsl"),
    ],
};

/// Frames on either side of a target that its reference is drawn from.
pub const REACH: usize = 8;
/// Other frames at most.
pub const VIEWS: usize = 2 * REACH;
/// Frames whose depth is kept.
pub const SLOTS: usize = VIEWS + 1;

crate::params! {
    /// Parameters of `targets/remember`.
    pub struct RememberParams {
        /// vec4 words of a slot.
        pub words: u32,
        /// Where the frame goes.
        pub slot: u32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
    }
}

crate::params! {
    /// Parameters of `targets/reproject`.
    pub struct ReprojectParams {
        /// Lens: k1, k2, p1, p2.
        pub lens_a: Vec4,
        /// k3, k4, k5, k6.
        pub lens_b: Vec4,
        /// Focal lengths.
        pub focal_px: Vec2,
        /// Principal point.
        pub centre_px: Vec2,
        /// Least x/z and y/z of the image's rays.
        pub field_min: Vec2,
        /// Greatest.
        pub field_max: Vec2,
        /// Pixels.
        pub width: u32,
        /// Pixels.
        pub height: u32,
        /// Pixels from slot to slot.
        pub slot_pixels: u32,
        /// Other frames.
        pub views: u32,
        /// Their slots.
        pub view: [UVec4; VIEWS],
        /// First rows of target camera from their cameras.
        pub target_from_view_x: [Vec4; VIEWS],
        /// Second rows.
        pub target_from_view_y: [Vec4; VIEWS],
        /// Third rows.
        pub target_from_view_z: [Vec4; VIEWS],
    }
}

crate::params! {
    /// Parameters of `targets/agree`.
    pub struct AgreeParams {
        /// Of the depth image.
        pub pixels: u32,
        /// Pixels from view to view.
        pub slot_pixels: u32,
        /// Views that must agree.
        pub least_views: u32,
        /// Share of the views with depth there that must agree.
        pub least_share: f32,
        /// Delta as a share of the depth.
        pub share: f32,
        /// Stereo noise over depth squared.
        pub noise_per_m: f32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
    }
}

crate::params! {
    /// Parameters of `targets/judge`.
    pub struct JudgeParams {
        /// Native pixels across one of the network's.
        pub scale: Vec2,
        /// Of the network's input.
        pub width: u32,
        /// Of the network's input.
        pub height: u32,
        /// Of the depth image.
        pub native_width: u32,
        /// Of the depth image.
        pub native_height: u32,
        /// Native pixels that one of the network's may touch.
        pub span_x: u32,
        /// The same downwards.
        pub span_y: u32,
        /// First pixel of the frame's slot.
        pub first: u32,
        /// Delta and sigma as a share of the reference.
        pub share: f32,
        /// Stereo noise over depth squared.
        pub noise_per_m: f32,
        /// Unused.
        pub pad0: u32,
    }
}

/// When measurements agree, and how depth is judged (spec 1 §2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rule {
    /// delta and sigma as a share of the depth.
    pub share: f64,
    /// Noise of the stereo matcher, pixels of disparity.
    pub noise_px: f64,
    /// Distance of the two imagers, metres.
    pub baseline_m: f64,
    /// Other frames that must agree on a reference.
    pub least_views: u32,
    /// Share of the other frames with depth there that must agree.
    pub least_share: f64,
}

impl Default for Rule {
    fn default() -> Self {
        Self { share: 0.02, noise_px: 0.08, baseline_m: 0.05, least_views: 4, least_share: 0.5 }
    }
}

impl Rule {
    /// sigma_stereo of a depth, over the depth squared, 1/m.
    pub fn noise_per_m(&self, camera: &CameraModel) -> f64 {
        self.noise_px / (camera.fx * self.baseline_m)
    }

    /// delta = max(share d, 2 sigma_stereo(d)), metres.
    pub fn tolerance_m(&self, camera: &CameraModel, depth_m: f64) -> f64 {
        (self.share * depth_m).max(2.0 * self.noise_per_m(camera) * depth_m * depth_m)
    }
}

/// Another frame: the slot of its depth, and its camera in the target's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Slot.
    pub slot: usize,
    /// Target camera from its camera.
    pub target_from_view: Rigid,
}

/// The stage: appends to a plan that has `depth_m` and `rays`.
#[derive(Debug)]
pub struct Targets {
    /// When depths agree.
    pub rule: Rule,
    /// Whether true depth is uploaded, to judge by it too.
    pub truth: bool,
}

/// A count of pixels or words, which all fit.
fn count(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

fn size() -> [u32; 2] {
    NATIVE_SIZE.map(count)
}

impl Targets {
    /// Declares its buffers and appends its passes. `reference_m` is of the depth image; `targets` (reference, soft, binary, depth),
    /// `picked` (native pixel), and with truth `true_targets` are of the network's input.
    ///
    /// # Errors
    /// Those of the plan.
    pub fn append(&self, plan: &mut Plan, job: &CameraJob) -> Result<()> {
        let image_bytes = job.image_bytes(4);
        let [rows, columns] = size();
        let low = u64::from(rows) * u64::from(columns);
        plan.uniform::<RememberParams>("remember_params")?;
        plan.uniform::<ReprojectParams>("reproject_params")?;
        plan.uniform::<AgreeParams>("agree_params")?;
        plan.uniform::<JudgeParams>("judge_params")?;
        plan.state("window_m", image_bytes * SLOTS as u64)?;
        plan.state("seen", image_bytes * VIEWS as u64)?;
        plan.scratch("reference_m", image_bytes)?;
        plan.scratch("targets", low * 16)?;
        plan.scratch("picked", low * 4)?;
        let line = Invocations::line(job.pixels());
        plan.step(REMEMBER, Invocations::line(job.pixel_words()), &[])?;
        plan.step(REPROJECT, Invocations([job.pixels(), count(VIEWS), 1]), &[])?;
        plan.with(&[("fisheye", job.depth.distortion.is_fisheye())])?;
        plan.step(AGREE, line, &[])?;
        plan.step(JUDGE, Invocations::line(rows * columns), &[])?;
        for name in ["reference_m", "targets", "picked"] {
            plan.read_back(name)?;
        }
        if self.truth {
            plan.upload("true_depth_m", image_bytes)?;
            plan.scratch("true_targets", low * 16)?;
            plan.product("true_picked", low * 4)?;
            let renamed =
                [("reference_m", "true_depth_m"), ("targets", "true_targets"), ("picked", "true_picked")];
            plan.step(JUDGE, Invocations::line(rows * columns), &renamed)?;
            plan.read_back("true_targets")?;
        }
        Ok(())
    }

    /// Remembers the depth of this frame in a slot; `None`: there is no new frame.
    ///
    /// # Errors
    /// Those of the input.
    pub fn write_remember(
        &self,
        job: &CameraJob,
        slot: Option<usize>,
        input: &mut FrameInput<'_>,
    ) -> Result<()> {
        let words = job.pixel_words();
        let params = RememberParams { words, slot: count(slot.unwrap_or(0)), pad0: 0, pad1: 0 };
        input.set("remember_params", &params)?;
        input.limit(REMEMBER.name, Invocations::line(if slot.is_some() { words } else { 0 }))
    }

    /// Draws a reference for the frame in `slot` from `views`, of which the first [`VIEWS`] are taken; none: there is no target.
    ///
    /// # Errors
    /// Those of the input.
    pub fn write_target(
        &self,
        job: &CameraJob,
        slot: usize,
        views: &[View],
        input: &mut FrameInput<'_>,
    ) -> Result<()> {
        let camera = &job.depth;
        let on = |extent: u32| if views.is_empty() { 0 } else { extent };
        let views = views.get(..VIEWS).unwrap_or(views);
        let (pixels, low) = (on(job.pixels()), on(size()[0] * size()[1]));
        input.set("reproject_params", &reproject_params(job, views))?;
        input.limit(REPROJECT.name, Invocations([pixels, count(views.len()), 1]))?;
        let (share, noise_per_m) = (single(self.rule.share), single(self.rule.noise_per_m(camera)));
        let slot_pixels = job.pixel_words() * 4;
        let agree = AgreeParams {
            pixels: job.pixels(),
            slot_pixels,
            least_views: self.rule.least_views,
            least_share: single(self.rule.least_share),
            share,
            noise_per_m,
            pad0: 0,
            pad1: 0,
        };
        input.set("agree_params", &agree)?;
        input.limit(AGREE.name, Invocations::line(pixels))?;
        let judge = judge_params([camera.height, camera.width], size(), [share, noise_per_m]);
        input.set("judge_params", &JudgeParams { first: count(slot) * slot_pixels, ..judge })?;
        // The first of that name is limited; the second runs on, and nobody reads what it makes.
        input.limit(JUDGE.name, Invocations::line(low))
    }
}

/// Parameters of `targets/judge` for the first slot; `[share, noise_per_m]` as in [`Rule`].
pub fn judge_params(native: [u32; 2], size: [u32; 2], [share, noise_per_m]: [f32; 2]) -> JudgeParams {
    let ratio = |axis: usize| single(f64::from(native[axis]) / f64::from(size[axis]));
    JudgeParams {
        scale: Vec2::new(ratio(1), ratio(0)),
        width: size[1],
        height: size[0],
        native_width: native[1],
        native_height: native[0],
        span_x: drm::span(native[1], size[1]),
        span_y: drm::span(native[0], size[0]),
        first: 0,
        share,
        noise_per_m,
        pad0: 0,
    }
}

/// Parameters of `targets/reproject` for those views.
pub fn reproject_params(job: &CameraJob, views: &[View]) -> ReprojectParams {
    let camera = &job.depth;
    let [lens_a, lens_b] = lens(camera);
    let [focal_px, centre_px] = pinhole(camera);
    let [least, most] = field(camera);
    // The field only keeps rays out that a lens model folds back into the image: half a pixel more at the border, for rounding.
    let margin = 0.6 / focal_px;
    let (field_min, field_max) = (least - margin, most + margin);
    let mut params = ReprojectParams {
        lens_a,
        lens_b,
        focal_px,
        centre_px,
        field_min,
        field_max,
        width: camera.width,
        height: camera.height,
        slot_pixels: job.pixel_words() * 4,
        views: count(views.len()),
        view: [UVec4::ZERO; VIEWS],
        target_from_view_x: [Vec4::ZERO; VIEWS],
        target_from_view_y: [Vec4::ZERO; VIEWS],
        target_from_view_z: [Vec4::ZERO; VIEWS],
    };
    for (at, view) in views.iter().enumerate() {
        params.view[at].x = count(view.slot);
        [params.target_from_view_x[at], params.target_from_view_y[at], params.target_from_view_z[at]] =
            rows(view.target_from_view);
    }
    params
}
