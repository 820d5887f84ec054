//! Labels scans, without a map: the passes of the ground and of glass alone.

use std::time::Duration;

use glam::DVec3;

use crate::base::Rigid;
use crate::base::{Error, Result};
use crate::config::{Config, GroundSource};
use crate::gpu::{Context, Executor, Plan, Store};
use crate::map::glass::LabelledScan;
use crate::map::jumps::PoseTrack;
use crate::map::{Clock, KEPT_PANES, PaneSet};
use crate::sensor::{BeamGrid, Scan, SensorPose};
use crate::stage::glass::{Glass, GlassMoment, MOST_POINTS};
use crate::stage::ground::{self, GroundMoment, Sampled};
use crate::stage::lidar::intensity_layers::POINT_ROW;

/// Points that a labeller is built for at least, and in steps of which it grows.
const CAPACITY_STEP: u32 = 4096;

/// Scans in, labels out, one at a time.
pub struct Labeller {
    config: Config,
    glass: Glass,
    store: Store,
    executor: Executor,
    capacity: u32,
    load: Option<PaneSet>,
    /// Whole metres near the first pose, once there is one.
    origin_m: Option<DVec3>,
    /// Stamp of the first scan.
    began_ns: Option<u64>,
    track: PoseTrack,
}

impl Labeller {
    /// For scans like `first`; built anew where one has more points.
    ///
    /// # Errors
    /// [`Error::Config`]; [`Error::Input`] for a first scan without points; [`Error::NoAdapter`], [`Error::Limit`],
    /// [`Error::Gpu`].
    pub fn open(config: &Config, first: &Scan, adapter: Option<&str>, profiling: bool) -> Result<Self> {
        Self::on(&Context::open(adapter, profiling)?, config, first)
    }

    /// As [`Labeller::open`], on a device that is open already.
    ///
    /// # Errors
    /// As there.
    pub fn on(context: &Context, config: &Config, first: &Scan) -> Result<Self> {
        config.validate()?;
        let capacity = roomy(first.points.len())?;
        let glass = Glass { grid: BeamGrid::of_scan(first)?, load: PaneSet::default() };
        let plan = plan(&glass, config, capacity)?;
        let store = Store::new(context);
        let executor = store.build(plan)?;
        Ok(Self {
            config: config.clone(),
            glass,
            store,
            executor,
            capacity,
            load: None,
            origin_m: None,
            began_ns: None,
            track: PoseTrack::default(),
        })
    }

    /// Panes to begin with, in the map of the poses. They replace all that are kept when the next scan is labelled, if
    /// there are none too.
    ///
    /// # Errors
    /// [`Error::Input`] for more than [`KEPT_PANES`].
    pub fn load(&mut self, set: PaneSet) -> Result<()> {
        if set.panes.len() > KEPT_PANES {
            let reason = format!("{}; at most {KEPT_PANES} are kept", set.panes.len());
            return Err(Error::Input { what: "panes".into(), reason });
        }
        self.load = Some(set);
        Ok(())
    }

    /// Forgets all panes and the last pose.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn reset(&mut self) -> Result<()> {
        (self.track, self.origin_m, self.began_ns) = (PoseTrack::default(), None, None);
        self.executor.reset()
    }

    /// The grid of beams.
    pub fn grid(&self) -> &BeamGrid {
        &self.glass.grid
    }

    /// Builds the passes anew for a scan with more points than fit; panes that are kept stay.
    fn fit(&mut self, points: usize) -> Result<()> {
        if points <= self.capacity as usize {
            return Ok(());
        }
        let capacity = roomy(points)?;
        let plan = plan(&self.glass, &self.config, capacity)?;
        (self.executor, self.capacity) = (self.store.build(plan)?, capacity);
        Ok(())
    }

    /// Labels a scan taken at `map_from_lidar`.
    ///
    /// # Errors
    /// [`Error::Input`] for a pose that is no number or too many points; [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn label(&mut self, scan: &Scan, map_from_lidar: Rigid) -> Result<LabelledScan> {
        if !(map_from_lidar.rotation.is_finite() && map_from_lidar.translation_m.is_finite()) {
            return Err(Error::Input { what: "pose".into(), reason: "is not finite".into() });
        }
        let points = u32::try_from(scan.points.len()).unwrap_or(u32::MAX);
        self.fit(scan.points.len())?;
        let origin_m = *self.origin_m.get_or_insert_with(|| PaneSet::origin_near(map_from_lidar));
        let load = self.load.take().map(|set| set.from_origin(origin_m));
        let local_from_lidar = map_from_lidar.from_origin(origin_m);
        let moment = GlassMoment { points, local_from_lidar, load: load.as_deref() };
        let mut input = self.executor.begin()?;
        input.write("points", bytemuck::cast_slice(&scan.points))?;
        self.glass.write(&self.config, &moment, &mut input)?;
        if self.config.ground == GroundSource::Estimate {
            let began_ns = *self.began_ns.get_or_insert(scan.stamp_ns);
            let since = Duration::from_nanos(scan.stamp_ns.saturating_sub(began_ns));
            let moment = GroundMoment {
                config: &self.config,
                sampled: Sampled::Points(points),
                pose: SensorPose { map_from_base: map_from_lidar, ..SensorPose::SENSOR },
                local_origin_m: origin_m,
                zero_m: origin_m,
                tick: Clock::ticks(since.as_secs_f64()) + 1,
                sensor: 0,
                sensors: 1,
            };
            input.set("ground_params", &ground::params(&moment))?;
        }
        input.submit()?;
        let missing = || Error::Gpu { what: "labels".into(), reason: "nothing was under way".into() };
        let readback = self.executor.receive()?.ok_or_else(missing)?;
        let jumped = self.track.jumps(&self.config, scan.stamp_ns, map_from_lidar);
        LabelledScan::read(&readback, &self.executor, "", scan.points.len(), jumped)
    }
}

/// Points to build for when a scan has `points`.
fn roomy(points: usize) -> Result<u32> {
    let most = u32::try_from(points).unwrap_or(u32::MAX);
    if most > MOST_POINTS {
        let reason = format!("{points} points; glass is searched for among at most {MOST_POINTS}");
        return Err(Error::Input { what: "scan".into(), reason });
    }
    Ok((most + most / 8).next_multiple_of(CAPACITY_STEP).min(MOST_POINTS))
}

/// The plan of a scan.
///
/// # Errors
/// [`Error::Plan`], [`Error::Shader`], [`Error::Input`].
fn plan(glass: &Glass, config: &Config, capacity: u32) -> Result<Plan> {
    let mut plan = Plan::default();
    plan.upload_texture("points", POINT_ROW, (2 * capacity).div_ceil(POINT_ROW))?;
    if config.ground == GroundSource::Estimate {
        ground::append_alone(&mut plan)?;
    }
    glass.append(&mut plan, config, capacity)?;
    for name in ["classes", "panes", "glass_counters"] {
        plan.read_back(name)?;
    }
    plan.check()?;
    Ok(plan)
}
