//! The model of learned solidity: its inputs and weights (spec 6 §3; `weights/README.md`).

use crate::base::Result;
use crate::stage::perceptron::{Layout, Perceptron, words};

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
        let layout = Layout { format: "lidar-solidity", inputs: &INPUTS, hidden: HIDDEN, biases: 2 };
        let file = Perceptron::from_bytes(bytes, &layout)?;
        let least_returns = file.number("least_returns", 1..=MOST_RETURNS)?;
        let bias = [file.bias[0], file.bias[1]];
        Ok(Self { inner: file.inner, outer: file.outer, bias, least_returns })
    }

    /// As the pass takes it.
    pub fn words(&self) -> Vec<u8> {
        words(&self.inner, &self.outer, &self.bias)
    }
}
