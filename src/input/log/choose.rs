//! Which sensors are read of a log: those that the configuration names, else one camera and one lidar that are found.

use std::path::Path;

use crate::base::{Error, Result};
use crate::config::{Config, SensorConfig, SensorKind};
use crate::input::ReadReport;
use crate::input::log::LogFiles;
use crate::input::log::camera::LogCamera;
use crate::input::log::cameras::{clouds_of_cameras, find_depth, shared_names};
use crate::input::log::lidar::{self, LogLidar};
use crate::input::log::motion::Motion;
use crate::input::log::reading::Log;
use crate::input::log::sensor::{LogSensor, Reader};
use crate::input::log::splits::Survey;
use crate::input::log::topics::{Channels, Kind, Topics};
use crate::input::log::unread::missing_scans;
use crate::input::points::Options;

/// What a log of messages holds, as far as choosing a path goes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Contents {
    /// Depth images.
    pub camera: bool,
    /// Lidar scans.
    pub lidar: bool,
}

/// What a recording holds.
///
/// # Errors
/// [`crate::Error::File`], [`crate::Error::Format`].
pub(crate) fn contents(files: &LogFiles) -> Result<Contents> {
    let channels = Survey::of(files)?.channels;
    let camera = find_depth(&channels).is_some();
    let lidar = lidar::find(&channels).is_some() || !camera && !channels.unread_packets().is_empty();
    Ok(Contents { camera, lidar })
}

/// The topic of a lidar, which is noted: the stated one, or that which is found.
pub(super) fn scan_topic(
    channels: &Channels,
    stated: &str,
    key: &str,
    path: &Path,
    report: &mut ReadReport,
) -> Result<String> {
    let topic = channels
        .configured(path, key, stated, Kind::is_scan)?
        .or_else(|| lidar::find(channels))
        .ok_or_else(|| missing_scans(path, key, channels))?;
    report.note(lidar::note(channels, &topic));
    Ok(topic)
}

/// A log with one lidar and its poses.
///
/// # Errors
/// What [`Log::open`] returns; [`crate::Error::Config`] for a configured topic that is absent or of another type.
pub(crate) fn lidar_log(files: LogFiles, config: &Config) -> Result<Log> {
    let path = &files.path().to_owned();
    Log::open(files, |channels, report| {
        let topic = scan_topic(channels, &config.scan_topic, "topic", path, report)?;
        let lidar = LogLidar::new(topic, Options::of(config), config, true);
        let sensor = LogSensor::new("lidar", Reader::Lidar(Box::new(lidar)));
        Ok((Motion::choose(channels, config, path)?, vec![sensor]))
    })
}

/// The sensors of a configuration that names none: what the log has of a camera and a lidar.
fn found(channels: &Channels, config: &Config) -> Vec<SensorConfig> {
    let has_camera = !config.depth_topic.is_empty() || find_depth(channels).is_some();
    let has_lidar = !config.scan_topic.is_empty() || lidar::find(channels).is_some();
    // Packets that cannot be decoded are a lidar's, too, where there is nothing else.
    let has_lidar = has_lidar || !has_camera && !channels.unread_packets().is_empty();
    let kinds = [(SensorKind::Camera, has_camera || !has_lidar), (SensorKind::Lidar, has_lidar)];
    let there = kinds.into_iter().filter(|&(_, there)| there);
    there.map(|(kind, _)| SensorConfig::found(kind, config)).collect()
}

/// The sensors of a log and how it moves.
pub(super) struct Chosen {
    pub(super) motion: Motion,
    pub(super) configs: Vec<SensorConfig>,
    pub(super) sensors: Vec<LogSensor>,
}

/// Chooses sensors and motion.
///
/// # Errors
/// [`crate::Error::Config`] and [`crate::Error::Format`] as [`Topics::choose`] and [`scan_topic`]; of sensors that the
/// configuration names only where the log has none of them.
pub(super) fn choose(
    channels: &Channels,
    config: &Config,
    path: &Path,
    report: &mut ReadReport,
) -> Result<Chosen> {
    let named = !config.sensors.is_empty();
    let configs = if named { config.sensors.clone() } else { found(channels, config) };
    let mut chosen =
        Chosen { motion: Motion::choose(channels, config, path)?, configs: vec![], sensors: vec![] };
    let mut first_error = None;
    for sensor in &configs {
        let others = Others::of(sensor, &configs);
        let reader = match sensor.kind {
            SensorKind::Camera => camera(channels, sensor, &others, path, &chosen.motion),
            SensorKind::Lidar => lidar(channels, sensor, &others, path, report),
        };
        let reader = match reader {
            Ok(reader) => reader,
            Err(error) if named && is_absent(&error, channels, sensor) => {
                report.note(format!("`{}` is missing: {error}", sensor.name));
                first_error.get_or_insert(error);
                Reader::Absent
            }
            Err(error @ Error::Format { .. }) if configs.len() > 1 && !named => {
                report.note(format!("the {} is left out: {error}", sensor.name));
                continue;
            }
            Err(error) => return Err(error),
        };
        chosen.sensors.push(LogSensor::new(&sensor.name, reader));
        chosen.configs.push(sensor.clone());
    }
    note_left_out(channels, &chosen, report);
    let nothing = chosen.sensors.iter().all(|sensor| matches!(sensor.reader, Reader::Absent));
    first_error.filter(|_| nothing).map_or(Ok(chosen), Err)
}

