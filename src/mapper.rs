//! The mapper: the stages of a camera frame, of a scan and of a published map, in the order of the papers, on one page; and
//! what runs them: observations in, one map out.

mod build;
mod channel;
mod checks;
mod read;

use std::collections::VecDeque;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use self::build::{Kind, camera_job, lidar_job};
use self::channel::Channel;
pub(crate) use self::checks::frame as check_frame;
use crate::base::{Error, Refused, Result, duration_ns};
pub use crate::config::SensorInfo;
use crate::config::{Config, Method};
use crate::gpu::{Context, Executor, FRAMES_IN_FLIGHT, Plan, Store};
use crate::map::{Clock, PaneSet, Update, Window};
use crate::sensor::{Observation, SensorModel, SensorPose};
use crate::stage::camera::{back_project, drm, ingest, see_through, spatial_median, tally, update, weigh};
use crate::stage::glass::{LabelGlass, pane_cells};
use crate::stage::lidar::{intensity_classes, intensity_layers};
use crate::stage::map::{goal_inflation, inflate, move_window, plan_map};
use crate::stage::{CameraJob, LidarJob, Moment, Stage, color_stage};

/// The stages of a camera's frame, in order (spec 1 §1 to §3: reliability, move window, update, hysteresis, inflate).
pub fn camera_stages(job: &Arc<CameraJob>) -> Vec<Box<dyn Stage>> {
    let of = || Arc::clone(job);
    let mut stages: Vec<Box<dyn Stage>> = vec![Box::new(ingest::Ingest { job: of() })];
    if job.config.method == Method::Median {
        stages.push(Box::new(spatial_median::SpatialMedian { job: of() }));
    }
    let color = color_stage(job);
    let (color, shown_color) = if job.drm.is_some() { (color, None) } else { (None, color) };
    stages.extend(color);
    if let Some(drm) = &job.drm {
        stages.push(Box::new(drm::DrmNet { job: of(), drm: drm.clone() }));
    }
    if job.confidence {
        stages.push(Box::new(weigh::Weigh { job: of() }));
    }
    stages.push(Box::new(move_window::MoveWindow { job: of() }));
    stages.push(Box::new(back_project::BackProject { job: of() }));
    stages.push(Box::new(see_through::SeeThrough::new(job)));
    stages.push(Box::new(update::Update { job: of() }));
    stages.push(Box::new(inflate::Inflate { job: of() }));
    stages.push(Box::new(tally::Tally { job: of() }));
    stages.extend(shown_color);
    stages
}

/// The stages of a lidar's scan, in order (spec 3; spec 2 §2 to §4).
pub fn lidar_stages(job: &Arc<LidarJob>) -> Vec<Box<dyn Stage>> {
    let of = || Arc::clone(job);
    let mut stages: Vec<Box<dyn Stage>> = Vec::new();
    if let Some(glass) = &job.glass {
        stages.push(Box::new(LabelGlass { job: of(), glass: glass.clone() }));
    }
    stages.push(Box::new(intensity_layers::IntensityLayers { job: of() }));
    stages.push(Box::new(intensity_classes::IntensityClasses { job: of() }));
    if job.glass.is_some() {
        stages.push(Box::new(pane_cells::PaneCells { job: of() }));
    }
    stages.push(Box::new(goal_inflation::GoalInflation { job: of() }));
    stages.push(Box::new(plan_map::PlanMap { job: of() }));
    stages
}

/// The plan of a camera's frame, with what is to be read back.
///
/// # Errors
/// [`Error::Plan`] or [`Error::Shader`] where a stage contradicts its shader or its neighbours.
pub fn camera_plan(job: &CameraJob, stages: &[Box<dyn Stage>]) -> Result<Plan> {
    let mut plan = Plan::default();
    plan.fixed("rays", back_project::rays(&job.depth))?;
    for stage in stages {
        stage.append(&mut plan)?;
    }
    let images = [job.depth_buffer(), "reliability"].into_iter().chain(job.color.map(|_| "color"));
    let layers = ["evidence", "occupancy", "state"];
    for name in images.filter(|_| job.images).chain(layers.into_iter().filter(|_| job.layers)) {
        plan.read_back(name)?;
    }
    plan.check()?;
    Ok(plan)
}

