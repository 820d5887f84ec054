//! From the columns of a cloud to points: which column is what, units of time, numbers that cannot be.

use crate::base::Result;
use crate::input::points::Options;
use crate::input::points::table::{Column, Scalar, Table};
use crate::message::decode_error;
use crate::sensor::{Columns, DropReason, Dropped, Point, ReturnType, Scan, Strength};

/// Most rings of an organized cloud whose points do not say theirs.
const MAX_RINGS: usize = 256;

/// The columns that are read.
struct Roles<'a> {
    x: &'a Column,
    y: &'a Column,
    z: &'a Column,
    intensity: &'a Column,
    ring: Option<&'a Column>,
    time: Option<&'a Column>,
    return_type: Option<&'a Column>,
    strength: Option<&'a Column>,
    label: Option<&'a Column>,
}

impl<'a> Roles<'a> {
    fn find(table: &'a Table) -> Result<Self> {
        let needed = |names: &[&str]| {
            table.find(names).ok_or_else(|| {
                let wanted = names.join("`, `");
                let reason = format!("it has no field `{wanted}`; its fields: {}", table.names());
                decode_error(table.what, reason)
            })
        };
        let roles = Self {
            x: needed(&["x"])?,
            y: needed(&["y"])?,
            z: needed(&["z"])?,
            intensity: needed(&["intensity", "reflectivity", "i"])?,
            ring: table.find(&["ring", "line", "channel"]),
            time: table.find(&["time", "t", "timestamp", "time_stamp", "time_s"]),
            return_type: table.find(&["return_type", "return"]),
            strength: table.find(&["strength"]),
            label: table.find(&["label"]),
        };
        roles.check_apart(table)?;
        Ok(roles)
    }

    /// # Errors
    /// [`crate::Error::Decode`] where two of the columns share bytes or a name.
    fn check_apart(&self, table: &Table) -> Result<()> {
        let optional = [self.ring, self.time, self.return_type, self.strength, self.label];
        let mut used = vec![self.x, self.y, self.z, self.intensity];
        used.extend(optional.into_iter().flatten());
        for column in &used {
            let same = table.columns.iter().filter(|other| other.name.eq_ignore_ascii_case(&column.name));
            if same.count() > 1 {
                return Err(decode_error(table.what, format!("it has field `{}` twice", column.name)));
            }
        }
        used.sort_by_key(|column| column.offset);
        if table.points()? == 0 {
            return Ok(());
        }
        for pair in used.windows(2) {
            if pair[0].offset + pair[0].scalar.size() > pair[1].offset {
                let reason = format!("fields `{}` and `{}` overlap", pair[0].name, pair[1].name);
                return Err(decode_error(table.what, reason));
            }
        }
        Ok(())
    }
}

/// How times are turned into seconds after the stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
struct TimeBase {
    unit_s: f64,
    /// Time of the stamp, in the unit of the field.
    zero: f64,
}

/// Units of times, each with the least size that the largest number of a scan has in it: times since 1970 are later
/// than 1973, and a scan lasts from 2 ms to 2 s.
const ABSOLUTE_UNITS: [(f64, f64); 4] = [(1e17, 1e-9), (1e14, 1e-6), (1e11, 1e-3), (1e8, 1.0)];
const INTEGER_UNITS: [(f64, f64); 3] = [(2e6, 1e-9), (2e3, 1e-6), (0.0, 1e-3)];
const FLOAT_UNITS: [(f64, f64); 4] = [(2e6, 1e-9), (2e4, 1e-6), (10.0, 1e-3), (0.0, 1.0)];

impl TimeBase {
    /// By the size of the largest number. Times since 1970 need 64 bits; without a stamp they count from the earliest,
    /// which then is the stamp.
    fn of(table: &Table, column: &Column, stamp_ns: &mut u64) -> Self {
        let (mut earliest, mut largest) = (f64::INFINITY, 0.0_f64);
        for row in 0..table.height {
            for at in 0..table.width {
                let value = table.value(column, row, at);
                if value.is_finite() {
                    earliest = earliest.min(value);
                    largest = largest.max(value.abs());
                }
            }
        }
        let unit = |units: &[(f64, f64)]| units.iter().find(|(least, _)| largest >= *least).map(|u| u.1);
        if let Some(unit_s) = unit(&ABSOLUTE_UNITS).filter(|_| column.declared.size() == 8) {
            if *stamp_ns == 0 {
                *stamp_ns = stamp_of(earliest * unit_s);
                return Self { unit_s, zero: earliest };
            }
            #[expect(clippy::cast_precision_loss, reason = "a quarter of a microsecond")]
            let zero = *stamp_ns as f64 * 1e-9 / unit_s;
            return Self { unit_s, zero };
        }
        let is_float = matches!(column.declared, Scalar::F32 | Scalar::F64);
        let unit_s = if is_float { unit(&FLOAT_UNITS) } else { unit(&INTEGER_UNITS) };
        Self { unit_s: unit_s.unwrap_or(1.0), zero: 0.0 }
    }

