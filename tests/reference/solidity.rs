//! Learned solidity, point by point and cell by cell (spec 6 §3), in plain words and f64.

use glam::DVec2;
use limpid::sensor::Point;
use limpid::stage::lidar::solidity::SolidityModel;

pub(crate) const SECTORS: usize = 720;
pub(crate) const SLOPES: usize = 128;
pub(crate) const WORDS: usize = 13;
pub(crate) const BLOCK_WORDS: usize = 5;

/// Cells around a lidar that stands on level ground.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    /// The lidar in the window.
    pub(crate) lidar: DVec2,
    pub(crate) lidar_m: f64,
    pub(crate) side: usize,
    pub(crate) cell_m: f64,
    /// log2 of intensity at 1 m, its slope, 1 / deviation.
    pub(crate) trend: [f64; 3],
    pub(crate) two_returns: f64,
    /// Cells to each side that count as around one.
    pub(crate) reach: i64,
    /// Cells along the side of a block.
    pub(crate) block: usize,
}

impl Place {
    /// Blocks along a side.
    pub(crate) fn blocks(&self) -> usize {
        self.side.div_ceil(self.block)
    }

    /// Words of all cells and blocks.
    pub(crate) fn words(&self) -> usize {
        self.side * self.side * WORDS + self.blocks() * self.blocks() * BLOCK_WORDS
    }

    fn centre(&self, cell: usize) -> DVec2 {
        let at = DVec2::new((cell % self.side) as f64, (cell / self.side) as f64) + 0.5;
        at * self.cell_m - self.lidar
    }
}

/// Sector of a direction, on a ring of 720.
fn turn_of(at: DVec2) -> f64 {
    let share = at.y.abs() / (at.x.abs() + at.y.abs());
    let turn = match (at.x < 0.0, at.y < 0.0) {
        (false, false) => share,
        (true, false) => 2.0 - share,
        (true, true) => 2.0 + share,
        (false, true) => 4.0 - share,
    };
    turn * 180.0
}

fn slope_bin(slope: f64) -> usize {
    ((0.5 + 0.5 * slope / (1.0 + slope.abs())) * 128.0) as usize
}

/// The words of all cells and blocks, then those of all bins of beams and slopes.
pub(crate) fn counts(points: &[Point], place: &Place) -> (Vec<u32>, Vec<u32>) {
    let mut cells = vec![0; place.words()];
    let mut bins = vec![0; SECTORS * SLOPES * 3 + SLOPES];
    for point in points {
        let [x, y, z] = point.position_m().map(f64::from);
        let (seen, above) = (DVec2::new(x, y), z + place.lidar_m);
        let cut = if above < -0.1 { place.lidar_m / (place.lidar_m - above) } else { 1.0 };
        let slope = slope_bin(z / seen.length());
        let bin = 3 * ((turn_of(seen) as usize).min(SECTORS - 1) * SLOPES + slope);
        let steps = (seen.length() * cut * 1024.0) as u32;
        bins[bin] = steps.max(bins[bin]);
        bins[bin + 1] = (262_144 - steps).max(bins[bin + 1]);
        bins[bin + 2] += 1;
        bins[3 * SECTORS * SLOPES + slope] += 1;
        let at = ((seen + place.lidar) / place.cell_m).floor();
        let inside = at.min_element() >= 0.0 && at.max_element() < place.side as f64;
        if !inside || above < 0.1 {
            continue;
        }
        let cell = at.y as usize * place.side + at.x as usize;
        let words = &mut cells[cell * WORDS..][..WORDS];
        if above > 2.0 {
            words[12] += 1;
            continue;
        }
        let band = [0.4, 0.8, 1.3].iter().filter(|&&bound| above >= bound).count();
        words[band] += 1;
        let height = (above * 256.0) as u32;
        words[4] = words[4].max(65536 - height);
        words[5] = words[5].max(1 + height);
        let depth = (seen.length() - place.centre(cell).length()) / place.cell_m;
        let along = ((depth + 0.75) * 64.0) as u32;
        words[6] += along;
        words[7] += along * along;
        words[8] += u32::from(point.return_type.is_of_two());
        let intensity = f64::from(point.intensity);
        if place.trend[2] > 0.0 && intensity > 0.0 {
            let range = seen.length().hypot(z);
            let light = (intensity.log2() - place.trend[0] - place.trend[1] * range.log2()) * place.trend[2];
            words[9] += 1;
            let steps = ((light.clamp(-3.9, 3.9) + 4.0) * 16.0) as u32;
            words[10] += steps;
            words[11] += steps * steps;
        }
        let [column, row] = [cell % place.side, cell / place.side].map(|at| at / place.block);
        let first = place.side * place.side * WORDS + (row * place.blocks() + column) * BLOCK_WORDS;
        cells[first + band] += 1;
        cells[first + 4] = cells[first + 4].max(1 + height);
    }
    (cells, bins)
}

