//! What the node says of itself once a second: one status for the map, one for each sensor.

use std::time::Instant;

use crate::config::SensorInfo;
use crate::map::{Seen, State, Update};
use crate::message::ros2::Header;
use crate::message::written::{DiagnosticArray, DiagnosticStatus, KeyValue};

const LEVEL_OK: u8 = 0;
const LEVEL_WARN: u8 = 1;
const LEVEL_ERROR: u8 = 2;

/// What happened to one sensor's data.
#[derive(Debug, Clone)]
pub(super) struct SensorHealth {
    pub(super) name: String,
    timeout_s: f64,
    pub(super) state: State,
    /// Observations that went into the map.
    pub(super) taken: u64,
    pub(super) without_pose: u64,
    pub(super) refused: u64,
    pub(super) last_refused: Option<String>,
    /// Seen before the stamps jumped back.
    pub(super) before_jump: u64,
    pub(super) low_reliability: Option<f64>,
    last_taken: Option<Instant>,
    /// Of the last second.
    taken_before: u64,
    rate_hz: f64,
}

impl SensorHealth {
    fn new(sensor: &SensorInfo) -> Self {
        Self {
            name: sensor.name.clone(),
            timeout_s: sensor.timeout_s,
            state: State::Stale,
            taken: 0,
            without_pose: 0,
            refused: 0,
            last_refused: None,
            before_jump: 0,
            low_reliability: None,
            last_taken: None,
            taken_before: 0,
            rate_hz: 0.0,
        }
    }

    fn status(&self, now: Instant) -> DiagnosticStatus {
        let age_s = self.last_taken.map(|last| now.saturating_duration_since(last).as_secs_f64());
        let message = match (self.state, age_s) {
            (State::Stale, None) => "STALE: no data so far".to_owned(),
            (State::Stale, Some(_)) => format!("STALE: no data for longer than {} s", self.timeout_s),
            (State::Degraded, _) => "DEGRADED: many of its pixels are unreliable".to_owned(),
            (State::Ok | State::Fault, _) => self.state.name().to_owned(),
        };
        let mut values = vec![
            pair("rate_hz", format!("{:.1}", self.rate_hz)),
            pair("used", self.taken.to_string()),
            pair("without_pose", self.without_pose.to_string()),
            pair("refused", self.refused.to_string()),
            pair("before_jump", self.before_jump.to_string()),
        ];
        values.extend(age_s.map(|age_s| pair("age_s", format!("{age_s:.3}"))));
        values.extend(
            self.low_reliability.map(|share| pair("low_reliability_fraction", format!("{share:.3}"))),
        );
        values.extend(self.last_refused.iter().map(|reason| pair("last_refused", reason.clone())));
        DiagnosticStatus {
            level: level(self.state),
            name: format!("limpid: {}", self.name),
            message,
            hardware_id: self.name.clone(),
            values,
        }
    }
}

/// See the module.
#[derive(Debug, Clone, Default)]
pub(super) struct Health {
    pub(super) sensors: Vec<SensorHealth>,
    /// What is wrong with the node itself: the GPU, or no sensor found.
    pub(super) fault: Option<String>,
    /// What the node waits for.
    pub(super) waits_for: Option<String>,
    /// Maps published, and those that were too old to be.
    pub(super) maps: u64,
    pub(super) late_maps: u64,
    /// How often the map began anew, with the last reason.
    pub(super) restarts: u64,
    pub(super) last_restart: Option<String>,
    /// What happened to messages, by topic or reason.
    pub(super) input: Vec<(String, String)>,
    /// Whether messages were dropped or not understood since the last look.
    pub(super) input_suffers: bool,
    /// From an observation to its map, milliseconds.
    pub(super) latency_ms: f64,
    pub(super) held_up: u64,
    maps_before: u64,
    maps_hz: f64,
    /// The state that the user was told last.
    told: Option<State>,
    looked: Option<Instant>,
}

impl Health {
    /// Begins with these sensors; what was counted of those of the same name stays.
    pub(super) fn watch(&mut self, sensors: &[SensorInfo]) {
        let known = std::mem::take(&mut self.sensors);
        let kept = |sensor: &SensorInfo| known.iter().find(|health| health.name == sensor.name).cloned();
        self.sensors =
            sensors.iter().map(|sensor| kept(sensor).unwrap_or_else(|| SensorHealth::new(sensor))).collect();
    }

    pub(super) fn took(&mut self, sensor: usize, now: Instant) {
        if let Some(health) = self.sensors.get_mut(sensor) {
            health.taken += 1;
            health.last_taken = Some(now);
        }
    }

    /// Takes what a result says.
    pub(super) fn judge(&mut self, update: &Update) {
        if let (Some(Seen::Camera(camera)), Some(sensor)) = (&update.seen, update.sensor)
            && let Some(health) = self.sensors.get_mut(sensor)
        {
            health.low_reliability = Some(camera.low_reliability_fraction);
        }
        let Some(map) = &update.map else { return };
        for (health, &state) in self.sensors.iter_mut().zip(&map.sensors) {
            health.state = state;
        }
    }

    /// The map's state: the worst of its sensors', FAULT where the node itself is at fault.
    pub(super) fn state(&self) -> State {
        let sensors = self.sensors.iter().map(|sensor| sensor.state).max().unwrap_or(State::Stale);
        if self.fault.is_some() { State::Fault } else { sensors }
    }

