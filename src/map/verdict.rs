//! What the map says of a cell, and why.

/// The rule's word of a cell (spec 4 §4), as the shader packs it: cost in bits 0-7, row of the rule in bits 8-11, sensor in
/// bits 12-16, age in bits 17-31.
///
/// ```
/// // Glass (row 1), seen by the third sensor 0.3 s ago.
/// let verdict = limpid::Verdict::pack(254, 1, Some(2), 3);
/// assert_eq!((verdict.cost(), verdict.row(), verdict.sensor(), verdict.age_s()), (254, 1, Some(2), 0.3));
/// assert_eq!(limpid::map::rule::ROWS[0].name, "glass");
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Verdict(pub u32);

/// Largest age that a word holds, tenths of a second.
pub const MOST_AGE: u32 = (1 << 15) - 1;

impl Verdict {
    /// Cost before inflation: 0 free, the passable cost, 254 lethal, 255 unknown.
    pub fn cost(self) -> u8 {
        self.0.to_le_bytes()[0]
    }

    /// Row of the rule that applied, from 1; 0 where no rule was asked.
    pub fn row(self) -> u32 {
        (self.0 >> 8) & 0xf
    }

    /// The sensor that it comes from, as the configuration counts them; `None`: none.
    pub fn sensor(self) -> Option<usize> {
        usize::try_from((self.0 >> 12) & 0x1f).ok()?.checked_sub(1)
    }

    /// [`Self::row`] as a byte.
    pub fn reason(self) -> u8 {
        self.0.to_le_bytes()[1] & 0xf
    }

    /// The sensor counted from 1; 0: none.
    pub fn sensor_number(self) -> u8 {
        self.sensor().and_then(|sensor| u8::try_from(sensor + 1).ok()).unwrap_or(0)
    }

    /// Time since that sensor's last evidence, seconds; at most [`MOST_AGE`] tenths. 0 where there is none.
    pub fn age_s(self) -> f64 {
        f64::from(self.0 >> 17) / 10.0
    }

    /// A word of these parts.
    pub fn pack(cost: u8, row: u32, sensor: Option<usize>, age_tenths: u32) -> Self {
        let sensor = sensor.map_or(0, |sensor| u32::try_from(sensor).unwrap_or(30).min(30) + 1);
        Self(u32::from(cost) | (row & 0xf) << 8 | sensor << 12 | age_tenths.min(MOST_AGE) << 17)
    }
}
