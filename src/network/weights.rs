//! Weight files of DRM-Net (spec 1 §1): safetensors whose metadata lists the layers.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::Path;

use safetensors::{Dtype, SafeTensors};
use serde::Deserialize;

use crate::base::{Error, Result};

/// The weight file that limpid comes with.
pub const SHIPPED: &[u8] = include_bytes!("../../weights/drm-net.safetensors");

/// Channels of the network's input: red, green, blue, depth, change of depth.
pub const INPUT_CHANNELS: usize = 5;

/// Rows and columns of the network's input in the paper.
pub const NATIVE_SIZE: [usize; 2] = [240, 320];

/// What a block computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Op {
    /// 3x3 convolution.
    Conv3x3,
    /// 3x3 depthwise convolution, then 1x1 convolution, each with bias and ReLU.
    Separable,
    /// 1x1 convolution.
    Conv1x1,
}

/// What follows a block's last convolution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// max(0, x).
    #[default]
    Relu,
    /// 1 / (1 + exp(-x)).
    Sigmoid,
}

/// A line of the metadata's `architecture`.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockShape {
    /// Name; prefix of its tensors.
    pub name: String,
    /// Kind.
    pub op: Op,
    /// Input channels, those of the skip included.
    #[serde(rename = "in")]
    pub inputs: usize,
    /// Output channels.
    #[serde(rename = "out")]
    pub outputs: usize,
    /// 1, or 2 to halve the resolution.
    pub stride: usize,
    /// 2 to double the resolution of the input first, bilinearly.
    #[serde(default = "one")]
    pub upsample: usize,
    /// Earlier block whose output is concatenated behind the (upsampled) input.
    #[serde(default)]
    pub skip: Option<String>,
    /// After the last convolution.
    #[serde(default)]
    pub activation: Activation,
}

fn one() -> usize {
    1
}

/// A convolution: weights as PyTorch has them (out, in per group, rows, columns), a bias per output.
#[derive(Debug, Clone, PartialEq)]
pub struct Convolution {
    /// Row-major.
    pub weight: Vec<f32>,
    /// One per output channel.
    pub bias: Vec<f32>,
}

/// A block with its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// Its line of the architecture.
    pub shape: BlockShape,
    /// Of a separable block: (inputs, 1, 3, 3).
    pub depthwise: Option<Convolution>,
    /// (outputs, inputs, 1, 1), or (outputs, inputs, 3, 3) of a `conv3x3`.
    pub convolution: Convolution,
}

/// A checked weight file.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    /// Metres that depth is divided by before it goes in.
    pub depth_scale_m: f64,
    /// Where the weights come from, as the file says.
    pub origin: String,
    /// Blocks in order.
    pub blocks: Vec<Block>,
}

