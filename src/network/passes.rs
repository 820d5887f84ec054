//! The passes that run a network, block by block.

use crate::base::{Error, Result};
use crate::gpu::{Executor, Extent, Invocations, Plan};
use crate::network::kernels::{Backend, Finish, Kernel, Sampling};
use crate::network::packing::{Texels, pack};
use crate::network::weights::{Block, INPUT_CHANNELS, Network, Op};

/// The tensor that goes in: R, G, B, depth, change of depth, in two quads.
pub const INPUT: &str = "net/input";

/// The buffer that comes out: one f32 a pixel.
pub const OUTPUT: &str = "reliability_low";

/// Quads of outputs that one invocation of a full or pointwise convolution sums up.
const QUADS_AT_ONCE: u32 = 4;

/// A network's passes for inputs of one size.
#[derive(Debug, Clone)]
pub struct Passes<'a> {
    /// Layers and weights.
    pub network: &'a Network,
    /// Rows and columns of the input.
    pub size: [u32; 2],
    /// How tensors are stored.
    pub backend: Backend,
    /// Whether every block's output is kept, which leaves the head apart.
    pub keep_all: bool,
}

/// A block's output as later blocks take it.
#[derive(Debug, Clone)]
struct Tensor {
    name: String,
    channels: u32,
    size: [u32; 2],
}

impl Tensor {
    fn quads(&self) -> u32 {
        self.channels.div_ceil(4)
    }

    fn extent(&self) -> Extent {
        Extent { width: self.size[1], height: self.size[0], layers: self.quads() }
    }
}

