//! The states of sensors and map as ROS diagnostics (spec 1 §5, spec 4 §3).

use crate::config::SensorInfo;
use crate::map::{CameraUpdate, Ground, GroundFrom, LidarUpdate, MapUpdate, Seen, State, Update};
use crate::message::ros2::Header;
use crate::message::written::{DiagnosticArray, DiagnosticStatus, KeyValue};
use crate::output::{one_of_several, pass_sums_ms};
use crate::sensor::SensorKind;

const LEVEL_OK: u8 = 0;
const LEVEL_WARN: u8 = 1;
const LEVEL_ERROR: u8 = 2;

/// A sensor, with what was said of it last.
struct Sensor {
    name: String,
    /// Name of its status.
    title: String,
    timeout_s: f64,
    last: Option<DiagnosticStatus>,
}

/// What is said of the sensors.
pub(super) struct Diagnostics(Vec<Sensor>);

impl Diagnostics {
    pub(super) fn new(sensors: &[SensorInfo]) -> Self {
        let sensor = |sensor: &SensorInfo| {
            let title = match sensor.model.kind() {
                SensorKind::Lidar => "limpid: lidar",
                SensorKind::Camera => "limpid: depth reliability",
            };
            let own =
                if one_of_several(sensors, sensor) { format!(": {}", sensor.name) } else { String::new() };
            let (name, timeout_s) = (sensor.name.clone(), sensor.timeout_s);
            Sensor { name, title: title.to_owned() + &own, timeout_s, last: None }
        };
        Self(sensors.iter().map(sensor).collect())
    }

    /// The sensor that the update came of, and with a map all others and the map itself. Level WARN when degraded or stale,
    /// ERROR when at fault; of a camera the low-reliability share and all counters, and the passes' milliseconds, as values.
    pub(super) fn of(&mut self, update: &Update, frame: Option<&str>) -> DiagnosticArray {
        let mut status = Vec::new();
        if let (Some(seen), Some(sensor)) = (&update.seen, update.sensor.and_then(|at| self.0.get_mut(at))) {
            let (level, message) = match seen {
                Seen::Camera(camera) => of_camera(camera),
                Seen::Lidar(lidar) => of_lidar(lidar),
            };
            let of = DiagnosticStatus {
                level,
                name: sensor.title.clone(),
                message,
                hardware_id: frame.unwrap_or(&sensor.name).to_owned(),
                values: values(update, seen),
            };
            sensor.last = Some(of.clone());
            status.push(of);
        }
        if let Some(map) = &update.map {
            let said = |(at, sensor): (usize, &Sensor)| match map.sensors.get(at) {
                Some(&state) => Some(sensor.status(state)),
                None => sensor.last.clone(),
            };
            status = self.0.iter().enumerate().filter_map(said).collect();
            status.push(self.map(update, map));
        }
        DiagnosticArray { header: Header::new(update.stamp_ns, ""), status }
    }

    /// The map, with its sensors' states.
    fn map(&self, update: &Update, map: &MapUpdate) -> DiagnosticStatus {
        let sensors = || self.0.iter().zip(&map.sensors);
        let worst = sensors().filter(|(_, state)| map.state != State::Ok && **state == map.state);
        let worst: Vec<_> = worst.map(|(sensor, _)| sensor.name.as_str()).collect();
        let mut message = map.state.name().to_owned();
        if !worst.is_empty() {
            message += &format!(": {}", worst.join(", "));
        }
        let states = sensors().map(|(sensor, state)| pair(&sensor.name, state.name().into()));
        // A sensor's own status has the passes that its data went through.
        let passes = update.seen.is_none().then(|| passes(update));
        DiagnosticStatus {
            level: level(map.state),
            name: "limpid: map".into(),
            message,
            hardware_id: update.map_frame.clone(),
            values: states.chain(passes.into_iter().flatten()).collect(),
        }
    }
}

