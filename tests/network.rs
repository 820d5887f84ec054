//! DRM-Net on the GPU against PyTorch and ONNX Runtime, block by block, on every kind of tensor.

use std::collections::HashMap;
use std::path::PathBuf;

use limpid::Error;
use limpid::gpu::Context;
use limpid::network::weights::Network;
use limpid::network::{Backend, BlockOutput, Inference};
use safetensors::SafeTensors;

use crate::reference::network::infer;
use crate::support::compare::{Tolerance, assert_close, compare};
use crate::support::data_dir;
use crate::support::gpu::{context, skipped};
use crate::support::random::Random;

/// Another order of some hundred additions of numbers around 1.
const ROUNDING: Tolerance = Tolerance { absolute: 5e-6, reason: "float32 sums in another order" };

const WEIGHTS: &[u8] = include_bytes!("../testdata/reference/network.safetensors");
const OUTPUTS: &[u8] = include_bytes!("../testdata/reference/network.io.safetensors");

/// Tensors of a file: shape and values.
type Tensors = HashMap<String, (Vec<usize>, Vec<f32>)>;

fn tensors(bytes: &[u8]) -> Tensors {
    let file = SafeTensors::deserialize(bytes).unwrap();
    let values = |data: &[u8]| data.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    file.iter().map(|(name, view)| (name.to_string(), (view.shape().to_vec(), values(view.data())))).collect()
}

fn size(input: &(Vec<usize>, Vec<f32>)) -> [u32; 2] {
    [2, 3].map(|axis| input.0[axis] as u32)
}

fn build(network: &Network, size: [u32; 2], keep_all: bool, backend: Backend) -> limpid::Result<Inference> {
    Inference::build(network.clone(), size, keep_all, backend, &context())
}

/// Compares every block's output with the stored one of its name.
fn compare_blocks(outputs: &[BlockOutput], want: &Tensors, prefix: &str) -> Result<(), String> {
    for BlockOutput { name, shape, values } in outputs {
        let stored = want.get(&format!("{prefix}{name}"));
        let (want_shape, want) = stored.or_else(|| want.get(&format!("{prefix}output"))).unwrap();
        assert_eq!(want_shape[1..], shape[..], "{name}");
        compare(name, values, want, ROUNDING)?;
    }
    Ok(())
}

fn shared(name: &str) -> Option<Vec<u8>> {
    data_dir("../golden").map(|folder: PathBuf| std::fs::read(folder.join(name)).unwrap())
}

#[test]
fn every_block_as_onnx_runtime_has_it() {
    if skipped() {
        return;
    }
    let (network, stored) = (Network::from_bytes(WEIGHTS).unwrap(), tensors(OUTPUTS));
    let input = &stored["input"];
    for backend in Backend::ALL {
        let mut all = build(&network, size(input), true, backend).unwrap();
        let outputs = all.run(&input.1).unwrap();
        assert_eq!(outputs.len(), network.blocks.len());
        compare_blocks(&outputs, &stored, "").unwrap();
        // The head folded into the block before it.
        let outputs = build(&network, size(input), false, backend).unwrap().run(&input.1).unwrap();
        assert_eq!(outputs.len(), 1);
        compare_blocks(&outputs, &stored, "").unwrap();
        // The same bits again.
        assert_eq!(all.run(&input.1).unwrap(), all.run(&input.1).unwrap());
    }
}

#[test]
fn every_block_of_the_papers_network_as_pytorch_has_it() {
    let Some(weights) = shared("drm-net-random.safetensors") else { return };
    let stored = tensors(&shared("drm-net-random-io.safetensors").unwrap());
    if skipped() {
        return;
    }
    let network = Network::from_bytes(&weights).unwrap();
    for backend in Backend::ALL {
        let input = &stored["small.input"];
        let outputs = build(&network, size(input), true, backend).unwrap().run(&input.1).unwrap();
        assert_eq!(outputs.len(), 10);
        compare_blocks(&outputs, &stored, "small.").unwrap();
        let input = &stored["full.input"];
        let outputs = build(&network, size(input), false, backend).unwrap().run(&input.1).unwrap();
        assert_close("full.output", &outputs[0].values, &stored["full.output"].1, ROUNDING);
    }
}

/// `network` with one weight of `block` moved by `by`: the centre tap of input `channel`, or the first output's weight for it.
fn perturbed(network: &Network, block: usize, depthwise: bool, channel: usize, by: f32) -> Network {
    let mut network = network.clone();
    let block = &mut network.blocks[block];
    let convolution = match (depthwise, &mut block.depthwise) {
        (true, Some(depthwise)) => depthwise,
        _ => &mut block.convolution,
    };
    convolution.weight[if depthwise { 9 * channel + 4 } else { channel }] += by;
    network
}

#[test]
fn control_one_perturbed_weight_fails_the_comparison() {
    if skipped() {
        return;
    }
    let (network, stored) = (Network::from_bytes(WEIGHTS).unwrap(), tensors(OUTPUTS));
    let input = &stored["input"];
    let best = Backend::of(&context());
    let mut inference = build(&network, size(input), true, best).unwrap();
    for (block, shape) in network.blocks.iter().enumerate() {
        let others = [false, true].into_iter().filter(|&depthwise| !depthwise || shape.depthwise.is_some());
        for depthwise in others {
            // ReLU silences some channels everywhere; of the first four one speaks.
            let noticed = (0..4).any(|channel| {
                inference.reload(perturbed(&network, block, depthwise, channel, 0.1)).unwrap();
                let outputs = inference.run(&input.1).unwrap();
                let reason = compare_blocks(&outputs, &stored, "");
                reason.is_err_and(|reason| reason.starts_with(&shape.shape.name))
            });
            assert!(noticed, "{} depthwise {depthwise}", shape.shape.name);
        }
    }
    inference.reload(network).unwrap();
    compare_blocks(&inference.run(&input.1).unwrap(), &stored, "").unwrap();
}

