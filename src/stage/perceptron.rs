//! Weight files of the small networks that judge cells: units of tanh on named inputs, and a weight for each unit.

use std::collections::HashMap;

use safetensors::{Dtype, SafeTensors};

use crate::base::{Error, Result};

/// What a pass asks of its weight file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout<'a> {
    /// The metadata's `format`.
    pub format: &'a str,
    /// Names of the inputs, in their order.
    pub inputs: &'a [&'a str],
    /// Hidden units.
    pub hidden: usize,
    /// Numbers that are added at the end, of which a pass takes one.
    pub biases: usize,
}

/// A checked file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Perceptron {
    /// Of each hidden unit a weight for each input and what is added.
    pub inner: Vec<f32>,
    /// Of each hidden unit.
    pub outer: Vec<f32>,
    /// What is added.
    pub bias: Vec<f32>,
    metadata: HashMap<String, String>,
}

impl Perceptron {
    /// Reads a safetensors file from memory: metadata `format` and `inputs` (names, comma-separated); F32 tensors `inner`
    /// (hidden x inputs + 1), `outer` (hidden) and `bias` (biases).
    ///
    /// # Errors
    /// [`Error::Weights`] that names the metadata key or the tensor: a file of another kind or for other inputs, wrong shapes,
    /// numbers that are not finite.
    pub(crate) fn from_bytes(bytes: &[u8], layout: &Layout<'_>) -> Result<Self> {
        let broken = |e: safetensors::SafeTensorError| bad("file", format!("is no safetensors file: {e}"));
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
        let metadata = header.metadata().clone().unwrap_or_default();
        for (key, wanted) in [("format", layout.format.to_owned()), ("inputs", layout.inputs.join(","))] {
            if *text(&metadata, key)? != wanted {
                return Err(bad(&format!("metadata `{key}`"), format!("is not `{wanted}`")));
            }
        }
        Ok(Self {
            inner: tensor(&tensors, "inner", &[layout.hidden, layout.inputs.len() + 1])?,
            outer: tensor(&tensors, "outer", &[layout.hidden])?,
            bias: tensor(&tensors, "bias", &[layout.biases])?,
            metadata,
        })
    }

    /// A number of the metadata.
    ///
    /// # Errors
    /// [`Error::Weights`] where it is missing or not in `range`.
    pub(crate) fn number<T: std::str::FromStr + PartialOrd + std::fmt::Debug>(
        &self,
        key: &str,
        range: std::ops::RangeInclusive<T>,
    ) -> Result<T> {
        let text = text(&self.metadata, key)?;
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| bad(&format!("metadata `{key}`"), format!("`{text}` is not in {range:?}")))
    }
}

/// The numbers as passes take them: of each hidden unit its inputs' weights and what is added, the units' weights, what is added.
pub(crate) fn words(inner: &[f32], outer: &[f32], bias: &[f32]) -> Vec<u8> {
    inner.iter().chain(outer).chain(bias).flat_map(|number| number.to_le_bytes()).collect()
}

fn text<'a>(metadata: &'a HashMap<String, String>, key: &str) -> Result<&'a String> {
    metadata.get(key).ok_or_else(|| bad(&format!("metadata `{key}`"), "is missing".into()))
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
