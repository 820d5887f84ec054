//! Drops, point by point and cell by cell (spec 6 §2).

use glam::{DVec2, DVec3};
use limpid::base::Rigid;
use limpid::sensor::CameraModel;

/// What is looked for, and from where.
pub(crate) struct Look<'a> {
    /// The sensor in the window, and its height above the ground.
    pub(crate) eye: DVec3,
    /// Height of a place above the ground.
    pub(crate) height: &'a dyn Fn(DVec3) -> f64,
    pub(crate) drop_m: f64,
    pub(crate) range_m: f64,
    pub(crate) resolution_m: f64,
    pub(crate) side: i64,
}

impl Look<'_> {
    pub(crate) fn cell(&self, at: DVec2) -> Option<usize> {
        let [x, y] = [at.x, at.y].map(|m| (m / self.resolution_m).floor() as i64);
        let inside = (0..self.side).contains(&x) && (0..self.side).contains(&y);
        inside.then_some((y * self.side + x) as usize)
    }

    /// Whether one of the nine cells around a place is as asked.
    pub(crate) fn around(&self, at: DVec2, is: impl Fn(usize) -> bool) -> bool {
        let step = |k: i32| f64::from(k) * self.resolution_m;
        (-1..=1).any(|i| (-1..=1).any(|j| self.cell(at + DVec2::new(step(i), step(j))).is_some_and(&is)))
    }

    /// Where the ray to a place crosses the ground; `None`: the place is no drop, or too far.
    pub(crate) fn crossing(&self, place: DVec3) -> Option<DVec2> {
        let (eye_m, height_m) = ((self.height)(self.eye), (self.height)(place));
        let at = self.eye.truncate().lerp(place.truncate(), eye_m / (eye_m - height_m));
        let away = (at - self.eye.truncate()).length();
        let deep = height_m < -(self.drop_m + 0.01 * away) && eye_m > 0.0 && away < self.range_m;
        deep.then_some(at)
    }

    /// Adds a place to what each cell holds: unexplained points, and whether an explained one ends there.
    pub(crate) fn mark(&self, cells: &mut [(u32, bool)], place: DVec3, explains: impl Fn(DVec2) -> bool) {
        let Some(crossing) = self.crossing(place) else { return };
        let [end, edge] = [self.cell(place.truncate()), self.cell(crossing)];
        if explains(crossing) {
            end.into_iter().for_each(|cell| cells[cell].1 = true);
            return;
        }
        end.into_iter().for_each(|cell| cells[cell].0 += 1);
        edge.filter(|_| edge != end).into_iter().for_each(|cell| cells[cell].0 += 1);
    }
}

/// What a camera sees of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Seen {
    Not,
    Past,
    InTheWay,
}

/// What a camera without distortion sees of the mirror place of `place` above a ground at z = 0.
pub(crate) fn seen_mirrored(camera: &CameraModel, at: Rigid, depth_m: &[f32], place: DVec3) -> Seen {
    let there = at.inverse().transform_point(DVec3::new(place.x, place.y, -place.z));
    if there.z < 0.05 {
        return Seen::Not;
    }
    let pixel = |k: i32| {
        let [i, j] = [k % 3 - 1, k / 3 - 1].map(|step| 2.0 * f64::from(step));
        let u = (there.x / there.z * camera.fx + camera.cx + i + 0.5).floor();
        let v = (there.y / there.z * camera.fy + camera.cy + j + 0.5).floor();
        let inside = u >= 0.0 && v >= 0.0 && u < f64::from(camera.width) && v < f64::from(camera.height);
        inside.then(|| f64::from(depth_m[v as usize * camera.width as usize + u as usize]))
    };
    let depths: Vec<f64> = (0..9).filter_map(pixel).filter(|depth| *depth > 0.0).collect();
    let is_there = |depth: &&f64| **depth < 1.08 * there.z + 0.1;
    match (depths.iter().filter(is_there).count(), depths.len()) {
        (0, past) if past >= 6 => Seen::Past,
        (0, _) => Seen::Not,
        _ => Seen::InTheWay,
    }
}

/// Whether the ground goes on behind a place, as seen from the eye, or close by on both sides of it.
pub(crate) fn is_in_ground(look: &Look<'_>, at: DVec2, ground: &dyn Fn(usize) -> bool) -> bool {
    let along = 0.05 * (at - look.eye.truncate()).normalize();
    let shows = |step: DVec2, steps: i32| {
        (1..=steps).any(|k| look.cell(at + f64::from(k) * step).is_some_and(ground))
    };
    shows(along, 30) || (shows(along.perp(), 8) && shows(-along.perp(), 8))
}

/// What is known of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Known {
    pub(crate) sure: f32,
    pub(crate) tick: u32,
    pub(crate) sensor: u32,
    pub(crate) drops: bool,
    pub(crate) ground: u32,
}

/// After a message of `sensor` at `tick` with so many unexplained points, explained ones, and the ground in the cell.
pub(crate) fn decide(
    old: Known,
    points: u32,
    explained: bool,
    ground: bool,
    (tick, sensor): (u32, u32),
) -> Known {
    let too_few = !ground && (1..2).contains(&points);
    if (!ground && points == 0 && !explained) || too_few || old.tick > tick {
        return old;
    }
    let falls = !ground && points > 0;
    let sure = 0.85 * old.sure + if falls { 1.0 - 0.85 } else { 0.0 };
    let ground = match (falls, ground) {
        (true, _) => old.ground.saturating_sub(1),
        (_, true) => (old.ground + 1).min(255),
        _ => old.ground,
    };
    Known { sure, tick, sensor, drops: sure >= if old.drops { 0.49 } else { 0.7 }, ground }
}
