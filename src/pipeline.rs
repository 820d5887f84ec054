//! The camera path: the stages of a frame in the order of the paper, on one page.

use std::collections::VecDeque;

use crate::base::Result;
use crate::base::seconds_between;
use crate::config::{Config, Method};
use crate::frame::Options;
use crate::gpu::{Context, Executor, Plan};
use crate::map::Window;
use crate::receive::{Pending, check_fit, check_pose, check_recalibration, load_drm};
use crate::sensor::RgbdFrame;
use crate::stage::camera::{back_project, drm, ingest, see_through};
use crate::stage::camera::{spatial_median, tally, update, weigh};
use crate::stage::map::{inflate, move_window};
use crate::stage::{Job, Moment, Stage, color_stage};

/// The stages of one frame, in order (spec 1 §3: move window, update, hysteresis, inflate).
pub fn stages(job: &Job) -> Vec<Box<dyn Stage>> {
    let mut stages: Vec<Box<dyn Stage>> = vec![Box::new(ingest::Ingest)];
    if job.config.method == Method::Median {
        stages.push(Box::new(spatial_median::SpatialMedian));
    }
    let color = color_stage(job);
    let (color, shown_color) = if job.drm.is_some() { (color, None) } else { (None, color) };
    stages.extend(color);
    if let Some(drm) = &job.drm {
        stages.push(Box::new(drm::DrmNet { drm: drm.clone() }));
    }
    if job.confidence {
        stages.push(Box::new(weigh::Weigh));
    }
    stages.push(Box::new(move_window::MoveWindow));
    stages.push(Box::new(back_project::BackProject));
    stages.push(Box::new(see_through::SeeThrough::new(&job.depth)));
    stages.push(Box::new(update::Update));
    stages.push(Box::new(inflate::Inflate));
    stages.push(Box::new(tally::Tally));
    stages.extend(shown_color);
    stages
}

/// The plan of a frame, with what is to be read back.
///
/// # Errors
/// [`crate::Error::Plan`] or [`crate::Error::Shader`] where a stage contradicts its shader or its neighbours.
pub fn plan(job: &Job, stages: &[Box<dyn Stage>]) -> Result<Plan> {
    let mut plan = Plan::default();
    plan.fixed("rays", back_project::rays(&job.depth))?;
    for stage in stages {
        stage.append(&mut plan, job)?;
    }
    let images = [job.depth_buffer(), "reliability"].into_iter().chain(job.color.map(|_| "color"));
    let layers = ["evidence", "occupancy", "state"];
    for name in images.filter(|_| job.images).chain(layers.into_iter().filter(|_| job.layers)) {
        plan.read_back(name)?;
    }
    plan.check()?;
    Ok(plan)
}

/// Frames in, costmaps out, with up to three frames under way.
pub struct Pipeline {
    pub(crate) job: Job,
    stages: Vec<Box<dyn Stage>>,
    pub(crate) executor: Executor,
    window: Option<Window>,
    last_stamp_ns: Option<u64>,
    /// Whether the frame before was refused.
    refused: bool,
    pub(crate) pending: VecDeque<Pending>,
}

impl Pipeline {
    /// Builds the pipeline for frames like `first` (size, encoding and calibrations) on the adapter of
    /// that name. `images` and `layers` say what is read back beside the costmap.
    ///
    /// # Errors
    /// [`crate::Error::Config`], [`crate::Error::NoAdapter`], [`crate::Error::Limit`], [`crate::Error::Gpu`].
    pub fn open(config: &Config, first: &RgbdFrame, options: &Options) -> Result<Self> {
        config.validate()?;
        let config = &config.resolved(options.color.is_some());
        first.depth.camera.validate()?;
        let context = Context::open(options.adapter.as_deref(), options.profiling)?;
        let drm = load_drm(config, options, &context)?;
        let job = options.job(config, first, drm);
        let stages = stages(&job);
        let plan = plan(&job, &stages)?;
        let executor = Executor::build(&context, plan)?;
        let pending = VecDeque::new();
        Ok(Self { job, stages, executor, window: None, last_stamp_ns: None, refused: false, pending })
    }

    /// Starts a frame; returns at once. Receive first when [`Pipeline::is_full`].
    ///
    /// # Errors
    /// [`crate::Error::Input`] where size or encoding differ from the first frame's, or pose or unit are
    /// missing or no numbers (the map stays as it was); [`crate::Error::Gpu`], [`crate::Error::DeviceLost`].
    pub fn submit(&mut self, frame: &RgbdFrame) -> Result<()> {
        let outcome = self.start(frame);
        self.refused = outcome.is_err();
        outcome
    }

    fn start(&mut self, frame: &RgbdFrame) -> Result<()> {
        check_fit(&self.job, frame)?;
        let pose = check_pose(frame)?;
        if frame.depth.camera != self.job.depth {
            check_recalibration(&self.job, frame)?;
            self.recalibrate(frame)?;
        }
        let base = pose.map_from_base.translation_m;
        let resolution_m = self.job.config.resolution_m;
        let window = Window::around(base.x, base.y, resolution_m, self.job.side(), self.window);
        let since_last_s = self.last_stamp_ns.map(|last| seconds_between(last, frame.depth.stamp_ns));
        let map_from_camera = pose.map_from_base.then(pose.base_from_camera);
        let moment = Moment::new(&self.job, frame, window, map_from_camera, since_last_s);
        let moment = Moment { follows: moment.follows && !self.refused, ..moment };
        let mut input = self.executor.begin()?;
        for stage in &self.stages {
            stage.write(&moment, &mut input)?;
        }
        input.submit()?;
        self.window = Some(window);
        self.last_stamp_ns = Some(frame.depth.stamp_ns);
        self.pending.push_back(Pending::new(
            &self.job,
            frame,
            pose,
            window.grid(resolution_m, self.job.side()),
        ));
        Ok(())
    }

    /// Takes a new calibration of the same size, between frames.
    fn recalibrate(&mut self, frame: &RgbdFrame) -> Result<()> {
        self.job.depth = frame.depth.camera;
        self.stages = stages(&self.job);
        self.executor.rewrite_fixed("rays", &back_project::rays(&self.job.depth))
    }
}
