//! The sensors' constants, from their manuals.

use crate::input::points::velodyne::packet::{BLOCKS, CHANNELS, TURN};
use crate::sensor::VelodyneModel;

/// Degrees above the horizontal by laser.
const VLP16_DEG: [f64; 16] =
    [-15.0, 1.0, -13.0, 3.0, -11.0, 5.0, -9.0, 7.0, -7.0, 9.0, -5.0, 11.0, -3.0, 13.0, -1.0, 15.0];

const PUCK_HI_RES_DEG: [f64; 16] = [
    -10.0, 0.667, -8.667, 2.0, -7.333, 3.333, -6.0, 4.667, -4.667, 6.0, -3.333, 7.333, -2.0, 8.667, -0.667,
    10.0,
];

const HDL32E_DEG: [f64; 32] = [
    -30.67, -9.33, -29.33, -8.0, -28.0, -6.67, -26.67, -5.33, -25.33, -4.0, -24.0, -2.67, -22.67, -1.33,
    -21.33, 0.0, -20.0, 1.33, -18.67, 2.67, -17.33, 4.0, -16.0, 5.33, -14.67, 6.67, -13.33, 8.0, -12.0, 9.33,
    -10.67, 10.67,
];

const VLP32C_DEG: [f64; 32] = [
    -25.0, -1.0, -1.667, -15.639, -11.31, 0.0, -0.667, -8.843, -7.254, 0.333, -0.333, -6.148, -5.333, 1.333,
    0.667, -4.0, -4.667, 1.667, 1.0, -3.667, -3.333, 3.333, 2.333, -2.667, -3.0, 7.0, 4.667, -2.333, -2.0,
    15.0, 10.333, -1.333,
];

/// Hundredths of a degree that a laser points ahead of the azimuth.
const VLP32C_AHEAD: [i16; 32] = [
    140, -420, 140, -140, 140, -140, 420, -140, 140, -420, 140, -140, 420, -140, 420, -140, 140, -420, 140,
    -420, 420, -140, 140, -140, 140, -140, 140, -420, 420, -140, 140, -140,
];

/// When the channels of a block fire.
struct Timing {
    /// From one block's first firing to the next's in single-return mode, microseconds.
    block_us: f64,
    /// From one firing within a block to the next, microseconds.
    firing_us: f64,
    /// From the block's start to that of its second firing sequence, microseconds.
    sequence_us: f64,
    /// Channels that fire at once.
    at_once: usize,
}

impl VelodyneModel {
    /// The last byte of the model's packets.
    pub fn factory_byte(self) -> u8 {
        match self {
            Self::Hdl32e => 0x21,
            Self::Vlp16 => 0x22,
            Self::PuckHiRes => 0x24,
            Self::Vlp32c => 0x28,
        }
    }

    /// The model that a packet's last byte names.
    pub fn of_factory_byte(byte: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.factory_byte() == byte)
    }

    /// Lasers, 16 or 32.
    pub fn lasers(self) -> usize {
        self.elevations_deg().len()
    }

    /// Metres per count of distance.
    pub fn distance_unit_m(self) -> f64 {
        if self == Self::Vlp32c { 0.004 } else { 0.002 }
    }

    /// From the axis to the point where all beams cross, metres (envelope drawings 86-0101, 86-0129, 86-0106, 86-0130).
    fn focal_m(self) -> f64 {
        match self {
            Self::Vlp16 | Self::PuckHiRes => 0.041_91,
            Self::Hdl32e => 0.028_83,
            Self::Vlp32c => 0.042_4,
        }
    }

    /// Degrees above the horizontal by laser.
    pub(crate) fn elevations_deg(self) -> &'static [f64] {
        match self {
            Self::Vlp16 => &VLP16_DEG,
            Self::PuckHiRes => &PUCK_HI_RES_DEG,
            Self::Hdl32e => &HDL32E_DEG,
            Self::Vlp32c => &VLP32C_DEG,
        }
    }

    /// Hundredths of a degree that a laser points ahead of the azimuth, clockwise.
    pub(crate) fn ahead_hundredths(self, laser: usize) -> i16 {
        if self == Self::Vlp32c { VLP32C_AHEAD[laser] } else { 0 }
    }

    fn timing(self) -> Timing {
        match self {
            Self::Vlp16 | Self::PuckHiRes => {
                Timing { block_us: 110.592, firing_us: 2.304, sequence_us: 55.296, at_once: 1 }
            }
            Self::Hdl32e => Timing { block_us: 46.08, firing_us: 1.152, sequence_us: 0.0, at_once: 1 },
            Self::Vlp32c => Timing { block_us: 55.296, firing_us: 2.304, sequence_us: 0.0, at_once: 2 },
        }
    }

    /// How far above the sensor's centre a laser's beam crosses the axis, metres.
    pub(crate) fn offset_m(self, laser: usize) -> f64 {
        -self.focal_m() * self.elevations_deg()[laser].to_radians().tan()
    }

    /// Time from the first firing of a sequence to a laser's, seconds.
    pub(crate) fn firing_s(self, laser: usize) -> f64 {
        let timing = self.timing();
        #[expect(clippy::cast_precision_loss, reason = "at most 32")]
        let turn = (laser / timing.at_once) as f64;
        timing.firing_us * turn * 1e-6
    }

    /// Time from a block's first firing to the next block's, microseconds; in dual mode, to the next pair's.
    pub fn block_us(self) -> f64 {
        self.timing().block_us
    }
}

