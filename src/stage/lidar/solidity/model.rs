//! The model of learned solidity: its inputs and weights (spec 6 §3; `weights/README.md`).

use safetensors::{Dtype, SafeTensors};

use crate::base::{Error, Result};

/// The weight file that limpid comes with.
pub const SHIPPED: &[u8] = include_bytes!("../../../../weights/lidar-solidity.safetensors");

/// Names of the inputs of a cell, in the order of `shaders/solidity/judge.wgsl`; `around`: of the cell and those within 0.3 m of it;
/// `wide`: of the block of half a metre and the eight around it.
pub const INPUTS: [&str; 48] = [
    "returns",
    "returns_around",
    "cells_around",
    "range",
    "went_on",
    "went_on_around",
    "ended",
    "ended_around",
    "hidden_around",
    "lost_around",
    "depth_spread",
    "depth_spread_around",
    "width_spread_around",
    "least_spread_around",
    "largest_spread_around",
    "lowest",
    "highest",
    "highest_around",
    "span_around",
    "span",
    "band_0_around",
    "band_1_around",
    "band_2_around",
    "bands_around",
    "two_returns_around",
    "two_returns_known",
    "contrast_known",
    "contrast_around",
    "contrast_spread_around",
    "resolution",
    "sent_around",
    "highest_wide",
    "band_0_wide",
    "band_1_wide",
    "band_2_wide",
    "returns_wide",
    "blocks_wide",
    "went_on_around * highest_around",
    "went_on_around * least_spread_around",
    "went_on_around * returns_around",
    "least_spread_around * highest_around",
    "least_spread_around * returns_around",
    "highest_around * highest_around",
    "highest_wide * highest_wide",
    "range * went_on_around",
    "range * contrast_spread_around",
    "span_around * span_around",
    "bands_around * least_spread_around",
];

/// Most returns that a file may ask for.
const MOST_RETURNS: u32 = 1000;

/// Hidden units (`HIDDEN` of the shader).
pub const HIDDEN: usize = 8;

/// A checked weight file: a cell is solid where the hidden units, each tanh of a weighted sum of inputs, come to at least 0 when
/// weighted and added to the bias.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidityModel {
    /// Of each hidden unit a weight for each of [`INPUTS`] and what is added.
    pub inner: Vec<f32>,
    /// Of each hidden unit.
    pub outer: Vec<f32>,
    /// Without intensities and with; the thresholds are in it.
    pub bias: [f32; 2],
    /// Returns in a cell and around it under which it is solid whatever the model says.
    pub least_returns: u32,
}

impl SolidityModel {
    /// The weights that limpid comes with.
    ///
    /// # Errors
    /// None; a test reads them.
    pub fn shipped() -> Result<Self> {
        Self::from_bytes(SHIPPED)
    }

    /// Reads a safetensors file from memory: metadata `format`, `inputs` (names, comma-separated) and `least_returns`; F32 tensors
    /// `inner` (8 x 49), `outer` (8) and `bias` (2).
    ///
    /// # Errors
    /// [`Error::Weights`] that names the metadata key or the tensor: a file of another kind or for other inputs, wrong shapes,
    /// numbers that are not finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let broken = |e: safetensors::SafeTensorError| bad("file", format!("is no safetensors file: {e}"));
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
        let metadata = |key: &str| {
            let value = header.metadata().as_ref().and_then(|all| all.get(key));
            value.ok_or_else(|| bad(&format!("metadata `{key}`"), "is missing".into()))
        };
        for (key, wanted) in [("format", "lidar-solidity".to_owned()), ("inputs", INPUTS.join(","))] {
            if *metadata(key)? != wanted {
                return Err(bad(&format!("metadata `{key}`"), format!("is not `{wanted}`")));
            }
        }
        let text = metadata("least_returns")?;
        let least_returns = text.parse().ok().filter(|count| (1..=MOST_RETURNS).contains(count));
        let least_returns = least_returns.ok_or_else(|| {
            bad("metadata `least_returns`", format!("`{text}` is not in 1..={MOST_RETURNS}"))
        })?;
        let bias = tensor(&tensors, "bias", &[2])?;
        Ok(Self {
            inner: tensor(&tensors, "inner", &[HIDDEN, INPUTS.len() + 1])?,
            outer: tensor(&tensors, "outer", &[HIDDEN])?,
            bias: [bias[0], bias[1]],
            least_returns,
        })
    }

    /// As the pass takes it.
    pub fn words(&self) -> Vec<u8> {
        self.inner
            .iter()
            .chain(&self.outer)
            .chain(&self.bias)
            .flat_map(|number| number.to_le_bytes())
            .collect()
    }
}

fn tensor(tensors: &SafeTensors<'_>, name: &str, shape: &[usize]) -> Result<Vec<f32>> {
    let named = format!("tensor `{name}`");
    let view = tensors.tensor(name).map_err(|_| bad(&named, "is missing".into()))?;
    if view.dtype() != Dtype::F32 || view.shape() != shape {
        return Err(bad(&named, format!("is {:?} {:?}, not F32 {shape:?}", view.dtype(), view.shape())));
    }
    let numbers: Vec<f32> = view.data().chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err(bad(&named, "has numbers that are not finite".into()));
    }
    Ok(numbers)
}

fn bad(what: &str, reason: String) -> Error {
    Error::Weights { what: what.into(), reason }
}
