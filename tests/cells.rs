//! Cells for map reliability: `limpid targets --map` and `weights/train_map.py`, from recording to weight file.

use std::path::{Path, PathBuf};
use std::process::Command;

use limpid::stage::camera::map_reliability::{INPUTS, MapReliability};
use safetensors::{Dtype, SafeTensors};

use crate::sim::record_small_room;
use crate::support::gpu::skipped;

/// Cells of a short recording, and the file's bytes.
fn cells(folder: &Path) -> (PathBuf, Vec<u8>) {
    let recording = folder.join("room-L1-1.mcap");
    record_small_room(&recording, 12);
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.arg("targets").arg("--map").arg(&recording).arg("-o").arg(folder.join("cells"));
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let file = folder.join("cells/map-cells.safetensors");
    let bytes = std::fs::read(&file).unwrap();
    (file, bytes)
}

#[test]
fn cells_of_a_drive_have_the_inputs_and_the_truth_of_a_room() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (_, bytes) = cells(folder.path());
    let (_, header) = SafeTensors::read_metadata(&bytes).unwrap();
    let metadata = header.metadata().clone().unwrap();
    assert_eq!(metadata["inputs"], INPUTS.join(","));
    assert_eq!(metadata["recordings"], "room-L1-1");
    let file = SafeTensors::deserialize(&bytes).unwrap();
    let column = |name: &str| file.tensor(name).unwrap();
    let inputs = column("inputs");
    let [count, width] = inputs.shape() else { panic!("{:?}", inputs.shape()) };
    assert_eq!((inputs.dtype(), *width), (Dtype::F32, INPUTS.len()));
    assert!(*count > 500, "{count}");
    assert!(inputs.data().chunks_exact(4).all(|b| f32::from_le_bytes(b.try_into().unwrap()).is_finite()));

    let solid = column("solid").data();
    let found = solid.iter().filter(|solid| **solid == 1).count();
    assert!(found > 20 && found < count - 20, "{found} of {count}");
    // An obstacle in the open would block a disc of free cells; a solid cell blocks nothing more.
    let blocks: Vec<u16> =
        column("blocks").data().chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    let radius = limpid::Config::default().inflation_radius_m / limpid::Config::default().resolution_m;
    let disc = std::f64::consts::PI * (radius + 1.0).powi(2);
    assert!(blocks.iter().all(|&blocks| f64::from(blocks) < disc));
    assert!(blocks.iter().zip(solid).all(|(&blocks, &solid)| solid == 0 || blocks == 0));
    assert!(blocks.iter().any(|&blocks| blocks > 0));
    // Nobody walks there.
    assert!(column("changes").data().iter().all(|&changes| changes == 0));
}

#[test]
fn a_training_repeats_its_file_and_tells_solid_from_free() {
    let wanted = "import numpy, safetensors";
    let found = Command::new("python3").args(["-c", wanted]).output().is_ok_and(|o| o.status.success());
    if skipped() || !found {
        eprintln!("skipped: no GPU, or `python3 -c \"{wanted}\"` fails");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (cells, _) = cells(folder.path());
    let train = |name: &str| {
        let file = folder.path().join(name);
        let mut command = Command::new("python3");
        command.arg("weights/train_map.py").arg(&cells).arg("--validate").arg(&cells);
        command.arg("-o").arg(&file).args(["--steps", "300"]).current_dir(env!("CARGO_MANIFEST_DIR"));
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        (std::fs::read(file).unwrap(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (first, log) = train("first.safetensors");
    assert_eq!(first, train("again.safetensors").0);
    MapReliability::from_bytes(&first).unwrap();
    // The row of the trained bias: at L1 most obstacles are found.
    let row = log.lines().find(|line| line.starts_with("| +0.00")).unwrap();
    let recall: f64 = row.split('|').nth(2).unwrap().split(',').next().unwrap().trim().parse().unwrap();
    assert!(recall > 0.8, "{log}");
}
