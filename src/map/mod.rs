//! The map's values: window and grid, panes and labels of glass.

pub mod clean;
pub mod glass;
mod grid;
pub(crate) mod jumps;
mod pane;
pub mod pane_file;
mod pane_set;
mod window;

pub use grid::Grid;
pub use pane::{KEPT_PANES, Pane};
pub use pane_set::PaneSet;
pub use window::Window;
