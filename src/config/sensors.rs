//! The sensors that a configuration names (spec 4 §1).

use super::{Config, bad_key};
use crate::base::{Error, Result};

/// Most sensors of one map.
pub const MAX_SENSORS: usize = 16;

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorKind {
    /// Depth images, with or without colour.
    Camera,
    /// Scans.
    Lidar,
}

impl SensorKind {
    /// Both kinds.
    pub const ALL: [Self; 2] = [Self::Camera, Self::Lidar];

    /// The kind as a file states it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Lidar => "lidar",
        }
    }
}

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
    /// The topic that the configuration gives it; empty: found by type.
    pub fn topic(&self) -> &str {
        match self.kind {
            SensorKind::Camera => &self.parameters.depth_topic,
            SensorKind::Lidar => &self.parameters.scan_topic,
        }
    }
}

impl Config {
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
    if !(timeout_s.is_finite() && *timeout_s >= 0.0) {
        return Err(bad_key(&format!("{name}.timeout_s"), format!("{timeout_s} is not a number from 0 up")));
    }
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
