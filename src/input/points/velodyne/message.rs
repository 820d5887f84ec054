//! `velodyne_msgs/VelodyneScan`, read where it lies: its packets are not copied.

use crate::base::{Error, Result};
use crate::input::points::velodyne::packet::PACKET_BYTES;
use crate::message::ros2::Time;
use crate::message::{bare_frame, decode_error};

/// Bytes of a packet with its stamp.
const STAMPED_BYTES: usize = 8 + PACKET_BYTES;

/// Where the azimuth of the last block lies.
const LAST_AZIMUTH_AT: usize = 11 * 100 + 2;

/// Hundredths of a degree.
const TURN: u32 = 36_000;

/// A packet and the time it came at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StampedPacket<'a> {
    /// Nanoseconds since the Unix epoch.
    pub stamp_ns: u64,
    /// As sent by the sensor.
    pub payload: &'a [u8],
}

/// The packets of about a revolution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScanMessage<'a> {
    /// Stamp of the message, nanoseconds since the Unix epoch.
    pub stamp_ns: u64,
    /// The sensor's frame.
    pub frame_id: String,
    /// In order of time.
    pub packets: Vec<StampedPacket<'a>>,
}

impl<'a> ScanMessage<'a> {
    /// From encapsulated CDR (ROS 2).
    ///
    /// # Errors
    /// [`Error::Decode`] for other encapsulations, messages that end early and stamps before 1970.
    pub fn from_cdr(payload: &'a [u8]) -> Result<Self> {
        let big_endian = match payload {
            [0, 0, _, _, ..] => true,
            [0, 1, _, _, ..] => false,
            _ => return Err(refuse("it does not start with a header of plain CDR")),
        };
        Self::read(Cursor { bytes: payload, at: 4, origin: 4, aligned: true, big_endian })
    }

    /// From ROS 1's serialisation.
    ///
    /// # Errors
    /// [`Error::Decode`] for messages that end early.
    pub fn from_ros1(payload: &'a [u8]) -> Result<Self> {
        let mut cursor = Cursor { bytes: payload, at: 0, origin: 0, aligned: false, big_endian: false };
        cursor.number()?; // sequence number
        Self::read(cursor)
    }

    /// Whether the packets are a revolution by themselves, as drivers send them, and not a part of one: they turn by
    /// more than 270 degrees.
    pub fn is_revolution(&self) -> bool {
        let azimuths = self.packets.iter().flat_map(|packet| {
            [2, LAST_AZIMUTH_AT]
                .map(|at| u32::from(packet.payload[at]) | u32::from(packet.payload[at + 1]) << 8)
        });
        let (mut turned, mut before) = (0, None);
        for azimuth in azimuths {
            // Whatever the packets hold, an azimuth is less than two turns.
            turned += before.map_or(0, |before| (azimuth + 2 * TURN - before) % TURN);
            before = Some(azimuth);
        }
        turned > TURN / 4 * 3
    }

    fn read(mut cursor: Cursor<'a>) -> Result<Self> {
        let stamp_ns = cursor.stamp_ns()?;
        let length = cursor.number()? as usize;
        let name = cursor.take(length)?;
        let name = name.strip_suffix(b"\0").unwrap_or(name);
        let frame_id = bare_frame(String::from_utf8_lossy(name).into_owned());
        let count = cursor.number()? as usize;
        if count > cursor.left() / STAMPED_BYTES {
            return Err(refuse(&format!("{count} packets do not fit {} bytes", cursor.left())));
        }
        let mut packets = Vec::with_capacity(count);
        for _ in 0..count {
            let stamp_ns = cursor.stamp_ns()?;
            packets.push(StampedPacket { stamp_ns, payload: cursor.take(PACKET_BYTES)? });
        }
        Ok(Self { stamp_ns, frame_id, packets })
    }
}

/// A place in a message.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Where alignment counts from.
    origin: usize,
    aligned: bool,
    big_endian: bool,
}

impl<'a> Cursor<'a> {
    fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    fn take(&mut self, length: usize) -> Result<&'a [u8]> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest.get(..length).ok_or_else(|| refuse("it ends early"))?;
        self.at += length;
        Ok(taken)
    }

    fn number(&mut self) -> Result<u32> {
        if self.aligned {
            self.at = self.origin + (self.at - self.origin).next_multiple_of(4);
        }
        let Some(&four) = self.take(4)?.first_chunk() else { return Err(refuse("it ends early")) };
        Ok(if self.big_endian { u32::from_be_bytes(four) } else { u32::from_le_bytes(four) })
    }

    fn stamp_ns(&mut self) -> Result<u64> {
        let (sec, nanosec) = (self.number()?.cast_signed(), self.number()?);
        Time { sec, nanosec }.stamp_ns()
    }
}

fn refuse(reason: &str) -> Error {
    decode_error("velodyne_msgs/VelodyneScan", reason)
}
