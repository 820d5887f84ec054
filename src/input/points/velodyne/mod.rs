//! Velodyne's raw data packets of 1206 bytes (VLP-16, Puck Hi-Res, HDL-32E, VLP-32C) to revolutions.
//!
//! Source: the sensors' user manuals (63-9243 VLP-16, 63-9277 HDL-32E, 63-9325 VLP-32C), chapters on the data packet,
//! firing sequences and angles. A packet is twelve blocks of flag, azimuth and 32 measurements of distance and
//! reflectivity, then a time stamp and two factory bytes: return mode and model.

mod detect;
mod message;
mod model;
mod packet;
mod revolution;

pub use crate::input::points::velodyne::message::{ScanMessage, StampedPacket};
pub(crate) use crate::input::points::velodyne::packet::{BLOCKS, CHANNELS};
pub use crate::input::points::velodyne::packet::{PACKET_BYTES, Packet, ReturnMode};
pub use crate::input::points::velodyne::revolution::{Cut, Decoder};
pub use crate::sensor::VelodyneModel;
