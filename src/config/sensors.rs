//! The sensors that a configuration names (spec 4 §1).

use super::validate::from_0_up;
use super::{Config, bad_key};
use crate::base::{Error, Result};
use crate::sensor::{CameraInfo, LidarInfo, Scan, SensorKind, SensorModel};

/// Most sensors of one map.
pub const MAX_SENSORS: usize = 16;

/// A sensor that the configuration names.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorConfig {
    /// Its name: that of its section.
    pub name: String,
    /// What it measures.
    pub kind: SensorKind,
    /// Time without data after which it is stale, seconds; 0: never.
    pub timeout_s: f64,
    /// The parameters that hold for it: those of all, with its section laid over them. Its own list of sensors is empty.
    pub parameters: Config,
}

impl SensorConfig {
    /// A sensor that no configuration names, by its kind.
    pub fn found(kind: SensorKind, config: &Config) -> Self {
        let parameters = Config { sensors: Vec::new(), ..config.clone() };
        Self { name: kind.name().into(), kind, timeout_s: config.timeout_s, parameters }
    }

    /// The topic that the configuration gives it; empty: found by type.
    pub fn topic(&self) -> &str {
        match self.kind {
            SensorKind::Camera => &self.parameters.depth_topic,
            SensorKind::Lidar => &self.parameters.scan_topic,
        }
    }
}

/// A sensor of a map: its parameters, and what its first observations say of it.
///
/// ```
/// let room = limpid::open_source("testdata/room.mcap".as_ref(), &limpid::Config::default())?;
/// let camera = &room.sensors()[0];
/// assert_eq!((camera.name.as_str(), camera.timeout_s), ("camera", 0.5));
/// assert!(matches!(&camera.model, limpid::sensor::SensorModel::Camera(info) if info.color.is_some()));
/// # Ok::<(), limpid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SensorInfo {
    /// As the configuration names it; `camera` or `lidar` where it was found in the recording.
    pub name: String,
    /// Its frame; empty where nothing of it came and none is configured.
    pub frame_id: String,
    /// The parameters that hold for it.
    pub config: Config,
    /// Time without data after which it is stale, seconds; 0: never.
    pub timeout_s: f64,
    /// What its first observations say of it.
    pub model: SensorModel,
    /// Why the first frames of a camera have no colour that can be used with their depth; `None` where one has.
    pub color_missing: Option<String>,
}

impl SensorInfo {
    /// A camera.
    pub fn camera(config: &Config, info: CameraInfo) -> Self {
        Self::of(config, SensorModel::Camera(info))
    }

    /// A lidar whose scans are like `first`.
    pub fn lidar(config: &Config, first: Scan) -> Self {
        Self::of(config, SensorModel::Lidar(LidarInfo { first }))
    }

    fn of(config: &Config, model: SensorModel) -> Self {
        let sensor = SensorConfig::found(model.kind(), config);
        Self { model, ..Self::missing(sensor) }
    }

    /// A sensor of which nothing has come yet.
    pub fn missing(sensor: SensorConfig) -> Self {
        let SensorConfig { name, kind, timeout_s, parameters: config } = sensor;
        let frame_id = match kind {
            SensorKind::Camera => config.camera_frame.clone(),
            SensorKind::Lidar => config.lidar_frame.clone(),
        };
        Self { name, frame_id, config, timeout_s, model: SensorModel::Missing(kind), color_missing: None }
    }
}

impl Config {
    /// The configuration with the sensors of a kind alone: those that it names, or the one that is found.
    ///
    /// # Errors
    /// [`Error::Config`] where it names sensors, and none of that kind.
    pub fn only(&self, kind: SensorKind) -> Result<Self> {
        let named = self.sensors.iter().filter(|sensor| sensor.kind == kind).cloned().collect();
        let sensors: Vec<_> =
            if self.sensors.is_empty() { vec![SensorConfig::found(kind, self)] } else { named };
        if sensors.is_empty() {
            return Err(bad_key("sensors", format!("names no {}", kind.name())));
        }
        Ok(Self { sensors, ..self.clone() })
    }

    /// Changes the parameters, and those of every sensor that the configuration names.
    pub fn change_all(&mut self, change: impl Fn(&mut Self)) {
        change(self);
        for sensor in &mut self.sensors {
            change(&mut sensor.parameters);
        }
    }

    pub(super) fn validate_sensors(&self) -> Result<()> {
        if self.sensors.len() > MAX_SENSORS {
            return Err(bad_key(
                "sensors",
                format!("names {}; 1 to {MAX_SENSORS} are supported", self.sensors.len()),
            ));
        }
        for (index, sensor) in self.sensors.iter().enumerate() {
            check_name(&sensor.name)?;
            check_values(sensor)?;
            for before in &self.sensors[..index] {
                check_pair(before, sensor)?;
            }
        }
        Ok(())
    }
}

/// Refuses names that a file or a topic cannot hold.
pub(super) fn check_name(name: &str) -> Result<()> {
    let bad = |reason: &str| Err(bad_key("sensors", format!("`{name}` {reason}")));
    if name.trim().is_empty() {
        return bad("is an empty name");
    }
    if name.contains('/') {
        return bad("holds a `/`: a sensor's name is part of topics and file names");
    }
    if ["map", "sensors"].contains(&name) || super::scope_of(name).is_some() {
        return bad("cannot be a sensor's name: it is a key of its own");
    }
    Ok(())
}

fn check_values(sensor: &SensorConfig) -> Result<()> {
    let SensorConfig { name, timeout_s, parameters, .. } = sensor;
    from_0_up(&[(&format!("{name}.timeout_s"), *timeout_s)])?;
    if !parameters.sensors.is_empty() {
        return Err(bad_key(name, "has sensors of its own".into()));
    }
    parameters.validate().map_err(|error| match error {
        Error::Config { key, reason } => bad_key(&key, format!("{reason}, for the sensor `{name}`")),
        other => other,
    })
}

fn check_pair(a: &SensorConfig, b: &SensorConfig) -> Result<()> {
    let both = format!("`{}` and `{}`", a.name, b.name);
    if a.name == b.name {
        return Err(bad_key("sensors", format!("names `{}` twice", a.name)));
    }
    if a.topic() == b.topic() && !a.topic().is_empty() {
        return Err(bad_key("sensors", format!("{both} read one topic, {}", a.topic())));
    }
    if a.kind == b.kind && a.topic().is_empty() && b.topic().is_empty() {
        let (kind, key) = match a.kind {
            SensorKind::Camera => ("camera", "depth_topic"),
            SensorKind::Lidar => ("lidar", "topic"),
        };
        let reason =
            format!("{both} have no topic, and only one {kind} can be found by type: state `{key}` in both");
        return Err(bad_key("sensors", reason));
    }
    Ok(())
}
