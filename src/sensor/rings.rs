//! Rings of a scan: lasers of one elevation each.

use crate::sensor::{Point, Scan};

/// Most that the elevations of a ring's points spread, radians (standard deviation). Lasers that draw another figure, such as the
/// `line`s of a Livox sensor that a driver calls rings, spread over the whole field of view.
const MOST_SPREAD_RAD: f64 = 0.03;

/// Points of a ring from which its elevation is taken.
const LEAST_POINTS: f64 = 8.0;

/// Mean elevation of each ring that has enough points, ascending, radians above the horizontal of the lidar; none where the
/// numbers that the source calls rings are not of steady elevation.
pub fn ring_elevations(scan: &Scan) -> Vec<(u16, f64)> {
    let mut moments = moments(scan);
    if !steady(&moments) {
        return Vec::new();
    }
    moments.sort_by(|a, b| a.1.total_cmp(&b.1));
    moments.into_iter().map(|(ring, mean, _)| (ring, mean)).collect()
}

/// Whether the numbers that the source calls rings are rings, as far as the scan shows.
pub fn has_steady_rings(scan: &Scan) -> bool {
    let moments = moments(scan);
    moments.is_empty() || steady(&moments)
}

/// Number, mean and standard deviation of the elevation of each ring that has enough points.
fn moments(scan: &Scan) -> Vec<(u16, f64, f64)> {
    let mut sums: Vec<[f64; 3]> = Vec::new();
    for point in scan.points.iter().filter(|point| point.ring != Point::UNKNOWN) {
        let ring = usize::from(point.ring);
        if sums.len() <= ring {
            sums.resize(ring + 1, [0.0; 3]);
        }
        let elevation = f64::from(point.z_m).atan2(f64::from(point.x_m.hypot(point.y_m)));
        for (sum, term) in sums[ring].iter_mut().zip([1.0, elevation, elevation * elevation]) {
            *sum += term;
        }
    }
    let usable = (0_u16..).zip(sums).filter(|(_, [count, sum, _])| *count >= LEAST_POINTS && sum.is_finite());
    let moments = usable.map(|(ring, [count, sum, squares])| {
        let mean = sum / count;
        (ring, mean, (squares / count - mean * mean).max(0.0).sqrt())
    });
    moments.collect()
}

fn steady(moments: &[(u16, f64, f64)]) -> bool {
    let mut spreads: Vec<f64> = moments.iter().map(|(_, _, spread)| *spread).collect();
    spreads.sort_by(f64::total_cmp);
    spreads.get(spreads.len() / 2).is_some_and(|median| *median <= MOST_SPREAD_RAD)
}
