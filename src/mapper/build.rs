//! What the passes of a sensor are built for, from its parameters and from what is known of it.

use std::sync::Arc;

use super::weights::{load_drm, load_map_reliability, load_solidity};
use super::{
    Options, SensorInfo, camera_plan, camera_stages, lidar_plan, lidar_stages, map_plan, map_stages,
};
use crate::base::{Error, Result};
use crate::config::{Config, Fusion, GroundSource, MAX_POINTS, Method};
use crate::gpu::{Context, Plan};
use crate::map::PaneSet;
use crate::map::pane_file::read_panes;
use crate::sensor::{BeamGrid, CameraInfo, LidarInfo, Scan, SensorModel};
use crate::stage::camera::map_reliability::knows_cells_of;
use crate::stage::glass::{Glass, MOST_POINTS};
use crate::stage::lidar::planes::{full_scale, plane_rings};
use crate::stage::map::layers::Layers;
use crate::stage::{CameraJob, LidarJob, MapJob, Stage};

/// The passes of a sensor, by its kind.
pub(super) enum Kind {
    Camera(Arc<CameraJob>),
    Lidar(Arc<LidarJob>),
    /// The map of several sensors.
    Map(Arc<MapJob>),
}

/// A kind with its stages and their plan.
pub(super) struct Program {
    pub(super) kind: Kind,
    pub(super) stages: Vec<Box<dyn Stage>>,
    pub(super) plan: Plan,
}

impl Kind {
    /// In which scope its buffers are named.
    pub(super) fn scope(&self) -> &str {
        match self {
            Self::Camera(job) => &job.scope,
            Self::Lidar(job) => &job.scope,
            Self::Map(_) => "",
        }
    }

    /// The stated ground, where it is estimated.
    pub(super) fn ground_z_m(&self) -> Option<f64> {
        let config = match self {
            Self::Camera(job) => &job.config,
            Self::Lidar(job) => &job.config,
            Self::Map(_) => return None,
        };
        (config.ground == GroundSource::Estimate).then_some(config.ground_z_m)
    }

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

/// What the map of these sensors is built for, published apart where there are several or it is live: those that are missing
/// take no part. Lidars alone have a map of `scan_resolution_m` and `scan_map_size_m`; where there is a camera, the map's own hold for lidars too.
pub(super) fn map_job(config: &Config, sensors: &[SensorInfo], options: &Options) -> Result<MapJob> {
    config.validate()?;
    let count = |of: fn(&SensorInfo) -> bool| sensors.iter().filter(|sensor| of(sensor)).count();
    let number = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
    let is_lidar = |sensor: &SensorInfo| matches!(sensor.model, SensorModel::Lidar(_));
    let cameras = number(count(|sensor| matches!(sensor.model, SensorModel::Camera(_))));
    let glass_lidars = number(count(is_glass_lidar));
    let lidars = sensors.iter().any(is_lidar);
    let of_lidars = lidars && cameras == 0;
    let config = one_size(config, of_lidars);
    config.validate()?;
    let drops = config.marks_drops();
    let fusion = one_fusion(sensors)?;
    let reliability = load_map_reliability(fusion, &config)?;
    Ok(MapJob {
        evidence: fusion.counts_trust(),
        reliability,
        side: config.cells_per_side()?,
        config,
        layers: Layers {
            cameras: cameras > 0,
            looks: fusion == Fusion::Learned,
            lidars,
            panes: glass_lidars > 0,
            drops,
        },
        sensors: sensors.len(),
        cameras,
        glass_lidars,
        apart: options.live || sensors.len() > 1,
        verdicts: options.live || sensors.len() > 1 || options.verdicts,
    })
}

/// The sensors with a fusion in place of [`Fusion::Auto`]: that of the cameras that state one that counts trust, or weight where they
/// state another; else map reliability where a camera has method drm and its network knows cells of that side, evidence in cells of
/// other sides, and weight where no camera has drm.
pub(super) fn with_fusion(config: &Config, sensors: &[SensorInfo]) -> Vec<SensorInfo> {
    let is_camera = |sensor: &&SensorInfo| matches!(sensor.model, SensorModel::Camera(_));
    let cameras = || sensors.iter().filter(is_camera);
    let stated = cameras().map(|camera| camera.config.fusion).find(|fusion| *fusion != Fusion::Auto);
    let drm = || cameras().any(|camera| method_of(camera) == Method::Drm);
    let settled = match stated {
        Some(fusion) if fusion.counts_trust() => fusion,
        None if drm() && knows_cells_of(config.resolution_m) => Fusion::Learned,
        None if drm() => Fusion::Evidence,
        _ => Fusion::Weight,
    };
    let mut sensors = sensors.to_vec();
    for sensor in sensors.iter_mut().filter(|sensor| sensor.config.fusion == Fusion::Auto) {
        sensor.config.fusion = settled;
    }
    sensors
}

/// The method that a camera comes to.
fn method_of(camera: &SensorInfo) -> Method {
    let color = match &camera.model {
        SensorModel::Camera(info) => info.color.is_some() && camera.color_missing.is_none(),
        _ => false,
    };
    camera.config.resolved(color).method
}

/// What the cameras' cells hold: of all of them evidence for and against, of which a rule or a network makes obstacles, or of none, as
/// they share the cells; then it is [`Fusion::Weight`].
fn one_fusion(sensors: &[SensorInfo]) -> Result<Fusion> {
    let cameras = sensors.iter().filter(|sensor| matches!(sensor.model, SensorModel::Camera(_)));
    let mut first: Option<(&str, Fusion)> = None;
    for camera in cameras {
        let fusion = camera.config.fusion;
        let fusion = if fusion.counts_trust() { fusion } else { Fusion::Weight };
        match first {
            Some((name, other)) if other != fusion => {
                let reason = format!(
                    "`{name}` and `{}` differ: all cameras of a map have `evidence`, or `learned`, or neither",
                    camera.name
                );
                return Err(Error::Config { key: "fusion".into(), reason });
            }
            _ => first = Some((&camera.name, fusion)),
        }
    }
    Ok(first.map_or(Fusion::Weight, |(_, fusion)| fusion))
}

/// The configuration with the map's resolution and size in both pairs of keys: those of lidars, or those of cameras.
fn one_size(config: &Config, of_lidars: bool) -> Config {
    let (resolution_m, map_size_m) = match of_lidars {
        true => (config.scan_resolution_m, config.scan_map_size_m),
        false => (config.resolution_m, config.map_size_m),
    };
    Config {
        resolution_m,
        map_size_m,
        scan_resolution_m: resolution_m,
        scan_map_size_m: map_size_m,
        ..config.clone()
    }
}

fn is_glass_lidar(sensor: &SensorInfo) -> bool {
    matches!(sensor.model, SensorModel::Lidar(_)) && sensor.config.glass
}

/// What the programs of a map's sensors are made of.
pub(super) struct Builder<'a> {
    pub(super) context: &'a Context,
    pub(super) options: &'a Options,
    pub(super) map: &'a Arc<MapJob>,
    pub(super) sensors: &'a [SensorInfo],
}