impl Network {
    /// Reads a safetensors file.
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be read, [`Error::Format`] with the message of [`Network::from_bytes`].
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(Error::file(path))?;
        let named = |error: Error| Error::Format { path: path.into(), reason: error.to_string() };
        Self::from_bytes(&bytes).map_err(named)
    }

    /// The weights that limpid comes with (`weights/README.md`).
    ///
    /// # Errors
    /// None; a test reads them.
    pub fn shipped() -> Result<Self> {
        Self::from_bytes(SHIPPED)
    }

    /// Reads a safetensors file from memory.
    ///
    /// # Errors
    /// [`Error::Weights`] that names the metadata key, block or tensor: a file that is no safetensors or
    /// is cut short, missing or unknown tensors, wrong shapes or types, numbers that are not finite,
    /// layers that do not fit together, widths that are no multiples of 4.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let broken = |e: safetensors::SafeTensorError| bad("file", format!("is no safetensors file: {e}"));
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(broken)?;
        let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
        let metadata = |key: &str| {
            let value = header.metadata().as_ref().and_then(|all| all.get(key));
            value.ok_or_else(|| bad(&format!("metadata `{key}`"), "is missing".into()))
        };
        if metadata("format")? != "drm-net" {
            return Err(bad("metadata `format`", format!("is `{}`, not `drm-net`", metadata("format")?)));
        }
        let scale = metadata("depth_scale_m")?;
        let depth_scale_m = scale.parse().ok().filter(|m: &f64| m.is_finite() && *m > 0.0);
        let depth_scale_m = depth_scale_m
            .ok_or_else(|| bad("metadata `depth_scale_m`", format!("`{scale}` is no positive number")))?;
        let shapes: Vec<BlockShape> = serde_json::from_str(metadata("architecture")?)
            .map_err(|e| bad("metadata `architecture`", e.to_string()))?;
        check_architecture(&shapes)?;
        let mut reader = Reader { tensors, known: HashSet::new() };
        let blocks = shapes.into_iter().map(|shape| reader.block(shape)).collect::<Result<_>>()?;
        reader.check_all_known()?;
        let origin = metadata("origin").cloned().unwrap_or_default();
        Ok(Self { depth_scale_m, origin, blocks })
    }

    /// Weights, biases and multiply-accumulates by block for an input of `size` rows and columns, and in
    /// total, as a Markdown table.
    pub fn table(&self, size: [usize; 2]) -> String {
        let mut text = String::from(
            "| block | op | in | out | resolution | weights | biases | MMAC |\n|---|---|---|---|---|---|---|---|\n",
        );
        let (mut weights, mut biases, mut macs) = (0, 0, 0);
        for (block, [rows, columns]) in self.blocks.iter().zip(self.resolutions(size)) {
            let BlockShape { name, op, inputs, outputs, .. } = &block.shape;
            let counts = block.counts(rows * columns);
            let op = format!("{op:?}").to_lowercase();
            let [w, b, m] = counts;
            let _ = writeln!(
                text,
                "| {name} | {op} | {inputs} | {outputs} | {rows}x{columns} | {w} | {b} | {} |",
                millions(m)
            );
            (weights, biases, macs) = (weights + w, biases + b, macs + m);
        }
        let _ = writeln!(text, "| **total** | | | | | {weights} | {biases} | {} |", millions(macs));
        text
    }

    /// Rows and columns of an input must be multiples of this: how much smaller the smallest tensor is, at least 4.
    pub fn size_factor(&self) -> usize {
        let mut level = 0_u32;
        let levels = self.blocks.iter().map(|block| {
            level = (level + u32::from(block.shape.stride == 2))
                .saturating_sub(u32::from(block.shape.upsample == 2));
            level
        });
        1 << levels.max().unwrap_or(0).max(2)
    }

    /// Rows and columns of each block's output for an input of `size`.
    pub fn resolutions(&self, size: [usize; 2]) -> Vec<[usize; 2]> {
        let mut now = size;
        let step = |shape: &BlockShape| {
            now = now.map(|extent| (extent * shape.upsample).div_ceil(shape.stride));
            now
        };
        self.blocks.iter().map(|block| &block.shape).map(step).collect()
    }
}

impl Block {
    /// Weights, biases, and multiply-accumulates for `pixels` outputs.
    fn counts(&self, pixels: usize) -> [usize; 3] {
        let all = || self.depthwise.iter().chain([&self.convolution]);
        let weights = all().map(|c| c.weight.len()).sum();
        [weights, all().map(|c| c.bias.len()).sum(), weights * pixels]
    }
}

fn millions(count: usize) -> String {
    let tenths = (count + 50_000) / 100_000;
    format!("{}.{}", tenths / 10, tenths % 10)
}

fn bad(what: &str, reason: String) -> Error {
    Error::Weights { what: what.into(), reason }
}