impl Passes<'_> {
    /// Refuses an input size that the network cannot halve as often as it wants to.
    ///
    /// # Errors
    /// [`Error::Input`] that names the size.
    pub fn check_size(&self) -> Result<()> {
        let factor = self.network.size_factor();
        let [rows, columns] = self.size.map(|extent| extent as usize);
        if rows > 0 && columns > 0 && rows.is_multiple_of(factor) && columns.is_multiple_of(factor) {
            return Ok(());
        }
        let reason = format!("{columns}x{rows} is no multiple of {factor} both ways");
        Err(Error::Input { what: "network input".into(), reason })
    }

    /// Declares the input tensor, which another pass is to write.
    ///
    /// # Errors
    /// [`Error::Plan`] where it is declared already.
    pub fn declare_input(&self, plan: &mut Plan) -> Result<()> {
        self.declare(plan, &self.input())
    }

    /// Appends all passes, from the tensor [`INPUT`] to the buffer [`OUTPUT`].
    ///
    /// # Errors
    /// [`Error::Plan`] and [`Error::Shader`] where a kernel contradicts its shape.
    pub fn append(&self, plan: &mut Plan) -> Result<()> {
        let [rows, columns] = self.size;
        plan.product(OUTPUT, u64::from(rows) * u64::from(columns) * 4)?;
        let mut made = vec![self.input()];
        for (index, block) in self.network.blocks.iter().enumerate() {
            if block.shape.op == Op::Conv1x1 {
                if !self.is_head_folded() {
                    self.head(plan, block, made.last())?;
                }
                continue;
            }
            let head = self.network.blocks.get(index + 1).filter(|next| next.shape.op == Op::Conv1x1);
            let head = head.filter(|_| self.is_head_folded());
            let tensor = self.output_of(block, index);
            self.fixed(plan, &block.shape.name, pack(block, head))?;
            if head.is_none() {
                self.declare(plan, &tensor)?;
            }
            let source = made.last().ok_or_else(|| no_tensor(block))?;
            let skip = block.shape.skip.as_ref().map(|name| find(&made, block, name)).transpose()?;
            Placed { passes: self, block, source, skip, sink: &tensor, head: head.is_some() }.append(plan)?;
            made.push(tensor);
        }
        Ok(())
    }

    /// Replaces all weights of a built plan by those of `network`, which has the same layers.
    ///
    /// # Errors
    /// [`Error::Weights`] where the layers differ; errors of the GPU.
    pub fn rewrite(&self, network: &Network, executor: &Executor) -> Result<()> {
        let shapes = |network: &Network| network.blocks.iter().map(|b| b.shape.clone()).collect::<Vec<_>>();
        if shapes(network) != shapes(self.network) {
            let reason = "has other layers than the network that runs".into();
            return Err(Error::Weights { what: "metadata `architecture`".into(), reason });
        }
        for (index, block) in network.blocks.iter().enumerate() {
            let is_head = block.shape.op == Op::Conv1x1;
            let head = network.blocks.get(index + 1).filter(|next| next.shape.op == Op::Conv1x1);
            let head = head.filter(|_| self.is_head_folded());
            if !(is_head && self.is_head_folded()) {
                let name = weights_name(&block.shape.name);
                executor.rewrite_fixed("", &name, &pack(block, head).bytes())?;
            }
        }
        Ok(())
    }

    /// Whether the block before the head computes the head too.
    fn is_head_folded(&self) -> bool {
        let before = self.network.blocks.iter().rev().nth(1);
        !self.keep_all && before.is_some_and(|block| self.is_fused(block))
    }

    /// Whether one pass does the whole block. Invocations then hold sums for all outputs, which pays while these are
    /// few; GPUs also want more invocations than deep blocks have pixels.
    fn is_fused(&self, block: &Block) -> bool {
        let most = if self.backend.textures { 64 } else { 32 };
        block.shape.op == Op::Separable && block.shape.outputs <= most
    }

    fn input(&self) -> Tensor {
        Tensor { name: INPUT.into(), channels: count(INPUT_CHANNELS), size: self.size }
    }

    fn output_of(&self, block: &Block, index: usize) -> Tensor {
        let sizes = self.network.resolutions(self.size.map(|extent| extent as usize));
        let size = sizes.get(index).copied().unwrap_or([0, 0]).map(count);
        Tensor { name: tensor_name(&block.shape.name), channels: count(block.shape.outputs), size }
    }

    fn declare(&self, plan: &mut Plan, tensor: &Tensor) -> Result<()> {
        let extent = tensor.extent();
        match self.backend.textures {
            true => plan.texture(&tensor.name, extent)?,
            false => plan.scratch(&tensor.name, extent.bytes())?,
        };
        Ok(())
    }

    fn fixed(&self, plan: &mut Plan, block: &str, texels: Texels) -> Result<()> {
        let name = weights_name(block);
        match self.backend.textures {
            true => plan.fixed_texture(&name, texels.extent(), texels.bytes())?,
            false => plan.fixed(&name, texels.bytes())?,
        };
        Ok(())
    }

    fn head(&self, plan: &mut Plan, block: &Block, source: Option<&Tensor>) -> Result<()> {
        let source = source.ok_or_else(|| no_tensor(block))?;
        let texels = pack(block, None);
        let width = texels.extent().width;
        self.fixed(plan, &block.shape.name, texels)?;
        let [rows, columns] = source.size;
        let constants = [
            ("WIDTH", columns),
            ("HEIGHT", rows),
            ("SOURCE_WIDTH", columns),
            ("SOURCE_HEIGHT", rows),
            ("SOURCE_QUADS", source.quads()),
            ("WEIGHTS_WIDTH", width),
        ];
        let text = Kernel::Head.text(tensor_name(&block.shape.name), self.backend, &constants);
        let renames = [("weights", &*weights_name(&block.shape.name)), ("source", &*source.name)];
        plan.step(text, Invocations::line(rows * columns), &renames)
    }
}

/// A block between its tensors.
struct Placed<'a> {
    passes: &'a Passes<'a>,
    block: &'a Block,
    source: &'a Tensor,
    skip: Option<&'a Tensor>,
    sink: &'a Tensor,
    head: bool,
}

