//! A simulated scan as its sensor sends it: Velodyne's packets (VLP-16 manual 63-9243, HDL-32E 63-9113, VLP-32C 63-9325).

use std::collections::BTreeMap;
use std::time::Duration;

use crate::input::points::velodyne::{BLOCKS, CHANNELS, PACKET_BYTES};
use crate::message::ros2::{Header, Time};
use crate::message::written::{VelodynePacket, VelodyneScan};
use crate::sensor::{Point, ReturnType, VelodyneModel};
use crate::sim::lidar::{LIDAR_FRAME, Lidar, Returns, Ring, SimScan};

/// First bytes of a block.
const BLOCK_FLAG: [u8; 2] = [0xff, 0xee];

/// Bytes of a block: flag, azimuth, measurements.
const BLOCK_BYTES: usize = 4 + 3 * CHANNELS;

/// Return modes of a packet: the strongest; both.
const STRONGEST: u8 = 0x37;
const DUAL: u8 = 0x39;

/// Hundredths of a degree in a turn.
const TURN: u64 = 36_000;

/// Microseconds in an hour, at which a sensor's clock starts anew.
const HOUR_US: u64 = 3_600_000_000;

/// A distance in counts, 0: nothing came back; and a reflectivity.
type Measured = (u16, u8);

/// What the two blocks of a firing hold, by column and laser: the last return, and the strongest or second strongest.
type Returned = BTreeMap<(usize, usize), [Measured; 2]>;

/// How a sensor packs its scans.
pub(super) struct Packets {
    model: VelodyneModel,
    rings: Vec<Ring>,
    columns: usize,
    column_s: f64,
    dual: bool,
}

impl Packets {
    /// Of a lidar that sends packets; `None` where it does not.
    pub(super) fn of(lidar: &Lidar) -> Option<Self> {
        let model = lidar.model.velodyne().filter(|_| lidar.packets)?;
        let columns = lidar.columns();
        Some(Self {
            model,
            rings: lidar.model.optics().rings,
            columns: columns as usize,
            column_s: 1.0 / (f64::from(columns) * lidar.rate_hz),
            dual: lidar.returns == Returns::StrongestLast,
        })
    }

    /// Numbers of the points in the order in which packets hold them.
    pub(super) fn order(&self, scan: &SimScan) -> Vec<usize> {
        let mut order: Vec<usize> = (0..scan.scan.points.len()).collect();
        order.sort_by_key(|&at| self.place(&scan.scan.points[at]));
        order
    }

    /// Column and laser of a point.
    fn place(&self, point: &Point) -> (usize, usize) {
        let laser = self.rings.get(usize::from(point.ring)).map_or(0, |ring| ring.laser);
        (usize::from(point.column), laser)
    }

    /// The packets of a revolution. The last one is filled up with firings that nothing came back from.
    pub(super) fn message(&self, scan: &SimScan) -> VelodyneScan {
        let returned = self.returned(scan);
        let stamp_ns = scan.scan.stamp_ns;
        let packets = (0..self.columns).step_by(self.columns_per_packet()).map(|first| {
            let after = Duration::from_secs_f64(f64::from(u32::try_from(first).unwrap_or(0)) * self.column_s);
            let stamp_ns = stamp_ns + u64::try_from(after.as_nanos()).unwrap_or(0);
            VelodynePacket {
                stamp: Time::from_stamp_ns(stamp_ns),
                data: self.packet(first, stamp_ns, &returned),
            }
        });
        VelodyneScan { header: Header::new(stamp_ns, LIDAR_FRAME), packets: packets.collect() }
    }

    fn returned(&self, scan: &SimScan) -> Returned {
        let mut returned = Returned::new();
        for point in &scan.scan.points {
            let slots = returned.entry(self.place(point)).or_default();
            let measured = self.measured(point);
            match point.return_type {
                ReturnType::Last => slots[0] = measured,
                ReturnType::StrongestOrSecond => slots[1] = measured,
                _ => *slots = [measured; 2],
            }
        }
        returned
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped before")]
    fn measured(&self, point: &Point) -> Measured {
        let offset_m = self.rings.get(usize::from(point.ring)).map_or(0.0, |ring| ring.offset_m);
        let [x, y, z] = point.position_m().map(f64::from);
        let range_m = x.hypot(y).hypot(z - offset_m);
        let counts = (range_m / self.model.distance_unit_m()).round().clamp(1.0, f64::from(u16::MAX));
        (counts as u16, point.intensity.round().clamp(0.0, 255.0) as u8)
    }

    /// Columns that fire within a block, and blocks that they fill.
    fn sequences(&self) -> usize {
        CHANNELS / self.model.lasers()
    }

    fn blocks_per_firing(&self) -> usize {
        if self.dual { 2 } else { 1 }
    }

    fn columns_per_packet(&self) -> usize {
        BLOCKS / self.blocks_per_firing() * self.sequences()
    }

    fn packet(&self, first: usize, stamp_ns: u64, returned: &Returned) -> [u8; PACKET_BYTES] {
        let mut bytes = [0; PACKET_BYTES];
        for (number, block) in bytes.chunks_exact_mut(BLOCK_BYTES).take(BLOCKS).enumerate() {
            let column = first + number / self.blocks_per_firing() * self.sequences();
            let slot = number % self.blocks_per_firing();
            block[..2].copy_from_slice(&BLOCK_FLAG);
            block[2..4].copy_from_slice(&self.azimuth(column).to_le_bytes());
            for (channel, measured) in block[4..].chunks_exact_mut(3).enumerate() {
                let (sequence, laser) = (channel / self.model.lasers(), channel % self.model.lasers());
                let slots = returned.get(&(column + sequence, laser)).copied().unwrap_or_default();
                let (distance, reflectivity) = slots[slot];
                measured[..2].copy_from_slice(&distance.to_le_bytes());
                measured[2] = reflectivity;
            }
        }
        let time_us = u32::try_from(stamp_ns / 1000 % HOUR_US).unwrap_or(0);
        let end = BLOCKS * BLOCK_BYTES;
        bytes[end..end + 4].copy_from_slice(&time_us.to_le_bytes());
        bytes[end + 4] = if self.dual { DUAL } else { STRONGEST };
        bytes[end + 5] = self.model.factory_byte();
        bytes
    }

    /// Hundredths of a degree, clockwise.
    fn azimuth(&self, column: usize) -> u16 {
        let (column, columns) = (column as u64, self.columns as u64);
        u16::try_from((TURN * column + columns / 2) / columns % TURN).unwrap_or(0)
    }
}
