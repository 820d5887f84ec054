//! The lidar path: the stages of a scan in the order of the paper, on one page.

use std::collections::VecDeque;

use glam::DVec3;

use super::output::{Pending, output};
use super::{MAX_POINTS, ScanFrame, ScanJob, ScanMoment, ScanOptions, ScanOutput, ScanStage};
use crate::base::seconds_between;
use crate::base::{Error, Result};
use crate::config::Config;
use crate::gpu::{Context, Executor, FRAMES_IN_FLIGHT, Plan, Store};
use crate::map::PaneSet;
use crate::map::Window;
use crate::map::jumps::PoseTrack;
use crate::map::pane_file::read_panes;
use crate::sensor::BeamGrid;
use crate::sensor::Scan;
use crate::stage::glass::pane_cells;
use crate::stage::glass::{Glass, MOST_POINTS};
use crate::stage::lidar::intensity_layers::POINT_ROW;
use crate::stage::lidar::planes::{full_scale, plane_rings};
use crate::stage::lidar::{intensity_classes, intensity_layers};
use crate::stage::map::{goal_inflation, plan_map};

/// Points that a pipeline is built for at least, and in steps of which it grows.
const CAPACITY_STEP: usize = 1 << 14;

/// The stages of one scan, in order (spec 2 §2 to §4).
pub fn stages(job: &ScanJob) -> Vec<Box<dyn ScanStage>> {
    let mut stages: Vec<Box<dyn ScanStage>> = Vec::new();
    if let Some(glass) = &job.glass {
        stages.push(Box::new(glass.clone()));
    }
    stages.push(Box::new(intensity_layers::IntensityLayers));
    stages.push(Box::new(intensity_classes::IntensityClasses));
    if job.glass.is_some() {
        stages.push(Box::new(pane_cells::PaneCells));
    }
    stages.push(Box::new(goal_inflation::GoalInflation));
    stages.push(Box::new(plan_map::PlanMap));
    stages
}

