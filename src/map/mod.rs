//! The map's values: window and grid, panes and labels of glass.

mod cell_class;
pub mod clean;
mod clock;
pub mod glass;
mod grid;
mod ground;
pub(crate) mod jumps;
mod pane;
pub mod pane_file;
mod pane_set;
pub mod rule;
mod state;
mod update;
mod verdict;
pub(crate) mod why;
mod window;

pub use cell_class::CellClass;
pub use clock::{Arrival, Clock};
pub use grid::Grid;
pub use ground::{Ground, GroundFrom, GroundPlane, GroundRun};
pub use pane::{KEPT_PANES, Pane};
pub use pane_set::PaneSet;
pub use state::State;
pub use update::{
    CameraUpdate, Counters, FrameImages, FrameLayers, LidarUpdate, MapUpdate, ScanLayers, Seen, Update,
};
pub use verdict::{MOST_AGE, Verdict};
pub use why::{CameraSays, LidarSays, Occupancy, PaneSays, SeenBy, Why};
pub use window::Window;
