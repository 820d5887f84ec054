//! Cells of the organized cloud, candidates, planes, labels and memory of panes (spec 3 §1, §3, §5, §7).

use std::collections::HashMap;

use glam::{DMat3, DVec3};
use limpid::map::Pane;
use limpid::map::glass::PointClass;

/// A point as a beam measured it.
pub(crate) type Beam = ([f32; 3], usize, usize);

/// Number of the nearest point of each cell (column, row, slot); of equals within a centimetre the first.
pub(crate) fn organize(beams: &[Beam], columns: usize) -> HashMap<(usize, usize, usize), usize> {
    let mut cells: HashMap<_, usize> = HashMap::new();
    let centimetres = |index: usize| {
        let [x, y, z] = beams[index].0.map(f64::from);
        ((x * x + y * y + z * z).sqrt() * 100.0) as u64
    };
    for (index, &([x, y, _], row, slot)) in beams.iter().enumerate() {
        let turn = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU + 1.0;
        let column = (turn * columns as f64).round() as usize % columns;
        let kept = cells.entry((column, row, slot)).or_insert(index);
        if centimetres(index) < centimetres(*kept) {
            *kept = index;
        }
    }
    cells
}

/// Words of the cells as the shaders keep them; `u32::MAX` where a cell is empty.
pub(crate) fn is_candidate(first: u32, last: u32, peak: bool, gap_m: f64) -> bool {
    let metres = |word: u32| f64::from(word >> 18) / 100.0;
    let some = first != u32::MAX;
    let differ = some && last != u32::MAX && metres(last) > metres(first) + gap_m;
    differ || (some && peak)
}

/// Columns from a maximum to where the intensity has fallen to 0.4 of it, if it falls gradually (spec 3 §2); else `None`.
fn foot(row: &[f32], top: usize, step: isize) -> Option<usize> {
    let at = |k: isize| row[(top as isize + k * step).rem_euclid(row.len() as isize) as usize];
    let most = (0.35 * row.len() as f32 / std::f32::consts::TAU) as isize;
    let end = (1..=most).find(|k| at(*k) <= 0.4 * at(0))?;
    let falls: Vec<f32> = (1..=end).map(|k| at(k - 1) - at(k)).collect();
    let rises = falls.iter().any(|fall| *fall < -0.1 * at(0));
    let steepest = falls.iter().copied().fold(0.0, f32::max);
    let gradual = steepest <= (1.25 / end as f32 + 0.15) * at(0);
    (end >= 2 && gradual && !rises).then_some(end as usize)
}

/// Columns of intensity peaks where all rows are alike and no range jumps.
pub(crate) fn peaks(row: &[f32]) -> Vec<bool> {
    let mut marks = vec![false; row.len()];
    for top in 0..row.len() {
        let [before, after] = [row.len() - 1, 1].map(|step| row[(top + step) % row.len()]);
        if before > row[top] || after >= row[top] {
            continue;
        }
        let Some((left, right)) = foot(row, top, -1).zip(foot(row, top, 1)) else { continue };
        (0..=left + right).for_each(|k| marks[(top + row.len() - left + k) % row.len()] = true);
    }
    marks
}

fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Plane number `number` through three of `points`: n and d > 0; `None` where they make none (spec 3 §3).
pub(crate) fn hypothesis(points: &[DVec3], seed: u32, number: u32) -> Option<(DVec3, f64)> {
    let count = points.len() as u32;
    let a = hash(seed ^ hash(number.wrapping_mul(3)));
    let b = hash(a ^ 0x9e37_79b9);
    let c = hash(b ^ 0x85eb_ca6b);
    let near = (count / 3).max(3);
    let start = a % count + count - near / 2;
    let at = |index: u32| points[(index % count) as usize];
    let origin = at(a);
    let legs = [at(start + b % near) - origin, at(start + c % near) - origin];
    let area = legs[0].cross(legs[1]);
    let [p, q] = legs.map(DVec3::length);
    if p.min(q) < 0.2 || area.length() < 0.2 * p * q {
        return None;
    }
    let normal = area.normalize();
    let distance_m = normal.dot(origin);
    Some(if distance_m > 0.0 { (normal, distance_m) } else { (-normal, -distance_m) })
}