impl Builder<'_> {
    /// The program of the sensor of that number; `None` where nothing is known of it.
    pub(super) fn sensor(&self, number: usize) -> Result<Option<Program>> {
        let sensor = &self.sensors[number];
        Ok(match &sensor.model {
            SensorModel::Camera(info) => Some(Kind::camera(self.camera_job(number, info)?)?),
            SensorModel::Lidar(info) => Some(Kind::lidar(self.lidar_job(number, info)?)?),
            SensorModel::Missing(_) => None,
        })
    }

    /// The program of the map of several sensors.
    pub(super) fn map(&self) -> Result<Program> {
        let stages = map_stages(self.map);
        let plan = map_plan(self.map, &stages)?;
        Ok(Program { kind: Kind::Map(Arc::clone(self.map)), stages, plan })
    }

    /// The parameters of a sensor, with the map's size.
    fn config(&self, number: usize) -> Result<Config> {
        let MapJob { config: map, .. } = &**self.map;
        let config = Config {
            resolution_m: map.resolution_m,
            map_size_m: map.map_size_m,
            scan_resolution_m: map.resolution_m,
            scan_map_size_m: map.map_size_m,
            ..self.sensors[number].config.clone()
        };
        config.validate()?;
        Ok(config)
    }

    fn scope(&self, number: usize) -> String {
        if self.map.apart { self.sensors[number].name.clone() } else { String::new() }
    }

    fn camera_job(&self, number: usize, info: &CameraInfo) -> Result<CameraJob> {
        info.depth.validate()?;
        let sensor = &self.sensors[number];
        let config = self.config(number)?.resolved(info.color.is_some() && sensor.color_missing.is_none());
        let drm = load_drm(&config, sensor, info, self.context)?;
        Ok(CameraJob {
            depth: info.depth,
            float_depth: info.float_depth,
            color: info.color.filter(|_| (self.options.images && !self.options.live) || drm.is_some()),
            color_aligned: info.color_aligned,
            confidence: info.confidence || !config.confidence_topic.is_empty(),
            drm,
            depth_alone: sensor.config.method == Method::Auto,
            images: self.options.images,
            layers: self.options.layers,
            cell_inputs: self.options.cell_inputs,
            config,
            map: Arc::clone(self.map),
            sensor: u32::try_from(number).unwrap_or(u32::MAX),
            scope: self.scope(number),
        })
    }

    fn lidar_job(&self, number: usize, info: &LidarInfo) -> Result<LidarJob> {
        let config = self.config(number)?;
        let glass_number = self.sensors[..number].iter().filter(|sensor| is_glass_lidar(sensor)).count();
        Ok(LidarJob {
            capacity: capacity(&config, &info.first)?,
            full_scale: full_scale(&config, &info.first),
            plane_rings: plane_rings(&config, &info.first)?,
            deskew: config.deskew && info.first.columns.time,
            layers: self.options.layers,
            solidity: load_solidity(&config)?,
            solidity_inputs: self.options.solidity_inputs,
            glass: glass(&config, &info.first)?,
            config,
            map: Arc::clone(self.map),
            sensor: u32::try_from(number).unwrap_or(u32::MAX),
            glass_number: u32::try_from(glass_number).unwrap_or(u32::MAX),
            scope: self.scope(number),
        })
    }
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
