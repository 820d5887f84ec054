//! A cell seen by several cameras at times of their own (spec 4 §1), beside what `update` keeps of it.

/// What one frame says of the cell: mean R, lowest and highest hit in metres above the height band's lower edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Look {
    Hit { mean_r: f64, low_m: f64, high_m: f64 },
    Seen,
    Nothing,
}

/// What is known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Marked {
    pub(crate) p: f64,
    pub(crate) occupied: bool,
    pub(crate) free: bool,
    /// Tick and sensor of the last look.
    pub(crate) last: Option<(u32, u32)>,
    /// Lowest of the hits that are remembered.
    pub(crate) low_m: Option<f64>,
    pub(crate) mean_r: f64,
}

impl Marked {
    /// Takes a frame at `tick` in, of which lambda is 0.85 for 30 Hz.
    pub(crate) fn look(&mut self, tick: u32, sensor: u32, timed: bool, look: Look) {
        if look == Look::Nothing || self.last.is_some_and(|(last, _)| last > tick) {
            return;
        }
        let lambda = match self.last {
            Some((last, _)) if timed => 0.85_f64.powf(f64::from(tick - last) * 0.01 * 30.0),
            _ => 0.85,
        };
        self.last = Some((tick, sensor));
        let e = if let Look::Hit { mean_r, .. } = look { mean_r } else { 0.0 };
        self.p = lambda * self.p + (1.0 - lambda) * e;
        self.occupied = self.p >= 0.7 || self.occupied && self.p >= 0.5;
        if let Look::Hit { mean_r, low_m, .. } = look {
            self.low_m = Some(self.low_m.map_or(low_m, |before| before.min(low_m)));
            self.mean_r = mean_r;
            self.free &= !self.occupied;
        } else {
            self.free = !self.occupied && (self.free || self.p < 0.5);
            if self.free {
                (self.low_m, self.mean_r) = (None, 0.0);
            }
        }
    }
}
