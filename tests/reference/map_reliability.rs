//! Map reliability of one cell, in f64 (spec 1 §9): what is kept of looks, the network's inputs, and its sum.

use glam::DVec2;
use limpid::stage::camera::map_reliability::{INPUTS, MapReliability};

/// Sums over looks, each worth 0.9 of the next.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Looks {
    pub(crate) hit: f64,
    pub(crate) through: f64,
    pub(crate) strength: f64,
    pub(crate) reliability: f64,
    pub(crate) floor: f64,
    pub(crate) all: f64,
}

/// What one look shows: number of hits and the sum of their R, share of pixels that look through, a floor point alone.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Look {
    pub(crate) hits: Option<(f64, f64)>,
    pub(crate) share: f64,
    pub(crate) floor: bool,
}

impl Looks {
    /// With another look, worth `counts` of one; hits count fully from `enough` on, and by the power `exponent` of their quality.
    pub(crate) fn with(self, look: Look, enough: f64, exponent: f64, counts: f64) -> Self {
        let left = 0.9_f64.powf(counts);
        let new = (1.0 - left) / 0.1;
        let after = |old: f64, value: f64| left * old + new * value;
        let (hit, strength, reliability) = look.hits.map_or((0.0, 0.0, 0.0), |(n, sum)| {
            (1.0, (sum / enough).min(1.0) * (sum / n / 0.9).min(1.0).powf(exponent), sum / n)
        });
        Self {
            hit: after(self.hit, hit),
            through: after(self.through, look.share),
            strength: after(self.strength, strength),
            reliability: after(self.reliability, reliability),
            floor: after(self.floor, f64::from(u8::from(look.floor && look.hits.is_none()))),
            all: after(self.all, 1.0),
        }
    }
}

/// Evidence for and against the cells of a window of that side, row 0 = smallest y.
pub(crate) struct Evidence<'a> {
    pub(crate) side: usize,
    pub(crate) cells: &'a [[f64; 2]],
}

impl Evidence<'_> {
    fn at(&self, x: i64, y: i64) -> [f64; 2] {
        let inside = |value: i64| usize::try_from(value).ok().filter(|value| *value < self.side);
        match (inside(x), inside(y)) {
            (Some(x), Some(y)) => self.cells[y * self.side + x],
            _ => [0.0; 2],
        }
    }

    fn around(&self, [x, y]: [i64; 2], reach: i64) -> Vec<[f64; 2]> {
        let offsets = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)));
        offsets.filter(|offset| *offset != (0, 0)).map(|(dx, dy)| self.at(x + dx, y + dy)).collect()
    }

    /// The cells one to four steps along the ray, or against it.
    fn along(&self, [x, y]: [i64; 2], ray: DVec2, sign: f64) -> [[f64; 2]; 4] {
        [1.0, 2.0, 3.0, 4.0].map(|steps: f64| {
            let place = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) + ray * steps * sign;
            self.at(place.x.floor() as i64, place.y.floor() as i64)
        })
    }
}

fn log_for(evidence: f64) -> f64 {
    (evidence + 0.05).log2()
}

fn log_against(evidence: f64) -> f64 {
    (evidence + 0.02).log2()
}

fn most(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, f64::max)
}

/// The inputs of the cell at `at` of the window, at that offset from the camera, hit between those heights above the band's lower edge.
pub(crate) fn inputs(
    evidence: &Evidence<'_>,
    at: [i64; 2],
    offset_m: DVec2,
    heights_m: [f64; 2],
    looks: Looks,
) -> [f64; INPUTS.len()] {
    let (near, wide) = (evidence.around(at, 1), evidence.around(at, 3));
    let mean = |cells: &[[f64; 2]], which: usize| {
        cells.iter().map(|cell| cell[which]).sum::<f64>() / cells.len() as f64
    };
    let strong =
        |cells: &[[f64; 2]]| cells.iter().filter(|cell| cell[0] >= 1.75).count() as f64 / cells.len() as f64;
    let distance_m = offset_m.length().max(0.3);
    let ray = offset_m / distance_m;
    let (behind, before) = (evidence.along(at, ray, 1.0), evidence.along(at, ray, -1.0));
    let [own_for, own_against] = evidence.at(at[0], at[1]);
    [
        looks.hit / looks.all,
        looks.through / looks.all,
        looks.strength / looks.all,
        looks.reliability / looks.all,
        looks.floor / looks.all,
        log_for(own_for),
        log_against(own_against),
        looks.all.log2(),
        distance_m,
        heights_m[0].min(2.0),
        heights_m[1].min(2.0),
        log_for(mean(&near, 0)),
        log_against(mean(&near, 1)),
        strong(&near),
        log_for(most(near.iter().map(|cell| cell[0]))),
        log_for(mean(&wide, 0)),
        log_against(mean(&wide, 1)),
        strong(&wide),
        log_for(most(behind[..2].iter().map(|cell| cell[0]))),
        log_for(most(behind[2..].iter().map(|cell| cell[0]))),
        log_for(most(before.iter().map(|cell| cell[0]))),
        log_against(most(behind.iter().map(|cell| cell[1]))),
    ]
}

/// The network's sum: an obstacle from 0 on.
pub(crate) fn logit(inputs: &[f64], network: &MapReliability) -> f64 {
    let units = network.inner.chunks_exact(INPUTS.len() + 1).map(|row| {
        let (added, weights) = row.split_last().unwrap();
        let sum: f64 = weights.iter().zip(inputs).map(|(&weight, input)| f64::from(weight) * input).sum();
        (sum + f64::from(*added)).tanh()
    });
    let outer = network.outer.iter().map(|&weight| f64::from(weight));
    outer.zip(units).map(|(weight, unit)| weight * unit).sum::<f64>() + f64::from(network.bias)
}
