//! Stamps in nanoseconds and durations in seconds.

/// Seconds from `before_ns` to `now_ns`, 0 where time went backwards.
pub fn seconds_between(before_ns: u64, now_ns: u64) -> f64 {
    std::time::Duration::from_nanos(now_ns.saturating_sub(before_ns)).as_secs_f64()
}

/// Nanoseconds of a duration in seconds; the configuration has checked that it is not negative.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates, which is meant")]
pub fn duration_ns(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}
