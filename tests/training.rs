//! `weights/train.py` from simulated recording to weight file, where Python has what it needs.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use limpid::network::weights::Network;
use safetensors::SafeTensors;

use crate::sim::record_small_room;
use crate::support::gpu::skipped;

/// Weights that were folded, unfolded and folded again, beside the largest.
const ROUNDING: f32 = 1e-5;

fn python(arguments: &[&str]) -> Output {
    let mut command = Command::new("python3");
    command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap()
}

/// Says so where Python or one of the packages is missing.
fn without_torch() -> bool {
    let wanted = "import numpy, safetensors, sklearn, torch";
    let found = Command::new("python3").args(["-c", wanted]).output().is_ok_and(|o| o.status.success());
    if !found {
        eprintln!("skipped: `python3 -c \"{wanted}\"` fails");
    }
    !found
}

/// Samples of a short recording.
fn samples(folder: &Path) -> PathBuf {
    let recording = folder.join("room.mcap");
    record_small_room(&recording, 8);
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.arg("targets").arg(&recording).args(["--truth", "-o"]).arg(folder);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder.join("room.safetensors")
}

/// A short training; its standard output and the file's bytes.
fn train(samples: &Path, file: &Path, more: &[&str]) -> (String, Vec<u8>) {
    let [samples, output] = [samples, file].map(|path| path.to_str().unwrap());
    let usual =
        ["weights/train.py", samples, "-o", output, "--loss", "bce", "--batch", "2", "--crop", "64", "80"];
    let place = ["--threads", "1", "--report", "8", "--sharpen", "1.5", "--at", "0.2"];
    let output = python(&[&usual[..], &place, more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (String::from_utf8_lossy(&output.stdout).into_owned(), std::fs::read(file).unwrap())
}

/// All numbers of a weight file in the order of their names.
fn numbers(file: &[u8]) -> Vec<f32> {
    let tensors = SafeTensors::deserialize(file).unwrap();
    let mut names: Vec<_> = tensors.names();
    names.sort_unstable();
    let bytes = names.iter().flat_map(|name| tensors.tensor(name).unwrap().data().to_vec());
    bytes.collect::<Vec<_>>().chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn a_training_repeats_itself_and_goes_on_from_its_file() {
    if skipped() || without_torch() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let samples = samples(folder.path());
    let [first, again, other, resumed] =
        ["first", "again", "other", "resumed"].map(|name| folder.path().join(format!("{name}.net")));
    let (log, file) = train(&samples, &first, &["--steps", "16"]);
    let losses = log.lines().filter_map(|line| line.split("loss ").nth(1));
    let losses: Vec<f64> =
        losses.map(|rest| rest.split(';').next().unwrap().trim().parse().unwrap()).collect();
    assert_eq!(losses.len(), 2, "{log}");
    assert!(losses.iter().all(|loss| *loss > 0.0 && loss.is_finite()), "{losses:?}");
    let network = Network::from_bytes(&file).unwrap();
    assert_eq!(
        network.blocks.len(),
        Network::from_bytes(limpid::network::weights::SHIPPED).unwrap().blocks.len()
    );

    assert_eq!(train(&samples, &again, &["--steps", "16"]).1, file, "the same seed gives the same file");
    assert_ne!(train(&samples, &other, &["--steps", "16", "--seed", "2"]).1, file);

    let init = first.to_str().unwrap();
    let (_, unchanged) = train(&samples, &resumed, &["--steps", "0", "--init", init]);
    let (want, got) = (numbers(&file), numbers(&unchanged));
    let largest = want.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
    assert!(largest > 0.1 && want.len() == got.len());
    let off = want.iter().zip(&got).map(|(want, got)| (want - got).abs()).fold(0.0, f32::max);
    assert!(off <= ROUNDING * largest, "{off} beside {largest}");
}
