//! Weights in the order in which the kernels read them: rows of texels of four floats.
//!
//! A separable block has a row for each quad of inputs (texels 0 to 8 the depthwise taps, 9 their bias, from 16 on four
//! texels for each quad of outputs: the weights of the four inputs), then the row of output biases, then, for the block
//! before the head, the head's weights and bias. A full convolution has a row for each tap of each quad of inputs.

use crate::gpu::Extent;
use crate::network::weights::{Block, Convolution, Op};

/// First texel of the pointwise part of a row.
const POINTWISE: usize = 16;

/// Rows of texels.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Texels {
    width: usize,
    values: Vec<[f32; 4]>,
}

impl Texels {
    fn zeros(width: usize, rows: usize) -> Self {
        Self { width, values: vec![[0.0; 4]; width * rows] }
    }

    fn at(&mut self, row: usize, texel: usize) -> &mut [f32; 4] {
        &mut self.values[row * self.width + texel]
    }

    /// The row of biases or of other values of which each output channel has one.
    fn fill(&mut self, row: usize, values: &[f32]) {
        for (channel, value) in values.iter().enumerate() {
            self.at(row, channel / 4)[channel % 4] = *value;
        }
    }

    pub(crate) fn extent(&self) -> Extent {
        let count = |extent: usize| u32::try_from(extent).unwrap_or(u32::MAX);
        Extent { width: count(self.width), height: count(self.values.len() / self.width), layers: 1 }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        bytemuck::cast_slice(&self.values).to_vec()
    }
}

/// Outputs of a convolution, padded so that kernels may read eight texels, or sixteen outputs, past any start.
fn padded(outputs: usize) -> usize {
    outputs.next_multiple_of(16) + 16
}

/// The weights of `block`, and of the head behind it where that is folded in.
pub(crate) fn pack(block: &Block, head: Option<&Block>) -> Texels {
    match (&block.depthwise, block.shape.op) {
        (Some(depthwise), _) => separable(block, depthwise, head.map(|head| &head.convolution)),
        (None, Op::Conv1x1) => head_alone(&block.convolution),
        (None, _) => full(block),
    }
}

fn separable(block: &Block, depthwise: &Convolution, head: Option<&Convolution>) -> Texels {
    let (inputs, outputs) = (block.shape.inputs, block.shape.outputs);
    let quads = inputs.div_ceil(4);
    let mut texels = Texels::zeros(POINTWISE + padded(outputs), quads + 2);
    for channel in 0..inputs {
        let (row, lane) = (channel / 4, channel % 4);
        for tap in 0..9 {
            texels.at(row, tap)[lane] = depthwise.weight[channel * 9 + tap];
        }
        texels.at(row, 9)[lane] = depthwise.bias[channel];
        for output in 0..outputs {
            let texel = POINTWISE + output / 4 * 4 + lane;
            texels.at(row, texel)[output % 4] = block.convolution.weight[output * inputs + channel];
        }
    }
    texels.fill(quads, &block.convolution.bias);
    if let Some(head) = head {
        texels.fill(quads + 1, &head.weight);
        texels.at(quads + 1, outputs / 4)[0] = head.bias[0];
    }
    texels
}

fn full(block: &Block) -> Texels {
    let (inputs, outputs) = (block.shape.inputs, block.shape.outputs);
    let quads = inputs.div_ceil(4);
    let mut texels = Texels::zeros(padded(outputs), 9 * quads + 1);
    for channel in 0..inputs {
        for tap in 0..9 {
            for output in 0..outputs {
                let weight = block.convolution.weight[(output * inputs + channel) * 9 + tap];
                texels.at(channel / 4 * 9 + tap, output / 4 * 4 + channel % 4)[output % 4] = weight;
            }
        }
    }
    texels.fill(9 * quads, &block.convolution.bias);
    texels
}

fn head_alone(head: &Convolution) -> Texels {
    let quads = head.weight.len() / 4;
    let mut texels = Texels::zeros(quads + 1, 1);
    texels.fill(0, &head.weight);
    texels.at(0, quads)[0] = head.bias[0];
    texels
}
