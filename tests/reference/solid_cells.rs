//! The solidity layer of one cell, scan by scan, and the heights at which beams crossed it (spec 4 §1).

/// Class and strength, tick and sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Solid {
    pub(crate) class: u32,
    pub(crate) strength: u32,
    pub(crate) tick: u32,
    pub(crate) sensor: u32,
}

/// What is kept after a scan that finds `now`; `said`: whether by itself, else from memory alone.
pub(crate) fn keep(old: Option<Solid>, now: Solid, said: bool) -> Option<Solid> {
    let Some(old) = old else { return said.then_some(now) };
    let own = old.sensor == now.sensor;
    if old.tick > now.tick {
        return Some(old);
    }
    if !said {
        return match (own, old.class, now.class) {
            (true, 4, 4) => Some(Solid { tick: old.tick, ..now }),
            (true, 4, _) => None,
            _ => Some(old),
        };
    }
    match (own, old.class, now.class) {
        (false, 2, 3 | 4) | (false, 4, 1 | 3) => Some(old),
        _ => Some(now),
    }
}

/// Lowest and highest crossing and the largest gap between two neighbours, metres above the ground, of the beams (range, z from
/// the lidar) that go on beyond `behind_m`.
pub(crate) fn crossing(
    beams: &[(f64, f64)],
    range_m: f64,
    behind_m: f64,
    lidar_height_m: f64,
) -> Option<[f64; 3]> {
    let beyond = beams.iter().filter(|(range, _)| *range > behind_m);
    let mut heights: Vec<f64> = beyond.map(|(range, z)| lidar_height_m + range_m * z / range).collect();
    heights.sort_by(f64::total_cmp);
    let gap = heights.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    Some([*heights.first()?, *heights.last()?, gap])
}