/// Whether the layers fit together: channels, resolutions, widths.
fn check_architecture(shapes: &[BlockShape]) -> Result<()> {
    let mut channels = INPUT_CHANNELS;
    // log2 of how much smaller than the input each block's output is.
    let mut level = 0_i32;
    let mut outputs: Vec<(&str, usize, i32)> = Vec::new();
    for (index, shape) in shapes.iter().enumerate() {
        let fail = |reason: String| Err(bad(&format!("block `{}`", shape.name), reason));
        if outputs.iter().any(|(name, ..)| *name == shape.name) {
            return fail("is listed twice".into());
        }
        if !matches!((shape.stride, shape.upsample), (1, 1 | 2) | (2, 1)) {
            return fail(format!(
                "stride {} with upsampling {} is not supported",
                shape.stride, shape.upsample
            ));
        }
        let resampled = shape.upsample == 2 || shape.skip.is_some();
        if shape.op != Op::Separable && resampled {
            return fail("only `separable` blocks take a skip or upsample".into());
        }
        level += i32::from(shape.stride == 2) - i32::from(shape.upsample == 2);
        let mut wanted = channels;
        if let Some(skip) = &shape.skip {
            let Some((_, width, at)) = outputs.iter().find(|(name, ..)| name == skip) else {
                return fail(format!("skips from `{skip}`, which is no block before it"));
            };
            if *at != level - i32::from(shape.stride == 2) {
                return fail(format!("skips from `{skip}`, which has another resolution"));
            }
            wanted += width;
        }
        if shape.inputs != wanted {
            return fail(format!("takes {} channels where {wanted} come in", shape.inputs));
        }
        let last = index + 1 == shapes.len();
        let head = (shape.op, shape.outputs, shape.activation) == (Op::Conv1x1, 1, Activation::Sigmoid);
        if last != head {
            return fail(
                "one `conv1x1` to 1 channel with sigmoid must end the network, and only end it".into(),
            );
        }
        if !last && (shape.outputs == 0 || !shape.outputs.is_multiple_of(4)) {
            return fail(format!("{} outputs are no multiple of 4", shape.outputs));
        }
        channels = shape.outputs;
        outputs.push((&shape.name, channels, level));
    }
    match (shapes.is_empty(), level) {
        (false, 0) => Ok(()),
        _ => Err(bad("metadata `architecture`", "does not end at the resolution of its input".into())),
    }
}

struct Reader<'a> {
    tensors: SafeTensors<'a>,
    known: HashSet<String>,
}

impl Reader<'_> {
    fn block(&mut self, shape: BlockShape) -> Result<Block> {
        let BlockShape { name, op, inputs, outputs, .. } = &shape;
        let (depthwise, convolution) = match op {
            Op::Conv3x3 => (None, self.convolution(name, [*outputs, *inputs, 3, 3])?),
            Op::Conv1x1 => (None, self.convolution(name, [*outputs, *inputs, 1, 1])?),
            Op::Separable => {
                let depthwise = self.convolution(&format!("{name}.dw"), [*inputs, 1, 3, 3])?;
                (Some(depthwise), self.convolution(&format!("{name}.pw"), [*outputs, *inputs, 1, 1])?)
            }
        };
        Ok(Block { shape, depthwise, convolution })
    }

    fn convolution(&mut self, prefix: &str, shape: [usize; 4]) -> Result<Convolution> {
        let weight = self.tensor(format!("{prefix}.weight"), &shape)?;
        Ok(Convolution { weight, bias: self.tensor(format!("{prefix}.bias"), &shape[..1])? })
    }

    fn tensor(&mut self, name: String, shape: &[usize]) -> Result<Vec<f32>> {
        let what = format!("tensor `{name}`");
        let view = self.tensors.tensor(&name).map_err(|_| bad(&what, "is missing".into()))?;
        if view.dtype() != Dtype::F32 {
            return Err(bad(&what, format!("is {:?}, not F32", view.dtype())));
        }
        if view.shape() != shape {
            return Err(bad(&what, format!("has shape {:?}, not {shape:?}", view.shape())));
        }
        let words = view.data().chunks_exact(4);
        let values: Vec<f32> =
            words.map(|word| f32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect();
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(bad(&what, format!("value {index} is {}", values[index])));
        }
        self.known.insert(name);
        Ok(values)
    }

    fn check_all_known(&self) -> Result<()> {
        let mut unknown: Vec<&str> =
            self.tensors.names().into_iter().filter(|name| !self.known.contains(*name)).collect();
        unknown.sort_unstable();
        match unknown.first() {
            Some(name) => {
                Err(bad(&format!("tensor `{name}`"), "belongs to no block of the architecture".into()))
            }
            None => Ok(()),
        }
    }
}
