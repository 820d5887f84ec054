//! Classes of cells.

use crate::map::Verdict;

const LETHAL: u8 = 254;
const UNKNOWN: u8 = 255;

/// What a cell of the plan map holds (spec 2 §4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellClass {
    /// No beam crossed it, or too few returns came from it.
    Unknown = 0,
    /// A beam crossed it and nothing returned from it.
    Free = 1,
    /// True positive: in the way, by a lidar or a camera.
    Solid = 2,
    /// False positive: returns, but weak in all layers.
    Passable = 3,
    /// False negative: glass, from this scan or remembered, or a known pane.
    Transparent = 4,
    /// Near a solid or transparent cell; an unknown cell only within the robot's inscribed radius.
    Inflated = 5,
}

impl CellClass {
    /// All, in order of their numbers.
    pub const ALL: [Self; 6] =
        [Self::Unknown, Self::Free, Self::Solid, Self::Passable, Self::Transparent, Self::Inflated];

    /// Of a cell with that verdict and, after inflation, that cost.
    pub fn of(verdict: Verdict, cost: u8) -> Self {
        match (verdict.cost(), verdict.row()) {
            (LETHAL, 1 | 3) => Self::Transparent,
            (LETHAL, _) => Self::Solid,
            (base, _) if cost != base => Self::Inflated,
            (UNKNOWN, _) => Self::Unknown,
            (_, 4 | 7) => Self::Passable,
            _ => Self::Free,
        }
    }

    /// Its name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Free => "free",
            Self::Solid => "solid",
            Self::Passable => "passable",
            Self::Transparent => "transparent",
            Self::Inflated => "inflated",
        }
    }
}
