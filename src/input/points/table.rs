//! Named columns of numbers in bytes: the common form of clouds in messages and files.

use crate::base::Result;
use crate::message::decode_error;

/// What CloudCompare writes before names.
const SCALAR: &str = "scalar_";

/// How a number lies in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The number in the first bytes; 64-bit integers are rounded to 53 bits.
    #[expect(clippy::cast_precision_loss, reason = "64-bit integers are times, to less than a microsecond")]
    fn read(self, bytes: &[u8], big_endian: bool) -> f64 {
        match self {
            Self::I8 => i8::from_le_bytes(take(bytes, big_endian)).into(),
            Self::U8 => u8::from_le_bytes(take(bytes, big_endian)).into(),
            Self::I16 => i16::from_le_bytes(take(bytes, big_endian)).into(),
            Self::U16 => u16::from_le_bytes(take(bytes, big_endian)).into(),
            Self::I32 => i32::from_le_bytes(take(bytes, big_endian)).into(),
            Self::U32 => u32::from_le_bytes(take(bytes, big_endian)).into(),
            Self::F32 => f32::from_le_bytes(take(bytes, big_endian)).into(),
            Self::I64 => i64::from_le_bytes(take(bytes, big_endian)) as f64,
            Self::U64 => u64::from_le_bytes(take(bytes, big_endian)) as f64,
            Self::F64 => f64::from_le_bytes(take(bytes, big_endian)),
        }
    }
}

/// The first bytes, the least significant first.
fn take<const N: usize>(bytes: &[u8], big_endian: bool) -> [u8; N] {
    let mut le = [0; N];
    le.copy_from_slice(&bytes[..N]);
    if big_endian {
        le.reverse();
    }
    le
}

/// Where the numbers of a field lie: that of point (row, column) at `offset + row * row_step + column * stride`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Column {
    pub(super) name: String,
    /// As it lies in the bytes.
    pub(super) scalar: Scalar,
    /// As the source declares it; text is parsed into 64-bit floats, whatever it stands for.
    pub(super) declared: Scalar,
    pub(super) offset: usize,
    pub(super) stride: usize,
}

/// Whether a field has a name, whatever its case; CloudCompare puts `scalar_` before any.
pub(crate) fn is_named(field: &str, name: &str) -> bool {
    let bare = field.get(..SCALAR.len()).filter(|start| start.eq_ignore_ascii_case(SCALAR));
    let bare = bare.map_or(field, |_| &field[SCALAR.len()..]);
    bare.eq_ignore_ascii_case(name)
}

/// A cloud of `height` rows of `width` points.
#[derive(Debug)]
pub(super) struct Table<'a> {
    /// The message type or format, for errors.
    pub(super) what: &'static str,
    pub(super) bytes: &'a [u8],
    pub(super) big_endian: bool,
    pub(super) height: usize,
    pub(super) width: usize,
    pub(super) row_step: usize,
    pub(super) columns: Vec<Column>,
}

impl Table<'_> {
    /// Checks that every number of every column lies within the bytes; a cloud without points passes.
    ///
    /// # Errors
    /// [`crate::Error::Decode`] with the field at fault.
    pub(super) fn validate(&self) -> Result<()> {
        if self.points()? == 0 {
            return Ok(());
        }
        for column in &self.columns {
            let last_row = (self.height - 1).checked_mul(self.row_step);
            let last_point = (self.width - 1).checked_mul(column.stride);
            let end = last_row
                .zip(last_point)
                .and_then(|(row, point)| row.checked_add(point)?.checked_add(column.offset))
                .and_then(|at| at.checked_add(column.scalar.size()));
            if end.is_none_or(|end| end > self.bytes.len()) {
                let reason = format!(
                    "field `{}` at offset {} runs past the data: {}x{} points in {} bytes",
                    column.name,
                    column.offset,
                    self.width,
                    self.height,
                    self.bytes.len()
                );
                return Err(decode_error(self.what, reason));
            }
        }
        Ok(())
    }

    /// How many points there are.
    ///
    /// # Errors
    /// [`crate::Error::Decode`] where it is beyond all numbers.
    pub(super) fn points(&self) -> Result<usize> {
        self.height
            .checked_mul(self.width)
            .ok_or_else(|| decode_error(self.what, format!("{}x{} points", self.width, self.height)))
    }

    /// The value of a validated table at a point.
    pub(super) fn value(&self, column: &Column, row: usize, at: usize) -> f64 {
        let start = column.offset + row * self.row_step + at * column.stride;
        column.scalar.read(&self.bytes[start..], self.big_endian)
    }

    /// The first column with one of the names, by order of the names.
    pub(super) fn find(&self, names: &[&str]) -> Option<&Column> {
        names.iter().find_map(|name| self.columns.iter().find(|column| is_named(&column.name, name)))
    }

    /// The columns' names, for errors.
    pub(super) fn names(&self) -> String {
        let names: Vec<&str> = self.columns.iter().take(40).map(|column| column.name.as_str()).collect();
        if names.is_empty() { "there are none".into() } else { names.join(", ") }
    }
}
