//! Glass in lidar scans (spec 3): the beams' grid, panes, classes of points, labels of whole scans.

mod clean;
mod grid;
mod labeller;
pub mod metrics;
mod pane;
mod set;
mod store;

pub use self::clean::{CleanPoint, cleaned};
pub use self::grid::BeamGrid;
pub use self::labeller::{LabelledScan, Labeller};
pub use self::pane::Pane;
pub use self::set::PaneSet;
pub use self::store::{panes_to_yaml, read_panes};
use crate::stage::glass::COUNTERS_WORDS;

/// What a point is (spec 3 §5).
#[repr(u8)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PointClass {
    /// No step decided, or the point is none.
    #[default]
    Unlabelled = 0,
    /// Real, and not behind a pane.
    Inside = 1,
    /// On a pane.
    Glass = 2,
    /// Seen in a pane; nothing real stands there.
    Reflection = 3,
    /// Real, behind a pane.
    Outside = 4,
}

impl PointClass {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 5] = [Self::Unlabelled, Self::Inside, Self::Glass, Self::Reflection, Self::Outside];

    /// Of a number as shaders give it; [`Self::Unlabelled`] where it is none.
    pub fn of_number(number: u8) -> Self {
        Self::ALL.get(usize::from(number)).copied().unwrap_or_default()
    }

    /// The class in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unlabelled => "unlabelled",
            Self::Inside => "inside",
            Self::Glass => "glass",
            Self::Reflection => "reflection",
            Self::Outside => "outside",
        }
    }
}

/// What was met in one scan.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct GlassCounters {
    /// Points that are no numbers, or no place a beam could reach.
    pub unusable_points: u32,
    /// Points whose ring or elevation has no row.
    pub points_without_row: u32,
    /// Beams with two returns that differ.
    pub dual_returns: u32,
    /// Points of intensity peaks.
    pub peak_points: u32,
    /// Candidates, of both kinds.
    pub candidates: u32,
    /// Of them those not looked at, as there were too many.
    pub thinned_candidates: u32,
    /// Planes that were fitted and are no panes.
    pub refused_planes: u32,
    /// Panes found.
    pub found_panes: u32,
    /// Points of each [`PointClass`].
    pub classes: [u32; 5],
    /// Whether the lidar's pose jumped since the scan before: panes that are kept stay where they were. 0 or 1.
    pub pose_jumps: u32,
}

impl GlassCounters {
    pub(crate) fn of_words(words: &[u32]) -> Self {
        let mut all = [0; COUNTERS_WORDS];
        all.iter_mut().zip(words).for_each(|(to, from)| *to = *from);
        let [unusable_points, points_without_row, dual_returns, peak_points, candidates, thinned, ..] = all;
        let [_, _, _, _, _, _, refused_planes, found_panes, a, b, c, d, e, ..] = all;
        Self {
            unusable_points,
            points_without_row,
            dual_returns,
            peak_points,
            candidates,
            thinned_candidates: thinned,
            refused_planes,
            found_panes,
            classes: [a, b, c, d, e],
            pose_jumps: 0,
        }
    }
}
