//! PCD files of version 0.7 and before: `ascii`, `binary` and `binary_compressed`.

use crate::base::{Error, Result};
use crate::input::points::Options;
use crate::input::points::fields::scan;
use crate::input::points::lzf;
use crate::input::points::table::{Column, Scalar, Table};
use crate::message::decode_error;
use crate::sensor::Scan;

/// First bytes as most writers have them; the comment may be missing.
pub(super) const MAGICS: [&[u8]; 2] = [b"# .PCD", b"VERSION"];

const WHAT: &str = "PCD";

/// Longest header, bytes.
const MAX_HEADER_BYTES: usize = 1 << 16;

/// The scan in a file's bytes: its fields are read as those of a `PointCloud2` (see [`crate::input::points::cloud::from_ros`]). The
/// `VIEWPOINT` is not applied: points stay in the sensor's frame.
///
/// # Errors
/// [`crate::Error::Decode`] for headers that contradict themselves, data that are cut short and fields as in a message.
pub fn read(bytes: &[u8], stamp_ns: u64, options: &Options) -> Result<Scan> {
    let (header, data) = Header::read(bytes)?;
    match header.data.as_str() {
        "binary" => {
            let columns = header.columns(|before, _| (before, header.point_bytes()));
            header.scan(data, columns, stamp_ns, options)
        }
        "binary_compressed" => {
            let plain = header.unpack(data)?;
            let points = header.points();
            let columns = header.columns(|before, size| (before.saturating_mul(points), size));
            header.scan(&plain, columns, stamp_ns, options)
        }
        "ascii" => {
            let numbers = header.parse(data)?;
            let row = 8 * header.fields.iter().map(|field| field.count).sum::<usize>();
            let mut columns = header.columns(|_, _| (0, row));
            let mut at = 0;
            for (column, field) in columns.iter_mut().zip(&header.fields) {
                (column.scalar, column.offset) = (Scalar::F64, 8 * at);
                at += field.count;
            }
            header.scan(&numbers, columns, stamp_ns, options)
        }
        other => Err(refuse(format!("DATA {other} is none of ascii, binary and binary_compressed"))),
    }
}

struct Field {
    name: String,
    scalar: Scalar,
    count: usize,
}

impl Field {
    fn bytes(&self) -> usize {
        self.scalar.size() * self.count
    }
}

/// A header that agrees with itself.
struct Header {
    fields: Vec<Field>,
    width: usize,
    height: usize,
    data: String,
}

impl Header {
    /// The header, and what follows it.
    fn read(bytes: &[u8]) -> Result<(Self, &[u8])> {
        let (mut rest, mut lines) = (bytes, Vec::new());
        loop {
            let end = rest.iter().take(MAX_HEADER_BYTES).position(|&byte| byte == b'\n');
            let (Some(end), true) = (end, bytes.len() - rest.len() < MAX_HEADER_BYTES) else {
                return Err(refuse("its header has no DATA line".into()));
            };
            let line = String::from_utf8_lossy(&rest[..end]).into_owned();
            rest = &rest[end + 1..];
            let words: Vec<String> = line.split_whitespace().map(Into::into).collect();
            let is_data = words.first().is_some_and(|word| word == "DATA");
            lines.push(words);
            if is_data {
                return Ok((Self::of(&lines)?, rest));
            }
        }
    }

    fn of(lines: &[Vec<String>]) -> Result<Self> {
        let find = |key: &str| lines.iter().find(|words| words.first().is_some_and(|word| word == key));
        let words = |key: &str| {
            find(key).map(|words| &words[1..]).ok_or_else(|| refuse(format!("its header has no {key}")))
        };
        let number = |key: &str| {
            let word = words(key)?.first().and_then(|word| word.parse::<usize>().ok());
            word.ok_or_else(|| refuse(format!("{key} is no number")))
        };
        let names = words("FIELDS")?;
        let (sizes, types) = (words("SIZE")?, words("TYPE")?);
        let counts = find("COUNT").map(|words| &words[1..]);
        let agree = sizes.len() == names.len() && types.len() == names.len();
        if !agree || counts.is_some_and(|counts| counts.len() != names.len()) {
            return Err(refuse("FIELDS, SIZE, TYPE and COUNT are not equally many".into()));
        }
        let field = |at: usize| {
            let count = counts.map_or("1", |counts| counts[at].as_str());
            field(&names[at], &types[at], &sizes[at], count)
        };
        let fields = (0..names.len()).map(field).collect::<Result<Vec<_>>>()?;
        let (width, height, points) = (number("WIDTH")?, number("HEIGHT")?, number("POINTS")?);
        if width.checked_mul(height) != Some(points) {
            return Err(refuse(format!("WIDTH {width} times HEIGHT {height} is not POINTS {points}")));
        }
        let data = words("DATA")?.first().cloned().unwrap_or_default();
        Ok(Self { fields, width, height, data })
    }

