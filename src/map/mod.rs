//! The map's values: window and grid, panes and labels of glass.

pub mod clean;
pub mod glass;
mod grid;
pub(crate) mod jumps;
mod pane;
pub mod pane_file;
mod window;

pub use grid::Grid;
pub use pane::{KEPT_PANES, Pane};
pub use window::Window;