/// The plan of a lidar's scan, with what is to be read back.
///
/// # Errors
/// As [`camera_plan`].
pub fn lidar_plan(job: &LidarJob, stages: &[Box<dyn Stage>]) -> Result<Plan> {
    let mut plan = Plan::default();
    intensity_layers::upload_points(&mut plan, job.capacity)?;
    for stage in stages {
        stage.append(&mut plan)?;
    }
    let products = ["layer_values", "cell_values"];
    for name in ["plan_costs", "plan_classes"].into_iter().chain(products.into_iter().filter(|_| job.layers))
    {
        plan.read_back(name)?;
    }
    for name in ["classes", "panes", "glass_counters"].into_iter().filter(|_| job.glass.is_some()) {
        plan.read_back(name)?;
    }
    plan.check()?;
    Ok(plan)
}

/// What a mapper runs on, and what it reads back beside the map.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Part of the adapter's name; `None`: `LIMPID_ADAPTER`, else the best.
    pub adapter: Option<String>,
    /// Whether passes are timed.
    pub profiling: bool,
    /// Whether depth, reliability and colour images are read back.
    pub images: bool,
    /// Whether the grids beside the map are read back.
    pub layers: bool,
}

/// What became of an observation that was given to the mapper.
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub enum Submitted {
    /// It is under way.
    Taken,
    /// It was not taken; the map stays as it was.
    Refused(Refused),
}

/// Observations in, maps out, with up to three of a sensor under way. It is `Send`, and blocks in [`Mapper::wait`] alone.
pub struct Mapper {
    context: Context,
    channels: Vec<Channel>,
    resolution_m: f64,
    side: u32,
    window: Option<Window>,
    /// Whole metres near the first pose, once there is one.
    local_origin_m: Option<DVec3>,
    clock: Clock,
    /// Channels in the order of what is under way.
    order: VecDeque<usize>,
}

impl Mapper {
    /// Builds the passes for `sensors`, which share the map of `config`: all that is compiled and allocated is so here.
    ///
    /// # Errors
    /// [`Error::Config`], [`Error::Decode`] for impossible intrinsics, [`Error::NoAdapter`], [`Error::Limit`], [`Error::Gpu`].
    pub fn open(config: &Config, sensors: &[SensorInfo], options: &Options) -> Result<Self> {
        Self::on(&Context::open(options.adapter.as_deref(), options.profiling)?, config, sensors, options)
    }

    /// As [`Mapper::open`], on a device that is open already.
    ///
    /// # Errors
    /// As there.
    pub fn on(context: &Context, config: &Config, sensors: &[SensorInfo], options: &Options) -> Result<Self> {
        config.validate()?;
        let lidars_only = sensors.iter().all(|sensor| matches!(sensor.model, SensorModel::Lidar(_)));
        let (resolution_m, side) = if lidars_only {
            (config.scan_resolution_m, config.scan_cells_per_side()?)
        } else {
            (config.resolution_m, config.cells_per_side()?)
        };
        let store = Store::new(context);
        let channel = |sensor: &SensorInfo| {
            sensor.config.validate()?;
            let kind = match &sensor.model {
                SensorModel::Camera(info) => Kind::camera(camera_job(sensor, info, options, context, side)?)?,
                SensorModel::Lidar(info) => Kind::lidar(lidar_job(sensor, info, options, side)?)?,
                SensorModel::Missing(_) => return Ok(Channel::missing(sensor)),
            };
            Channel::build(sensor, kind, &store)
        };
        let channels = sensors.iter().map(channel).collect::<Result<Vec<_>>>()?;
        let timeouts_ns: Vec<u64> = sensors.iter().map(|sensor| duration_ns(sensor.timeout_s)).collect();
        Ok(Self {
            context: context.clone(),
            clock: Clock::new(&timeouts_ns),
            channels,
            resolution_m,
            side,
            window: None,
            local_origin_m: None,
            order: VecDeque::new(),
        })
    }