    fn points(&self) -> usize {
        self.width * self.height
    }

    fn point_bytes(&self) -> usize {
        self.fields.iter().map(Field::bytes).sum()
    }

    /// Columns whose offset and stride follow from the bytes of the fields before and of the field.
    fn columns(&self, place: impl Fn(usize, usize) -> (usize, usize)) -> Vec<Column> {
        let mut before = 0;
        let column = |field: &Field| {
            let (offset, stride) = place(before, field.bytes());
            before += field.bytes();
            Column { name: field.name.clone(), scalar: field.scalar, declared: field.scalar, offset, stride }
        };
        self.fields.iter().map(column).collect()
    }

    fn scan(&self, bytes: &[u8], columns: Vec<Column>, stamp_ns: u64, options: &Options) -> Result<Scan> {
        let row_step = |column: &Column| column.stride.saturating_mul(self.width);
        // Rows lie one after the other in every column, so that one long row is the same, but for its shape.
        let same = columns.windows(2).all(|pair| pair[0].stride == pair[1].stride);
        let (height, width) = if same { (self.height, self.width) } else { (1, self.points()) };
        let row_step = columns.first().map_or(0, row_step);
        let table = Table { what: WHAT, bytes, big_endian: false, height, width, row_step, columns };
        scan(&table, stamp_ns, String::new(), options)
    }

    /// The columns of compressed data, one after the other.
    fn unpack(&self, data: &[u8]) -> Result<Vec<u8>> {
        let Some((sizes, packed)) = data.split_first_chunk::<8>() else {
            return Err(refuse("its data end before they begin".into()));
        };
        let [a, b, c, d, e, f, g, h] = *sizes;
        let (packed_bytes, bytes) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
        if self.points().checked_mul(self.point_bytes()) != Some(bytes as usize) {
            let reason =
                format!("{} points of {} bytes are not {bytes} bytes", self.points(), self.point_bytes());
            return Err(refuse(reason));
        }
        let packed = packed.get(..packed_bytes as usize);
        let packed =
            packed.ok_or_else(|| refuse(format!("its {packed_bytes} packed bytes are cut short")))?;
        lzf::decompress(packed, bytes as usize).ok_or_else(|| refuse("its packed data are damaged".into()))
    }

    /// The numbers of text, as 64-bit floats.
    fn parse(&self, data: &[u8]) -> Result<Vec<u8>> {
        let in_row: usize = self.fields.iter().map(|field| field.count).sum();
        let text = str::from_utf8(data).map_err(|_| refuse("its data are no text".into()))?;
        let (mut numbers, mut rows) = (Vec::new(), 0);
        for line in text.lines().filter(|line| !line.trim().is_empty()).take(self.points()) {
            let before = numbers.len();
            for word in line.split_whitespace() {
                let number: f64 = word
                    .parse()
                    .map_err(|_| refuse(format!("point {rows} has `{word}`, which is no number")))?;
                numbers.extend_from_slice(&number.to_le_bytes());
            }
            if numbers.len() - before != 8 * in_row {
                return Err(refuse(format!("point {rows} does not have {in_row} numbers")));
            }
            rows += 1;
        }
        if rows < self.points() {
            return Err(refuse(format!("it is cut short: {rows} of {} points", self.points())));
        }
        Ok(numbers)
    }
}

fn field(name: &str, kind: &str, size: &str, count: &str) -> Result<Field> {
    let scalar = match (kind, size) {
        ("I", "1") => Scalar::I8,
        ("I", "2") => Scalar::I16,
        ("I", "4") => Scalar::I32,
        ("I", "8") => Scalar::I64,
        ("U", "1") => Scalar::U8,
        ("U", "2") => Scalar::U16,
        ("U", "4") => Scalar::U32,
        ("U", "8") => Scalar::U64,
        ("F", "4") => Scalar::F32,
        ("F", "8") => Scalar::F64,
        _ => return Err(refuse(format!("field `{name}` is of type {kind} and size {size}"))),
    };
    // Counts are limited so that sums of sizes cannot overflow.
    match count.parse::<u16>() {
        Ok(count) if count > 0 => Ok(Field { name: name.into(), scalar, count: count.into() }),
        _ => Err(refuse(format!("field `{name}` has COUNT {count}"))),
    }
}

fn refuse(reason: String) -> Error {
    decode_error(WHAT, reason)
}