    fn seconds(self, value: f64) -> f64 {
        (value - self.zero) * self.unit_s
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rounded and cut off on purpose")]
fn stamp_of(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

#[expect(clippy::cast_possible_truncation, reason = "narrowed on purpose: points have 32-bit floats")]
pub(super) fn narrow(value: f64) -> f32 {
    value as f32
}

/// Where in the grid of beams a point of an organized cloud stands.
#[derive(Debug, Clone, Copy)]
enum Grid {
    None,
    RingsAreRows,
    RingsAreColumns,
}

impl Grid {
    /// There are more firings in a scan than rings in a sensor.
    fn of(table: &Table) -> Self {
        let (rows, width) = (table.height, table.width);
        let fits = |rings: usize, columns: usize| {
            rings > 1 && rings <= MAX_RINGS && columns > rings && columns < usize::from(Point::UNKNOWN)
        };
        if fits(rows, width) {
            Self::RingsAreRows
        } else if fits(width, rows) {
            Self::RingsAreColumns
        } else {
            Self::None
        }
    }

    fn ring_and_column(self, row: usize, at: usize) -> [u16; 2] {
        let [ring, column] = match self {
            Self::None => return [Point::UNKNOWN; 2],
            Self::RingsAreRows => [row, at],
            Self::RingsAreColumns => [at, row],
        };
        [ring, column].map(|index| u16::try_from(index).unwrap_or(Point::UNKNOWN))
    }
}

/// A whole number in `0..end`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "checked to be a whole number in range"
)]
fn whole(value: f64, end: u32) -> Option<u32> {
    (value >= 0.0 && value < f64::from(end) && value.fract() == 0.0).then_some(value as u32)
}

/// Reads the points of one cloud.
struct Reader<'a> {
    table: &'a Table<'a>,
    roles: Roles<'a>,
    time: Option<(&'a Column, TimeBase)>,
    grid: Grid,
    options: &'a Options,
}

impl Reader<'_> {
    fn point(&self, row: usize, at: usize) -> Result<Point, DropReason> {
        let value = |column: &Column| self.table.value(column, row, at);
        let roles = &self.roles;
        let [x_m, y_m, z_m, intensity] =
            [roles.x, roles.y, roles.z, roles.intensity].map(|column| narrow(value(column)));
        let time_s = self.time.map_or(0.0, |(column, base)| narrow(base.seconds(value(column))));
        if ![x_m, y_m, z_m, intensity, time_s].iter().all(|value| value.is_finite()) {
            return Err(DropReason::NotFinite);
        }
        if [x_m, y_m, z_m] == [0.0; 3] {
            return Err(DropReason::NoReturn);
        }
        let [row_ring, column] = self.grid.ring_and_column(row, at);
        let ring = match roles.ring {
            Some(ring) => self.ring(value(ring))?,
            None => row_ring,
        };
        let code = roles.return_type.map(value);
        let (return_type, strength) = match code {
            Some(code) => self.options.return_codes.decode(code).ok_or(DropReason::ReturnCode)?,
            None => (ReturnType::Single, Strength::Unknown),
        };
        let own = roles.strength.and_then(|column| Strength::of_code(value(column)));
        let label = match roles.label {
            Some(label) => whole(value(label), Point::UNLABELLED).ok_or(DropReason::Label)?,
            None => Point::UNLABELLED,
        };
        let strength = own.unwrap_or(strength);
        Ok(Point {
            x_m,
            y_m,
            z_m,
            intensity,
            time_s,
            ring,
            column,
            return_type,
            strength,
            reserved: 0,
            label,
        })
    }

    /// The number that stands for no ring is one, too, so that a point keeps its place without its ring.
    fn ring(&self, value: f64) -> Result<u16, DropReason> {
        let ring = whole(value, u32::from(Point::UNKNOWN) + 1).and_then(|ring| u16::try_from(ring).ok());
        ring.ok_or(DropReason::Ring)
    }
}

/// The scan in a table, which is checked first; `stamp_ns` 0 where there is none.
///
/// # Errors
/// [`crate::Error::Decode`] for missing, doubled and overlapping fields and for those that run past the data.
pub(super) fn scan(table: &Table, mut stamp_ns: u64, frame_id: String, options: &Options) -> Result<Scan> {
    table.validate()?;
    let roles = Roles::find(table)?;
    // A cloud without points may still have any number of empty rows.
    let height = if table.width == 0 { 0 } else { table.height };
    let time = roles.time.filter(|_| height > 0);
    let time = time.map(|column| (column, TimeBase::of(table, column, &mut stamp_ns)));
    let grid = Grid::of(table);
    let organized = !matches!(grid, Grid::None);
    let columns = Columns {
        ring: roles.ring.is_some() || organized,
        column: organized,
        time: time.is_some(),
        return_type: roles.return_type.is_some(),
        label: roles.label.is_some(),
    };
    let reader = Reader { table, roles, time, grid, options };
    let (mut points, mut dropped) = (Vec::with_capacity(table.points()?), Dropped::default());
    for row in 0..height {
        for at in 0..table.width {
            match reader.point(row, at) {
                Ok(point) => points.push(point),
                Err(reason) => dropped.add(reason, 1),
            }
        }
    }
    Ok(Scan { index: 0, stamp_ns, frame_id, points, columns, dropped })
}
