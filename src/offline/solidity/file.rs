//! Cells as a safetensors file, which Python reads without this crate.

use std::collections::HashMap;
use std::path::Path;

use safetensors::Dtype;
use safetensors::tensor::TensorView;

use super::Cells;
use crate::base::{Error, Result};
use crate::output::save_in_folder;
use crate::sim::generate::Family;
use crate::sim::lidar::LidarModel;
use crate::stage::lidar::solidity::INPUTS;

/// Collects cells.
///
/// | tensor | shape | type |
/// |---|---|---|
/// | `inputs` | n x 48 | F32: what learned solidity judges by |
/// | `label`, `class` | n | U8: [`Label`](super::Label), [`CellClass`](crate::map::CellClass) |
/// | `family`, `sensor`, `material` | n | U8: numbers of the names in the metadata |
/// | `bright` | n | U8: 1 where the cloud has intensities |
/// | `seed`, `scan`, `points` | n | I64 |
/// | `range_m`, `resolution_m` | n | F32 |
#[derive(Debug, Default)]
pub struct CellFile {
    count: usize,
    materials: Vec<String>,
    columns: HashMap<&'static str, (Option<Dtype>, Vec<u8>)>,
}

impl CellFile {
    /// Adds the cells of a scan.
    pub fn add(&mut self, cells: &Cells) {
        let drawn = &cells.drawn;
        let number = |at: Option<usize>| at.and_then(|at| u8::try_from(at).ok()).unwrap_or(u8::MAX);
        let family = number(Family::ALL.iter().position(|known| *known == drawn.family));
        let sensor = number(LidarModel::ALL.iter().position(|known| *known == drawn.lidar().model));
        let (seed, scan) = (drawn.seed.to_le_bytes(), (cells.scan as u64).to_le_bytes());
        let resolution_m = crate::stage::single(drawn.resolution_m).to_le_bytes();
        for cell in &cells.cells {
            let material = self.materials.iter().position(|known| *known == cell.material);
            let material = material.unwrap_or_else(|| {
                self.materials.push(cell.material.clone());
                self.materials.len() - 1
            });
            self.extend("inputs", Dtype::F32, bytemuck::cast_slice(&cell.inputs));
            for (name, byte) in [
                ("label", cell.label as u8),
                ("class", cell.class),
                ("family", family),
                ("sensor", sensor),
                ("material", number(Some(material))),
                ("bright", u8::from(drawn.light.gain.is_some())),
            ] {
                self.extend(name, Dtype::U8, &[byte]);
            }
            self.extend("seed", Dtype::I64, &seed);
            self.extend("scan", Dtype::I64, &scan);
            self.extend("points", Dtype::I64, &u64::from(cell.points).to_le_bytes());
            self.extend("range_m", Dtype::F32, &cell.range_m.to_le_bytes());
            self.extend("resolution_m", Dtype::F32, &resolution_m);
            self.count += 1;
        }
    }

    fn extend(&mut self, name: &'static str, dtype: Dtype, bytes: &[u8]) {
        let (kind, column) = self.columns.entry(name).or_default();
        *kind = Some(dtype);
        column.extend_from_slice(bytes);
    }

    /// Cells so far.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Writes them.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Encode`].
    pub fn save(&self, path: &Path) -> Result<()> {
        let bad =
            |e: safetensors::SafeTensorError| Error::Encode { path: path.into(), reason: e.to_string() };
        let mut tensors = Vec::new();
        for (name, (dtype, bytes)) in &self.columns {
            let shape = if *name == "inputs" { vec![self.count, INPUTS.len()] } else { vec![self.count] };
            let Some(dtype) = *dtype else { continue };
            tensors.push((*name, TensorView::new(dtype, shape, bytes).map_err(bad)?));
        }
        let metadata: HashMap<String, String> = [
            ("format", "limpid-cells".to_owned()),
            ("inputs", INPUTS.join(",")),
            ("families", Family::ALL.map(Family::name).join(",")),
            ("sensors", LidarModel::ALL.map(LidarModel::name).join(",")),
            ("materials", self.materials.join(",")),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .into();
        save_in_folder(path, &safetensors::serialize(tensors, Some(metadata)).map_err(bad)?)
    }
}
