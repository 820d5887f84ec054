//! Samples as safetensors files, which Python reads without this crate.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use safetensors::Dtype;
use safetensors::tensor::TensorView;

use crate::base::{Error, Result};
use crate::network::weights::{INPUT_CHANNELS, NATIVE_SIZE};
use crate::offline::targets::sample::Sample;
use crate::output::save_in_folder;

/// Samples in one file; a longer recording goes on in another.
pub(super) const MOST_SAMPLES: usize = 64;

/// Writes the samples of one recording as `STEM.safetensors`, `STEM-1.safetensors`, ..., each complete in itself.
///
/// | tensor | shape | type |
/// |---|---|---|
/// | `input` | n x 5 x rows x columns | F32: R, G, B, depth and change of depth as the network takes them |
/// | `reference_m`, `soft` | n x rows x columns | F32: D* in metres (0: none, leave the pixel out), soft target |
/// | `binary` | n x rows x columns | U8: binary target |
/// | `true_depth_m`, `true_soft`, `true_binary` | the same | by true depth, where the recording has truth |
/// | `material` | n x rows x columns | U8: kind of the true surface |
/// | `frame`, `stamp_ns` | n | I64 |
pub struct SampleFile {
    stem: PathBuf,
    metadata: HashMap<String, String>,
    part: usize,
    count: usize,
    buffers: Vec<(&'static str, Dtype, Vec<u8>)>,
    written: Vec<PathBuf>,
}

impl SampleFile {
    /// For samples of `recording` in `folder`, which is made; the files take the recording's name.
    ///
    /// # Errors
    /// [`Error::File`] where the folder cannot be made, [`Error::Encode`] where the recording has no name.
    pub fn create(folder: &Path, recording: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(Error::file(folder))?;
        let nameless = || Error::Encode { path: recording.into(), reason: "has no name".into() };
        let name = recording.file_stem().ok_or_else(nameless)?;
        let metadata = [
            ("format".to_owned(), "limpid-samples".to_owned()),
            ("recording".to_owned(), name.to_string_lossy().into_owned()),
        ];
        Ok(Self {
            stem: folder.join(name),
            metadata: metadata.into(),
            part: 0,
            count: 0,
            buffers: Vec::new(),
            written: Vec::new(),
        })
    }

    /// Adds a sample.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Encode`].
    pub fn add(&mut self, sample: &Sample) -> Result<()> {
        let Sample { input, measured, truth, .. } = sample;
        self.extend("input", Dtype::F32, bytemuck::cast_slice(input));
        self.extend("reference_m", Dtype::F32, bytemuck::cast_slice(&measured.reference_m));
        self.extend("soft", Dtype::F32, bytemuck::cast_slice(&measured.soft));
        self.extend("binary", Dtype::U8, &bits(&measured.binary));
        if let Some((truth, material)) = truth {
            self.extend("true_depth_m", Dtype::F32, bytemuck::cast_slice(&truth.reference_m));
            self.extend("true_soft", Dtype::F32, bytemuck::cast_slice(&truth.soft));
            self.extend("true_binary", Dtype::U8, &bits(&truth.binary));
            self.extend("material", Dtype::U8, material);
        }
        self.extend("frame", Dtype::I64, &sample.index.to_le_bytes());
        self.extend("stamp_ns", Dtype::I64, &sample.stamp_ns.to_le_bytes());
        self.count += 1;
        if self.count == MOST_SAMPLES { self.write() } else { Ok(()) }
    }

    fn extend(&mut self, name: &'static str, dtype: Dtype, bytes: &[u8]) {
        match self.buffers.iter_mut().find(|(known, ..)| *known == name) {
            Some((_, _, buffer)) => buffer.extend_from_slice(bytes),
            None => self.buffers.push((name, dtype, bytes.to_vec())),
        }
    }

    /// Writes what is not written yet; the files that there are.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Encode`].
    pub fn finish(mut self) -> Result<Vec<PathBuf>> {
        if self.count > 0 {
            self.write()?;
        }
        Ok(self.written)
    }

    fn write(&mut self) -> Result<()> {
        let mut name = self.stem.clone().into_os_string();
        name.push(if self.part == 0 { String::new() } else { format!("-{}", self.part) });
        name.push(".safetensors");
        let path = PathBuf::from(name);
        let bad =
            |e: safetensors::SafeTensorError| Error::Encode { path: path.clone(), reason: e.to_string() };
        let [rows, columns] = NATIVE_SIZE;
        let mut tensors = Vec::new();
        for (name, dtype, bytes) in &self.buffers {
            let shape = match *name {
                "input" => vec![self.count, INPUT_CHANNELS, rows, columns],
                "frame" | "stamp_ns" => vec![self.count],
                _ => vec![self.count, rows, columns],
            };
            tensors.push((*name, TensorView::new(*dtype, shape, bytes).map_err(bad)?));
        }
        let bytes = safetensors::serialize(tensors, Some(self.metadata.clone())).map_err(bad)?;
        save_in_folder(&path, &bytes)?;
        self.written.push(path);
        self.part += 1;
        self.count = 0;
        self.buffers.clear();
        Ok(())
    }
}

/// 0 and 1 as bytes.
fn bits(values: &[f32]) -> Vec<u8> {
    values.iter().map(|&value| u8::from(value > 0.5)).collect()
}
