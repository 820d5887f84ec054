//! Cells of simulated drives with what map reliability judges them by and what is true of them (spec 1 §9): data for
//! `weights/train_map.py`.

mod file;

use std::path::Path;

pub use file::CellFile;

use crate::base::{Error, Result};
use crate::config::{Config, Fusion, Method};
use crate::gpu::Context;
use crate::map::Grid;
use crate::mapper::{Mapper, Options, SensorInfo};
use crate::offline::eval::{Recorded, Source, TrueFrame, TrueWindow};
use crate::sensor::{CameraInfo, Observation};
use crate::sim::truth::{FREE, OCCUPIED, TruthFrame, UNKNOWN};
use crate::stage::camera::map_reliability::INPUTS;
use crate::stage::map::inflate::radius_cells;

/// A cell that map reliability judged in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Numbers that [`INPUTS`] names.
    pub inputs: Vec<f32>,
    /// Whether something solid stands there; else nothing does.
    pub solid: bool,
    /// Truly free cells that it blocks where it is called an obstacle: those within the inflation radius whose true cost is 0, but for
    /// those beside a true border, which FOR leaves out.
    pub blocks: u16,
    /// Whether something came or went there before this frame or after it: a person.
    pub changes: bool,
    /// Number of the frame.
    pub frame: u16,
}

/// Puts every frame of a recording with truth through the map and gives the cells of every `every`-th that are solid or free.
///
/// # Errors
/// Those of [`Recorded::open`] and of the mapper; [`Error::Empty`] for a recording without frames.
pub fn make(path: &Path, config: &Config, every: u64, context: &Context) -> Result<Vec<Cell>> {
    let config = Config { fusion: Fusion::Learned, method: Method::Drm, ..config.clone() };
    let mut source = Recorded::open(path, &config)?;
    let (mut mapper, mut frames, mut number) = (None, Vec::new(), 0_u64);
    let mut changes = Changes::default();
    while let Some(TrueFrame { frame, truth }) = source.next_frame()? {
        let mapper = match &mut mapper {
            Some(mapper) => mapper,
            None => {
                let nothing = || Error::Empty { reason: "no first frame".into() };
                let info = CameraInfo::of_frames([&frame]).ok_or_else(nothing)?;
                let options = Options { cell_inputs: true, ..Options::default() };
                mapper.insert(Mapper::on(context, &config, &[SensorInfo::camera(&config, info)], &options)?)
            }
        };
        let update = mapper.step(&Observation::of_frame(0, &config.map_frame, frame))?;
        number += 1;
        changes.observe(&truth);
        let (Some(map), Some(camera)) = (&update.map, update.camera()) else { continue };
        if number.is_multiple_of(every) {
            let window = TrueWindow::new(&truth, &map.grid, &config)?;
            let frame = u16::try_from(number - 1).unwrap_or(u16::MAX);
            let cells = of_frame(&camera.cell_inputs, &window, &config, frame).collect();
            frames.push((truth, map.grid, cells));
        }
    }
    changes.told(frames, &config)
}

/// The truth of a frame, where its map lies, and its cells by their places there.
type Frame = (TruthFrame, Grid, Vec<(usize, Cell)>);

/// The cells that were free at one time and held something at another.
#[derive(Default)]
struct Changes {
    last: Vec<i8>,
    changed: Vec<bool>,
}

impl Changes {
    fn observe(&mut self, truth: &TruthFrame) {
        self.last.resize(truth.cells.len(), UNKNOWN);
        self.changed.resize(truth.cells.len(), false);
        for ((last, changed), now) in self.last.iter_mut().zip(&mut self.changed).zip(&truth.cells) {
            *changed |= matches!((*last, *now), (FREE, OCCUPIED) | (OCCUPIED, FREE));
            if *now != UNKNOWN {
                *last = *now;
            }
        }
    }

    /// The cells of all frames, each with whether it changes.
    fn told(&self, frames: Vec<Frame>, config: &Config) -> Result<Vec<Cell>> {
        let codes = self.changed.iter().map(|changed| if *changed { OCCUPIED } else { FREE });
        let codes: Vec<i8> = codes.collect();
        let mut all = Vec::new();
        for (truth, grid, cells) in frames {
            let window = TrueWindow::new(&TruthFrame { cells: codes.clone(), ..truth }, &grid, config)?;
            let told = |(at, cell): (usize, Cell)| Cell { changes: window.cells[at] == OCCUPIED, ..cell };
            all.extend(cells.into_iter().map(told));
        }
        Ok(all)
    }
}

fn of_frame<'a>(
    inputs: &'a [f32],
    window: &'a TrueWindow,
    config: &Config,
    frame: u16,
) -> impl Iterator<Item = (usize, Cell)> + 'a {
    let radius = radius_cells(config) as usize;
    let judged = inputs.chunks_exact(INPUTS.len()).enumerate();
    let judged = judged.filter(|(_, own)| own.iter().any(|input| *input != 0.0));
    judged.filter_map(move |(cell, own)| {
        let solid = match window.cells.get(cell) {
            Some(&OCCUPIED) => true,
            Some(&FREE) => false,
            _ => return None,
        };
        let blocks = if solid { 0 } else { window.free_within(cell, radius) };
        Some((cell, Cell { inputs: own.to_vec(), solid, blocks, changes: false, frame }))
    })
}
