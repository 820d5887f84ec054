//! Points that are left out of a scan, counted by reason.

/// Why a point is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(usize)]
pub enum DropReason {
    /// The beam came back from nothing: distance 0, or a place at the origin.
    NoReturn,
    /// A coordinate, the intensity or the time is NaN or infinite.
    NotFinite,
    /// The return's code has no meaning in the configured [`crate::sensor::ReturnCodes`].
    ReturnCode,
}

impl DropReason {
    /// All, in order of their numbers.
    pub const ALL: [Self; 3] = [Self::NoReturn, Self::NotFinite, Self::ReturnCode];

    /// In words.
    pub fn text(self) -> &'static str {
        match self {
            Self::NoReturn => "no return",
            Self::NotFinite => "a value is NaN or infinite",
            Self::ReturnCode => "the return's code is unknown",
        }
    }
}

/// Counts of points left out.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Dropped {
    counts: [u64; DropReason::ALL.len()],
}

impl Dropped {
    /// How many were left out for `reason`.
    pub fn count(&self, reason: DropReason) -> u64 {
        self.counts[reason as usize]
    }

    /// How many were left out.
    pub fn total(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The reasons there were, with their counts.
    pub fn reasons(&self) -> impl Iterator<Item = (DropReason, u64)> {
        let counts = *self;
        DropReason::ALL.into_iter().map(move |reason| (reason, counts.count(reason))).filter(|&(_, n)| n > 0)
    }

    pub(crate) fn add(&mut self, reason: DropReason, points: u64) {
        self.counts[reason as usize] += points;
    }

    pub(crate) fn add_all(&mut self, other: Self) {
        for (sum, count) in self.counts.iter_mut().zip(other.counts) {
            *sum += count;
        }
    }
}
