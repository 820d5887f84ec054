//! The safety state of sensors and of the map.

/// How far a sensor, or the map, can be trusted (spec 4 §3). The map's is the worst of its sensors'.
///
/// ```
/// use limpid::State;
///
/// let sensors = [State::Ok, State::Stale, State::Degraded];
/// assert_eq!(sensors.iter().max(), Some(&State::Stale));
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum State {
    /// Data come, and they are good.
    #[default]
    Ok,
    /// Data come, and many of them are unreliable (spec 1 §5).
    Degraded,
    /// No data for longer than the sensor's `timeout_s`, or never.
    Stale,
    /// The sensor cannot be used any more.
    Fault,
}

impl State {
    /// Its name, as in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ok => "OK",
            Self::Degraded => "DEGRADED",
            Self::Stale => "STALE",
            Self::Fault => "FAULT",
        }
    }
}
