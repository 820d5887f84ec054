//! One data packet, checked.

use crate::base::{Error, Result};
use crate::message::decode_error;

/// Bytes of a data packet, without the headers of Ethernet, IP and UDP.
pub const PACKET_BYTES: usize = 1206;

/// Blocks in a packet.
pub(crate) const BLOCKS: usize = 12;

/// Measurements in a block.
pub(crate) const CHANNELS: usize = 32;

const BLOCK_BYTES: usize = 4 + 3 * CHANNELS;

/// First bytes of every block of these models.
const BLOCK_FLAG: [u8; 2] = [0xff, 0xee];

/// Last byte of a VLS-128's packets.
const VLS128_BYTE: u8 = 0xa1;

/// Hundredths of a degree in a turn.
pub(super) const TURN: u16 = 36_000;

/// Which returns a sensor was set to send.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReturnMode {
    /// The strongest of each beam (0x37).
    Strongest,
    /// The last of each beam (0x38).
    Last,
    /// Both: in each pair of blocks the first holds the last returns (0x39).
    Dual,
}

/// A data packet whose blocks, azimuths and return mode are as they should be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packet {
    bytes: Box<[u8; PACKET_BYTES]>,
    mode: ReturnMode,
}

impl Packet {
    /// Checks the payload of a UDP packet.
    ///
    /// # Errors
    /// [`Error::Decode`] for other sizes, blocks without the flag, azimuths beyond 360 degrees and unknown return
    /// modes.
    pub fn new(payload: &[u8]) -> Result<Self> {
        let bytes: Box<[u8; PACKET_BYTES]> = Box::<[u8]>::from(payload)
            .try_into()
            .map_err(|_| refuse(format!("{} bytes in place of {PACKET_BYTES}", payload.len())))?;
        if let Some(sensor) = other_sensor(&bytes) {
            return Err(refuse(format!(
                "it is a packet of {sensor}, which is not decoded (VLP-16, Puck Hi-Res, HDL-32E and VLP-32C are): use the point cloud of its driver"
            )));
        }
        let mode = match bytes[PACKET_BYTES - 2] {
            0x37 => ReturnMode::Strongest,
            0x38 => ReturnMode::Last,
            0x39 => ReturnMode::Dual,
            other => return Err(refuse(format!("return mode {other:#04x} is none of 0x37, 0x38 and 0x39"))),
        };
        let packet = Self { bytes, mode };
        for block in 0..BLOCKS {
            if packet.block(block)[..2] != BLOCK_FLAG {
                return Err(refuse("a block does not start with 0xff 0xee".into()));
            }
            // Some firmware rounds up to a whole turn.
            if packet.azimuth(block) > TURN {
                return Err(refuse("an azimuth is beyond 360 degrees".into()));
            }
        }
        Ok(packet)
    }

    /// Which returns it holds.
    pub fn mode(&self) -> ReturnMode {
        self.mode
    }

    /// The factory byte that names the model.
    pub fn model_byte(&self) -> u8 {
        self.bytes[PACKET_BYTES - 1]
    }

    /// Time of the first firing, microseconds after the full hour by the sensor's clock.
    pub fn time_us(&self) -> u32 {
        let [a, b, c, d] = [0, 1, 2, 3].map(|at| self.bytes[BLOCKS * BLOCK_BYTES + at]);
        u32::from_le_bytes([a, b, c, d])
    }

    /// Azimuth of a block's first firing, hundredths of a degree clockwise from above, 0 to 36000.
    pub fn azimuth(&self, block: usize) -> u16 {
        let bytes = self.block(block);
        u16::from_le_bytes([bytes[2], bytes[3]])
    }

    /// Distances (in the model's unit, 0: no return) and reflectivities of a block's measurements.
    pub(super) fn measurements(&self, block: usize) -> impl Iterator<Item = (u16, u8)> {
        self.block(block)[4..]
            .as_chunks::<3>()
            .0
            .iter()
            .map(|&[low, high, reflectivity]| (u16::from_le_bytes([low, high]), reflectivity))
    }

    /// Blocks from one firing to the next: in dual mode a firing fills two.
    pub(super) fn blocks_per_firing(&self) -> usize {
        if self.mode == ReturnMode::Dual { 2 } else { 1 }
    }

    fn block(&self, block: usize) -> &[u8] {
        &self.bytes[block * BLOCK_BYTES..][..BLOCK_BYTES]
    }
}

/// The sensor whose blocks start otherwise: the lower lasers of an HDL-64E, and lasers from 32 on of a VLS-128 (Alpha Prime).
fn other_sensor(bytes: &[u8; PACKET_BYTES]) -> Option<&'static str> {
    let flags = || bytes[..BLOCKS * BLOCK_BYTES].chunks_exact(BLOCK_BYTES).map(|block| [block[0], block[1]]);
    if !flags().all(|[first, second]| first == 0xff && [0xee, 0xdd, 0xcc, 0xbb].contains(&second)) {
        return None;
    }
    let has = |second: u8| flags().any(|flag| flag[1] == second);
    let four_groups = has(0xcc) || has(0xbb);
    let two_groups = has(0xdd);
    match bytes[PACKET_BYTES - 1] {
        _ if four_groups => Some("a VLS-128 (Alpha Prime)"),
        VLS128_BYTE if two_groups => Some("a VLS-128 (Alpha Prime)"),
        _ if two_groups => Some("an HDL-64E"),
        _ => None,
    }
}

fn refuse(reason: String) -> Error {
    decode_error("Velodyne packet", reason)
}
