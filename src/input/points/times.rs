//! Times of a cloud's points: their unit, and the time they count from.
//!
//! Drivers write seconds, milliseconds, microseconds or nanoseconds, counted from the stamp, from 1970, or from a start of their
//! own such as the sensor's boot, without saying which. The unit follows from the type and from how far a scan's times lie
//! apart: a revolution lasts from 2 ms to 2 s.

use crate::input::points::table::{Column, Scalar, Table};
use crate::sensor::PointClock;

/// How the numbers of a column are turned into seconds after the stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeBase {
    unit_s: f64,
    /// The number that stands for the stamp.
    zero: f64,
    /// What the times count from.
    pub(super) clock: PointClock,
}

/// Units of times since 1970.
const ABSOLUTE_UNITS: [f64; 4] = [1e-9, 1e-6, 1e-3, 1.0];
/// Units of other times with the least number in each, of whole numbers and of floats.
const INTEGER_UNITS: [(f64, f64); 3] = [(2e6, 1e-9), (2e3, 1e-6), (0.0, 1e-3)];
const FLOAT_UNITS: [(f64, f64); 4] = [(2e6, 1e-9), (2e3, 1e-6), (10.0, 1e-3), (0.0, 1.0)];

/// Times since 1970 lie between 1973 and 2100, seconds.
const EPOCH_S: [f64; 2] = [1e8, 4.1e9];
/// Times since 1970 in 32 bits, as later numbers are taken for: from 2001 on, seconds.
const ROUNDED_S: f64 = 1e9;
/// Stamp and points are of one clock where they are no farther apart than this, seconds.
const SAME_CLOCK_S: f64 = 2.0;
/// Longest time of a scan, seconds.
const LONGEST_S: f64 = 10.0;
/// Longest time of clouds that are put together from scans, seconds.
const ACCUMULATED_S: f64 = 1e5;
/// A revolution takes this long, seconds.
const REVOLUTION_S: [f64; 2] = [2e-3, 0.5];
/// Floats smaller than this are whole numbers of 64 bits under a wrong type.
const LEAST_FLOAT: f64 = 1e-100;

/// Least and largest number of a column, NaN and infinities left out.
#[derive(Debug, Clone, Copy)]
struct Range {
    least: f64,
    most: f64,
}

impl Range {
    fn of(table: &Table, column: &Column) -> Self {
        let mut range = Self { least: f64::INFINITY, most: f64::NEG_INFINITY };
        for row in 0..table.height {
            for at in 0..table.width {
                let value = table.value(column, row, at);
                if value.is_finite() {
                    range = Self { least: range.least.min(value), most: range.most.max(value) };
                }
            }
        }
        range
    }

    fn spread(self) -> f64 {
        self.most - self.least
    }

    fn largest(self) -> f64 {
        self.least.abs().max(self.most.abs())
    }
}

fn unit(units: &[(f64, f64)], number: f64) -> f64 {
    units.iter().find(|(least, _)| number >= *least).map_or(1.0, |(_, unit_s)| *unit_s)
}

fn within([low, high]: [f64; 2], value: f64) -> bool {
    low <= value && value <= high
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rounded and cut off on purpose")]
fn stamp_of(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

/// The column as it is to be read: some drivers write 64-bit nanoseconds and call them floats, as `PointCloud2` has no type for
/// them.
pub(super) fn retyped(table: &Table, column: &Column) -> Column {
    let whole = Column { scalar: Scalar::U64, declared: Scalar::U64, ..column.clone() };
    let is_tiny = |range: Range| range.most > 0.0 && range.largest() < LEAST_FLOAT;
    let is_whole = column.scalar == Scalar::F64
        && is_tiny(Range::of(table, column))
        && within(EPOCH_S, Range::of(table, &whole).most * 1e-9);
    if is_whole { whole } else { column.clone() }
}

impl TimeBase {
    /// Of a column. Without a stamp, times since 1970 count from the earliest, which then is the stamp.
    pub(super) fn of(table: &Table, column: &Column, stamp_ns: &mut u64) -> Self {
        let range = Range::of(table, column);
        if range.least > range.most {
            return Self { unit_s: 0.0, zero: 0.0, clock: PointClock::Stamp };
        }
        let is_epoch =
            |unit_s: &f64| within(EPOCH_S, range.least * unit_s) && range.spread() * unit_s <= LONGEST_S;
        if let Some(unit_s) =
            ABSOLUTE_UNITS.into_iter().find(is_epoch).filter(|_| column.declared.size() == 8)
        {
            return Self::absolute(range, unit_s, stamp_ns);
        }
        let is_float = matches!(column.declared, Scalar::F32 | Scalar::F64);
        let useless = match (column.declared, range.spread()) {
            _ if !within([ROUNDED_S, EPOCH_S[1]], range.least) => None,
            (Scalar::F32, _) | (Scalar::U32 | Scalar::I32, 0.0..=LONGEST_S) => Some(PointClock::Rounded),
            (Scalar::F64, 0.0..=ACCUMULATED_S) => Some(PointClock::Spread),
            _ => None,
        };
        if let Some(clock) = useless {
            return Self { unit_s: 0.0, zero: 0.0, clock };
        }
        Self::unstated(range, if is_float { &FLOAT_UNITS } else { &INTEGER_UNITS })
    }

    fn absolute(range: Range, unit_s: f64, stamp_ns: &mut u64) -> Self {
        if *stamp_ns == 0 {
            *stamp_ns = stamp_of(range.least * unit_s);
            return Self { unit_s, zero: range.least, clock: PointClock::Stamp };
        }
        #[expect(clippy::cast_precision_loss, reason = "a quarter of a microsecond")]
        let zero = *stamp_ns as f64 * 1e-9 / unit_s;
        let apart_s = (zero - range.most).max(range.least - zero) * unit_s;
        if apart_s > SAME_CLOCK_S {
            return Self { unit_s, zero: range.least, clock: PointClock::Own };
        }
        Self { unit_s, zero, clock: PointClock::Stamp }
    }

    /// Times that count from the stamp, or from a start of their own: then their spread tells the unit.
    fn unstated(range: Range, units: &[(f64, f64)]) -> Self {
        let (spread, largest) = (range.spread(), range.largest());
        let of_largest = unit(units, largest);
        let of_spread = unit(units, spread);
        let is_own = spread * of_largest < REVOLUTION_S[0]
            && within(REVOLUTION_S, spread * of_spread)
            && largest * of_spread > SAME_CLOCK_S;
        let unit_s = if is_own { of_spread } else { of_largest };
        if spread * unit_s > LONGEST_S {
            return Self { unit_s: 0.0, zero: 0.0, clock: PointClock::Spread };
        }
        if largest * unit_s > SAME_CLOCK_S {
            return Self { unit_s, zero: range.least, clock: PointClock::Own };
        }
        Self { unit_s, zero: 0.0, clock: PointClock::Stamp }
    }

    /// Seconds after the stamp.
    pub(super) fn seconds(self, value: f64) -> f64 {
        if self.unit_s == 0.0 { 0.0 } else { (value - self.zero) * self.unit_s }
    }
}
