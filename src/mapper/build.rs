//! What the passes of a sensor are built for, from its parameters and from what is known of it.

use std::sync::Arc;

use super::{Options, SensorInfo, camera_plan, camera_stages, lidar_plan, lidar_stages};
use crate::base::{Error, Result};
use crate::config::{Config, MAX_POINTS, Method};
use crate::gpu::{Context, Plan};
use crate::map::PaneSet;
use crate::map::pane_file::read_panes;
use crate::network::Backend;
use crate::network::weights::Network;
use crate::sensor::{BeamGrid, CameraInfo, LidarInfo, Scan};
use crate::stage::camera::drm::Drm;
use crate::stage::glass::{Glass, MOST_POINTS};
use crate::stage::lidar::planes::{full_scale, plane_rings};
use crate::stage::{CameraJob, LidarJob, Stage};

/// The passes of a sensor, by its kind.
pub(super) enum Kind {
    Camera(Arc<CameraJob>),
    Lidar(Arc<LidarJob>),
}

/// A kind with its stages and their plan.
pub(super) struct Program {
    pub(super) kind: Kind,
    pub(super) stages: Vec<Box<dyn Stage>>,
    pub(super) plan: Plan,
}

impl Kind {
    pub(super) fn camera(job: CameraJob) -> Result<Program> {
        let job = Arc::new(job);
        let stages = camera_stages(&job);
        let plan = camera_plan(&job, &stages)?;
        Ok(Program { kind: Self::Camera(job), stages, plan })
    }

    pub(super) fn lidar(job: LidarJob) -> Result<Program> {
        let job = Arc::new(job);
        let stages = lidar_stages(&job);
        let plan = lidar_plan(&job, &stages)?;
        Ok(Program { kind: Self::Lidar(job), stages, plan })
    }
}

pub(super) fn camera_job(
    sensor: &SensorInfo,
    info: &CameraInfo,
    options: &Options,
    context: &Context,
    side: u32,
) -> Result<CameraJob> {
    info.depth.validate()?;
    let config = sensor.config.resolved(info.color.is_some());
    let drm = load_drm(&config, info, context)?;
    Ok(CameraJob {
        depth: info.depth,
        float_depth: info.float_depth,
        color: info.color.filter(|_| options.images || drm.is_some()),
        color_aligned: info.color_aligned,
        confidence: info.confidence || !config.confidence_topic.is_empty(),
        drm,
        images: options.images,
        layers: options.layers,
        config,
        side,
    })
}

/// The network of method drm; `None` for the others.
fn load_drm(config: &Config, info: &CameraInfo, context: &Context) -> Result<Option<Drm>> {
    if config.method != Method::Drm {
        return Ok(None);
    }
    if info.color.is_none() {
        let reason =
            "drm needs colour images, and none with a calibration is among the first frames (range does not)";
        return Err(Error::Config { key: "method".into(), reason: reason.into() });
    }
    let network = match config.weights.as_str() {
        "" => Network::shipped()?,
        file => Network::read(std::path::Path::new(file))?,
    };
    Ok(Some(Drm { network: Arc::new(network), backend: Backend::of(context) }))
}

pub(super) fn lidar_job(
    sensor: &SensorInfo,
    info: &LidarInfo,
    options: &Options,
    side: u32,
) -> Result<LidarJob> {
    let config = &sensor.config;
    Ok(LidarJob {
        capacity: capacity(config, &info.first)?,
        full_scale: full_scale(config, &info.first)?,
        plane_rings: plane_rings(config, &info.first)?,
        deskew: config.deskew && info.first.columns.time,
        layers: options.layers,
        glass: glass(config, &info.first)?,
        config: config.clone(),
        side,
    })
}

/// Points to build for: enough for scans somewhat larger than the first.
fn capacity(config: &Config, first: &Scan) -> Result<u32> {
    let most = if config.glass { MOST_POINTS } else { MAX_POINTS } as usize;
    let points = first.points.len();
    if points > most {
        let reason = match config.glass {
            true => format!("{points} points; glass is searched for among at most {most}"),
            false => format!("{points} points; at most {most} are supported"),
        };
        return Err(Error::Decode { what: "scan".into(), reason });
    }
    let roomy = (points + points / 8).max(config.max_points as usize).min(most);
    u32::try_from(roomy).map_err(|e| Error::Decode { what: "scan".into(), reason: e.to_string() })
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
