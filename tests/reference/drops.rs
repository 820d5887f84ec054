//! Drops, ray by ray and cell by cell (spec 6 §2), in plain words and f64.

use glam::{DVec2, DVec3};
use limpid::base::Rigid;
use limpid::sensor::CameraModel;

/// What a ray says of the cell in which it meets the ground's height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Ground,
    Shallow,
    Open,
    Unsure,
    Mirrored,
    Rough,
}

/// What is looked for, and from where; the ground is z = 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Look {
    pub(crate) eye: DVec3,
    pub(crate) drop_m: f64,
    pub(crate) floor_m: f64,
    pub(crate) range_m: f64,
    pub(crate) resolution_m: f64,
    pub(crate) side: i64,
}

impl Look {
    pub(crate) fn cell(&self, at: DVec2) -> Option<usize> {
        let [x, y] = [at.x, at.y].map(|m| (m / self.resolution_m).floor() as i64);
        let inside = (0..self.side).contains(&x) && (0..self.side).contains(&y);
        inside.then_some((y * self.side + x) as usize)
    }

    /// Where the ray to a place meets the ground's height, and what it does there; what is deep is `Open`. `None`: it does not, or
    /// too far away.
    pub(crate) fn crossing(&self, place: DVec3) -> Option<(DVec2, Kind)> {
        let (eye_m, height_m) = (self.eye.z, place.z);
        if height_m >= self.floor_m || eye_m <= self.floor_m {
            return None;
        }
        let share = eye_m / (eye_m - height_m.min(0.5 * eye_m));
        let at = self.eye.truncate().lerp(place.truncate(), share);
        let away = at.distance(self.eye.truncate());
        let kind = match height_m {
            h if h > -0.5 * self.drop_m => Kind::Ground,
            h if h < -(self.drop_m + 0.01 * away) => Kind::Open,
            _ => Kind::Shallow,
        };
        (away < self.range_m).then_some((at, kind))
    }
}

/// What a camera without distortion says of a deep place that pixel (u, v) shows.
pub(crate) fn deep_kind(
    camera: &CameraModel,
    at: Rigid,
    depth_m: &[f32],
    place: DVec3,
    [u, v]: [u32; 2],
) -> Kind {
    let inside =
        |u: f64, v: f64| u >= 0.0 && v >= 0.0 && u < f64::from(camera.width) && v < f64::from(camera.height);
    let depth_at = |u: f64, v: f64| {
        inside(u, v).then(|| f64::from(depth_m[v as usize * camera.width as usize + u as usize]))
    };
    let there = at.inverse().transform_point(DVec3::new(place.x, place.y, -place.z));
    let around = (0..9).filter_map(|k| {
        let [i, j] = [k % 3 - 1, k / 3 - 1].map(|step| 2.0 * f64::from(step));
        let u = (there.x / there.z * camera.fx + camera.cx + i + 0.5).floor();
        let v = (there.y / there.z * camera.fy + camera.cy + j + 0.5).floor();
        depth_at(u, v).filter(|depth| *depth > 0.0)
    });
    let depths: Vec<f64> = around.filter(|_| there.z >= 0.05).collect();
    let in_the_way = depths.iter().any(|depth| *depth < 1.08 * there.z + 0.1);
    if in_the_way {
        return Kind::Mirrored;
    }
    let depth = f64::from(depth_m[(v * camera.width + u) as usize]);
    let beside = [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)].into_iter().filter(|(i, j)| {
        let beside = depth_at(f64::from(u) + i, f64::from(v) + j).unwrap_or(0.0);
        beside > 0.0 && (beside - depth).abs() < 0.03 + 0.06 * depth
    });
    match (beside.count(), depths.len()) {
        (0..=2, _) => Kind::Rough,
        (_, 6..) => Kind::Open,
        _ => Kind::Unsure,
    }
}

/// Votes of a cell by kind, and the mean depth of what is deep.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Votes {
    pub(crate) counts: [u32; 6],
    pub(crate) depth_m: f64,
}

impl Votes {
    fn of(self, kind: Kind) -> u32 {
        self.counts[kind as usize]
    }

    fn all(self) -> u32 {
        self.counts.iter().sum()
    }

    pub(crate) fn deep(self) -> u32 {
        self.of(Kind::Open) + self.of(Kind::Unsure)
    }

    fn mostly(self, kind: Kind) -> bool {
        2 * self.of(kind) > self.all()
    }
}

