//! Weight files: the paper's counts, and every way in which a file can be wrong.

use std::collections::HashMap;

use limpid::network::weights::{NATIVE_SIZE, Network};
use safetensors::tensor::TensorView;
use safetensors::{Dtype, serialize};
use serde_json::{Value, json};

use crate::support::data_dir;

/// The paper's network (specification page 1, section 1).
fn architecture() -> Value {
    let down = |name: &str, inputs: u32, outputs: u32| json!({"name": name, "op": "separable", "in": inputs, "out": outputs, "stride": 2});
    let up = |name: &str, inputs: u32, outputs: u32, skip: &str| json!({"name": name, "op": "separable", "in": inputs, "out": outputs, "stride": 1, "upsample": 2, "skip": skip});
    json!([
        {"name": "stem", "op": "conv3x3", "in": 5, "out": 16, "stride": 1},
        down("enc1", 16, 32), down("enc2", 32, 64), down("enc3", 64, 96), down("enc4", 96, 128),
        up("dec3", 224, 96, "enc3"), up("dec2", 160, 64, "enc2"), up("dec1", 96, 32, "enc1"), up("dec0", 48, 16, "stem"),
        {"name": "head", "op": "conv1x1", "in": 16, "out": 1, "stride": 1, "activation": "sigmoid"},
    ])
}

/// A weight file in the making.
#[derive(Clone)]
struct File {
    tensors: HashMap<String, (Dtype, Vec<usize>, Vec<u8>)>,
    metadata: HashMap<String, String>,
}

impl File {
    /// Of `architecture`, with every weight 0.5.
    fn of(architecture: &Value) -> Self {
        let mut tensors = HashMap::new();
        let mut add = |name: String, shape: &[usize]| {
            let count = shape.iter().product::<usize>();
            tensors.insert(name, (Dtype::F32, shape.to_vec(), 0.5_f32.to_le_bytes().repeat(count)));
        };
        for block in architecture.as_array().unwrap() {
            let size = |key: &str| block[key].as_u64().unwrap() as usize;
            let (name, inputs, outputs) = (block["name"].as_str().unwrap(), size("in"), size("out"));
            let mut layer = |name: &str, shape: [usize; 4]| {
                add(format!("{name}.weight"), &shape);
                add(format!("{name}.bias"), &shape[..1]);
            };
            match block["op"].as_str().unwrap() {
                "separable" => {
                    layer(&format!("{name}.dw"), [inputs, 1, 3, 3]);
                    layer(&format!("{name}.pw"), [outputs, inputs, 1, 1]);
                }
                "conv3x3" => layer(name, [outputs, inputs, 3, 3]),
                _ => layer(name, [outputs, inputs, 1, 1]),
            }
        }
        let fixed = [("format", "drm-net"), ("depth_scale_m", "10.0"), ("origin", "made by a test")];
        let mut metadata: HashMap<_, _> = fixed.map(|(key, value)| (key.into(), value.into())).into();
        metadata.insert("architecture".into(), architecture.to_string());
        Self { tensors, metadata }
    }

    fn paper() -> Self {
        Self::of(&architecture())
    }

    fn bytes(&self) -> Vec<u8> {
        let views = self.tensors.iter().map(|(name, (dtype, shape, data))| {
            (name.clone(), TensorView::new(*dtype, shape.clone(), data).unwrap())
        });
        serialize(views, Some(self.metadata.clone())).unwrap()
    }

    fn read(&self) -> limpid::Result<Network> {
        Network::from_bytes(&self.bytes())
    }
}

/// Asserts that the file is refused with a message that holds all of `parts`.
#[track_caller]
fn refused(result: limpid::Result<Network>, parts: &[&str]) {
    let message = result.unwrap_err().to_string();
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
}

/// The paper's network with block `index` changed.
fn with_block(index: usize, key: &str, value: Value) -> File {
    let mut lines = architecture();
    lines[index][key] = value;
    let mut file = File::paper();
    file.metadata.insert("architecture".into(), lines.to_string());
    file
}

#[test]
fn the_papers_counts() {
    let network = File::paper().read().unwrap();
    let weights = |block: usize| {
        let block = &network.blocks[block];
        block.convolution.weight.len() + block.depthwise.as_ref().map_or(0, |d| d.weight.len())
    };
    let counts: Vec<usize> = (0..10).map(weights).collect();
    assert_eq!(counts, [720, 656, 2_336, 6_720, 13_152, 23_520, 11_680, 3_936, 1_200, 16]);
    let table = network.table(NATIVE_SIZE);
    // Biases: 16, (16 + 32), (32 + 64), (64 + 96), (96 + 128), (224 + 96), (160 + 64), (96 + 32), (48 + 16), 1.
    assert!(table.ends_with("| **total** | | | | | 63936 | 1281 | 344.4 |\n"), "{table}");
    assert!(table.contains("| dec3 | separable | 224 | 96 | 30x40 | 23520 | 320 | 28.2 |"), "{table}");
}