/// Least-squares plane of the points within `tolerance_m` of a plane, three times.
pub(crate) fn refit(points: &[DVec3], mut plane: (DVec3, f64), tolerance_m: f64) -> (DVec3, f64) {
    for _ in 0..3 {
        let near: Vec<DVec3> =
            points.iter().copied().filter(|p| (plane.0.dot(*p) - plane.1).abs() < tolerance_m).collect();
        let mean = near.iter().sum::<DVec3>() / near.len() as f64;
        let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
        let spread = near.iter().fold(DMat3::ZERO, |sum, p| sum + outer(*p - mean));
        // Inverse iteration: the direction of least variance grows most.
        let inverse = (spread + DMat3::from_diagonal(DVec3::splat(1e-9))).inverse();
        let normal = (0..60).fold(plane.0, |n, _| (inverse * n).normalize());
        let distance_m = normal.dot(mean);
        plane = if distance_m > 0.0 { (normal, distance_m) } else { (-normal, -distance_m) };
    }
    plane
}

/// The largest value of 20 leading bits under which no more than a quarter of the values lie; all are positive.
pub(crate) fn lower_quartile(values: &[f32]) -> f32 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    f32::from_bits(sorted[sorted.len() / 4].to_bits() & !((1 << 11) - 1))
}

/// What labels are given by.
pub(crate) struct Rules {
    pub(crate) plane_tolerance_m: f64,
    pub(crate) match_m: f64,
    pub(crate) match_per_m: f64,
    pub(crate) lobe_cos: f64,
    pub(crate) half_rows: i64,
    pub(crate) half_columns: i64,
    pub(crate) gap_m: f64,
}

/// A scan that one pane stands in: places, intensities, cells (column, row, slot) and their sizes.
pub(crate) struct Organized<'a> {
    pub(crate) places_m: &'a [DVec3],
    pub(crate) intensities: &'a [f64],
    pub(crate) beams: &'a [Beam],
    pub(crate) cells: &'a HashMap<(usize, usize, usize), usize>,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) row_of: &'a dyn Fn(DVec3) -> Option<usize>,
}

impl Organized<'_> {
    fn column_of(&self, p: DVec3) -> usize {
        let turn = p.y.atan2(p.x) / std::f64::consts::TAU + 1.0;
        (turn * self.columns as f64).round() as usize % self.columns
    }

    fn cell(&self, at: (usize, usize), step: (i64, i64)) -> Option<(usize, usize)> {
        let row = usize::try_from(at.1 as i64 + step.1).ok().filter(|row| *row < self.rows)?;
        Some(((at.0 as i64 + step.0).rem_euclid(self.columns as i64) as usize, row))
    }

    /// Range of the first return of a cell, in the steps that cells keep.
    fn range_m(&self, cell: (usize, usize), slot: usize) -> Option<f64> {
        let index = self.cells.get(&(cell.0, cell.1, slot))?;
        Some((self.places_m[*index].length() * 100.0).floor() / 100.0)
    }
}

fn around(columns: i64, rows: i64) -> impl Iterator<Item = (i64, i64)> {
    (-columns..=columns).flat_map(move |c| (-rows..=rows).map(move |r| (c, r)))
}

/// A pane in a scan, and what it mirrors: ranges by column and row, and how deep the room before it is.
struct View<'a> {
    scan: &'a Organized<'a>,
    pane: &'a Pane,
    rules: &'a Rules,
    images: HashMap<(usize, usize), f64>,
    deepest_m: f64,
}