/// Tells of clouds and packets beside what is read.
fn note_left_out(channels: &Channels, chosen: &Chosen, report: &mut ReadReport) {
    let is_read = |topic: &str| {
        let mut lidars = chosen.sensors.iter();
        lidars.any(|sensor| matches!(&sensor.reader, Reader::Lidar(lidar) if lidar.topic == topic))
    };
    for topic in clouds_of_cameras(channels).iter().filter(|topic| !is_read(topic)) {
        report.note(format!(
            "{topic} is left out: it looks like the camera's own cloud of its depth images (`scan_topic` takes it as a lidar's)"
        ));
    }
    let unread = channels.unread_packets();
    if !unread.is_empty() {
        report.note(format!("left out: {}, which are not decoded", unread.join(", ")));
    }
}

/// Whether an error says that the log has nothing of a sensor, and not that something is configured wrongly.
fn is_absent(error: &Error, channels: &Channels, sensor: &SensorConfig) -> bool {
    let (main_key, topic) = topic_of(sensor);
    match error {
        Error::Config { key, .. } => key == main_key && !channels.has(topic),
        Error::Format { .. } => true,
        _ => false,
    }
}

/// What the other sensors of a configuration say that concerns one.
struct Others<'a> {
    /// Topics that are another's and not its own.
    taken: Vec<&'a str>,
    /// Depth topics of the other cameras.
    depth: Vec<&'a str>,
    has_lidar: bool,
}

impl<'a> Others<'a> {
    fn of(sensor: &SensorConfig, configs: &'a [SensorConfig]) -> Self {
        let others = || configs.iter().filter(|other| other.name != sensor.name);
        let topics = |of: &'a SensorConfig| [topic_of(of).1, of.parameters.color_topic.as_str()];
        let own = [topic_of(sensor).1, sensor.parameters.color_topic.as_str()];
        let of_kind = |kind| others().filter(move |other| other.kind == kind);
        Self {
            taken: others().flat_map(topics).filter(|topic| !own.contains(topic)).collect(),
            depth: of_kind(SensorKind::Camera).map(|other| topic_of(other).1).collect(),
            has_lidar: of_kind(SensorKind::Lidar).next().is_some(),
        }
    }
}

/// Key and topic that a sensor's data are configured by; the topic is empty where it is found.
fn topic_of(sensor: &SensorConfig) -> (&'static str, &str) {
    match sensor.kind {
        SensorKind::Camera => ("depth_topic", &sensor.parameters.depth_topic),
        SensorKind::Lidar => ("scan_topic", &sensor.parameters.scan_topic),
    }
}

fn camera(
    channels: &Channels,
    sensor: &SensorConfig,
    others: &Others<'_>,
    path: &Path,
    motion: &Motion,
) -> Result<Reader> {
    let mut topics = Topics::choose(&channels.without(&others.taken), &sensor.parameters, path)?;
    if sensor.parameters.color_topic.is_empty() {
        // Colour that is as near to another camera in the tree of names is not known to be this one's.
        let nearness = |depth: &str| topics.color.as_ref().map(|color| shared_names(color, depth));
        if others.depth.iter().any(|depth| nearness(depth) >= nearness(&topics.depth)) {
            (topics.color, topics.color_info) = (None, None);
        }
    }
    let camera = LogCamera::new(topics, &sensor.parameters, motion.is_recorded());
    Ok(Reader::Camera(Box::new(camera)))
}

fn lidar(
    channels: &Channels,
    sensor: &SensorConfig,
    others: &Others<'_>,
    path: &Path,
    report: &mut ReadReport,
) -> Result<Reader> {
    let (key, stated) = topic_of(sensor);
    let topic = scan_topic(&channels.without(&others.taken), stated, key, path, report)?;
    let options = Options::of(&sensor.parameters);
    Ok(Reader::Lidar(Box::new(LogLidar::new(topic, options, &sensor.parameters, !others.has_lidar))))
}