impl Sensor {
    /// What the map says of it, or else it said itself last.
    fn status(&self, state: State) -> DiagnosticStatus {
        let message = match (state, &self.last) {
            (State::Ok | State::Degraded, Some(last)) => return last.clone(),
            (State::Ok | State::Degraded, None) => state.name().to_owned(),
            (State::Stale, Some(_)) => format!("STALE: no data for longer than {} s", self.timeout_s),
            (State::Stale, None) => "STALE: no data so far".to_owned(),
            (State::Fault, _) => "FAULT: it cannot be used any more".to_owned(),
        };
        let hardware_id = self.last.as_ref().map_or(&self.name, |last| &last.hardware_id).clone();
        let values = Vec::new();
        DiagnosticStatus { level: level(state), name: self.title.clone(), message, hardware_id, values }
    }
}

fn level(state: State) -> u8 {
    match state {
        State::Ok => LEVEL_OK,
        State::Degraded | State::Stale => LEVEL_WARN,
        State::Fault => LEVEL_ERROR,
    }
}

fn of_camera(camera: &CameraUpdate) -> (u8, String) {
    let percent = camera.low_reliability_fraction * 100.0;
    if camera.degraded {
        (
            LEVEL_WARN,
            format!("DEGRADED: {percent:.0} % of the depth pixels are unreliable; slow down or look again"),
        )
    } else {
        (LEVEL_OK, format!("OK: {percent:.0} % of the depth pixels are unreliable"))
    }
}

fn of_lidar(lidar: &LidarUpdate) -> (u8, String) {
    (LEVEL_OK, format!("OK: {} points", lidar.points))
}

fn pair(key: &str, value: String) -> KeyValue {
    KeyValue { key: key.to_owned(), value }
}

fn passes(update: &Update) -> Vec<KeyValue> {
    let passes = pass_sums_ms(update).into_iter();
    passes.map(|(pass, ms)| pair(&format!("{pass}_ms"), format!("{ms:.4}"))).collect()
}

fn values(update: &Update, seen: &Seen) -> Vec<KeyValue> {
    let mut values = match seen {
        Seen::Camera(camera) => camera_values(camera),
        Seen::Lidar(lidar) => lidar_values(lidar),
    };
    values.extend(update.ground.iter().flat_map(ground_values));
    values.extend(passes(update));
    values
}

/// Where heights count from, and the floor as the sensor sees it.
fn ground_values(ground: &Ground) -> Vec<KeyValue> {
    let from = match ground.from {
        GroundFrom::Stated => "stated",
        GroundFrom::Seen => "seen",
        GroundFrom::Other => "other",
    };
    let mut values = vec![
        pair("ground_from", from.into()),
        pair("ground_seen", ground.seen.to_string()),
        pair("ground_sensor_height_m", format!("{:.4}", ground.sensor_height_m)),
        pair("ground_support", format!("{:.3}", ground.support)),
        pair("ground_area_m2", format!("{:.2}", ground.area_m2)),
    ];
    if let Some(plane) = ground.plane {
        values.push(pair("ground_tilt_deg", format!("{:.2}", plane.tilt_deg())));
        values.push(pair("ground_below_m", format!("{:.4}", plane.below_m)));
    }
    if let Some(above_m) = ground.above_stated_m {
        values.push(pair("ground_above_stated_m", format!("{above_m:.4}")));
    }
    values
}

fn camera_values(camera: &CameraUpdate) -> Vec<KeyValue> {
    let mut values = vec![pair("low_reliability_fraction", camera.low_reliability_fraction.to_string())];
    values.extend(camera.depth_alone.iter().map(|reason| pair("depth_alone", reason.clone())));
    if let Ok(serde_json::Value::Object(counters)) = serde_json::to_value(camera.counters) {
        values.extend(counters.iter().map(|(key, value)| pair(key, value.to_string())));
    }
    values
}

fn lidar_values(lidar: &LidarUpdate) -> Vec<KeyValue> {
    let panes = lidar.glass.iter().map(|glass| pair("panes", glass.panes.len().to_string()));
    std::iter::once(pair("points", lidar.points.to_string())).chain(panes).collect()
}