#[test]
fn the_shared_random_weights_read() {
    let Some(path) = data_dir("../golden/drm-net-random.safetensors") else { return };
    let network = Network::from_bytes(&std::fs::read(path).unwrap()).unwrap();
    assert!((network.depth_scale_m - 10.0).abs() < 1e-12 && network.blocks.len() == 10);
    assert_eq!(network.table(NATIVE_SIZE), File::paper().read().unwrap().table(NATIVE_SIZE));
}

#[test]
fn other_widths_read_too() {
    let network = File::of(&json!([
        {"name": "stem", "op": "conv3x3", "in": 5, "out": 8, "stride": 1},
        {"name": "down", "op": "separable", "in": 8, "out": 12, "stride": 2},
        {"name": "up", "op": "separable", "in": 20, "out": 4, "stride": 1, "upsample": 2, "skip": "stem"},
        {"name": "head", "op": "conv1x1", "in": 4, "out": 1, "stride": 1, "activation": "sigmoid"},
    ]))
    .read()
    .unwrap();
    assert_eq!(network.resolutions([48, 64]), [[48, 64], [24, 32], [48, 64], [48, 64]]);
}

#[test]
fn tensors_that_are_missing_unknown_or_misshapen_are_named() {
    let mut file = File::paper();
    file.tensors.remove("dec1.pw.bias");
    refused(file.read(), &["tensor `dec1.pw.bias`", "is missing"]);
    let mut file = File::paper();
    let spare = file.tensors["head.bias"].clone();
    file.tensors.insert("dec9.bias".into(), spare);
    refused(file.read(), &["tensor `dec9.bias`", "no block"]);
    let mut file = File::paper();
    file.tensors.get_mut("stem.weight").unwrap().1 = vec![5, 16, 3, 3];
    refused(file.read(), &["tensor `stem.weight`", "[5, 16, 3, 3]", "[16, 5, 3, 3]"]);
    let mut file = File::paper();
    file.tensors.insert("head.bias".into(), (Dtype::F16, vec![1], vec![0; 2]));
    refused(file.read(), &["tensor `head.bias`", "F16, not F32"]);
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for poison in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut file = File::paper();
        file.tensors.get_mut("enc2.dw.weight").unwrap().2[40..44].copy_from_slice(&poison.to_le_bytes());
        refused(file.read(), &["tensor `enc2.dw.weight`", "value 10 is"]);
    }
}

#[test]
fn metadata_that_is_missing_or_wrong_is_refused() {
    for key in ["format", "depth_scale_m", "architecture"] {
        let mut file = File::paper();
        file.metadata.remove(key);
        refused(file.read(), &[&format!("metadata `{key}`"), "is missing"]);
    }
    for (key, value) in
        [("format", "onnx"), ("depth_scale_m", "-1"), ("depth_scale_m", "NaN"), ("architecture", "[")]
    {
        let mut file = File::paper();
        file.metadata.insert(key.into(), value.into());
        refused(file.read(), &[&format!("metadata `{key}`")]);
    }
}

#[test]
fn layers_that_do_not_fit_together_are_refused() {
    refused(with_block(1, "in", json!(12)).read(), &["block `enc1`", "takes 12 channels where 16 come in"]);
    refused(with_block(0, "out", json!(18)).read(), &["block `stem`", "18 outputs"]);
    refused(with_block(5, "skip", json!("enc9")).read(), &["block `dec3`", "`enc9`"]);
    refused(with_block(5, "skip", json!("enc2")).read(), &["block `dec3`", "`enc2`", "another resolution"]);
    refused(with_block(2, "stride", json!(3)).read(), &["block `enc2`", "stride 3"]);
    refused(with_block(2, "name", json!("enc1")).read(), &["block `enc1`", "twice"]);
    refused(with_block(9, "activation", json!("relu")).read(), &["block `head`", "sigmoid"]);
    refused(with_block(3, "dilation", json!(2)).read(), &["metadata `architecture`", "dilation"]);
    let mut file = File::paper();
    file.metadata.insert("architecture".into(), "[]".into());
    refused(file.read(), &["metadata `architecture`"]);
}

#[test]
fn files_that_are_no_safetensors_are_refused() {
    let whole = File::paper().bytes();
    for end in [0, 7, 8, 100, whole.len() / 2, whole.len() - 1] {
        refused(Network::from_bytes(&whole[..end]), &["file", "no safetensors"]);
    }
    let mut huge = whole.clone();
    huge[..8].copy_from_slice(&(1_u64 << 60).to_le_bytes());
    refused(Network::from_bytes(&huge), &["file", "no safetensors"]);
    refused(Network::from_bytes(b"\x89PNG\r\n\x1a\n and so on"), &["file", "no safetensors"]);
}