    /// What happened in all, in words.
    pub(super) fn summary(&self) -> Vec<String> {
        let messages = self.input.iter().map(|(key, value)| format!("{key}: {value}"));
        let sensor = |sensor: &SensorHealth| {
            let SensorHealth { name, taken, without_pose, refused, before_jump, .. } = sensor;
            let reason = sensor.last_refused.iter().map(|reason| format!(", the last: {reason}"));
            format!(
                "{name}: {taken} used, {without_pose} without a pose, {before_jump} from before a jump, {refused} refused{}",
                reason.collect::<String>()
            )
        };
        let maps = format!("{} maps published, {} too late to be", self.maps, self.late_maps);
        messages.chain(self.sensors.iter().map(sensor)).chain([maps]).collect()
    }

    /// The message of this second.
    pub(super) fn message(&mut self, stamp_ns: u64, now: Instant) -> DiagnosticArray {
        let seconds = self.looked.map_or(1.0, |looked| now.saturating_duration_since(looked).as_secs_f64());
        self.looked = Some(now);
        let rate = |count: u64, before: u64| {
            #[expect(clippy::cast_precision_loss, reason = "messages of a second")]
            let count = count.saturating_sub(before) as f64;
            count / seconds.max(1e-3)
        };
        self.maps_hz = rate(self.maps, self.maps_before);
        self.maps_before = self.maps;
        for sensor in &mut self.sensors {
            sensor.rate_hz = rate(sensor.taken, sensor.taken_before);
            sensor.taken_before = sensor.taken;
        }
        let mut status = vec![self.map()];
        status.extend(self.sensors.iter().map(|sensor| sensor.status(now)));
        status.push(self.messages());
        DiagnosticArray { header: Header::new(stamp_ns, ""), status }
    }

    /// What the map's state is now, where it has changed since this was asked last; nothing before the first map.
    pub(super) fn news(&mut self) -> Option<String> {
        let state = self.state();
        (self.maps > 0 && self.told.replace(state) != Some(state)).then(|| self.map().message)
    }

    fn messages(&self) -> DiagnosticStatus {
        let (level, message) = match self.input_suffers {
            true => (LEVEL_WARN, "messages were dropped, lost or not understood"),
            false => (LEVEL_OK, "OK"),
        };
        let values = self.input.iter().map(|(key, value)| pair(key, value.clone()));
        DiagnosticStatus {
            level,
            name: "limpid: messages".into(),
            message: message.into(),
            hardware_id: "limpid".into(),
            values: values.collect(),
        }
    }

    fn map(&self) -> DiagnosticStatus {
        let state = self.state();
        let worst = self.sensors.iter().filter(|sensor| state != State::Ok && sensor.state == state);
        let worst: Vec<_> = worst.map(|sensor| sensor.name.as_str()).collect();
        let message = match (&self.fault, &self.waits_for) {
            (Some(fault), _) => format!("FAULT: {fault}"),
            (None, Some(what)) => format!("{}: {what}", state.name()),
            (None, None) if self.sensors.is_empty() => format!("{}: no sensor found yet", state.name()),
            (None, None) if worst.is_empty() => state.name().to_owned(),
            (None, None) => format!("{}: {}", state.name(), worst.join(", ")),
        };
        let mut values = vec![
            pair("rate_hz", format!("{:.1}", self.maps_hz)),
            pair("published", self.maps.to_string()),
            pair("too_late", self.late_maps.to_string()),
            pair("latency_ms", format!("{:.1}", self.latency_ms)),
            pair("restarts", self.restarts.to_string()),
            pair("held_up", self.held_up.to_string()),
        ];
        values.extend(self.last_restart.iter().map(|reason| pair("last_restart", reason.clone())));
        DiagnosticStatus {
            level: level(state),
            name: "limpid: map".into(),
            message,
            hardware_id: "limpid".into(),
            values,
        }
    }
}

/// A robot drives on a map that is stale or at fault at its own risk: both are errors.
fn level(state: State) -> u8 {
    match state {
        State::Ok => LEVEL_OK,
        State::Degraded => LEVEL_WARN,
        State::Stale | State::Fault => LEVEL_ERROR,
    }
}

fn pair(key: &str, value: String) -> KeyValue {
    KeyValue { key: key.into(), value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Config, SensorConfig, SensorKind};

    #[test]
    fn the_worst_sensor_is_named_and_a_fault_is_above_all() {
        let sensor = |name: &str| {
            let found = SensorConfig::found(SensorKind::Camera, &Config::default());
            SensorInfo::missing(SensorConfig { name: name.into(), ..found })
        };
        let mut health = Health::default();
        health.watch(&[sensor("front"), sensor("rear")]);
        let now = Instant::now();
        health.sensors[0].state = State::Ok;
        health.took(0, now);
        let said = health.message(7, now).status;
        assert_eq!((said[0].level, said[0].message.as_str()), (LEVEL_ERROR, "STALE: rear"));
        assert_eq!((said[1].level, said[2].level), (LEVEL_OK, LEVEL_ERROR));
        assert!(said[2].message.contains("no data so far"), "{said:?}");
        health.fault = Some("the GPU is lost".into());
        assert_eq!(health.message(8, now).status[0].message, "FAULT: the GPU is lost");
        health.maps = 1;
        assert_eq!(health.news().as_deref(), Some("FAULT: the GPU is lost"));
        assert_eq!(health.news(), None);
        health.fault = None;
        assert_eq!(health.news().as_deref(), Some("STALE: rear"));
        // Counts of a sensor outlive a new start.
        health.watch(&[sensor("front")]);
        assert_eq!((health.sensors.len(), health.sensors[0].taken), (1, 1));
    }
}
