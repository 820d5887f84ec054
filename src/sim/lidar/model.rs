//! What sensors are made of: rings, columns, beams, detectors.

use serde::{Deserialize, Serialize};

use crate::sensor::VelodyneModel;

/// The sensors that are simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum LidarModel {
    /// Velodyne VLP-16.
    #[serde(rename = "vlp16")]
    #[cfg_attr(feature = "cli", value(name = "vlp16"))]
    Vlp16,
    /// Velodyne HDL-32E.
    #[serde(rename = "hdl32e")]
    #[cfg_attr(feature = "cli", value(name = "hdl32e"))]
    Hdl32e,
    /// Velodyne VLP-32C.
    #[serde(rename = "vlp32c")]
    #[cfg_attr(feature = "cli", value(name = "vlp32c"))]
    Vlp32c,
    /// Ouster OS1-64 (first generation), 1024 columns.
    #[serde(rename = "os1-64")]
    #[cfg_attr(feature = "cli", value(name = "os1-64"))]
    Os1x64,
    /// Hesai PandarQT64.
    #[serde(rename = "qt64")]
    #[cfg_attr(feature = "cli", value(name = "qt64"))]
    Qt64,
}

/// A laser by its place among the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Above the horizontal, radians.
    pub elevation_rad: f64,
    /// How far it points ahead of its column, counter-clockwise, radians.
    pub ahead_rad: f64,
    /// How far above the sensor's centre its beam crosses the axis, metres.
    pub offset_m: f64,
    /// When it fires after its column's first, seconds.
    pub firing_s: f64,
    /// Its number in the sensor's packets.
    pub laser: usize,
}

/// A sensor's constants. Rings, columns, noise and divergence are those of the manuals where these give them. The
/// range at which a tenth is still seen, the length of a pulse, the noise of the signal and its focus are assumptions.
#[derive(Debug, Clone, PartialEq)]
pub struct Optics {
    /// The lowest first.
    pub rings: Vec<Ring>,
    /// Columns of a revolution at 10 Hz.
    pub columns: u32,
    /// Full divergence across and along the vertical, radians.
    pub divergence_rad: [f64; 2],
    /// Least and largest range, metres.
    pub range_m: [f64; 2],
    /// Range at which a surface that returns a tenth is just seen, head on, metres.
    pub tenth_seen_m: f64,
    /// Echoes nearer to each other than this are one, metres.
    pub pulse_m: f64,
    /// Deviation of ranges, metres.
    pub range_noise_m: f64,
    /// Deviation of the signal, as a share of it.
    pub power_noise: f64,
    /// Whether intensity is reflectivity (the range is taken out), or else the signal.
    pub calibrated: bool,
    /// Range below which the signal grows no further, where it is not calibrated, metres.
    pub focus_m: f64,
    /// Intensity of a white wall; where it is the signal, of one at 1 m that is in focus.
    pub scale: f64,
    /// Largest intensity.
    pub largest: f64,
}

impl LidarModel {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Vlp16, Self::Hdl32e, Self::Vlp32c, Self::Os1x64, Self::Qt64];

    /// The name in the manual.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vlp16 => "VLP-16",
            Self::Hdl32e => "HDL-32E",
            Self::Vlp32c => "VLP-32C",
            Self::Os1x64 => "OS1-64",
            Self::Qt64 => "PandarQT64",
        }
    }

    /// The Velodyne whose packets it sends.
    pub fn velodyne(self) -> Option<VelodyneModel> {
        match self {
            Self::Vlp16 => Some(VelodyneModel::Vlp16),
            Self::Hdl32e => Some(VelodyneModel::Hdl32e),
            Self::Vlp32c => Some(VelodyneModel::Vlp32c),
            Self::Os1x64 | Self::Qt64 => None,
        }
    }

    /// Its constants.
    pub fn optics(self) -> Optics {
        let rings = match (self.velodyne(), self) {
            (Some(velodyne), _) => velodyne_rings(velodyne),
            (None, Self::Os1x64) => even_rings(64, 16.6),
            // The manual's steps differ by ring; even ones here.
            (None, _) => even_rings(64, 52.1),
        };
        // Reflectivity up to 100 is matt, above that come mirrors and retroreflectors (Velodyne's manuals).
        let velodyne = Optics {
            rings,
            columns: 1808,
            divergence_rad: [0.003, 0.0015],
            range_m: [0.5, 100.0],
            tenth_seen_m: 50.0,
            pulse_m: 1.0,
            range_noise_m: 0.015,
            power_noise: 0.05,
            calibrated: true,
            focus_m: 0.0,
            scale: 100.0,
            largest: 255.0,
        };
        match self {
            Self::Vlp16 => velodyne,
            Self::Hdl32e => Optics { columns: 2170, divergence_rad: [0.0028, 0.0028], ..velodyne },
            Self::Vlp32c => Optics {
                tenth_seen_m: 120.0,
                range_m: [0.5, 200.0],
                divergence_rad: [0.003, 0.0015],
                ..velodyne
            },
            Self::Os1x64 => Optics {
                columns: 1024,
                divergence_rad: [0.003, 0.003],
                range_m: [0.3, 120.0],
                tenth_seen_m: 40.0,
                pulse_m: 0.6,
                calibrated: false,
                focus_m: 5.0,
                scale: 40_000.0,
                largest: 65_535.0,
                ..velodyne
            },
            Self::Qt64 => Optics {
                columns: 600,
                divergence_rad: [0.007, 0.007],
                range_m: [0.1, 30.0],
                tenth_seen_m: 20.0,
                pulse_m: 0.6,
                ..velodyne
            },
        }
    }
}

fn velodyne_rings(model: VelodyneModel) -> Vec<Ring> {
    let ring = |laser: usize| Ring {
        elevation_rad: model.elevations_deg()[laser].to_radians(),
        ahead_rad: -(f64::from(model.ahead_hundredths(laser)) / 100.0).to_radians(),
        offset_m: model.offset_m(laser),
        firing_s: model.firing_s(laser),
        laser,
    };
    let mut rings: Vec<Ring> = (0..model.lasers()).map(ring).collect();
    rings.sort_by(|a, b| a.elevation_rad.total_cmp(&b.elevation_rad));
    rings
}

fn even_rings(count: u32, half_deg: f64) -> Vec<Ring> {
    let step = 2.0 * half_deg / f64::from(count - 1);
    let ring = |number: u32| Ring {
        elevation_rad: (f64::from(number) * step - half_deg).to_radians(),
        ahead_rad: 0.0,
        offset_m: 0.0,
        firing_s: 0.0,
        laser: number as usize,
    };
    (0..count).map(ring).collect()
}