impl Placed<'_> {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        if self.block.shape.op == Op::Conv3x3 {
            return self.convolve(plan);
        }
        if self.passes.is_fused(self.block) {
            return self.fused(plan);
        }
        let name = format!("{}/depthwise", self.sink.name);
        let between = Tensor { name, channels: count(self.block.shape.inputs), size: self.sink.size };
        self.passes.declare(plan, &between)?;
        self.depthwise(plan, self.source, self.sampling(), &between, 0)?;
        if let Some(skip) = self.skip {
            self.depthwise(plan, skip, Sampling::Straight, &between, self.source.quads())?;
        }
        self.pointwise(plan, &between)
    }

    fn sampling(&self) -> Sampling {
        if self.block.shape.upsample == 2 { Sampling::Upsampled } else { Sampling::Straight }
    }

    fn stride(&self) -> u32 {
        count(self.block.shape.stride)
    }

    fn fused(&self, plan: &mut Plan) -> Result<()> {
        let tile = match (self.stride(), self.sink.quads()) {
            (2, _) => [2, 1],
            (_, ..=4) => [4, 2],
            _ => [2, 2],
        };
        let finish = if self.head { Finish::Head } else { Finish::Store };
        let kernel = Kernel::Fused { from: self.sampling(), skip: self.skip.is_some(), finish };
        let quads = self.sink.quads();
        self.step(plan, kernel, "", [self.source, self.sink], tile, self.stride(), quads, &[])
    }

    fn convolve(&self, plan: &mut Plan) -> Result<()> {
        let channels = [("SOURCE_CHANNELS", self.source.channels)];
        let quads = self.sink.quads().min(QUADS_AT_ONCE);
        let tensors = [self.source, self.sink];
        self.step(plan, Kernel::Convolve, "", tensors, [2, 2], self.stride(), quads, &channels)
    }

    fn pointwise(&self, plan: &mut Plan, between: &Tensor) -> Result<()> {
        let quads = self.sink.quads().min(QUADS_AT_ONCE);
        self.step(plan, Kernel::Pointwise, "/pointwise", [between, self.sink], [4, 1], 1, quads, &[])
    }

    fn depthwise(
        &self,
        plan: &mut Plan,
        source: &Tensor,
        from: Sampling,
        between: &Tensor,
        first: u32,
    ) -> Result<()> {
        let part = if first == 0 { "/depthwise" } else { "/depthwise_skip" };
        let stride = if from == Sampling::Upsampled { 1 } else { self.stride() };
        let kernel = Kernel::Depthwise { from };
        let tile = if stride == 2 { [2, 1] } else { [2, 2] };
        let constants = [("FIRST_QUAD", first)];
        self.step(plan, kernel, part, [source, between], tile, stride, 1, &constants)
    }

    /// One dispatch over the tiles of the sink, a row of the grid for every `quads` quads of its outputs (for every quad of
    /// the source in a depthwise pass).
    #[expect(clippy::too_many_arguments, reason = "the one place that turns shapes into constants")]
    fn step(
        &self,
        plan: &mut Plan,
        kernel: Kernel,
        part: &str,
        [source, sink]: [&Tensor; 2],
        tile: [u32; 2],
        stride: u32,
        quads: u32,
        more: &[(&str, u32)],
    ) -> Result<()> {
        let [rows, columns] = sink.size;
        let tiles = [columns.div_ceil(tile[0]), rows.div_ceil(tile[1])];
        let head = self.head.then(|| self.passes.network.blocks.last()).flatten();
        let mut constants = vec![
            ("WIDTH", columns),
            ("HEIGHT", rows),
            ("STRIDE", stride),
            ("TILE_X", tile[0]),
            ("TILE_Y", tile[1]),
            ("TILES_X", tiles[0]),
            ("TILES_Y", tiles[1]),
            ("SOURCE_WIDTH", source.size[1]),
            ("SOURCE_HEIGHT", source.size[0]),
            ("SOURCE_QUADS", source.quads()),
            ("SKIP_WIDTH", self.skip.map_or(1, |skip| skip.size[1])),
            ("SKIP_HEIGHT", self.skip.map_or(1, |skip| skip.size[0])),
            ("SKIP_QUADS", self.skip.map_or(0, Tensor::quads)),
            ("OUT_QUADS", quads),
            ("SINK_QUADS", sink.quads()),
            ("WEIGHTS_WIDTH", pack(self.block, head).extent().width),
        ];
        constants.extend_from_slice(more);
        let label = format!("{}{part}", self.sink.name);
        let weights = weights_name(&self.block.shape.name);
        let mut renames = vec![("weights", &*weights), ("source", &*source.name), ("sink", &*sink.name)];
        renames.extend(self.skip.map(|skip| ("skip", &*skip.name)));
        let grid_rows = match kernel {
            Kernel::Depthwise { .. } => source.quads(),
            _ => sink.quads().div_ceil(quads),
        };
        let text = kernel.text(label, self.passes.backend, &constants);
        plan.step(text, Invocations::area(tiles[0] * tiles[1], grid_rows), &renames)
    }
}

fn tensor_name(block: &str) -> String {
    format!("net/{block}")
}

fn weights_name(block: &str) -> String {
    format!("net/{block}/weights")
}

fn find<'a>(made: &'a [Tensor], block: &Block, name: &str) -> Result<&'a Tensor> {
    made.iter().find(|tensor| tensor.name == tensor_name(name)).ok_or_else(|| no_tensor(block))
}

fn no_tensor(block: &Block) -> Error {
    let reason = "takes a tensor that no block before it makes".into();
    Error::Weights { what: format!("block `{}`", block.shape.name), reason }
}

/// Channels and extents come from checked files and images, far below the limit.
fn count(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}