/// Of each cell with returns: beams that end before it, that go on behind it, that are sent there; heights and directions are off by
/// `hair`.
pub(crate) fn beams(cells: &[u32], bins: &[u32], place: &Place, hair: f64) -> Vec<[f64; 4]> {
    let of = |cell: usize| beams_of(cell, &cells[cell * WORDS..], bins, place, hair);
    (0..place.side * place.side).map(of).collect()
}

fn beams_of(cell: usize, words: &[u32], bins: &[u32], place: &Place, hair: f64) -> [f64; 4] {
    let (centre, range) = (place.centre(cell), place.centre(cell).length());
    if words[5] == 0 || range < place.cell_m {
        return [0.0; 4];
    }
    let low = f64::from(65536 - words[4]) / 256.0 - place.lidar_m - 0.05 + hair;
    let high = f64::from(words[5] - 1) / 256.0 - place.lidar_m + 0.05 + hair;
    let aside = centre.perp() / range * 0.5 * place.cell_m;
    let [from, to] = [turn_of(centre - aside) + hair, turn_of(centre + aside)];
    let wide = if to < from { to - from + 720.0 } else { to - from };
    let whole = (from.fract() + wide) as usize + 1;
    let kept = whole.min(24);
    let first = from as usize + (whole - kept) / 2;
    let [near, far] = [-0.5, 0.5].map(|half| (range + half * place.cell_m) * 1024.0);
    let mut sums = [0.0; 4];
    for slope in slope_bin(low / range)..=slope_bin(high / range) {
        sums[2] += f64::from(bins[3 * SECTORS * SLOPES + slope]) / 720.0 * kept as f64;
        for sector in first..first + kept {
            let bin = &bins[3 * (sector % SECTORS * SLOPES + slope)..][..3];
            let count = f64::from(bin[2]);
            if bin[2] == 0 {
                continue;
            }
            let (last, first) = (f64::from(bin[0]), f64::from(262_144 - bin[1]));
            let apart = (count - 2.0).max(0.0) / (last - first).max(1.0);
            sums[0] += match (first >= near, last <= near) {
                (true, _) => 0.0,
                (_, true) => count,
                _ => 1.0 + apart * (near - first),
            };
            sums[1] += match (last < far, first >= far) {
                (true, _) => 0.0,
                (_, true) => count,
                _ => 1.0 + apart * (last - far),
            };
        }
    }
    sums.map(|sum| sum * wide / kept as f64)
}

/// A cell's returns as the model takes them: where their middle lies, in cells from the cell that is judged.
struct Own<'a> {
    words: &'a [u32],
    beams: [f64; 4],
    returns: f64,
    middle: DVec2,
    within: f64,
}

fn own<'a>(words: &'a [u32], beams: [f64; 4], offset: DVec2, along: DVec2) -> Own<'a> {
    let returns = f64::from(words[..4].iter().sum::<u32>());
    let mean = f64::from(words[6]) / 64.0 / returns;
    let within = (f64::from(words[7]) / 4096.0 / returns - mean * mean).max(0.0);
    Own { words, beams, returns, middle: offset + along * (mean - 0.75), within }
}

