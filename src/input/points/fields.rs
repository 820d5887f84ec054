//! From the columns of a cloud to points: which column is what, units of time, numbers that cannot be.

use crate::base::Result;
use crate::input::points::Options;
use crate::input::points::table::{Column, Table};
use crate::input::points::times::{TimeBase, retyped};
use crate::message::decode_error;
use crate::sensor::{Columns, DropReason, Dropped, Point, PointClock, ReturnType, Scan, Strength};

/// Most rings of an organized cloud whose points do not say theirs.
const MAX_RINGS: usize = 256;

/// Names of intensities, the commonest first. CloudCompare puts `scalar_` before any name.
pub(crate) const INTENSITY: &[&str] = &[
    "intensity",
    "intensities",
    "reflectivity",
    "reflectance",
    "reflection",
    "remission",
    "i",
    "signal",
    "amplitude",
    "echo_intensity",
    "signal_photons",
    "refl",
    "intens",
];

/// Names of rings. `line` and `laser` of a Livox sensor count lasers that draw a rosette, so that they are no rings.
pub(crate) const RING: &[&str] = &["ring", "channel", "ring_id", "row"];

/// Names of times of points.
pub(crate) const TIME: &[&str] = &[
    "time",
    "t",
    "timestamp",
    "time_stamp",
    "time_s",
    "offset_time",
    "time_offset",
    "point_time_offset",
    "gps_time",
];

/// The columns that are read.
struct Roles<'a> {
    x: &'a Column,
    y: &'a Column,
    z: &'a Column,
    intensity: Option<&'a Column>,
    ring: Option<&'a Column>,
    time: Option<&'a Column>,
    return_type: Option<&'a Column>,
    strength: Option<&'a Column>,
    label: Option<&'a Column>,
}

impl<'a> Roles<'a> {
    fn find(table: &'a Table, options: &Options) -> Result<Self> {
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
            intensity: match &options.intensity_field {
                Some(stated) => Some(needed(&[stated])?),
                None => table.find(INTENSITY),
            },
            ring: table.find(RING),
            time: table.find(TIME),
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
        let optional = [self.intensity, self.ring, self.time, self.return_type, self.strength, self.label];
        let mut used = vec![self.x, self.y, self.z];
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
    time: Option<(Column, TimeBase)>,
    grid: Grid,
    options: &'a Options,
}

impl Reader<'_> {
    fn point(&self, row: usize, at: usize) -> Result<Point, DropReason> {
        let value = |column: &Column| self.table.value(column, row, at);
        let roles = &self.roles;
        let [x_m, y_m, z_m] = [roles.x, roles.y, roles.z].map(|column| narrow(value(column)));
        let intensity = roles.intensity.map_or(0.0, |column| narrow(value(column)));
        let time_s = self.time.as_ref().map_or(0.0, |(column, base)| narrow(base.seconds(value(column))));
        if ![x_m, y_m, z_m, intensity, time_s].iter().all(|value| value.is_finite()) {
            return Err(DropReason::NotFinite);
        }
        if [x_m, y_m, z_m] == [0.0; 3] {
            return Err(DropReason::NoReturn);
        }
        let [row_ring, column] = self.grid.ring_and_column(row, at);
        // A point keeps its place without its ring or its label: it may be of an obstacle.
        let ring = match roles.ring.map(|ring| whole(value(ring), u32::from(Point::UNKNOWN))) {
            Some(ring) => ring.and_then(|ring| u16::try_from(ring).ok()).unwrap_or(Point::UNKNOWN),
            None => row_ring,
        };
        let code = roles.return_type.map(value);
        let (return_type, strength) = match code {
            Some(code) => self.options.return_codes.decode(code).ok_or(DropReason::ReturnCode)?,
            None => (ReturnType::Single, Strength::Unknown),
        };
        let own = roles.strength.and_then(|column| Strength::of_code(value(column)));
        let label = roles.label.and_then(|label| whole(value(label), Point::UNLABELLED));
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
            label: label.unwrap_or(Point::UNLABELLED),
        })
    }
}

/// The scan in a table, which is checked first; `stamp_ns` 0 where there is none.
///
/// # Errors
/// [`crate::Error::Decode`] for missing, doubled and overlapping fields and for those that run past the data.
pub(super) fn scan(table: &Table, mut stamp_ns: u64, frame_id: String, options: &Options) -> Result<Scan> {
    table.validate()?;
    let mut roles = Roles::find(table, options)?;
    // A cloud without points may still have any number of empty rows.
    let height = if table.width == 0 { 0 } else { table.height };
    // Some drivers fill what they do not measure with NaN.
    let is_finite = |column: &&Column| {
        let mut values = (0..height).flat_map(|row| (0..table.width).map(move |at| (row, at)));
        height == 0 || values.any(|(row, at)| table.value(column, row, at).is_finite())
    };
    roles.intensity = roles.intensity.filter(is_finite);
    let time = roles.time.filter(|_| height > 0).map(|column| retyped(table, column));
    let time = time.map(|column| {
        let base = TimeBase::of(table, &column, &mut stamp_ns);
        (column, base)
    });
    let clock = time.as_ref().map_or(PointClock::Stamp, |(_, base)| base.clock);
    let grid = Grid::of(table);
    let organized = !matches!(grid, Grid::None);
    let columns = Columns {
        intensity: roles.intensity.is_some(),
        ring: roles.ring.is_some() || organized,
        column: organized,
        time: time.is_some() && clock.is_usable(),
        clock,
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