#[test]
fn other_weights_compile_nothing() {
    if skipped() {
        return;
    }
    let (network, stored) = (Network::from_bytes(WEIGHTS).unwrap(), tensors(OUTPUTS));
    let input = &stored["input"];
    // A device of its own: what other tests compile meanwhile would count on the shared one.
    let own = Context::open(None, false).unwrap();
    let best = Backend::of(&own);
    let build = |network: &Network, size| Inference::build(network.clone(), size, false, best, &own);
    let other = perturbed(&network, 3, true, 0, 1.0);
    let mut inference = build(&network, size(input)).unwrap();
    let counts = |inference: &Inference| {
        let hal = inference.executor().context().counters().hal;
        [
            hal.compute_pipelines.read(),
            hal.shader_modules.read(),
            hal.texture_views.read(),
            hal.buffers.read(),
        ]
    };
    let before = counts(&inference);
    let tensors_held = if best.textures { before[2] } else { before[3] };
    assert!(before[0] > 5 && tensors_held > 5, "{best:?}: {before:?}");
    inference.reload(other.clone()).unwrap();
    let reloaded = inference.run(&input.1).unwrap();
    assert_eq!(counts(&inference), before);
    let mut fresh = build(&other, size(input)).unwrap();
    assert_eq!(reloaded, fresh.run(&input.1).unwrap());
    // Shader texts carry shapes alone, so that a driver's cache serves any weights.
    let texts = |i: &Inference| {
        i.executor().plan().steps().iter().map(|s| s.shader.source.clone()).collect::<Vec<_>>()
    };
    assert_eq!(texts(&inference), texts(&fresh));
    // The control: another size has other texts.
    assert_ne!(texts(&inference), texts(&build(&other, [8, 8]).unwrap()));
}

#[test]
fn the_twin_agrees_at_every_small_size() {
    if skipped() {
        return;
    }
    let (network, stored) = (Network::from_bytes(WEIGHTS).unwrap(), tensors(OUTPUTS));
    // The twin itself is held against ONNX Runtime.
    let input = &stored["input"];
    for (name, want) in infer(&network, [12, 20], &input.1) {
        let key = if name == "head" { "output" } else { &name };
        assert_close(&name, &want, &stored[key].1, ROUNDING);
    }
    let mut random = Random(3);
    for backend in [Backend::ALL[0], Backend::ALL[3]] {
        for size in [[4, 4], [4, 8], [8, 4], [20, 12]] {
            let count = 5 * size[0] * size[1];
            let input: Vec<f32> = (0..count).map(|_| random.unit()).collect();
            let mut inference = build(&network, size.map(|s| s as u32), true, backend).unwrap();
            for (output, (name, want)) in
                inference.run(&input).unwrap().iter().zip(infer(&network, size, &input))
            {
                assert_eq!(output.name, name);
                assert_close(&name, &output.values, &want, ROUNDING);
            }
        }
    }
}

#[track_caller]
fn refused<T>(result: limpid::Result<T>, part: &str) {
    let error = result.err().expect("refused");
    assert!(matches!(error, Error::Input { .. } | Error::Weights { .. }), "{error}");
    assert!(error.to_string().contains(part), "{error}");
}

#[test]
fn wrong_inputs_are_refused_by_name() {
    if skipped() {
        return;
    }
    let network = Network::from_bytes(WEIGHTS).unwrap();
    let best = Backend::of(&context());
    for size in [[12, 22], [10, 20], [0, 4], [4, 0], [1, 1]] {
        refused(build(&network, size, false, best), "is no multiple of 4 both ways");
    }
    let mut inference = build(&network, [4, 4], false, best).unwrap();
    let good = vec![0.5; 5 * 16];
    refused(inference.run(&good[1..]), "has 79 values where 80 are wanted");
    for (index, value) in [(0, f32::NAN), (79, f32::INFINITY), (33, f32::NEG_INFINITY)] {
        let mut bad = good.clone();
        bad[index] = value;
        refused(inference.run(&bad), &format!("value {index} is {value}"));
    }
    let mut other = network.clone();
    other.blocks[3].shape.outputs = 24;
    refused(inference.reload(other), "has other layers");
    let output = inference.run(&good).unwrap();
    assert!(output[0].values.iter().all(|r| (0.0..=1.0).contains(r)));
}

#[test]
fn reliability_stays_a_share_whatever_the_weights() {
    if skipped() {
        return;
    }
    let network = Network::from_bytes(WEIGHTS).unwrap();
    for backend in [Backend::ALL[0], Backend::ALL[3]] {
        for keep_all in [false, true] {
            let mut inference = build(&network, [4, 8], keep_all, backend).unwrap();
            for factor in [1e30_f32, -1e30, 3.4e38] {
                let mut huge = network.clone();
                for block in &mut huge.blocks {
                    block.convolution.weight.iter_mut().for_each(|w| *w = factor.copysign(*w * factor));
                }
                inference.reload(huge).unwrap();
                let outputs = inference.run(&[0.7; 5 * 32]).unwrap();
                let head = &outputs.last().unwrap().values;
                assert!(head.iter().all(|r| (0.0..=1.0).contains(r)), "{factor}: {head:?}");
            }
        }
    }
}
