//! A sensor's way into the map: its passes, what they keep in mind between observations, and what is under way.

use std::collections::VecDeque;
use std::sync::Arc;

use glam::DVec2;

use super::build::{Kind, Program};
use super::stages::image_buffers;
use super::{SensorInfo, camera_stages, checks};
use crate::base::{Error, Refused, Result, Rigid, seconds_between};
use crate::config::{Config, SensorConfig};
use crate::gpu::{Executor, Readback, Store};
use crate::map::jumps::PoseTrack;
use crate::map::{Grid, State, Update, Window};
use crate::sensor::{Observation, SensorKind, SensorPose};
use crate::stage::camera::back_project;
use crate::stage::camera::color::usable_color;
use crate::stage::lidar::trust::IntensityTrust;
use crate::stage::{CameraJob, Moment, Stage};

/// What is remembered of an observation while it is under way.
#[derive(Debug, Clone)]
pub(super) struct Pending {
    /// `None`: the map is published.
    pub(super) sensor: Option<usize>,
    pub(super) index: u64,
    pub(super) stamp_ns: u64,
    pub(super) map_frame: String,
    pub(super) pose: SensorPose,
    pub(super) grid: Grid,
    pub(super) towards_goal: Option<DVec2>,
    /// What the clock said of the sensors.
    pub(super) states: Vec<State>,
    /// Why a frame is fused by depth alone, where method auto is drm.
    pub(super) depth_alone: Option<String>,
    /// Whether images come back.
    pub(super) images: bool,
    /// Of a scan.
    pub(super) points: usize,
    pub(super) pose_jumped: bool,
}

/// A published map's number, time and frame.
pub(super) struct Published {
    pub(super) index: u64,
    pub(super) stamp_ns: u64,
    pub(super) map_frame: String,
}

/// The passes of a sensor as built.
pub(super) struct Built {
    pub(super) kind: Kind,
    stages: Vec<Box<dyn Stage>>,
    pub(super) executor: Executor,
}

/// See the module.
pub(super) struct Channel {
    pub(super) name: String,
    pub(super) config: Config,
    /// `None`: nothing of the sensor came when the mapper was built.
    built: Option<Built>,
    track: PoseTrack,
    trust: IntensityTrust,
    last_stamp_ns: Option<u64>,
    last_window: Option<Window>,
    /// Whether the observation before was refused.
    pub(super) refused: bool,
    /// Whether images are read back, where that was built.
    pub(super) images: bool,
    pending: VecDeque<Pending>,
}

impl Channel {
    pub(super) fn build(sensor: &SensorInfo, program: Program, store: &Store) -> Result<Self> {
        let Program { kind, stages, plan } = program;
        let built = Built { kind, stages, executor: store.build(plan)? };
        Ok(Self { built: Some(built), ..Self::missing(sensor) })
    }

    /// That of the map of several sensors.
    pub(super) fn of_map(config: &Config, program: Program, store: &Store) -> Result<Self> {
        let kind = SensorKind::Camera;
        let nobody =
            SensorInfo::missing(SensorConfig { name: "map".into(), ..SensorConfig::found(kind, config) });
        Self::build(&nobody, program, store)
    }

    pub(super) fn missing(sensor: &SensorInfo) -> Self {
        Self {
            name: sensor.name.clone(),
            config: sensor.config.clone(),
            built: None,
            track: PoseTrack::default(),
            trust: IntensityTrust::default(),
            last_stamp_ns: None,
            last_window: None,
            refused: false,
            images: true,
            pending: VecDeque::new(),
        }
    }

    pub(super) fn in_flight(&self) -> usize {
        self.pending.len()
    }

    pub(super) fn executor(&self) -> Option<&Executor> {
        self.built.as_ref().map(|built| &built.executor)
    }

    /// Seconds since the observation before; `None` for the first.
    pub(super) fn since_last_s(&self, stamp_ns: u64) -> Option<f64> {
        self.last_stamp_ns.map(|last_ns| seconds_between(last_ns, stamp_ns))
    }

    /// The window as it moved since the observation before.
    pub(super) fn own_window(&self, window: Window, side: u32) -> Window {
        window.since(self.last_window, side)
    }

    /// Takes in the intensities of a scan that was checked: whether what stands in it is solid, as they say nothing.
    pub(super) fn stands(&mut self, observation: &Observation, pose: SensorPose) -> bool {
        match (self.built.as_ref().map(|built| &built.kind), observation.scan()) {
            (Some(Kind::Lidar(job)), Some(scan)) => self.trust.stands(job, scan, pose),
            _ => false,
        }
    }

    /// Whether the observation fits what the passes were built for.
    pub(super) fn check(&self, observation: &Observation) -> std::result::Result<(), Refused> {
        let missing = || Refused::Sensor(format!("`{}` was missing then", self.name));
        let built = self.built.as_ref().ok_or_else(missing)?;
        match (&built.kind, observation.frame(), observation.scan()) {
            (Kind::Camera(job), Some(frame), _) => checks::frame(job, frame)?,
            (Kind::Lidar(job), _, Some(scan)) => {
                let (points, most) = (scan.points.len(), job.capacity as usize);
                if points > most {
                    return Err(Refused::TooManyPoints { points, most });
                }
            }
            _ => return Err(Refused::Sensor(format!("`{}` is of the other kind", self.name))),
        }
        built.stages.iter().try_for_each(|stage| stage.check(observation))
    }

