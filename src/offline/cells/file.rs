//! Judged cells as a safetensors file, which Python reads without this crate.

use std::collections::HashMap;
use std::path::Path;

use safetensors::Dtype;
use safetensors::tensor::TensorView;

use super::Cell;
use crate::base::{Error, Result};
use crate::output::save_in_folder;
use crate::stage::camera::map_reliability::INPUTS;

/// Collects cells of recordings.
///
/// | tensor | shape | type |
/// |---|---|---|
/// | `inputs` | n x 22 | F32: what map reliability judges by |
/// | `solid` | n | U8: 1 where something solid stands, else nothing does |
/// | `blocks` | n | U16: see [`Cell`] |
/// | `changes` | n | U8: see [`Cell`] |
/// | `frame` | n | U16 |
/// | `recording` | n | U16: number of the name in the metadata |
#[derive(Debug, Default)]
pub struct CellFile {
    recordings: Vec<String>,
    inputs: Vec<f32>,
    solid: Vec<u8>,
    blocks: Vec<u16>,
    changes: Vec<u8>,
    frame: Vec<u16>,
    recording: Vec<u16>,
}

impl CellFile {
    /// Adds the cells of a recording of that name.
    pub fn add(&mut self, name: &str, cells: &[Cell]) {
        let number = u16::try_from(self.recordings.len()).unwrap_or(u16::MAX);
        self.recordings.push(name.into());
        for cell in cells {
            self.inputs.extend(&cell.inputs);
            self.solid.push(u8::from(cell.solid));
            self.blocks.push(cell.blocks);
            self.changes.push(u8::from(cell.changes));
            self.frame.push(cell.frame);
            self.recording.push(number);
        }
    }

    /// Cells so far.
    pub fn count(&self) -> usize {
        self.solid.len()
    }

    /// Writes them.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Encode`].
    pub fn save(&self, path: &Path) -> Result<()> {
        let bad =
            |e: safetensors::SafeTensorError| Error::Encode { path: path.into(), reason: e.to_string() };
        let count = self.count();
        let column = |dtype, bytes| TensorView::new(dtype, vec![count], bytes).map_err(bad);
        let words = bytemuck::cast_slice::<u16, u8>;
        let inputs = bytemuck::cast_slice(&self.inputs);
        let tensors = [
            ("inputs", TensorView::new(Dtype::F32, vec![count, INPUTS.len()], inputs).map_err(bad)?),
            ("solid", column(Dtype::U8, &self.solid)?),
            ("blocks", column(Dtype::U16, words(&self.blocks))?),
            ("changes", column(Dtype::U8, &self.changes)?),
            ("frame", column(Dtype::U16, words(&self.frame))?),
            ("recording", column(Dtype::U16, words(&self.recording))?),
        ];
        let metadata: HashMap<String, String> = [
            ("format", "limpid-map-cells".to_owned()),
            ("inputs", INPUTS.join(",")),
            ("recordings", self.recordings.join(",")),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .into();
        save_in_folder(path, &safetensors::serialize(tensors, Some(metadata)).map_err(bad)?)
    }
}
