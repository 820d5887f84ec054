//! What is taken from the first scan: the rings of the two planes and the full scale of intensities.

use crate::base::{Error, Result};
use crate::config::{Config, PlaneSource};
use crate::sensor::{Point, Scan};

/// Rings this much farther from the horizontal than the nearest still count as nearest; the upper one is taken.
const TIE_RAD: f64 = 2e-3;

/// Points of a ring from which its elevation is taken.
const LEAST_POINTS: u32 = 8;

/// Mean elevation of each ring that has points, ascending, radians above the horizontal of the lidar.
fn elevations(scan: &Scan) -> Vec<(u16, f64)> {
    let mut sums: Vec<(f64, u32)> = Vec::new();
    for point in scan.points.iter().filter(|point| point.ring != Point::UNKNOWN) {
        let ring = usize::from(point.ring);
        if sums.len() <= ring {
            sums.resize(ring + 1, (0.0, 0));
        }
        let elevation = f64::from(point.z_m).atan2(f64::from(point.x_m.hypot(point.y_m)));
        sums[ring].0 += elevation;
        sums[ring].1 += 1;
    }
    let means = (0_u16..).zip(sums).filter(|(_, (sum, count))| *count >= LEAST_POINTS && sum.is_finite());
    let mut rings: Vec<_> = means.map(|(ring, (sum, count))| (ring, sum / f64::from(count))).collect();
    rings.sort_by(|a, b| a.1.total_cmp(&b.1));
    rings
}

/// The ring nearest the horizontal and the one below it (spec 2 §2); `None` where slabs are to be taken.
///
/// # Errors
/// [`Error::Decode`] where `plane_source` asks for rings and the scan has none, or only one.
pub fn plane_rings(config: &Config, scan: &Scan) -> Result<Option<[u16; 2]>> {
    if config.plane_source == PlaneSource::Slabs {
        return Ok(None);
    }
    let rings = elevations(scan);
    let nearest = rings.iter().map(|(_, elevation)| elevation.abs()).fold(f64::INFINITY, f64::min);
    let at = rings.iter().rposition(|(_, elevation)| elevation.abs() <= nearest + TIE_RAD);
    let pair = at.and_then(|at| Some([rings[at].0, rings[at.checked_sub(1)?].0]));
    if pair.is_none() && config.plane_source == PlaneSource::Rings {
        let reason = format!("{} rings in the first scan; plane_source rings needs two", rings.len());
        return Err(Error::Decode { what: "rings".into(), reason });
    }
    Ok(pair)
}

/// R: as configured, or the configured percentile of the scan's intensities.
///
/// # Errors
/// [`Error::Decode`] where no intensity of the scan is above 0.
pub fn full_scale(config: &Config, scan: &Scan) -> Result<f64> {
    if config.intensity_full_scale > 0.0 {
        return Ok(config.intensity_full_scale);
    }
    let mut intensities: Vec<f32> =
        scan.points.iter().map(|point| point.intensity).filter(|i| i.is_finite()).collect();
    intensities.sort_by(f32::total_cmp);
    let last = intensities.len().saturating_sub(1);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "an index into at most a million"
    )]
    let rank = (config.intensity_percentile / 100.0 * last as f64).round() as usize;
    match intensities.get(rank) {
        Some(&scale) if scale > 0.0 => Ok(scale.into()),
        _ => {
            let reason = "no intensity above 0 in the first scan to take the full scale from".into();
            Err(Error::Decode { what: "intensity".into(), reason })
        }
    }
}