/// What a channel of a block adds to azimuth and distance.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Channel {
    pub(super) cos_elevation: f32,
    pub(super) sin_elevation: f32,
    /// Added to z: the beams do not cross in the axis.
    pub(super) offset_m: f32,
    /// Hundredths of a degree ahead of the azimuth, in `0..TURN`.
    pub(super) ahead: usize,
    /// Laser by elevation, 0 the lowest.
    pub(super) ring: u16,
    /// Number of the firing sequence within the block.
    pub(super) sequence: u16,
}

/// A model's constants as the decoder needs them.
pub(super) struct Calibration {
    pub(super) channels: [Channel; CHANNELS],
    /// Time of each firing after the packet's first, seconds, by block (in dual mode: pair of blocks) and channel.
    pub(super) firing_s: [[f32; CHANNELS]; BLOCKS],
    pub(super) distance_unit_m: f32,
    /// Firing sequences in a block.
    pub(super) sequences: u16,
    /// Cosine and sine by hundredths of a degree.
    pub(super) directions: Vec<[f32; 2]>,
}

impl Calibration {
    #[expect(clippy::cast_possible_truncation, reason = "constants, far from the limits of their types")]
    pub(super) fn new(model: VelodyneModel) -> Self {
        let (lasers, elevations, timing) = (model.lasers(), model.elevations_deg(), model.timing());
        let (mut channels, mut firing_s) = ([Channel::default(); CHANNELS], [[0.0; CHANNELS]; BLOCKS]);
        for (at, channel) in channels.iter_mut().enumerate() {
            let (laser, sequence) = (at % lasers, at / lasers);
            let elevation = elevations[laser].to_radians();
            let ahead = model.ahead_hundredths(laser);
            *channel = Channel {
                cos_elevation: elevation.cos() as f32,
                sin_elevation: elevation.sin() as f32,
                offset_m: model.offset_m(laser) as f32,
                ahead: i32::from(ahead).rem_euclid(TURN.into()).unsigned_abs() as usize,
                ring: elevations.iter().filter(|&&other| other < elevations[laser]).count() as u16,
                sequence: sequence as u16,
            };
            let in_block_us = timing.sequence_us * sequence as f64 + model.firing_s(laser) * 1e6;
            for (block, firing_s) in firing_s.iter_mut().enumerate() {
                firing_s[at] = ((timing.block_us * block as f64 + in_block_us) * 1e-6) as f32;
            }
        }
        let direction = |hundredths: u16| {
            let (sin, cos) = (f64::from(hundredths) * 0.01).to_radians().sin_cos();
            [cos as f32, sin as f32]
        };
        Self {
            channels,
            firing_s,
            distance_unit_m: model.distance_unit_m() as f32,
            sequences: (CHANNELS / lasers) as u16,
            directions: (0..TURN).map(direction).collect(),
        }
    }
}
