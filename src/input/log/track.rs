//! The stamps of one sensor as a log is read: how far they are, and where they jump back.

use crate::input::transforms::JUMP_NS;

/// Stamps that differ by more than this when they are read are of different clocks, nanoseconds.
const CLOCKS_DIFFER_NS: u64 = 1_000_000_000;

/// See the module.
#[derive(Debug, Clone, Default)]
pub(super) struct Track {
    /// Newest stamp since the last jump, nanoseconds.
    pub(super) newest_ns: Option<u64>,
    /// First stamp since the last jump, nanoseconds.
    pub(super) first_ns: Option<u64>,
    /// Log time of the newest message, nanoseconds.
    log_time_ns: u64,
    /// How often stamps have jumped back by more than a second.
    pub(super) jumps: u32,
}

impl Track {
    /// Takes in a stamp; whether it jumps back.
    pub(super) fn see(&mut self, stamp_ns: u64, log_time_ns: u64) -> bool {
        let jumps = self.newest_ns.is_some_and(|newest_ns| stamp_ns.saturating_add(JUMP_NS) < newest_ns);
        if jumps {
            self.jumps += 1;
            (self.newest_ns, self.first_ns) = (None, None);
        }
        self.newest_ns = self.newest_ns.max(Some(stamp_ns));
        self.first_ns.get_or_insert(stamp_ns);
        self.log_time_ns = log_time_ns;
        jumps
    }

    /// How far the stamps have come since the last jump, nanoseconds.
    pub(super) fn span_ns(&self) -> u64 {
        self.newest_ns
            .zip(self.first_ns)
            .map_or(0, |(newest_ns, first_ns)| newest_ns.saturating_sub(first_ns))
    }

    /// Seconds that the stamps of `self` are ahead of another sensor's as both were read, where the two clocks differ: the
    /// difference is neither the time that went by in the log nor that of a jump which the other has still to make.
    pub(super) fn ahead_of_s(&self, other: &Self) -> Option<f64> {
        let (newest_ns, other_ns) = (i128::from(self.newest_ns?), i128::from(other.newest_ns?));
        let ahead_ns = newest_ns - other_ns;
        let logged_ns = i128::from(self.log_time_ns) - i128::from(other.log_time_ns);
        let far = |ns: i128| ns.unsigned_abs() > u128::from(CLOCKS_DIFFER_NS);
        if self.jumps != other.jumps || !far(ahead_ns) || !far(ahead_ns - logged_ns) {
            return None;
        }
        #[expect(clippy::cast_precision_loss, reason = "told to a tenth of a second")]
        let ahead_s = ahead_ns as f64 * 1e-9;
        Some(ahead_s)
    }
}
