//! A network run by itself: planes of floats in, planes of floats out.

use bytemuck::{cast_slice, pod_read_unaligned};

use crate::base::{Error, Result};
use crate::gpu::{Context, Executor, Invocations, Plan, Readback};
use crate::network::kernels::{Backend, Kernel};
use crate::network::passes::{INPUT, OUTPUT, Passes};
use crate::network::weights::{INPUT_CHANNELS, Network, Op};

/// A network built for inputs of one size.
pub struct Inference {
    network: Network,
    size: [u32; 2],
    backend: Backend,
    keep_all: bool,
    executor: Executor,
    pass_ms: Vec<(String, f64)>,
}

/// A block's output: channels x rows x columns.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockOutput {
    /// The block.
    pub name: String,
    /// Channels, rows, columns.
    pub shape: [usize; 3],
    /// Row-major.
    pub values: Vec<f32>,
}

impl Inference {
    /// Builds the passes for inputs of `size` rows and columns on the adapter of that name (see
    /// [`Context::open`]). `keep_all` reads every block's output back, not only the last.
    ///
    /// # Errors
    /// [`Error::Input`] where the network cannot take that size; [`Error::NoAdapter`], [`Error::Limit`],
    /// [`Error::Gpu`].
    pub fn open(network: Network, size: [u32; 2], keep_all: bool, adapter: Option<&str>) -> Result<Self> {
        let context = Context::open(adapter, false)?;
        Self::build(network, size, keep_all, Backend::of(&context), &context)
    }

    /// The same with a given backend, on a device that is open already.
    ///
    /// # Errors
    /// Those of [`Inference::open`].
    pub fn build(
        network: Network,
        size: [u32; 2],
        keep_all: bool,
        backend: Backend,
        context: &Context,
    ) -> Result<Self> {
        let passes = Passes { network: &network, size, backend, keep_all };
        let plan = plan(&passes)?;
        let executor = Executor::build(context, plan)?;
        Ok(Self { network, size, backend, keep_all, executor, pass_ms: Vec::new() })
    }

    /// Adapter and driver.
    pub fn describe(&self) -> String {
        self.executor.context().describe()
    }

    /// The plan as built, and the device it runs on.
    pub fn executor(&self) -> &Executor {
        &self.executor
    }

    /// Takes the weights of another network with the same layers; nothing is compiled anew.
    ///
    /// # Errors
    /// [`Error::Weights`] where the layers differ; [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn reload(&mut self, network: Network) -> Result<()> {
        let Self { size, backend, keep_all, .. } = *self;
        Passes { network: &self.network, size, backend, keep_all }.rewrite(&network, &self.executor)?;
        self.network = network;
        Ok(())
    }

    /// Runs one input of 5 x rows x columns (R, G, B and depth in [0, 1], change of depth). The head's output comes
    /// last; the others come before it where they are kept.
    ///
    /// # Errors
    /// [`Error::Input`] where the length is wrong or a value is no finite number; [`Error::Gpu`],
    /// [`Error::DeviceLost`].
    pub fn run(&mut self, input: &[f32]) -> Result<Vec<BlockOutput>> {
        let bad = |reason: String| Error::Input { what: "network input".into(), reason };
        let [rows, columns] = self.size.map(|extent| extent as usize);
        let wanted = INPUT_CHANNELS * rows * columns;
        if input.len() != wanted {
            return Err(bad(format!("has {} values where {wanted} are wanted", input.len())));
        }
        if let Some(index) = input.iter().position(|value| !value.is_finite()) {
            return Err(bad(format!("value {index} is {}", input[index])));
        }
        let mut frame = self.executor.begin()?;
        frame.write("planes", cast_slice(input))?;
        frame.submit()?;
        let missing = || Error::Gpu { what: "network".into(), reason: "gave no result".into() };
        let readback = self.executor.receive()?.ok_or_else(missing)?;
        let spans = readback.spans.iter();
        self.pass_ms = spans.map(|(name, span)| (name.to_string(), span.length_ns * 1e-6)).collect();
        self.outputs(&readback)
    }

    /// GPU time of each pass of the last run in milliseconds, where the device was opened for profiling.
    pub fn pass_ms(&self) -> &[(String, f64)] {
        &self.pass_ms
    }

    fn outputs(&self, readback: &Readback) -> Result<Vec<BlockOutput>> {
        let sizes = self.network.resolutions(self.size.map(|extent| extent as usize));
        let mut outputs = Vec::new();
        for (block, [rows, columns]) in self.network.blocks.iter().zip(sizes) {
            let head = block.shape.op == Op::Conv1x1;
            if !head && !self.keep_all {
                continue;
            }
            let buffer = if head { OUTPUT.into() } else { planes_name(&block.shape.name) };
            let shape = [block.shape.outputs, rows, columns];
            let bytes = readback.bytes(self.executor.find(&buffer)?)?;
            let values = bytes.chunks_exact(4).map(pod_read_unaligned).collect();
            outputs.push(BlockOutput { name: block.shape.name.clone(), shape, values });
        }
        Ok(outputs)
    }
}

fn planes_name(block: &str) -> String {
    format!("net/{block}/planes")
}

fn plan(passes: &Passes<'_>) -> Result<Plan> {
    passes.check_size()?;
    let [rows, columns] = passes.size;
    let mut plan = Plan::default();
    let channels = u32::try_from(INPUT_CHANNELS).unwrap_or(0);
    plan.upload("planes", u64::from(rows) * u64::from(columns) * u64::from(channels) * 4)?;
    passes.declare_input(&mut plan)?;
    let constants = [("WIDTH", columns), ("HEIGHT", rows), ("CHANNELS", channels)];
    let text = Kernel::Pack.text("net/pack".into(), passes.backend, &constants);
    plan.step(text, Invocations::area(rows * columns / 4, channels.div_ceil(4)), &[("sink", INPUT)])?;
    passes.append(&mut plan)?;
    plan.read_back(OUTPUT)?;
    if passes.keep_all {
        keep_all(passes, &mut plan)?;
    }
    Ok(plan)
}

/// Reads every block's output back as planes.
fn keep_all(passes: &Passes<'_>, plan: &mut Plan) -> Result<()> {
    let sizes = passes.network.resolutions(passes.size.map(|extent| extent as usize));
    for (block, size) in passes.network.blocks.iter().zip(sizes) {
        if block.shape.op == Op::Conv1x1 {
            continue;
        }
        let count = |value: usize| u32::try_from(value).unwrap_or(u32::MAX);
        let ([rows, columns], outputs) = (size.map(count), count(block.shape.outputs));
        let planes = planes_name(&block.shape.name);
        plan.product(&planes, u64::from(rows) * u64::from(columns) * u64::from(outputs) * 4)?;
        plan.read_back(&planes)?;
        let sizes =
            [("WIDTH", columns), ("HEIGHT", rows), ("SOURCE_WIDTH", columns), ("SOURCE_HEIGHT", rows)];
        let label = format!("net/{}/unpack", block.shape.name);
        let tensor = format!("net/{}", block.shape.name);
        let text = Kernel::Unpack.text(label, passes.backend, &sizes);
        let grid = Invocations::area(rows * columns, outputs / 4);
        plan.step(text, grid, &[("source", &tensor), ("planes", &planes)])?;
    }
    Ok(())
}
