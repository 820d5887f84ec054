//! `limpid info RECORDING`: what it holds, what `limpid run` would use of it, and what is missing.
//!
//! What would be used is what [`open_source`] chooses, as for a run; its first observations are read and none is mapped.

use std::collections::BTreeMap;
use std::path::Path;

use limpid::config::SensorKind;
use limpid::input::{Inventory, Source, SourceReport, open_source};
use limpid::run::method_note;
use limpid::sensor::{CameraModel, Distortion, SensorModel};
use limpid::{Config, Error, Result, SensorInfo};
use serde::Serialize;

use crate::cli::Common;

/// Observations that are read of a recording at most to see whether they have poses.
const OBSERVATIONS: u64 = 64;

/// Most topics listed that are not used, of types that are read and of others each; a robot's own can be hundreds.
const UNUSED_TOPICS: usize = 20;

/// Everything that is told of a recording.
#[derive(Serialize)]
struct Report {
    recording: String,
    #[serde(flatten)]
    inventory: Inventory,
    duration_s: Option<f64>,
    /// By topic, what it would be used for.
    uses: BTreeMap<String, Vec<String>>,
    sensors: Vec<Sensor>,
    /// What a run would say: choices, what was passed over of the observations that were read, and why there are no poses.
    remarks: Vec<String>,
    missing: Vec<String>,
}

/// A sensor that would be used.
#[derive(Serialize)]
struct Sensor {
    name: String,
    kind: &'static str,
    frame: String,
    /// What is known of it.
    about: String,
    /// How depth becomes evidence, of a camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    method: Option<String>,
    /// Observations read, and those of them with a pose.
    read: u64,
    with_pose: u64,
    /// Frame of the map that its poses are in; empty where it has none.
    map_frame: String,
}

pub(super) fn execute(path: &Path, config: Option<&Path>, json: bool) -> Result<()> {
    let common =
        Common { config: config.map(Into::into), method: None, weights: None, port: None, adapter: None };
    let config = common.config()?;
    let inventory = Inventory::of(path, &config)?;
    let mut report = Report {
        recording: path.display().to_string(),
        duration_s: inventory.duration_s(),
        inventory,
        uses: BTreeMap::new(),
        sensors: Vec::new(),
        remarks: Vec::new(),
        missing: Vec::new(),
    };
    let used = report.look(path, &config);
    if json {
        report.missing.extend(used.as_ref().err().map(ToString::to_string));
        let text = serde_json::to_string_pretty(&report);
        println!("{}", text.map_err(|error| Error::Encode { path: path.into(), reason: error.to_string() })?);
    } else {
        report.print();
    }
    used
}

impl Report {
    /// Opens the recording as a run does and reads its first observations. Wrong usage is an error; what is wrong with the
    /// recording is told.
    fn look(&mut self, path: &Path, config: &Config) -> Result<()> {
        let mut source = open_source(path, config)?;
        let mut map_frames = vec![String::new(); source.sensors().len()];
        let read = read_ahead(source.as_mut(), &mut map_frames);
        for (topic, role) in source.uses() {
            self.uses.entry(topic).or_default().push(role);
        }
        let told = source.report();
        self.sensors = source.sensors().iter().zip(&told.sensors).map(sensor).collect();
        for (sensor, map_frame) in self.sensors.iter_mut().zip(&map_frames) {
            sensor.map_frame.clone_from(map_frame);
        }
        self.tell(&told);
        read
    }

    fn tell(&mut self, told: &SourceReport) {
        let notes = told.read.notes.iter().filter(|note| !self.inventory.notes.contains(note));
        self.remarks.extend(notes.cloned());
        let skipped = told.read.skipped.iter();
        self.remarks.extend(skipped.map(|s| format!("passed over {} x {}: {}", s.count, s.source, s.reason)));
        self.missing.extend(told.read.frames.iter().cloned());
    }

    fn print(&self) {
        let Inventory { format, size_bytes, topics, frame_tree, notes, .. } = &self.inventory;
        let duration = self.duration_s.map_or_else(String::new, |s| format!(", {s:.1} s"));
        println!("{}: {format}, {}{duration}", self.recording, size(*size_bytes));
        for note in notes {
            println!("note: {note}");
        }
        if !topics.is_empty() {
            self.print_topics();
        }
        if !topics.is_empty() || !frame_tree.is_empty() {
            println!("\nframes: {}", if frame_tree.is_empty() { "none" } else { frame_tree });
        }
        println!("\nlimpid run {} would use", self.recording);
        if self.sensors.is_empty() {
            println!("  nothing");
        }
        for sensor in &self.sensors {
            println!("  {} ({} in `{}`): {}", sensor.name, sensor.kind, sensor.frame, sensor.about);
            sensor.method.iter().for_each(|method| println!("    {method}"));
            println!("    {}", poses(sensor));
        }
        for remark in &self.remarks {
            println!("note: {remark}");
        }
        for missing in &self.missing {
            println!("missing: {missing}");
        }
    }