impl View<'_> {
    fn normal(&self) -> DVec3 {
        self.pane.unit_normal().as_dvec3()
    }

    fn over(&self, p: DVec3) -> f64 {
        self.normal().dot(p) - f64::from(self.pane.normal.w)
    }

    fn through(&self, p: DVec3) -> bool {
        let n = self.normal();
        let level = self.pane.level.truncate().as_dvec3();
        let [u0, u1, v0, v1] = self.pane.extent_m.to_array().map(f64::from);
        let at = p * (f64::from(self.pane.normal.w) / n.dot(p));
        let (u, v) = (at.dot(level), at.dot(n.cross(level)));
        n.dot(p) > 1e-6 && u >= u0 - 0.3 && u <= u1 + 0.3 && v >= v0 - 0.3 && v <= v1 + 0.3
    }

    fn meets(&self, p: DVec3) -> bool {
        self.through(p) && self.over(p) > -self.rules.plane_tolerance_m
    }

    fn mirrored_m(&self, p: DVec3) -> DVec3 {
        p - 2.0 * self.over(p) * self.normal()
    }

    fn cell_of(&self, index: usize) -> (usize, usize) {
        (self.scan.column_of(self.scan.places_m[index]), self.scan.beams[index].1)
    }

    /// Mirrors all first returns before the pane (step 1); how deep the room is, every point tells.
    fn mirror(&mut self) {
        for (p, beam) in self.scan.places_m.iter().zip(self.scan.beams) {
            let before_m = -self.over(*p);
            self.deepest_m = self.deepest_m.max(before_m);
            if beam.2 != 0 || self.meets(*p) || before_m <= 0.1 {
                continue;
            }
            let image = self.mirrored_m(*p);
            if let Some(row) = (self.scan.row_of)(image).filter(|_| self.through(image)) {
                let cell = (self.scan.column_of(image), row);
                let range_m = self.images.entry(cell).or_insert(f64::INFINITY);
                *range_m = range_m.min(image.length());
            }
        }
    }

    /// The class of a point behind the pane (steps 1 and 2).
    fn behind(&self, p: DVec3, cell: (usize, usize)) -> PointClass {
        let (scan, rules) = (self.scan, self.rules);
        let (range_m, near) = (p.length(), rules.match_m + rules.match_per_m * p.length());
        let image = |step| self.images.get(&scan.cell(cell, step)?).copied();
        let close: Vec<f64> = around(1, 1).filter_map(image).collect();
        let wide: Vec<f64> = around(rules.half_columns, rules.half_rows).filter_map(image).collect();
        let window = (2 * rules.half_columns + 1) * (2 * rules.half_rows + 1);
        let farthest_m = wide.iter().copied().fold(0.0, f64::max);
        let beyond = close.len() >= 2 && 2 * wide.len() as i64 >= window && farthest_m < range_m - near;
        let place = self.mirrored_m(p);
        let near_place = rules.match_m + rules.match_per_m * place.length();
        let target = (scan.row_of)(place).map(|row| (scan.column_of(place), row));
        let measured = |step| scan.range_m(scan.cell(target?, step)?, 0);
        let measured_m: Vec<f64> = around(1, 1).filter_map(measured).collect();
        let passes = measured((0, 0)).is_some()
            && measured_m.len() >= 4
            && measured_m.iter().all(|m| *m > place.length() + near_place);
        if close.iter().any(|m| (m - range_m).abs() < near)
            || measured_m.iter().any(|m| (m - place.length()).abs() < near_place)
        {
            PointClass::Reflection
        } else if beyond || passes || self.over(p) > self.deepest_m + 2.0 * rules.match_m {
            PointClass::Outside
        } else {
            PointClass::Unlabelled
        }
    }

    /// The class of a point by steps 1 and 2.
    fn class(&self, index: usize) -> PointClass {
        let p = self.scan.places_m[index];
        if !self.meets(p) {
            return PointClass::Inside;
        }
        if self.over(p) >= self.rules.plane_tolerance_m {
            return self.behind(p, self.cell_of(index));
        }
        let [near, far] = [0, 1].map(|slot| self.scan.range_m(self.cell_of(index), slot));
        let dual = near.zip(far).is_some_and(|(near, far)| far > near + self.rules.gap_m);
        let bright = f64::from(self.pane.level.w);
        let limit = bright * if dual { 3.0 } else { 1.0 };
        let head_on = self.normal().dot(p) > self.rules.lobe_cos * p.length();
        let glass = self.scan.beams[index].2 == 0
            && (bright <= 0.0 || head_on || self.scan.intensities[index] < limit);
        if glass { PointClass::Glass } else { PointClass::Inside }
    }
}

