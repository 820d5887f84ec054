//! The layers of the map (spec 4 §1): resident records, one for each cell of the window's ring buffer.

use crate::base::Result;
use crate::gpu::Plan;

/// Which layers a map has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Layers {
    /// Occupancy, by cameras: `cells` and `cell_marks`.
    pub cameras: bool,
    /// What map reliability keeps of the cameras' looks: `cell_looks`.
    pub looks: bool,
    /// Solidity, by lidars: `solid_cells`.
    pub lidars: bool,
    /// Panes, by lidars that search for glass: `pane_cells`.
    pub panes: bool,
    /// Where the ground drops away, by all sensors that estimate it: `drop_cells`.
    pub drops: bool,
}

/// Names of the buffers and bytes a cell.
const CAMERA_BUFFERS: [(&str, u64); 2] = [("cells", 16), ("cell_marks", 8)];
const LOOK_BUFFERS: [(&str, u64); 1] = [("cell_looks", 32)];
const LIDAR_BUFFERS: [(&str, u64); 1] = [("solid_cells", 16)];
const PANE_BUFFERS: [(&str, u64); 1] = [("pane_cells", 8)];
const DROP_BUFFERS: [(&str, u64); 1] = [("drop_cells", 16)];

impl Layers {
    /// Names of its buffers and bytes a cell.
    pub fn buffers(self) -> impl Iterator<Item = (&'static str, u64)> {
        let cameras = CAMERA_BUFFERS.into_iter().filter(move |_| self.cameras);
        let looks = LOOK_BUFFERS.into_iter().filter(move |_| self.looks);
        let lidars = LIDAR_BUFFERS.into_iter().filter(move |_| self.lidars);
        let panes = PANE_BUFFERS.into_iter().filter(move |_| self.panes);
        let drops = DROP_BUFFERS.into_iter().filter(move |_| self.drops);
        cameras.chain(looks).chain(lidars).chain(panes).chain(drops)
    }

    /// Declares those of its buffers that the plan does not have yet, for a window of `side` x `side` cells.
    ///
    /// # Errors
    /// [`crate::Error::Plan`] where a size is 0.
    pub fn declare(self, plan: &mut Plan, side: u32) -> Result<()> {
        let cells = u64::from(side) * u64::from(side);
        for (name, bytes) in self.buffers() {
            if plan.find_in("", name).is_none() {
                plan.shared(name, cells * bytes)?;
            }
        }
        Ok(())
    }
}
