//! The node's time: that of a clock that never jumps, or with `use_sim_time` that of `/clock`; and what the map's time is now.

use std::time::{Duration, Instant};

/// `/clock` that goes back by more than this was set back, nanoseconds.
const JUMP_NS: u64 = 1_000_000_000;

/// See the module.
#[derive(Debug, Clone)]
pub(super) struct Timeline {
    start: Instant,
    /// Newest time of `/clock`, where that is the time, nanoseconds.
    simulated: Option<Simulated>,
    /// The newest stamp, and what the clock said when it came, nanoseconds.
    anchor: Option<(u64, u64)>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Simulated {
    last_ns: Option<u64>,
    /// Time that went by, jumps left out.
    passed_ns: u64,
}

impl Timeline {
    pub(super) fn new(use_sim_time: bool) -> Self {
        let simulated = use_sim_time.then(Simulated::default);
        Self { start: Instant::now(), simulated, anchor: None }
    }

    /// Nanoseconds since the start at an instant, whatever `/clock` says: what bounds waits for messages.
    pub(super) fn steady_ns(&self, at: Instant) -> u64 {
        nanoseconds(at.saturating_duration_since(self.start))
    }

    /// Takes the time of `/clock`; whether it was set back.
    pub(super) fn take_clock(&mut self, stamp_ns: u64) -> bool {
        let Some(simulated) = &mut self.simulated else { return false };
        let last_ns = simulated.last_ns.replace(stamp_ns).unwrap_or(stamp_ns);
        simulated.passed_ns += stamp_ns.saturating_sub(last_ns);
        stamp_ns.saturating_add(JUMP_NS) < last_ns
    }

    fn passed_ns(&self, at: Instant) -> u64 {
        match &self.simulated {
            Some(simulated) => simulated.passed_ns,
            None => self.steady_ns(at),
        }
    }

    /// Takes in that data which came at `at` moved the map's time from `before_ns` to `after_ns`. Data that did not move it say
    /// nothing: they waited while it went on without them.
    pub(super) fn took(&mut self, [before_ns, after_ns]: [u64; 2], at: Instant) {
        if after_ns > before_ns {
            self.anchor = Some((after_ns, self.passed_ns(at)));
        }
    }

    /// The map begins anew.
    pub(super) fn forget(&mut self) {
        self.anchor = None;
    }

    /// The map's time now: that of the newest data and what has gone by since; `None` before any.
    pub(super) fn map_ns(&self, at: Instant) -> Option<u64> {
        let (newest_ns, then_ns) = self.anchor?;
        Some(newest_ns.saturating_add(self.passed_ns(at).saturating_sub(then_ns)))
    }

    /// What messages without data of a sensor are stamped with: `/clock`, or this machine's.
    pub(super) fn stamp_ns(&self) -> u64 {
        let machine_ns = || {
            let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
            since.map_or(0, nanoseconds)
        };
        match &self.simulated {
            Some(simulated) => simulated.last_ns.unwrap_or(0),
            None => machine_ns(),
        }
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn time_goes_on_without_data_whatever_the_stamps_are() {
        let mut time = Timeline::new(false);
        let start = time.start;
        assert_eq!(time.map_ns(start), None);
        time.took([0, 7 * SECOND], start + Duration::from_secs(3));
        assert_eq!(time.map_ns(start + Duration::from_secs(5)), Some(9 * SECOND));
        // An older stamp says nothing.
        time.took([7 * SECOND; 2], start + Duration::from_secs(4));
        assert_eq!(time.map_ns(start + Duration::from_secs(5)), Some(9 * SECOND));
    }

    #[test]
    fn what_waited_while_time_went_on_without_data_does_not_set_it_ahead() {
        let mut time = Timeline::new(false);
        let at = |seconds| time.start + Duration::from_secs(seconds);
        let [first, second, third, late] = [0, 1, 2, 6].map(at);
        // A frame a second, and passes that take five seconds to build: the map goes on without data, then come the others.
        time.took([0, 10 * SECOND], first);
        let stale_ns = time.map_ns(late).unwrap();
        assert_eq!(stale_ns, 16 * SECOND);
        time.took([stale_ns; 2], second);
        time.took([stale_ns; 2], third);
        assert_eq!(time.map_ns(late), Some(16 * SECOND));
        time.took([stale_ns, 17 * SECOND], late + Duration::from_secs(1));
        assert_eq!(time.map_ns(late + Duration::from_secs(2)), Some(18 * SECOND));
    }

    #[test]
    fn simulated_time_stands_still_while_clock_does_and_tells_of_jumps() {
        let mut time = Timeline::new(true);
        let later = time.start + Duration::from_secs(60);
        assert!(!time.take_clock(100 * SECOND));
        time.took([0, 5 * SECOND], time.start);
        assert_eq!(time.map_ns(later), Some(5 * SECOND));
        assert!(!time.take_clock(102 * SECOND));
        assert_eq!(time.map_ns(later), Some(7 * SECOND));
        assert!(time.take_clock(10 * SECOND));
        assert!(!time.take_clock(11 * SECOND));
        assert_eq!(time.map_ns(later), Some(8 * SECOND), "a jump back is no time");
    }
}
