//! Whose turn it is: the observations of several sensors in order of their stamps, as far as it can be known.
//!
//! The order of one sensor's own observations is that of its recording. An observation waits for an earlier one of
//! another sensor while that is known to wait, and for one that may still come until the other sensor's stamps have passed
//! its own or the newest stamp of all is a window past it. It waits for nothing once too many wait. Stamps that have
//! jumped back come after those that have not.

use crate::input::log::sensor::LogSensor;

/// Most observations that wait for their turn.
pub(super) const MAX_READY: usize = 64;

/// Jumps back, then stamp, nanoseconds.
type Moment = (u32, u64);

/// The first that is ready of a sensor.
fn first(sensor: &LogSensor) -> Option<Moment> {
    sensor.ready.front().map(|(jumps, observation)| (*jumps, observation.stamp_ns()))
}

/// The sensor whose first observation is to be given now.
pub(super) fn turn(sensors: &[LogSensor], window_ns: u64, at_end: bool) -> Option<usize> {
    let ready = sensors.iter().enumerate().filter_map(|(at, sensor)| Some((first(sensor)?, at)));
    let (moment, at) = ready.min()?;
    let many = || sensors.iter().map(|sensor| sensor.ready.len()).sum::<usize>() > MAX_READY;
    if at_end || sensors.len() == 1 || many() {
        return Some(at);
    }
    let seen = |sensor: &LogSensor| Some((sensor.track.jumps, sensor.track.newest_ns?));
    let window_end = (moment.0, moment.1.saturating_add(window_ns));
    // A clock that differs says nothing of how long this has waited.
    let own = &sensors[at].track;
    let alike = sensors.iter().filter(|sensor| sensor.track.ahead_of_s(own).is_none());
    let passed =
        own.jumps > moment.0 || alike.filter_map(seen).any(|seen| seen.0 == moment.0 && seen >= window_end);
    let awaited = |sensor: &LogSensor| match sensor.waiting_ns() {
        _ if !sensor.ready.is_empty() => false,
        Some(waiting_ns) => (sensor.track.jumps, waiting_ns) < moment,
        None => !passed && seen(sensor) < Some(moment),
    };
    (!sensors.iter().any(awaited)).then_some(at)
}
