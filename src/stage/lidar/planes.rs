//! What is taken from the first scan: the rings of the two planes and the full scale of intensities.

use crate::base::{Error, Result};
use crate::config::{Config, PlaneSource};
use crate::sensor::{Scan, ring_elevations};

/// Rings this much farther from the horizontal than the nearest still count as nearest; the upper one is taken.
const TIE_RAD: f64 = 2e-3;

/// The ring nearest the horizontal and the one below it (spec 2 §2); `None` where slabs are to be taken.
///
/// # Errors
/// [`Error::Decode`] where `plane_source` asks for rings and the scan has none, or only one.
pub fn plane_rings(config: &Config, scan: &Scan) -> Result<Option<[u16; 2]>> {
    if config.plane_source == PlaneSource::Slabs {
        return Ok(None);
    }
    let rings = ring_elevations(scan);
    let nearest = rings.iter().map(|(_, elevation)| elevation.abs()).fold(f64::INFINITY, f64::min);
    let at = rings.iter().rposition(|(_, elevation)| elevation.abs() <= nearest + TIE_RAD);
    let pair = at.and_then(|at| Some([rings[at].0, rings[at.checked_sub(1)?].0]));
    if pair.is_none() && config.plane_source == PlaneSource::Rings {
        let reason = format!(
            "{} rings of steady elevation in the first scan; plane_source rings needs two",
            rings.len()
        );
        return Err(Error::Decode { what: "rings".into(), reason });
    }
    Ok(pair)
}

/// R: as configured, or the configured percentile of the scan's intensities; where that is 0 their largest, else 1, as then
/// they say nothing ([`crate::stage::lidar::trust`]).
pub fn full_scale(config: &Config, scan: &Scan) -> f64 {
    if config.intensity_full_scale > 0.0 {
        return config.intensity_full_scale;
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
    let scales = [intensities.get(rank), intensities.last()].into_iter().flatten();
    scales.copied().find(|&scale| scale > 0.0).map_or(1.0, f64::from)
}
