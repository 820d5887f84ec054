//! Why a cell of the map has its cost.

use glam::DVec2;

use super::Mapper;
use crate::base::Result;
use crate::map::why::Records;
use crate::map::{Update, Why};

impl Mapper {
    /// Why the cell at (`x_m`, `y_m`) of the map is what it is in `update`, which must be the newest result, with nothing under
    /// way: the layers are asked as they are now. `None` outside of the map, and where `update` has no map. The verdict is empty where it
    /// was not asked for (see [`Options::verdicts`](crate::mapper::Options::verdicts)).
    ///
    /// # Errors
    /// [`crate::Error::Gpu`], [`crate::Error::DeviceLost`].
    pub fn why(&self, update: &Update, x_m: f64, y_m: f64) -> Result<Option<Why>> {
        let (Some(map), Some(window)) = (&update.map, self.window) else { return Ok(None) };
        let Some([x, y]) = map.grid.cell_at(x_m, y_m) else { return Ok(None) };
        let side = self.map.side;
        let [slot_x, slot_y] = window.origin_slot(side);
        let slot = u64::from((y + slot_y) % side * side + (x + slot_x) % side);
        let cell = (y * side + x) as usize;
        let at_m = map.grid.centre_m(x, y);
        let base = update.map_from_base.translation_m;
        let records = Records {
            cell: self.record("cells", slot)?,
            marks: self.record("cell_marks", slot)?,
            solid: self.record("solid_cells", slot)?,
            pane: self.record("pane_cells", slot)?,
            drop: self.record("drop_cells", slot)?,
        };
        let now = self.clock.now();
        Ok(Some(Why {
            at_m,
            range_m: (DVec2::from(at_m) - base.truncate()).length(),
            cost: map.costmap.get(cell).copied().unwrap_or(255),
            verdict: map.verdicts.get(cell).copied().unwrap_or_default(),
            camera: records.camera(now, self.map.config.height_min_m, self.map.evidence),
            lidar: records.lidar(now),
            pane: records.pane(now),
            drop: records.drop(now),
        }))
    }

    fn record<const WORDS: usize>(&self, name: &str, slot: u64) -> Result<Option<[u32; WORDS]>> {
        let bytes = 4 * WORDS as u64;
        let read = self.store.read(name, slot * bytes, bytes)?;
        Ok(read.map(|bytes| {
            let mut words = bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned);
            std::array::from_fn(|_| words.next().unwrap_or(0))
        }))
    }
}