/// The plan of a scan, with what is to be read back.
///
/// # Errors
/// [`crate::Error::Plan`] or [`crate::Error::Shader`] where a stage contradicts its shader or its neighbours.
pub fn plan(job: &ScanJob, stages: &[Box<dyn ScanStage>]) -> Result<Plan> {
    let mut plan = Plan::default();
    plan.upload_texture("points", POINT_ROW, (2 * job.capacity).div_ceil(POINT_ROW))?;
    for stage in stages {
        stage.append(&mut plan, job)?;
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

/// Scans in, plan maps out, with up to three scans under way.
pub struct ScanPipeline {
    job: ScanJob,
    stages: Vec<Box<dyn ScanStage>>,
    store: Store,
    executor: Executor,
    window: Option<Window>,
    /// Whole metres near the first pose, once there is one.
    origin_m: Option<DVec3>,
    track: PoseTrack,
    pending: VecDeque<Pending>,
    /// Results taken from an executor that was replaced by a larger one.
    ready: VecDeque<ScanOutput>,
}

impl ScanPipeline {
    /// Builds the pipeline for scans like `first` (number of points, rings, intensities).
    ///
    /// # Errors
    /// [`Error::Config`], [`Error::Input`] for a first scan that is too large or lacks what the configuration asks for,
    /// [`Error::NoAdapter`], [`Error::Limit`], [`Error::Gpu`].
    pub fn open(config: &Config, first: &ScanFrame, options: &ScanOptions) -> Result<Self> {
        config.validate()?;
        let job = ScanJob {
            config: config.clone(),
            capacity: capacity(first.scan.points.len(), most_points(config.glass))?,
            full_scale: full_scale(config, &first.scan)?,
            plane_rings: plane_rings(config, &first.scan)?,
            deskew: config.deskew && first.scan.columns.time,
            layers: options.layers,
            glass: glass(config, &first.scan)?,
        };
        let stages = stages(&job);
        let plan = plan(&job, &stages)?;
        let store = Store::new(&Context::open(options.adapter.as_deref(), options.profiling)?);
        let executor = store.build(plan)?;
        let (pending, ready, track) = (VecDeque::new(), VecDeque::new(), PoseTrack::default());
        Ok(Self { job, stages, store, executor, window: None, origin_m: None, track, pending, ready })
    }

    /// Starts a scan; returns at once. Receive first when [`ScanPipeline::is_full`].
    ///
    /// # Errors
    /// [`Error::Input`] where the pose is missing or no numbers or the scan has more than [`MAX_POINTS`] points, or [`MOST_POINTS`] with glass (the map
    /// stays as it was); [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn submit(&mut self, frame: &ScanFrame) -> Result<()> {
        let pose = frame.pose.ok_or_else(|| bad_input("pose", "no transform from map to lidar".into()))?;
        let finite = |m: crate::base::Rigid| m.rotation.is_finite() && m.translation_m.is_finite();
        if !(finite(pose.map_from_base) && finite(pose.base_from_lidar)) {
            return Err(bad_input("pose", "is not finite".into()));
        }
        self.fit(frame.scan.points.len())?;
        let (resolution_m, side) = (self.job.config.scan_resolution_m, self.job.side());
        let base = pose.map_from_base.translation_m;
        let window = Window::around(base.x, base.y, resolution_m, side, self.window);
        let origin_m = self.origin_m.unwrap_or_else(|| PaneSet::origin_near(pose.map_from_lidar()));
        let since_last_s = self.track.last_stamp_ns().map(|last| seconds_between(last, frame.scan.stamp_ns));
        let moment = ScanMoment::new(&self.job, frame, pose, window, origin_m, since_last_s);
        let mut input = self.executor.begin()?;
        input.write("points", bytemuck::cast_slice(&frame.scan.points))?;
        for stage in &self.stages {
            stage.write(&moment, &mut input)?;
        }
        input.submit()?;
        (self.window, self.origin_m) = (Some(window), Some(origin_m));
        let jumped = self.track.jumps(&self.job.config, frame.scan.stamp_ns, pose.map_from_lidar());
        self.pending.push_back(Pending::new(frame, &moment, window.grid(resolution_m, side), jumped));
        Ok(())
    }

    /// Builds the pipeline anew for a scan with more points than fit; what is kept from scan to scan stays.
    fn fit(&mut self, points: usize) -> Result<()> {
        if points <= self.job.capacity as usize {
            return Ok(());
        }
        let job = ScanJob {
            capacity: capacity(points, most_points(self.job.glass.is_some()))?,
            ..self.job.clone()
        };
        while let Some(output) = self.receive_submitted()? {
            self.ready.push_back(output);
        }
        let stages = stages(&job);
        let plan = plan(&job, &stages)?;
        let executor = self.store.build(plan)?;
        (self.job, self.stages, self.executor) = (job, stages, executor);
        Ok(())
    }

    fn receive_submitted(&mut self) -> Result<Option<ScanOutput>> {
        let Some(readback) = self.executor.receive()? else { return Ok(None) };
        let pending = self.pending.pop_front();
        pending.map(|pending| output(pending, &readback, &self.executor, &self.job)).transpose()
    }

    /// Waits for the oldest scan under way; `None` when there is none.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn receive(&mut self) -> Result<Option<ScanOutput>> {
        match self.ready.pop_front() {
            Some(output) => Ok(Some(output)),
            None => self.receive_submitted(),
        }
    }

    /// Whether as many scans are under way as may be.
    pub fn is_full(&self) -> bool {
        self.ready.len() + self.executor.in_flight() >= FRAMES_IN_FLIGHT
    }

    /// What the pipeline was built for, the full scale and the rings it chose included.
    pub fn job(&self) -> &ScanJob {
        &self.job
    }

    /// The plan as built, and the device it runs on.
    pub fn executor(&self) -> &Executor {
        &self.executor
    }
}

/// Where glass is searched for: the sensor's beams and the panes to begin with.
fn glass(config: &Config, first: &Scan) -> Result<Option<Glass>> {
    if !config.glass {
        return Ok(None);
    }
    let load = match config.glass_panes.as_str() {
        "" => PaneSet::default(),
        path => read_panes(path.as_ref())?,
    };
    Ok(Some(Glass { grid: BeamGrid::of_scan(first)?, load }))
}

/// Most points of a scan, with glass or without.
fn most_points(glass: bool) -> usize {
    if glass { MOST_POINTS as usize } else { MAX_POINTS }
}

/// Points to build for when a scan has `points` of at most `most`.
fn capacity(points: usize, most: usize) -> Result<u32> {
    if points > most {
        let reason = match most {
            MAX_POINTS => format!("{points} points; at most {most} are supported"),
            _ => format!("{points} points; glass is searched for among at most {most}"),
        };
        return Err(bad_input("scan", reason));
    }
    let roomy = (points + points / 8).next_multiple_of(CAPACITY_STEP).clamp(CAPACITY_STEP, most);
    u32::try_from(roomy).map_err(|_| bad_input("scan", "is too large".into()))
}

fn bad_input(what: &str, reason: String) -> Error {
    Error::Input { what: what.into(), reason }
}
