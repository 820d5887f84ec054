//! ROS 1 messages and bags made by the tests themselves, byte by byte.

use std::io::Write;

use bzip2::write::BzEncoder;

use super::synthetic::SIZE;

pub(crate) const IMAGE: &str = "sensor_msgs/Image";
pub(crate) const INFO: &str = "sensor_msgs/CameraInfo";

pub(crate) fn u32s(values: &[usize]) -> Vec<u8> {
    values.iter().flat_map(|&value| u32::try_from(value).unwrap().to_le_bytes()).collect()
}

pub(crate) fn f64s(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// Bytes after their length.
pub(crate) fn sized(bytes: &[u8]) -> Vec<u8> {
    [&u32s(&[bytes.len()]), bytes].concat()
}

fn time(stamp_ns: u64) -> Vec<u8> {
    u32s(&[stamp_ns / 1_000_000_000, stamp_ns % 1_000_000_000].map(|part| usize::try_from(part).unwrap()))
}

pub(crate) fn header(stamp_ns: u64, frame_id: &str) -> Vec<u8> {
    [u32s(&[4711]), time(stamp_ns), sized(frame_id.as_bytes())].concat()
}

pub(crate) fn image(stamp_ns: u64, frame_id: &str, encoding: &str, step: usize, data: &[u8]) -> Vec<u8> {
    let [width, height] = SIZE.map(|pixels| pixels as usize);
    let head = [header(stamp_ns, frame_id), u32s(&[height, width]), sized(encoding.as_bytes())].concat();
    [head, vec![0], u32s(&[step]), sized(data)].concat()
}

pub(crate) fn depth_image(stamp_ns: u64, frame_id: &str, value: u16) -> Vec<u8> {
    image(stamp_ns, frame_id, "mono16", 8, &value.to_le_bytes().repeat(12))
}

pub(crate) fn camera_info(stamp_ns: u64, frame_id: &str) -> Vec<u8> {
    let [width, height] = SIZE.map(|pixels| pixels as usize);
    let head = [header(stamp_ns, frame_id), u32s(&[height, width]), sized(b"plumb_bob"), u32s(&[5])].concat();
    let k = [5.0, 0.0, 2.0, 0.0, 6.0, 1.5, 0.0, 0.0, 1.0];
    [head, f64s(&[0.0; 5]), f64s(&k), f64s(&[0.0; 21]), u32s(&[0; 6]), vec![0]].concat()
}

/// A transform or, where it ends with a covariance and a twist, the pose of odometry.
pub(crate) fn stamped(stamp_ns: u64, [parent, child]: [&str; 2], numbers: &[f64]) -> Vec<u8> {
    [header(stamp_ns, parent), sized(child.as_bytes()), f64s(numbers)].concat()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Compression {
    None,
    Lz4,
    Bz2,
}

impl Compression {
    pub(crate) const ALL: [Self; 3] = [Self::None, Self::Lz4, Self::Bz2];

    fn name(self) -> &'static [u8] {
        match self {
            Self::None => b"none",
            Self::Lz4 => b"lz4",
            Self::Bz2 => b"bz2",
        }
    }

    fn pack(self, bytes: &[u8]) -> Vec<u8> {
        match self {
            Self::None => bytes.to_vec(),
            Self::Lz4 => {
                let mut encoder = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
                encoder.write_all(bytes).unwrap();
                encoder.finish().0
            }
            Self::Bz2 => {
                let mut encoder = BzEncoder::new(Vec::new(), bzip2::Compression::default());
                encoder.write_all(bytes).unwrap();
                encoder.finish().unwrap()
            }
        }
    }
}

fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let header = fields.iter().flat_map(|(name, value)| sized(&[name.as_bytes(), b"=", value].concat()));
    [sized(&header.collect::<Vec<u8>>()), sized(data)].concat()
}

/// A bag in the making.
pub(crate) struct Bag {
    compression: Compression,
    bytes: Vec<u8>,
    chunk: Vec<u8>,
    /// Messages of each connection in the open chunk.
    counts: Vec<usize>,
    connections: Vec<(String, Vec<u8>)>,
    /// The records of the index that tell of chunks.
    infos: Vec<Vec<u8>>,
    /// Where each chunk starts, and where the last ends.
    pub(crate) chunks_at: Vec<usize>,
}

impl Bag {
    pub(crate) fn new(compression: Compression) -> Self {
        let mut bytes = b"#ROSBAG V2.0\n".to_vec();
        bytes.extend(bag_header(0, 0, 0));
        let (chunk, counts, connections, infos) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let chunks_at = vec![bytes.len()];
        Self { compression, bytes, chunk, counts, connections, infos, chunks_at }
    }

    pub(crate) fn message(&mut self, topic: &str, type_name: &str, stamp_ns: u64, payload: &[u8]) {
        let known = self.connections.iter().position(|(name, _)| name == topic);
        let id = known.unwrap_or(self.connections.len());
        if known.is_none() {
            let about: Vec<u8> = [("topic", topic), ("type", type_name), ("message_definition", "")]
                .iter()
                .flat_map(|(name, value)| sized(format!("{name}={value}").as_bytes()))
                .collect();
            let fields = [("op", &[7][..]), ("conn", &u32s(&[id])), ("topic", topic.as_bytes())];
            let connection = record(&fields, &about);
            self.chunk.extend(&connection);
            self.connections.push((topic.into(), connection));
        }
        self.counts.resize(self.connections.len(), 0);
        self.counts[id] += 1;
        let fields = [("op", &[2][..]), ("conn", &u32s(&[id])), ("time", &time(stamp_ns))];
        self.chunk.extend(record(&fields, payload));
    }

    /// Writes the chunk, with a record of its index as recorders do.
    pub(crate) fn end_chunk(&mut self) {
        let fields = [
            ("op", &[5][..]),
            ("compression", self.compression.name()),
            ("size", &u32s(&[self.chunk.len()])),
        ];
        self.bytes.extend(record(&fields, &self.compression.pack(&self.chunk)));
        self.bytes.extend(record(&[("op", &[4]), ("ver", &u32s(&[1])), ("conn", &[0; 4])], &[0; 12]));
        let pairs: Vec<usize> = self.counts.iter().enumerate().flat_map(|(id, &count)| [id, count]).collect();
        self.infos.push(record(&[("op", &[6]), ("ver", &u32s(&[1]))], &u32s(&pairs)));
        self.chunks_at.push(self.bytes.len());
        self.chunk.clear();
        self.counts.clear();
    }

    /// As a recorder leaves it that did not come to close it.
    pub(crate) fn unclosed(self) -> Vec<u8> {
        self.bytes
    }

    pub(crate) fn finish(mut self) -> Vec<u8> {
        if !self.chunk.is_empty() {
            self.end_chunk();
        }
        let header = bag_header(self.bytes.len(), self.connections.len(), self.infos.len());
        self.bytes[13..13 + header.len()].copy_from_slice(&header);
        self.bytes.extend(self.connections.iter().flat_map(|(_, record)| record));
        self.bytes.extend(self.infos.concat());
        self.bytes
    }
}

fn bag_header(index_at: usize, connections: usize, chunks: usize) -> Vec<u8> {
    let fields = [
        ("op", &[3][..]),
        ("index_pos", &(index_at as u64).to_le_bytes()),
        ("conn_count", &u32s(&[connections])),
        ("chunk_count", &u32s(&[chunks])),
    ];
    record(&fields, &[b' '; 100])
}
