//! DRM-Net at the command line: `limpid net` and method drm.

use std::path::{Path, PathBuf};

use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};

use crate::cli::{ROOM, fails, json, limpid, succeeds};
use crate::support::compare::{Tolerance, assert_close};
use crate::support::gpu::skipped;

const WEIGHTS: &str = "testdata/reference/network.safetensors";
const STORED: &str = "testdata/reference/network.io.safetensors";
const ROUNDING: Tolerance = Tolerance { absolute: 5e-6, reason: "float32 sums in another order" };

fn floats(path: &Path, name: &str) -> (Vec<usize>, Vec<f32>) {
    let bytes = std::fs::read(path).unwrap();
    let file = SafeTensors::deserialize(&bytes).unwrap();
    let view = file.tensor(name).unwrap();
    let values = view.data().chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    (view.shape().to_vec(), values)
}

fn input_file(folder: &Path, name: &str, shape: [usize; 4], value: f32) -> PathBuf {
    let data = value.to_le_bytes().repeat(shape.iter().product());
    let view = TensorView::new(Dtype::F32, shape.to_vec(), &data).unwrap();
    let path = folder.join("input.safetensors");
    std::fs::write(&path, safetensors::serialize([(name, view)], None).unwrap()).unwrap();
    path
}

fn net(input: &Path, output: &Path, more: &[&str]) -> std::process::Output {
    let (input, output) = (input.to_str().unwrap(), output.to_str().unwrap());
    limpid(&[&["net", "--weights", WEIGHTS, "--input", input, "-o", output], more].concat())
}

#[test]
fn net_writes_what_onnx_runtime_gives() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.safetensors");
    succeeds(&net(Path::new(STORED), &out, &[]));
    let (shape, values) = floats(&out, "output");
    assert_eq!(shape, [1, 1, 12, 20]);
    assert_close("output", &values, &floats(Path::new(STORED), "output").1, ROUNDING);

    let text = succeeds(&net(Path::new(STORED), &out, &["--all"]));
    for block in ["stem", "enc1", "enc2", "middle", "dec1", "dec0"] {
        assert!(text.contains(&format!("{block}: ")), "{text}");
        let ((shape, values), (want_shape, want)) = (floats(&out, block), floats(Path::new(STORED), block));
        assert_eq!(shape, want_shape, "{block}");
        assert_close(block, &values, &want, ROUNDING);
    }
}

#[test]
fn net_refuses_inputs_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.safetensors");
    let wrong = |name: &str, shape: [usize; 4], parts: &[&str]| {
        let input = input_file(folder.path(), name, shape, 0.5);
        fails(&net(&input, &out, &[]), 1, parts);
        assert!(!out.exists());
    };
    wrong("image", [1, 5, 12, 20], &["tensor `input`", "missing", "image"]);
    wrong("input", [1, 4, 12, 20], &["tensor `input`", "[1, 4, 12, 20]"]);
    if !skipped() {
        wrong("input", [1, 5, 13, 20], &["network input", "20x13 is no multiple of 4"]);
        for value in [f32::NAN, f32::INFINITY] {
            let input = input_file(folder.path(), "input", [1, 5, 12, 20], value);
            fails(&net(&input, &out, &[]), 1, &["network input", &format!("value 0 is {value}")]);
        }
        // Huge numbers give a reliability that is one.
        succeeds(&net(&input_file(folder.path(), "input", [1, 5, 12, 20], f32::MAX), &out, &[]));
        let values = floats(&out, "output").1;
        assert!(values.iter().all(|r| (0.0..=1.0).contains(r)), "{values:?}");
        std::fs::remove_file(&out).unwrap();
    }
    fails(&net(Path::new("Cargo.toml"), &out, &[]), 1, &["tensor `input`", "no safetensors file"]);
    fails(&limpid(&["net", "--weights", WEIGHTS, "--input", STORED]), 2, &["--output"]);
}

#[test]
fn method_drm_weighs_a_recording_by_a_weight_file() {
    let drm = ["run", ROOM, "--frames", "0..2", "--method", "drm"];
    fails(&limpid(&[&drm[..], &["--weights", "Cargo.toml"]].concat()), 1, &["Cargo.toml"]);
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let dump = folder.path().join("dump");
    let more = ["--weights", WEIGHTS, "--timing", "--dump", dump.to_str().unwrap()];
    succeeds(&limpid(&[&drm[..], &more].concat()));
    let frame = json(&dump.join("000001").join("frame.json"));
    for pass in ["net/resize", "net/stem", "net/dec0", "net/restore", "back_project"] {
        assert!(frame["pass_ms"][pass].as_f64().is_some(), "{pass}: {frame}");
    }
    let low = frame["counters"]["low_reliability"].as_u64().unwrap();
    let without =
        frame["counters"]["pixels"].as_u64().unwrap() - frame["counters"]["valid"].as_u64().unwrap();
    assert!(low >= without, "holes count as unreliable: {frame}");
    assert!(dump.join("000001/reliability.exr").exists());

    let trace = folder.path().join("trace.json");
    let profile = ["profile", ROOM, "--samples", "2", "--method", "drm", "--weights", WEIGHTS];
    succeeds(&limpid(&[&profile[..], &["-o", trace.to_str().unwrap()]].concat()));
    let trace = json(&trace);
    let events = trace["traceEvents"].as_array().unwrap();
    for pass in ["net/stem", "net/middle", "net/dec0"] {
        assert!(events.iter().any(|e| e["ph"] == "X" && e["name"] == pass), "{pass}");
    }
}
