//! PLY files: ascii and binary of either byte order. The points are the element `vertex`.

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyDef, PropertyType,
    ScalarType,
};

use crate::base::{Error, Result};
use crate::input::points::Options;
use crate::input::points::fields::scan;
use crate::input::points::table::{Column, Scalar, Table};
use crate::message::decode_error;
use crate::sensor::Scan;

/// First bytes of a file.
pub(super) const MAGIC: &[u8] = b"ply";

const WHAT: &str = "PLY";

/// Longest message of the parser that is passed on, characters.
const MAX_MESSAGE: usize = 400;

/// Vertices parsed at a time.
const CHUNK: usize = 4096;

/// The numbers of an element in the order of its properties.
struct Numbers(Vec<f64>);

impl PropertyAccess for Numbers {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, _name: &str, property: Property) -> PropertyAccessResult {
        self.0.push(match property {
            Property::Char(value) => value.into(),
            Property::UChar(value) => value.into(),
            Property::Short(value) => value.into(),
            Property::UShort(value) => value.into(),
            Property::Int(value) => value.into(),
            Property::UInt(value) => value.into(),
            Property::Float(value) => value.into(),
            Property::Double(value) => value,
            _ => return PropertyAccessResult::UnsupportedType,
        });
        PropertyAccessResult::Set
    }
}

/// An element that is passed over.
struct Nothing;

impl PropertyAccess for Nothing {
    fn new() -> Self {
        Self
    }
}

/// The scan in a file's bytes: the vertices' properties are read as the fields of a `PointCloud2` (see
/// [`crate::input::points::cloud::from_ros`]). Comments `stamp_ns N` and `frame_id NAME`, as [`crate::output::save_scan`] writes them,
/// are its stamp and frame; `stamp_ns` is the stamp of a file without the first, or with stamp 0.
///
/// # Errors
/// [`crate::Error::Decode`] for files that are no PLY, have no vertices, are cut short, or have vertices with lists, and
/// for properties as in a message.
pub fn read(bytes: &[u8], stamp_ns: u64, options: &Options) -> Result<Scan> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Nothing>::new().read_header(&mut reader).map_err(refuse)?;
    for element in header.elements.values() {
        check_size(element, header.encoding, bytes.len())?;
        if element.name == "vertex" {
            let numbers = vertices(&mut reader, element, &header)?;
            let stamp_ns = said(&header, "stamp_ns")
                .and_then(|stamp| stamp.parse().ok())
                .filter(|&s| s != 0)
                .unwrap_or(stamp_ns);
            let frame_id = said(&header, "frame_id").unwrap_or_default();
            return points(&numbers, element, stamp_ns, options)
                .map(|scan| Scan { frame_id: frame_id.into(), ..scan });
        }
        let (mut left, parser) = (element.count, Parser::<Nothing>::new());
        while left > 0 {
            let part = part(element, &mut left);
            parser.read_payload_for_element(&mut reader, &part, &header).map_err(refuse)?;
        }
    }
    Err(decode_error(WHAT, "it has no element `vertex`"))
}

/// The one word of the first comment that is `key` and a word.
fn said<'a>(header: &'a Header, key: &str) -> Option<&'a str> {
    header.comments.iter().find_map(|comment| {
        let mut words = comment.split_ascii_whitespace();
        let word = words.next().filter(|first| *first == key).and(words.next())?;
        words.next().is_none().then_some(word)
    })
}

/// The element with as many as are parsed at a time, which are taken off those left.
fn part(element: &ElementDef, left: &mut usize) -> ElementDef {
    let count = CHUNK.min(*left);
    *left -= count;
    ElementDef { count, ..element.clone() }
}

/// # Errors
/// [`Error::Decode`] where so many elements cannot be in the file.
fn check_size(element: &ElementDef, encoding: Encoding, file_bytes: usize) -> Result<()> {
    let least = |property: &PropertyType| match (encoding, property) {
        (Encoding::Ascii, _) => 1,
        (_, PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) => scalar_of(scalar).size(),
    };
    let least: usize = element.properties.values().map(|property| least(&property.data_type)).sum();
    let fits = element.count == 0
        || least > 0 && element.count.checked_mul(least).is_some_and(|needed| needed <= file_bytes);
    if fits {
        return Ok(());
    }
    let reason = format!("{} of element `{}` do not fit {file_bytes} bytes", element.count, element.name);
    Err(decode_error(WHAT, reason))
}

/// The vertices' numbers as 64-bit floats, one vertex after the other.
fn vertices(reader: &mut Reader<&[u8]>, element: &ElementDef, header: &Header) -> Result<Vec<u8>> {
    let is_list = |property: &&PropertyDef| matches!(property.data_type, PropertyType::List(..));
    if let Some(list) = element.properties.values().find(is_list) {
        return Err(decode_error(WHAT, format!("property `{}` of the vertices is a list", list.name)));
    }
    let (mut numbers, mut left) = (Vec::new(), element.count);
    let parser = Parser::<Numbers>::new();
    while left > 0 {
        let part = part(element, &mut left);
        for vertex in parser.read_payload_for_element(reader, &part, header).map_err(refuse)? {
            numbers.extend(vertex.0.into_iter().flat_map(f64::to_le_bytes));
        }
    }
    Ok(numbers)
}

fn points(numbers: &[u8], element: &ElementDef, stamp_ns: u64, options: &Options) -> Result<Scan> {
    let stride = 8 * element.properties.len();
    let column = |(at, (name, property)): (usize, (&String, &PropertyDef))| {
        let declared = match &property.data_type {
            PropertyType::Scalar(scalar) | PropertyType::List(_, scalar) => scalar_of(scalar),
        };
        Column { name: name.clone(), scalar: Scalar::F64, declared, offset: 8 * at, stride }
    };
    let table = Table {
        what: WHAT,
        bytes: numbers,
        big_endian: false,
        height: 1,
        width: element.count,
        row_step: numbers.len(),
        columns: element.properties.iter().enumerate().map(column).collect(),
    };
    scan(&table, stamp_ns, String::new(), options)
}

fn scalar_of(scalar: &ScalarType) -> Scalar {
    match scalar {
        ScalarType::Char => Scalar::I8,
        ScalarType::UChar => Scalar::U8,
        ScalarType::Short => Scalar::I16,
        ScalarType::UShort => Scalar::U16,
        ScalarType::Int => Scalar::I32,
        ScalarType::UInt => Scalar::U32,
        ScalarType::Float => Scalar::F32,
        ScalarType::Double => Scalar::F64,
    }
}

/// The parser's message without the line that it quotes, which may be long.
fn refuse(error: ply_rs_bw::parser::ParseError) -> Error {
    let text = error.to_string();
    let lines = text.lines().map(str::trim).enumerate();
    let said: Vec<&str> =
        lines.filter(|(at, line)| *at == 0 || line.starts_with("Error: ")).map(|(_, line)| line).collect();
    decode_error(WHAT, said.join(" ").chars().take(MAX_MESSAGE).collect::<String>())
}