/// Returns by height in the blocks around a cell, the highest, and blocks with any.
fn wide(cells: &[u32], place: &Place, [x, y]: [usize; 2]) -> ([f64; 4], f64, f64) {
    let (mut bands, mut highest, mut blocks) = ([0.0; 4], 0.0_f64, 0.0);
    let [column, row] = [x, y].map(|at| at / place.block);
    let near = |at: usize| at.saturating_sub(1)..=(at + 1).min(place.blocks() - 1);
    for (column, row) in near(row).flat_map(|row| near(column).map(move |column| (column, row))) {
        let first = place.side * place.side * WORDS + (row * place.blocks() + column) * BLOCK_WORDS;
        // A block that lies a block's side away lies in the window there too, but for the last, which may be cut off.
        let inside = |at: usize, own: usize, block: usize| {
            let away = (block as i64 - (own / place.block) as i64) * place.block as i64;
            at as i64 + away < place.side as i64
        };
        if cells[first + 4] == 0 || !inside(x, x, column) || !inside(y, y, row) {
            continue;
        }
        (0..4).for_each(|band| bands[band] += f64::from(cells[first + band]));
        highest = highest.max(f64::from(cells[first + 4] - 1) / 256.0);
        blocks += 1.0;
    }
    (bands, highest, blocks)
}

