//! `limpid net`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use clap::Args;
use limpid::network::weights::{INPUT_CHANNELS, NATIVE_SIZE, Network};
use limpid::network::{BlockOutput, Inference};
use limpid::output::save_file;
use limpid::{Error, Result};
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};

use super::paths::Paths;

#[derive(Debug, Args)]
pub(crate) struct NetArguments {
    /// DRM-Net's weights (safetensors)
    #[arg(long, value_name = "FILE")]
    weights: PathBuf,
    /// Run the network on the tensor `input` of this safetensors file: 1 x 5 x rows x columns of R, G, B, depth and change
    /// of depth (float32)
    #[arg(long, value_name = "FILE", requires = "output")]
    input: Option<PathBuf>,
    /// Write the tensor `output` (1 x 1 x rows x columns) to this safetensors file
    #[arg(short, long, value_name = "FILE", requires = "input")]
    output: Option<PathBuf>,
    /// Write every block's output too, under its name
    #[arg(long, requires = "input")]
    all: bool,
    /// Part of the adapter's name [default: LIMPID_ADAPTER, else the best]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

pub(crate) fn execute(arguments: &NetArguments) -> Result<()> {
    let paths = Paths::default().reads("--weights", &arguments.weights);
    let paths = paths.may_read("--input", arguments.input.as_deref());
    paths.may_write("--output", arguments.output.as_deref()).check()?;
    let network = Network::read(&arguments.weights)?;
    match (&arguments.input, &arguments.output) {
        (Some(input), Some(output)) => infer(arguments, network, input, output),
        _ => {
            println!("origin: {}\ndepth scale: {} m\n", network.origin, network.depth_scale_m);
            print!("{}", network.table(NATIVE_SIZE));
            Ok(())
        }
    }
}

fn infer(arguments: &NetArguments, network: Network, input: &Path, output: &Path) -> Result<()> {
    let bytes = std::fs::read(input).map_err(Error::file(input))?;
    let (size, values) = read_input(&bytes)?;
    let mut inference = Inference::open(network, size, arguments.all, arguments.adapter.as_deref())?;
    println!("adapter: {}", inference.describe());
    let outputs = inference.run(&values)?;
    write_outputs(&outputs, output)?;
    for BlockOutput { name, shape, values } in &outputs {
        let (least, most) = values.iter().fold((f32::MAX, f32::MIN), |(a, b), &v| (a.min(v), b.max(v)));
        println!("{name}: {} x {} x {} in [{least}, {most}]", shape[0], shape[1], shape[2]);
    }
    Ok(())
}

/// Rows and columns, and the values of tensor `input`.
fn read_input(bytes: &[u8]) -> Result<([u32; 2], Vec<f32>)> {
    let bad = |reason: String| Error::Input { what: "tensor `input`".into(), reason };
    let tensors = SafeTensors::deserialize(bytes)
        .map_err(|e| bad(format!("cannot be read: no safetensors file: {e}")))?;
    let view = tensors
        .tensor("input")
        .map_err(|_| bad(format!("is missing; the file has {:?}", tensors.names())))?;
    let &[1, INPUT_CHANNELS, rows, columns] = view.shape() else {
        return Err(bad(format!("has shape {:?}, not 1 x {INPUT_CHANNELS} x rows x columns", view.shape())));
    };
    if view.dtype() != Dtype::F32 {
        return Err(bad(format!("is {:?}, not F32", view.dtype())));
    }
    let extent = |value: usize| u32::try_from(value).map_err(|_| bad(format!("is {value} wide")));
    let words = view.data().chunks_exact(4);
    let values = words.map(|word| f32::from_le_bytes([word[0], word[1], word[2], word[3]])).collect();
    Ok(([extent(rows)?, extent(columns)?], values))
}

/// The last as `output`, all but it under the names of their blocks (and the last under its own, where there are others).
fn write_outputs(outputs: &[BlockOutput], path: &Path) -> Result<()> {
    let mut named: Vec<(&str, &BlockOutput)> = outputs.iter().map(|o| (o.name.as_str(), o)).collect();
    if let Some(last) = outputs.last() {
        named.push(("output", last));
    }
    if outputs.len() == 1 {
        named.remove(0);
    }
    let bad =
        |e: safetensors::SafeTensorError| Error::Input { what: "outputs".into(), reason: e.to_string() };
    let mut tensors = HashMap::new();
    for (name, BlockOutput { shape: [channels, rows, columns], values, .. }) in named {
        let shape = vec![1, *channels, *rows, *columns];
        let view = TensorView::new(Dtype::F32, shape, bytemuck::cast_slice(values)).map_err(bad)?;
        tensors.insert(name, view);
    }
    let bytes = safetensors::serialize(&tensors, None).map_err(bad)?;
    save_file(path, &bytes)
}