    /// Writes and submits an observation that was checked.
    pub(super) fn start(
        &mut self,
        moment: &Moment<'_>,
        observation: &Observation,
        states: Vec<State>,
    ) -> Result<()> {
        let missing = || Error::Plan { pass: self.name.clone(), reason: "has no passes".into() };
        let built = self.built.as_mut().ok_or_else(missing)?;
        built.recalibrate(observation)?;
        built.submit(moment, self.images)?;
        let (stamp_ns, map_from_sensor) = (observation.stamp_ns(), moment.pose.map_from_sensor());
        self.pending.push_back(Pending {
            sensor: Some(observation.sensor),
            index: observation.index(),
            stamp_ns: built.oldest_ns(observation),
            map_frame: observation.map_frame.clone(),
            pose: moment.pose,
            grid: moment.grid,
            towards_goal: moment.towards_goal,
            states,
            depth_alone: built.depth_alone(observation),
            images: self.images,
            points: observation.scan().map_or(0, |scan| scan.points.len()),
            pose_jumped: self.track.jumps(&self.config, stamp_ns, map_from_sensor),
        });
        self.last_stamp_ns = Some(stamp_ns);
        self.last_window = Some(moment.window);
        self.refused = false;
        Ok(())
    }

    /// Writes and submits the publication of the map.
    pub(super) fn publish(&mut self, moment: &Moment<'_>, of: Published, states: Vec<State>) -> Result<()> {
        let missing = || Error::Plan { pass: self.name.clone(), reason: "has no passes".into() };
        self.built.as_mut().ok_or_else(missing)?.submit(moment, true)?;
        let Published { index, stamp_ns, map_frame } = of;
        self.pending.push_back(Pending {
            sensor: None,
            index,
            stamp_ns,
            map_frame,
            pose: SensorPose { base_from_sensor: Rigid::IDENTITY, sweep: None, ..moment.pose },
            grid: moment.grid,
            towards_goal: moment.towards_goal,
            states,
            depth_alone: None,
            images: false,
            points: 0,
            pose_jumped: false,
        });
        Ok(())
    }

    /// The oldest result, if it is there.
    pub(super) fn poll(&mut self) -> Result<Option<Update>> {
        let Some(built) = self.built.as_mut() else { return Ok(None) };
        match built.executor.try_receive() {
            Ok(None) => Ok(None),
            received => self.take(received),
        }
    }

    /// The oldest result, waited for.
    pub(super) fn wait(&mut self) -> Result<Option<Update>> {
        let Some(built) = self.built.as_mut() else { return Ok(None) };
        let received = built.executor.receive();
        self.take(received)
    }

    /// What was received, with what is remembered of it: a result that is given up takes its memory along, so that the
    /// next bears its own stamp and pose.
    fn take(&mut self, received: Result<Option<Readback>>) -> Result<Option<Update>> {
        let pending = self.pending.pop_front();
        match (received?, pending, &self.built) {
            (Some(readback), Some(pending), Some(built)) => built.update(pending, &readback).map(Some),
            _ => Ok(None),
        }
    }

    /// What was decided when the passes were built and since, in words.
    pub(super) fn notes(&self) -> Vec<String> {
        self.built.as_ref().map(|built| built.notes(&self.trust)).unwrap_or_default()
    }
}

impl Built {
    fn submit(&mut self, moment: &Moment<'_>, images: bool) -> Result<()> {
        let mut input = self.executor.begin()?;
        input.enter(self.kind.scope());
        if let Kind::Camera(job) = &self.kind
            && !images
        {
            image_buffers(job).try_for_each(|name| input.leave(name))?;
        }
        for stage in &self.stages {
            stage.write(moment, &mut input)?;
        }
        input.submit()
    }

    /// Takes a new calibration of the same size, between frames.
    fn recalibrate(&mut self, observation: &Observation) -> Result<()> {
        let (Kind::Camera(job), Some(frame)) = (&self.kind, observation.frame()) else { return Ok(()) };
        if job.depth == frame.depth.camera {
            return Ok(());
        }
        let job = Arc::new(CameraJob { depth: frame.depth.camera, ..(**job).clone() });
        self.stages = camera_stages(&job);
        self.executor.rewrite_fixed(&job.scope, "rays", &back_project::rays(&job.depth))?;
        self.kind = Kind::Camera(job);
        Ok(())
    }

    /// Why a frame is fused by depth alone, where method auto is drm.
    fn depth_alone(&self, observation: &Observation) -> Option<String> {
        match (&self.kind, observation.frame()) {
            (Kind::Camera(job), Some(frame)) if job.drm.is_some() => usable_color(job, frame).err(),
            _ => None,
        }
    }

    /// Stamp of the oldest data used: a colour image counts where the passes use it.
    fn oldest_ns(&self, observation: &Observation) -> u64 {
        let color_ns = match (&self.kind, observation.frame()) {
            (Kind::Camera(job), Some(frame)) => usable_color(job, frame).ok().map(|color| color.stamp_ns),
            _ => None,
        };
        observation.stamp_ns().min(color_ns.unwrap_or(u64::MAX))
    }

    /// See [`Channel::notes`].
    fn notes(&self, trust: &IntensityTrust) -> Vec<String> {
        match &self.kind {
            Kind::Camera(_) | Kind::Map(_) => Vec::new(),
            Kind::Lidar(job) => {
                let planes = match job.plane_rings {
                    Some([plane, below]) => format!("planes z = 0 and below it: rings {plane} and {below}"),
                    None => "planes z = 0 and below it: slabs".into(),
                };
                let deskew = if job.deskew {
                    "points are placed by the poses at their own times, where there are poses"
                } else if job.config.deskew {
                    "points are not deskewed: scans have no times of points that can be used"
                } else {
                    "points are not deskewed (deskew: false)"
                };
                vec![trust.note(job), planes, deskew.into()]
            }
        }
    }
}
