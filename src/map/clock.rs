//! The map's time: ticks since it began, the newest stamp of any sensor, and which sensors are behind it (spec 4 §3).

use crate::base::duration_ns;
use crate::map::State;

/// Nanoseconds of a tick.
const TICK_NS: u64 = 10_000_000;

/// A stamp this far before the newest of its own sensor is a clock set back or a recording that looped, nanoseconds.
const JUMP_NS: u64 = 1_000_000_000;

/// A stamp this far ahead of all other sensors is not believed at first, nanoseconds.
const AHEAD_NS: u64 = 10_000_000_000;

/// How long before its first observation a map's ticks begin, nanoseconds: what comes late after it has ticks of its own.
const LEAD_NS: u64 = 10_000_000_000;

/// So many stamps in a row that lie ahead are believed: the clock is another one, or all others ended.
const AHEAD_BELIEVED: u32 = 3;

/// What a stamp told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival {
    /// Tick of the stamp, from 1.
    pub tick: u32,
    /// Seconds since the sensor's observation before, in whole nanoseconds; `None` for the first.
    pub since_last_ns: Option<u64>,
    /// Whether the sensor's stamps jumped back: its time goes on from the map's.
    pub jumped: bool,
}

/// A sensor's time.
#[derive(Debug, Clone, Copy, Default)]
struct Track {
    timeout_ns: u64,
    /// In the map's time.
    last_ns: Option<u64>,
    /// From the sensor's stamps to the map's time.
    offset_ns: i128,
    /// Evidence before this tick is stale.
    fresh_since: u32,
    ahead: u32,
    /// The last stamp that was not believed, in the map's time.
    ahead_ns: Option<u64>,
}

impl Track {
    fn map_ns(&self, stamp_ns: u64) -> u64 {
        u64::try_from((i128::from(stamp_ns) + self.offset_ns).max(0)).unwrap_or(u64::MAX)
    }

    fn is_stale(&self, now_ns: u64) -> bool {
        match self.last_ns {
            None => true,
            Some(last_ns) => self.timeout_ns > 0 && now_ns.saturating_sub(last_ns) > self.timeout_ns,
        }
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub struct Clock {
    began_ns: Option<u64>,
    now_ns: u64,
    tracks: Vec<Track>,
}

impl Clock {
    /// Length of a tick, seconds.
    pub const TICK_S: f64 = std::time::Duration::from_nanos(TICK_NS).as_secs_f64();

    /// A duration in ticks, rounded up; 0 of 0.
    pub fn ticks(seconds: f64) -> u32 {
        u32::try_from(duration_ns(seconds).div_ceil(TICK_NS)).unwrap_or(u32::MAX)
    }

    /// For sensors that are stale after so many nanoseconds without data; 0: never.
    pub fn new(timeouts_ns: &[u64]) -> Self {
        let track = |&timeout_ns: &u64| Track { timeout_ns, ..Track::default() };
        Self { began_ns: None, now_ns: 0, tracks: timeouts_ns.iter().map(track).collect() }
    }

    /// Seconds by which a stamp is ahead of all other sensors, where it is so far ahead that it is not believed yet.
    pub fn ahead_s(&mut self, sensor: usize, stamp_ns: u64) -> Option<u64> {
        let now_ns = self.now_ns;
        let heard =
            |track: &Track| track.last_ns.is_some_and(|last_ns| now_ns - last_ns.min(now_ns) < JUMP_NS);
        let at_ns = self.tracks.get(sensor)?.map_ns(stamp_ns);
        let other = |is: &dyn Fn(&Track) -> bool| {
            self.tracks.iter().enumerate().any(|(at, track)| at != sensor && is(track))
        };
        let others = other(&heard);
        // Two sensors that say the same are believed: all of them paused.
        let agreed =
            other(&|track| track.ahead_ns.is_some_and(|other_ns| other_ns.abs_diff(at_ns) <= AHEAD_NS));
        let track = self.tracks.get_mut(sensor)?;
        let by_ns = at_ns.saturating_sub(now_ns);
        if !others || by_ns <= AHEAD_NS || agreed {
            (track.ahead, track.ahead_ns) = (0, None);
            return None;
        }
        track.ahead += 1;
        track.ahead_ns = Some(at_ns);
        (track.ahead <= AHEAD_BELIEVED).then_some(by_ns / 1_000_000_000)
    }

    /// Takes on a sensor's stamp.
    pub fn observe(&mut self, sensor: usize, stamp_ns: u64) -> Arrival {
        let now_ns = self.now_ns;
        let Some(track) = self.tracks.get_mut(sensor) else {
            return Arrival { tick: 1, since_last_ns: None, jumped: false };
        };
        let mut at_ns = track.map_ns(stamp_ns);
        let jumped = track.last_ns.is_some_and(|last_ns| at_ns.saturating_add(JUMP_NS) < last_ns);
        if jumped {
            track.offset_ns += i128::from(now_ns) - i128::from(at_ns);
            at_ns = now_ns;
        }
        let since_last_ns = track.last_ns.map(|last_ns| at_ns.saturating_sub(last_ns));
        let began_ns = *self.began_ns.get_or_insert(at_ns.saturating_sub(LEAD_NS));
        let tick = tick_of(began_ns, at_ns);
        if track.is_stale(at_ns) {
            track.fresh_since = tick;
        }
        track.last_ns = Some(track.last_ns.unwrap_or(0).max(at_ns));
        self.now_ns = now_ns.max(at_ns);
        Arrival { tick, since_last_ns, jumped }
    }

    /// The newest stamp, nanoseconds in the map's time; 0 before the first.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// The newest tick.
    pub fn now(&self) -> u32 {
        self.began_ns.map_or(0, |began_ns| tick_of(began_ns, self.now_ns))
    }

    /// Moves on to a time without data, as a robot's clock does.
    pub fn advance(&mut self, now_ns: u64) {
        self.now_ns = self.now_ns.max(now_ns);
    }

    /// Of each sensor the tick before which its evidence is stale; `u32::MAX` for a sensor that is stale now.
    pub fn fresh_since(&self) -> Vec<u32> {
        let of = |track: &Track| if track.is_stale(self.now_ns) { u32::MAX } else { track.fresh_since };
        self.tracks.iter().map(of).collect()
    }

    /// Which sensors are stale now.
    pub fn states(&self) -> Vec<State> {
        self.states_at(self.now_ns)
    }

    /// Which sensors will be stale at a time, if nothing comes until then.
    pub fn states_at(&self, now_ns: u64) -> Vec<State> {
        let of = |track: &Track| if track.is_stale(now_ns) { State::Stale } else { State::Ok };
        self.tracks.iter().map(of).collect()
    }
}

fn tick_of(began_ns: u64, at_ns: u64) -> u32 {
    u32::try_from(at_ns.saturating_sub(began_ns) / TICK_NS + 1).unwrap_or(u32::MAX - 1)
}
