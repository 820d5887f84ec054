//! Twin of the network's kernels: every block in f64, one sum at a time.

use limpid::network::weights::{Activation, Block, Convolution, Network, Op};

/// Channels x rows x columns.
#[derive(Clone)]
struct Tensor {
    channels: usize,
    rows: usize,
    columns: usize,
    values: Vec<f64>,
}

impl Tensor {
    fn of(channels: usize, rows: usize, columns: usize, value: impl Fn(usize, usize, usize) -> f64) -> Self {
        let at = |i: usize| value(i / (rows * columns), i / columns % rows, i % columns);
        Self { channels, rows, columns, values: (0..channels * rows * columns).map(at).collect() }
    }

    /// 0 outside.
    fn at(&self, channel: usize, row: isize, column: isize) -> f64 {
        let inside = |i: isize, count: usize| usize::try_from(i).ok().filter(|&i| i < count);
        match (inside(row, self.rows), inside(column, self.columns)) {
            (Some(row), Some(column)) => self.values[(channel * self.rows + row) * self.columns + column],
            _ => 0.0,
        }
    }

    /// Twice as large, bilinearly: pixel centres at (i + 0.5) / 2, the border repeated.
    fn upsampled(&self) -> Self {
        let split = |i: usize, count: usize| {
            let place = ((i as f64 + 0.5) / 2.0 - 0.5).clamp(0.0, count as f64 - 1.0);
            let low = place.floor();
            (low as isize, (low as isize + 1).min(count as isize - 1), place - low)
        };
        Self::of(self.channels, 2 * self.rows, 2 * self.columns, |channel, row, column| {
            let ((y0, y1, v), (x0, x1, u)) = (split(row, self.rows), split(column, self.columns));
            let mixed = |y| self.at(channel, y, x0) * (1.0 - u) + self.at(channel, y, x1) * u;
            mixed(y0) * (1.0 - v) + mixed(y1) * v
        })
    }

    fn with(&self, other: &Self) -> Self {
        let values = [self.values.clone(), other.values.clone()].concat();
        Self { channels: self.channels + other.channels, values, ..*self }
    }

    /// `kernel` x `kernel` convolution with zeros outside; `depthwise`: each channel by itself.
    fn convolved(&self, c: &Convolution, kernel: usize, stride: usize, depthwise: bool) -> Self {
        let per_output = if depthwise { 1 } else { self.channels };
        let half = (kernel / 2) as isize;
        let (rows, columns) = (self.rows.div_ceil(stride), self.columns.div_ceil(stride));
        Self::of(c.bias.len(), rows, columns, |output, row, column| {
            let mut sum = f64::from(c.bias[output]);
            for (index, tap) in
                (0..per_output * kernel * kernel).map(|i| (i / (kernel * kernel), i % (kernel * kernel)))
            {
                let channel = if depthwise { output } else { index };
                let y = (row * stride + tap / kernel) as isize - half;
                let x = (column * stride + tap % kernel) as isize - half;
                let weight = c.weight[(output * per_output + index) * kernel * kernel + tap];
                sum += f64::from(weight) * self.at(channel, y, x);
            }
            sum
        })
    }

    fn activated(mut self, activation: Activation) -> Self {
        for value in &mut self.values {
            *value = match activation {
                Activation::Relu => value.max(0.0),
                Activation::Sigmoid => 1.0 / (1.0 + (-*value).exp()),
            };
        }
        self
    }
}

fn block_output(block: &Block, input: &Tensor) -> Tensor {
    let (shape, c) = (&block.shape, &block.convolution);
    match (shape.op, &block.depthwise) {
        (Op::Separable, Some(depthwise)) => {
            let between = input.convolved(depthwise, 3, shape.stride, true).activated(Activation::Relu);
            between.convolved(c, 1, 1, false)
        }
        (Op::Conv3x3, _) => input.convolved(c, 3, shape.stride, false),
        _ => input.convolved(c, 1, 1, false),
    }
    .activated(shape.activation)
}

/// Every block's name and output for an input of 5 x rows x columns.
pub(crate) fn infer(
    network: &Network,
    [rows, columns]: [usize; 2],
    input: &[f32],
) -> Vec<(String, Vec<f32>)> {
    let values = input.iter().map(|&v| f64::from(v)).collect();
    let mut now = Tensor { channels: 5, rows, columns, values };
    let mut made: Vec<(String, Tensor)> = Vec::new();
    for block in &network.blocks {
        if block.shape.upsample == 2 {
            now = now.upsampled();
        }
        if let Some(skip) = &block.shape.skip {
            now = now.with(&made.iter().find(|(name, _)| name == skip).unwrap().1);
        }
        now = block_output(block, &now);
        made.push((block.shape.name.clone(), now.clone()));
    }
    let single = |tensor: Tensor| tensor.values.into_iter().map(|v| v as f32).collect();
    made.into_iter().map(|(name, tensor)| (name, single(tensor))).collect()
}
