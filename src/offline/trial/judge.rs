//! Measures maps and depth of a trial against the truth; the robot knows nothing of it (spec 7 §2, §3).

use super::classes::ClassTally;
use super::record::{Depth, Picture, Record, letter_of_truth, runs};
use super::setup::Setup;
use super::world::World;
use crate::base::Result;
use crate::config::Config;
use crate::map::MapUpdate;
use crate::offline::eval::{MapTally, TrueWindow};
use crate::sensor::CameraModel;
use crate::sim::frame::SimFrame;
use crate::sim::rates::Rates;
use crate::sim::truth::{TrueMap, TruthFrame};

/// Frames from one scored map to the next.
const EVERY: u64 = 5;

/// Frames from one that tells what the camera could have seen to the next.
const LOOKS: u64 = 2;

/// Frames before the first (spec 1 §6).
const UNSCORED: u64 = 10;

/// See the module.
pub struct Judge {
    config: Config,
    camera: Option<CameraModel>,
    map: TrueMap,
    tally: MapTally,
    classes: ClassTally,
    rates: Rates,
}

impl Judge {
    /// For maps of a set-up: a lidar alone has cells of its own size.
    pub fn new(world: &World, setup: &Setup) -> Self {
        let mut config = setup.config.clone();
        if setup.camera.is_none() {
            config.resolution_m = config.scan_resolution_m;
        }
        let map = TrueMap::new(&world.scene, &config);
        let camera = setup.camera.as_ref().map(|_| world.scene.camera.model());
        let (tally, classes, rates) = Default::default();
        Self { config, camera, map, tally, classes, rates }
    }

    /// Takes in what the camera could have seen.
    pub fn see(&mut self, frame: &SimFrame, tick: u64) {
        if let Some(camera) = self.camera.as_ref().filter(|_| tick.is_multiple_of(LOOKS)) {
            self.map.observe(frame, camera);
        }
        if tick.is_multiple_of(EVERY) {
            self.rates.add(&Rates::of(frame));
        }
    }

    /// Scores a map, twice a second.
    ///
    /// # Errors
    /// Those of [`TrueWindow::new`].
    pub fn score(&mut self, map: &MapUpdate, tick: u64) -> Result<()> {
        if tick < UNSCORED || !tick.is_multiple_of(EVERY) {
            return Ok(());
        }
        let cells = if self.camera.is_some() { self.map.cells() } else { self.map.all_cells() };
        let window = TrueWindow::new(&self.truth(cells), &map.grid, &self.config)?;
        if self.camera.is_some() {
            self.tally.observe(&map.costmap, &window)?;
        }
        // What stands in a cell is compared whether a camera saw it or not.
        if !map.classes.is_empty() {
            let all = TrueWindow::new(&self.truth(self.map.all_cells()), &map.grid, &self.config)?;
            self.classes = ClassTally::of(map, &all.cells);
        }
        Ok(())
    }

    fn truth(&self, cells: Vec<i8>) -> TruthFrame {
        let (depth_m, material) = (Vec::new(), Vec::new());
        TruthFrame { stamp_ns: 0, width: 0, height: 0, depth_m, material, grid: self.map.grid(), cells }
    }

    /// Puts all figures into the record.
    pub fn finish(&self, record: &mut Record) {
        record.map = self.tally;
        record.classes = self.classes;
        let (holes, spikes) = (self.rates.hole_rate(), self.rates.spike_rate());
        record.depth = self.camera.as_ref().map(|_| Depth { holes, spikes });
        let grid = self.map.grid();
        record.truth = Some(Picture {
            t_s: 0.0,
            origin_m: [grid.origin_x_m, grid.origin_y_m],
            cell_m: grid.resolution_m,
            width: grid.width,
            runs: runs(self.map.all_cells().into_iter().map(letter_of_truth)),
            path: Vec::new(),
        });
    }
}