/// Classes by steps 1 to 3 (spec 3 §5) for one pane, without memory.
pub(crate) fn labels(scan: &Organized<'_>, pane: &Pane, rules: &Rules) -> Vec<PointClass> {
    let mut view = View { scan, pane, rules, images: HashMap::new(), deepest_m: 0.0 };
    view.mirror();
    let classes: Vec<PointClass> = (0..scan.places_m.len()).map(|index| view.class(index)).collect();
    let settled = |(index, class): (usize, &PointClass)| {
        let (column, row) = view.cell_of(index);
        let last = scan.cells.get(&(column, row, 1)).filter(|last| **last != index);
        let passed = last.is_some_and(|last| {
            let farther_m = scan.places_m[*last].length() - scan.places_m[index].length();
            classes[*last] == PointClass::Outside && farther_m > rules.match_m
        });
        if *class == PointClass::Unlabelled && passed { PointClass::Reflection } else { *class }
    };
    classes.iter().enumerate().map(settled).collect()
}

/// A kept pane after one more scan has found it (spec 3 §7): the mean plane through the mean of the centres, weighted by
/// scans. Normal and a point on the plane.
pub(crate) fn refined(kept: &Pane, fresh: &Pane) -> (DVec3, DVec3) {
    let weight = f64::from(kept.hits.min(50));
    let [n, m] = [kept, fresh].map(|pane| pane.unit_normal().as_dvec3());
    let m = if n.dot(m) < 0.0 { -m } else { m };
    let centre_m = fresh.centre_m();
    let off_m = n.dot(centre_m) - f64::from(kept.normal.w);
    ((n * weight + m).normalize(), centre_m - n * (off_m * weight / (weight + 1.0)))
}

/// What is known of a kept pane's ends (least and largest u at open air, scans that say so) and its extent along u after a scan
/// that saw it from `seen[0]` to `seen[1]` and showed `ends` (least and largest u of glass, 1 where it ended at open air);
/// `None` where the scan shows another pane, past an end.
pub(crate) fn ended(
    known: [f32; 4],
    extent: [f32; 2],
    seen: [f32; 2],
    ends: [f32; 4],
) -> Option<([f32; 4], [f32; 2])> {
    let [low, high, low_scans, high_scans] = known;
    if (low_scans >= 3.0 && ends[1] < low) || (high_scans >= 3.0 && ends[0] > high) {
        return None;
    }
    let after = |at: f32, scans: f32, seen: f32, air: bool, past: bool| match (air, past) {
        (true, _) => (seen, (scans + 1.0).min(3.0)),
        (false, true) => (at, 0.0),
        (false, false) => (at, scans),
    };
    let (low, low_scans) = after(low, low_scans, seen[0], ends[2] > 0.0, low - ends[0] > 0.3);
    let (high, high_scans) = after(high, high_scans, seen[1], ends[3] > 0.0, ends[1] - high > 0.3);
    let united = [extent[0].min(seen[0]), extent[1].max(seen[1])];
    let cut = [
        if low_scans >= 3.0 { united[0].max(low) } else { united[0] },
        if high_scans >= 3.0 { united[1].min(high) } else { united[1] },
    ];
    Some(([low, high, low_scans, high_scans], cut))
}
