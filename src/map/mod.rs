//! The map's values: window and grid, panes and labels of glass.

pub mod clean;
pub mod glass;
mod grid;
pub(crate) mod jumps;
mod pane;
pub mod pane_file;
mod pane_set;
pub mod rule;
mod state;
mod verdict;
mod window;

pub use grid::Grid;
pub use pane::{KEPT_PANES, Pane};
pub use pane_set::PaneSet;
pub use state::State;
pub use verdict::{MOST_AGE, Verdict};
pub use window::Window;