    /// Starts an observation; returns at once. Take results first where [`Mapper::is_full`].
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`]; an observation that cannot be taken is none, but [`Submitted::Refused`].
    pub fn submit(&mut self, observation: &Observation) -> Result<Submitted> {
        match self.checked(observation) {
            Ok(pose) => self.start(observation, pose).map(|()| Submitted::Taken),
            Err(reason) => {
                if let Some(channel) = self.channels.get_mut(observation.sensor) {
                    channel.refused = true;
                }
                Ok(Submitted::Refused(reason))
            }
        }
    }

    fn checked(&mut self, observation: &Observation) -> std::result::Result<SensorPose, Refused> {
        let channel = self.channels.get_mut(observation.sensor);
        let channel = channel.ok_or_else(|| Refused::Sensor(format!("no sensor {}", observation.sensor)))?;
        channel.check(observation)?;
        checks::pose(observation)
    }

    fn start(&mut self, observation: &Observation, pose: SensorPose) -> Result<()> {
        let stamp_ns = observation.stamp_ns();
        let base = pose.map_from_base.translation_m;
        let window = Window::around(base.x, base.y, self.resolution_m, self.side, self.window);
        let local_origin_m =
            *self.local_origin_m.get_or_insert_with(|| PaneSet::origin_near(pose.map_from_sensor()));
        let channel = &mut self.channels[observation.sensor];
        let moment = Moment {
            observation: Some(observation),
            pose,
            window,
            grid: window.grid(self.resolution_m, self.side),
            since_last_s: channel.since_last_s(stamp_ns),
            follows: !channel.refused,
            local_origin_m,
            towards_goal: towards_goal(&channel.config, observation, pose, self.resolution_m),
        };
        channel.start(&moment, observation)?;
        self.window = Some(window);
        self.clock.observe(observation.sensor, stamp_ns);
        self.order.push_back(observation.sensor);
        Ok(())
    }

    /// The next result, if it is there; never waits.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn poll(&mut self) -> Result<Option<Update>> {
        let Some(&next) = self.order.front() else { return Ok(None) };
        let taken = self.channels[next].poll();
        self.count(taken)
    }

    /// The next result; waits for it, at most a minute. `None` where nothing is under way.
    ///
    /// # Errors
    /// [`Error::Gpu`], also where it does not end in time: that result is given up, and those after it can still be had;
    /// [`Error::DeviceLost`].
    pub fn wait(&mut self) -> Result<Option<Update>> {
        let Some(&next) = self.order.front() else { return Ok(None) };
        let taken = self.channels[next].wait();
        self.count(taken)
    }

    /// Submits an observation and waits for its result, for tools that go step by step.
    ///
    /// # Errors
    /// Those of [`Mapper::submit`] and [`Mapper::wait`]; [`Error::Input`] where it was refused.
    pub fn step(&mut self, observation: &Observation) -> Result<Update> {
        if let Submitted::Refused(reason) = self.submit(observation)? {
            return Err(Error::Input { what: "observation".into(), reason: reason.to_string() });
        }
        let lost = || Error::Gpu { what: "observation".into(), reason: "nothing came back".into() };
        self.wait()?.ok_or_else(lost)
    }

    fn count(&mut self, taken: Result<Option<Update>>) -> Result<Option<Update>> {
        if !matches!(taken, Ok(None)) {
            self.order.pop_front();
        }
        taken
    }

    /// Whether as many observations of a sensor are under way as may be.
    pub fn is_full(&self, sensor: usize) -> bool {
        self.channels.get(sensor).is_some_and(|channel| channel.in_flight() >= FRAMES_IN_FLIGHT)
    }

    /// How many observations are under way.
    pub fn in_flight(&self) -> usize {
        self.order.len()
    }

    /// The device.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// The passes of a sensor, and what they run on.
    pub fn executor(&self, sensor: usize) -> Option<&Executor> {
        self.channels.get(sensor)?.executor()
    }

    /// What was decided when the passes were built, in words, for each sensor.
    pub fn notes(&self) -> Vec<String> {
        self.channels.iter().flat_map(Channel::notes).collect()
    }
}

/// The goal's direction; that of the robot's x axis without a goal; `None` within a cell of the goal.
fn towards_goal(
    config: &Config,
    observation: &Observation,
    pose: SensorPose,
    resolution_m: f64,
) -> Option<DVec2> {
    let stated = match config.goal_m[..] {
        [x, y] => Some(DVec2::new(x, y)),
        _ => None,
    };
    let way = match observation.goal_m.or(stated) {
        Some(goal_m) => {
            let way_m = goal_m - pose.map_from_base.translation_m.truncate();
            (way_m.length() > resolution_m).then_some(way_m)?
        }
        None => (pose.map_from_base.rotation * DVec3::X).truncate(),
    };
    way.try_normalize()
}