/// Deviations of the middles of returns: along the beam, across it, the least and the largest of all directions, decimetres.
fn spreads(all: &[Own<'_>], along: DVec2, cell_m: f64) -> [f64; 4] {
    let returns: f64 = all.iter().map(|own| own.returns).sum();
    let mean = all.iter().map(|own| own.middle * own.returns).sum::<DVec2>() / returns;
    let moment = |of: &dyn Fn(DVec2) -> f64| {
        all.iter().map(|own| own.returns * of(own.middle - mean)).sum::<f64>() / returns
    };
    let (xx, yy, xy) = (moment(&|d| d.x * d.x), moment(&|d| d.y * d.y), moment(&|d| d.x * d.y));
    let within = all.iter().map(|own| own.returns * own.within).sum::<f64>() / returns;
    let (half, apart) = (0.5 * (xx + yy), (0.25 * (xx - yy).powi(2) + xy * xy).sqrt());
    let beam = moment(&|d| d.dot(along).powi(2));
    let across = moment(&|d| d.perp_dot(along).powi(2));
    [beam + within, across, half - apart + within, half + apart].map(|v| v.max(0.0).sqrt() * cell_m / 0.1)
}

/// Of beams before, behind and sent, and of those that ended: went on, ended, hidden, lost.
fn shares(beams: [f64; 4], ended: f64) -> [f64; 4] {
    let total = beams[0] + beams[1] + ended + 0.5;
    let lost = (beams[2] + 0.5 - total).max(0.0) / (beams[2] + 0.5);
    [beams[1] / (beams[1] + ended + 0.5), ended / total, beams[0] / total, lost]
}

/// The inputs of the cell at (x, y) in which something stands.
#[expect(clippy::too_many_lines, reason = "a line for each input")]
pub(crate) fn inputs(cells: &[u32], beams: &[[f64; 4]], place: &Place, [x, y]: [usize; 2]) -> Vec<f64> {
    let cell = y * place.side + x;
    let range = place.centre(cell).length();
    let along = place.centre(cell) / range;
    let mut all = Vec::new();
    let offsets = -place.reach..=place.reach;
    for (dx, dy) in offsets.clone().flat_map(|dy| offsets.clone().map(move |dx| (dx, dy))) {
        let (at_x, at_y) = (x as i64 + dx, y as i64 + dy);
        let sides = 0..place.side as i64;
        let other = (at_y * place.side as i64 + at_x) as usize;
        if sides.contains(&at_x) && sides.contains(&at_y) && cells[other * WORDS + 5] > 0 {
            let words = &cells[other * WORDS..][..WORDS];
            all.push(own(words, beams[other], DVec2::new(dx as f64, dy as f64), along));
        }
    }
    let alone = own(&cells[cell * WORDS..][..WORDS], beams[cell], DVec2::ZERO, along);
    let sum = |of: &dyn Fn(&Own<'_>) -> f64| all.iter().map(of).sum::<f64>();
    let word = |at: usize| sum(&|own| f64::from(own.words[at]));
    let returns = sum(&|own| own.returns);
    let near = shares([0, 1, 2, 3].map(|at| sum(&|own| own.beams[at])), returns);
    let own_shares = shares(alone.beams, alone.returns);
    let [depth, across, least, largest] = spreads(&all, along, place.cell_m);
    let metres = |own: &Own<'_>| {
        [f64::from(65536 - own.words[4]), f64::from(own.words[5]) - 1.0].map(|steps| steps / 256.0)
    };
    let [low, high] = metres(&alone);
    let lowest = all.iter().map(|own| metres(own)[0]).fold(f64::INFINITY, f64::min);
    let highest = all.iter().map(|own| metres(own)[1]).fold(f64::NEG_INFINITY, f64::max);
    let (lit, many, away) = (word(9), (1.0 + returns).log2(), (range.max(0.5) / 5.0).log2());
    let known = if lit > 0.0 { 1.0 } else { 0.0 };
    let mean = word(10) / 16.0 / lit.max(1.0);
    let contrast = known * (mean - 4.0);
    let contrasts = known * (word(11) / 256.0 / lit.max(1.0) - mean * mean).max(0.0).sqrt();
    let filled = (0..4).filter(|&band| word(band) > 0.0).count() as f64 / 4.0;
    let (wide_bands, wide_highest, blocks) = wide(cells, place, [x, y]);
    let wide_returns: f64 = wide_bands.iter().sum();
    let area = ((2 * place.reach + 1) * (2 * place.reach + 1)) as f64;
    let span = highest - lowest;
    vec![
        (1.0 + alone.returns).log2(),
        many,
        all.len() as f64 / area,
        away,
        own_shares[0],
        near[0],
        own_shares[1],
        near[1],
        near[2],
        near[3],
        alone.within.sqrt(),
        depth,
        across,
        least,
        largest,
        low,
        high,
        highest,
        span,
        high - low,
        word(0) / returns,
        word(1) / returns,
        word(2) / returns,
        filled,
        word(8) / returns,
        place.two_returns,
        known,
        contrast,
        contrasts,
        (place.cell_m / 0.1).log2(),
        (1.0 + sum(&|own| own.beams[2])).log2(),
        wide_highest,
        wide_bands[0] / wide_returns.max(1.0),
        wide_bands[1] / wide_returns.max(1.0),
        wide_bands[2] / wide_returns.max(1.0),
        (1.0 + wide_returns).log2(),
        blocks / 9.0,
        near[0] * highest,
        near[0] * least,
        near[0] * many,
        least * highest,
        least * many,
        highest * highest,
        wide_highest * wide_highest,
        away * near[0],
        away * contrasts,
        span * span,
        filled * least,
    ]
}

/// What the model makes of a cell's inputs: solid from 0 on.
pub(crate) fn logit(inputs: &[f64], model: &SolidityModel) -> f64 {
    let units = model.inner.chunks_exact(inputs.len() + 1).zip(&model.outer);
    let unit = |(inner, outer): (&[f32], &f32)| {
        let sum: f64 = inputs.iter().zip(inner).map(|(input, weight)| input * f64::from(*weight)).sum();
        f64::from(*outer) * (sum + f64::from(inner[inputs.len()])).tanh()
    };
    units.map(unit).sum::<f64>() + f64::from(model.bias[usize::from(inputs[26] > 0.5)])
}

/// A thin, upright sheet that few beams pass.
pub(crate) fn is_sheet(inputs: &[f64]) -> bool {
    inputs[13] < 0.3 && inputs[18] > 0.5 && inputs[5] < 0.6
}