/// A message's votes, what is known, and how a message is judged.
pub(crate) struct Judge<'a> {
    pub(crate) look: Look,
    pub(crate) votes: &'a [Votes],
    /// Messages that showed a drop less those that showed the ground.
    pub(crate) known: &'a [i32],
    pub(crate) least_votes: u32,
    pub(crate) edge_m: f64,
    pub(crate) drops_after: i32,
}

/// What a message says of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Says {
    Nothing,
    Ground,
    Drop,
}

impl Judge<'_> {
    fn at(&self, at: DVec2) -> (Votes, i32) {
        self.look.cell(at).map_or((Votes::default(), 0), |cell| (self.votes[cell], self.known[cell]))
    }

    fn is_ground(&self, at: DVec2) -> bool {
        let (votes, known) = self.at(at);
        votes.mostly(Kind::Ground) || (votes.deep() <= votes.of(Kind::Ground) && known <= -3)
    }

    fn has_edge(&self, at: DVec2, away: DVec2) -> bool {
        let step_m = self.look.resolution_m.max(0.05);
        let steps = (self.edge_m.min(at.distance(self.look.eye.truncate())) / step_m) as usize;
        let mut shallow_m = 0.0;
        for k in 1..=steps {
            let place = at - k as f64 * step_m * away;
            if self.look.cell(place).is_none() {
                return false;
            }
            if self.is_ground(place) || self.at(place).1 >= self.drops_after {
                return shallow_m <= f64::max(0.15, step_m) + 0.5 * step_m;
            }
            shallow_m += if self.at(place).0.mostly(Kind::Shallow) { step_m } else { 0.0 };
        }
        false
    }

    fn is_level(&self, at: DVec2, away: DVec2) -> bool {
        let eye = self.look.eye;
        let deep: Vec<[f64; 2]> = (-6..10)
            .filter_map(|k| {
                let place = at + f64::from(k) * self.look.resolution_m.max(0.05) * away;
                let (votes, _) = self.at(place);
                let away_m = place.distance(eye.truncate()) * (eye.z + votes.depth_m) / eye.z;
                (votes.deep() > 0).then_some([votes.depth_m, away_m])
            })
            .collect();
        let relative = |of: usize| {
            let mean = deep.iter().map(|values| values[of]).sum::<f64>() / deep.len() as f64;
            let squares = deep.iter().map(|values| (values[of] - mean).powi(2)).sum::<f64>();
            (mean, (squares / deep.len() as f64).sqrt() / mean)
        };
        let ((depth_m, heights), (_, distances)) = (relative(0), relative(1));
        deep.len() >= 4 && heights < 0.7 * distances && depth_m < 2.0
    }

    fn is_in_ground(&self, at: DVec2, away: DVec2, level: bool) -> bool {
        let step = |k: i32, way: DVec2| at + f64::from(k) * self.look.resolution_m.max(0.05) * way;
        let image = |place: DVec2| !level && self.at(place).0.mostly(Kind::Mirrored);
        let beside = |way: DVec2| (1..=8).any(|k| self.is_ground(step(k, way)));
        (1..=30).any(|k| self.is_ground(step(k, away)) || image(step(k, away)))
            || (beside(away.perp()) && beside(-away.perp()))
    }

    pub(crate) fn says(&self, cell: usize) -> Says {
        let side = self.look.side as usize;
        let at = (DVec2::new((cell % side) as f64, (cell / side) as f64) + 0.5) * self.look.resolution_m;
        let votes = self.votes[cell];
        if votes.mostly(Kind::Ground) {
            return Says::Ground;
        }
        let around: u32 = (0..9)
            .map(|k| {
                let off = DVec2::new(f64::from(k % 3 - 1), f64::from(k / 3 - 1)) * self.look.resolution_m;
                self.at(at + off).0.deep()
            })
            .sum();
        let away = (at - self.look.eye.truncate()).normalize_or_zero();
        let falls = votes.deep() > 0 && f64::from(votes.deep()) >= 0.7 * f64::from(votes.all());
        if !falls || around < self.least_votes || !self.has_edge(at, away) {
            return Says::Nothing;
        }
        let unsure = 2 * votes.of(Kind::Unsure) > votes.deep();
        if unsure && self.is_in_ground(at, away, self.is_level(at, away)) {
            return Says::Nothing;
        }
        Says::Drop
    }
}

/// What is known of a cell: messages for a drop less those for the ground, and whether it is one.
pub(crate) fn decide(known: i32, drops: bool, says: Says, after: i32) -> (i32, bool) {
    let known = match says {
        Says::Nothing => return (known, drops),
        Says::Ground => known - 1,
        Says::Drop => known + 1,
    };
    let known = known.clamp(-2 * after, 2 * after);
    (known, known >= if drops { after / 2 } else { after })
}
