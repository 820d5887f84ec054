//! Evidence for and against one cell, and the share of looks through it, in f64 (spec 1 §9).

use glam::{DVec2, DVec3};
use limpid::base::Rigid;
use limpid::sensor::CameraModel;

use crate::reference::update::State;

/// What one frame says of a cell.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Look {
    /// Number of hits and the sum of their R.
    pub(crate) hits: Option<(f64, f64)>,
    /// Share of the looks at the heights that count that pass behind the cell.
    pub(crate) share: f64,
    pub(crate) floor: bool,
    /// A neighbour was occupied by enough evidence of its own before the frame.
    pub(crate) beside: bool,
    /// Camera to cell, metres.
    pub(crate) distance_m: f64,
}

/// A cell over time.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Cell {
    pub(crate) support: f64,
    pub(crate) opposed: f64,
    pub(crate) state: State,
    /// Tick of the last look.
    pub(crate) tick: Option<u32>,
}

impl Cell {
    /// Takes one frame in; gives a, -1 where it says nothing. `focal_px` squared is the product of both; `timed`: looks count by time.
    pub(crate) fn look(&mut self, look: Look, focal_px: f64, tick: u32, timed: bool) -> f64 {
        let b = look.share + if look.floor && look.hits.is_none() { 0.07 } else { 0.0 };
        if look.hits.is_none() && b == 0.0 {
            return -1.0;
        }
        let enough = (7.5e-5 * (focal_px / look.distance_m.max(0.3)).powi(2)).max(2.0);
        let a = look.hits.map_or(0.0, |(n, sum)| (sum / enough).min(1.0) * (sum / n / 0.9).min(1.0).powi(8));
        let counts = match self.tick {
            Some(last) if timed => (f64::from(tick - last) * 0.01 * 30.0).min(1.0),
            _ => 1.0,
        };
        self.tick = Some(tick);
        let after = |old: f64, new: f64, kept: f64| {
            kept.powf(counts) * old + new * (1.0 - kept.powf(counts)) / (1.0 - kept)
        };
        self.support = after(self.support, a, 0.95).min(8.75);
        self.opposed = after(self.opposed, b, 0.8);
        let need = if look.beside { 0.44 } else { 1.75 };
        let (support, opposed) = (self.support, self.opposed);
        if support >= need && support >= 2.0 * opposed {
            self.state = State::Occupied;
        } else if self.state == State::Occupied && (support < 0.22 || support < 1.75 * opposed) {
            self.state = State::Unknown;
        }
        if self.state != State::Occupied && opposed >= 0.002 && support < 1.75 * opposed {
            self.state = State::Free;
        }
        a
    }

    /// How near a threshold the cell is, so that f32 may decide otherwise.
    pub(crate) fn margin(&self) -> f64 {
        let (support, opposed) = (self.support, self.opposed);
        if support == 0.0 && opposed == 0.0 {
            return f64::INFINITY;
        }
        let to = [1.75, 0.44, 0.22, 2.0 * opposed, 1.75 * opposed].map(|edge| (support - edge).abs());
        to.into_iter().fold((opposed - 0.002).abs(), f64::min)
    }
}

/// Layers of height above the ground between which a hit counts, metres.
pub(crate) const EDGES_M: [f64; 9] = [0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.1, 1.5, 2.0];

/// Lower and upper edge of the layers from that of `low_m` to that of `high_m`.
pub(crate) fn layers(low_m: f64, high_m: f64) -> [f64; 2] {
    let below = EDGES_M[..8].iter().rev().find(|edge| **edge <= low_m).unwrap_or(&EDGES_M[0]);
    let above = EDGES_M[1..].iter().find(|edge| **edge > high_m).unwrap_or(&EDGES_M[8]);
    [*below, *above]
}

/// A frame and where it was taken.
#[derive(Clone, Copy)]
pub(crate) struct Frame<'a> {
    pub(crate) camera: &'a CameraModel,
    pub(crate) window_from_camera: Rigid,
    pub(crate) depth_m: &'a [f32],
    pub(crate) reliability: &'a [f32],
    pub(crate) tau: f64,
}

/// Share of the pixels on the vertical over `centre` between two heights that are trusted and end behind the cell of that side; `None`
/// where none is in view. Goes up the vertical in steps far smaller than pixels.
pub(crate) fn share_through(
    frame: Frame<'_>,
    centre: DVec2,
    side_m: f64,
    heights_m: [f64; 2],
) -> Option<f64> {
    let camera_from_window = frame.window_from_camera.inverse();
    let offset = centre - frame.window_from_camera.translation_m.truncate();
    let reach = 0.5 * side_m * offset.length() / offset.abs().max_element();
    let (mut last, mut in_view, mut passing) = (None, 0.0, 0.0);
    for step in 0..=8000 {
        let height = heights_m[0] + (heights_m[1] - heights_m[0]) * f64::from(step) / 8000.0;
        let point = camera_from_window.transform_point(DVec3::new(centre.x, centre.y, height));
        if point.z < 0.05 {
            continue;
        }
        let CameraModel { fx, fy, cx, cy, width, height, .. } = *frame.camera;
        let [u, v] = [point.x / point.z * fx + cx, point.y / point.z * fy + cy].map(f64::round);
        if u < 0.0 || v < 0.0 || u >= f64::from(width) || v >= f64::from(height) || last == Some((u, v)) {
            continue;
        }
        last = Some((u, v));
        in_view += 1.0;
        let pixel = v as usize * width as usize + u as usize;
        let behind = f64::from(frame.depth_m[pixel]) > point.z * (1.0 + reach / offset.length());
        if behind && f64::from(frame.reliability[pixel]) > frame.tau {
            passing += 1.0;
        }
    }
    (in_view > 0.0 && offset.length() > reach).then(|| passing / in_view)
}