    fn print_topics(&self) {
        let (mut listed, mut left_out) = ([0, 0], 0);
        let rows: Vec<[String; 5]> = self
            .inventory
            .topics
            .iter()
            .filter(|topic| {
                let is_used = self.uses.contains_key(&topic.topic);
                let listed = &mut listed[usize::from(topic.is_read)];
                let is_listed = is_used || *listed < UNUSED_TOPICS;
                *listed += usize::from(!is_used);
                left_out += usize::from(!is_listed);
                is_listed
            })
            .map(|topic| self.row(topic))
            .collect();
        let head = ["topic", "type", "messages", "rate", "used for"].map(String::from);
        let wide = |column: usize| {
            rows.iter().chain([&head]).map(|row| row[column].chars().count()).max().unwrap_or(0)
        };
        let widths: [usize; 4] = std::array::from_fn(wide);
        println!();
        for [topic, kind, messages, rate, used] in [&head].into_iter().chain(&rows) {
            let [a, b, c, d] = widths;
            let row = format!("{topic:a$}  {kind:b$}  {messages:>c$}  {rate:>d$}  {used}");
            println!("{}", row.trim_end());
        }
        if left_out > 0 {
            println!("and {left_out} more that are not used (--json lists all)");
        }
    }

    fn row(&self, topic: &limpid::input::TopicInfo) -> [String; 5] {
        let used = match self.uses.get(&topic.topic) {
            Some(roles) => roles.join(", "),
            None if topic.is_read => "-".into(),
            None => "(type not read)".into(),
        };
        [
            topic.topic.clone(),
            topic.type_name.clone(),
            topic.messages.map_or_else(|| "?".into(), |messages| messages.to_string()),
            topic.rate_hz.map_or_else(|| "-".into(), |hz| format!("{hz:.1} Hz")),
            used,
        ]
    }
}

/// Reads on until every sensor has shown whether it has poses, and in which frame.
fn read_ahead(source: &mut dyn Source, map_frames: &mut [String]) -> Result<()> {
    for _ in 0..OBSERVATIONS * map_frames.len() as u64 {
        let Some(observation) = source.next()? else { return Ok(()) };
        if observation.pose.is_some() {
            map_frames[observation.sensor].clone_from(&observation.map_frame);
        }
        if map_frames.iter().all(|frame| !frame.is_empty()) {
            return Ok(());
        }
    }
    Ok(())
}

/// Whether the observations that were read have poses.
fn poses(sensor: &Sensor) -> String {
    let Sensor { kind, frame, read, with_pose, map_frame, .. } = sensor;
    let what = if *kind == SensorKind::Lidar.name() { "scan" } else { "depth image" };
    match (read, with_pose) {
        (0, _) => format!("no {what} can be used"),
        (read, 0) => format!("none of the first {read} {what}s has a pose"),
        _ if map_frame == frame => {
            format!("no transforms: the map lies in the {kind}'s own frame and does not move with the robot")
        }
        (1, _) => format!("the first {what} has a pose in `{map_frame}`"),
        (read, posed) => format!("{posed} of the first {read} {what}s have a pose in `{map_frame}`"),
    }
}

fn sensor((info, told): (&SensorInfo, &limpid::input::SensorReport)) -> Sensor {
    Sensor {
        name: info.name.clone(),
        kind: info.model.kind().name(),
        frame: info.frame_id.clone(),
        about: about(info),
        method: (info.model.kind() == SensorKind::Camera).then(|| {
            method_note(info).unwrap_or_else(|| format!("method {:?}", info.config.method).to_lowercase())
        }),
        read: told.given,
        with_pose: told.given - told.without_pose,
        map_frame: String::new(),
    }
}

fn about(info: &SensorInfo) -> String {
    match &info.model {
        SensorModel::Camera(camera) => {
            let unit = if camera.float_depth {
                "float metres".into()
            } else {
                format!("counts of {} m", info.config.depth_unit_m)
            };
            let color = match (&camera.color, camera.color_aligned) {
                (None, _) => "without colour".into(),
                (Some(color), true) => format!("colour {} on the depth grid", lens(color)),
                (Some(color), false) => format!("colour {}, placed by its transform", lens(color)),
            };
            let confidence = if camera.confidence { ", with confidence" } else { "" };
            format!("depth {} in {unit}, {color}{confidence}", lens(&camera.depth))
        }
        SensorModel::Lidar(lidar) => {
            let rings = lidar
                .first
                .points
                .iter()
                .map(|point| point.ring)
                .filter(|&ring| ring != limpid::sensor::Point::UNKNOWN);
            let rings = rings.max().map_or_else(|| "no rings".into(), |ring| format!("rings up to {ring}"));
            format!("{} points in the first scan, {rings}", lidar.first.points.len())
        }
        SensorModel::Missing(_) => "nothing of it can be used".into(),
    }
}

fn lens(camera: &CameraModel) -> String {
    let CameraModel { width, height, fx, fy, cx, cy, distortion } = camera;
    let bent = if *distortion == Distortion::None { "" } else { ", distorted" };
    format!("{width}x{height} (fx {fx:.1}, fy {fy:.1}, cx {cx:.1}, cy {cy:.1}{bent})")
}

#[expect(clippy::cast_precision_loss, reason = "told to a tenth")]
fn size(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} bytes"),
        1024..1_048_576 => format!("{:.1} KiB", bytes as f64 / 1024.0),
        1_048_576..1_073_741_824 => format!("{:.1} MiB", bytes as f64 / 1_048_576.0),
        _ => format!("{:.1} GiB", bytes as f64 / 1_073_741_824.0),
    }
}
