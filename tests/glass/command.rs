//! `limpid eval` on labelled scans as a user meets it.

use std::path::Path;
use std::process::{Command, Output};

use limpid::map::glass::PointClass;
use limpid::output::save_scan;
use serde_json::Value;

use crate::support::glass_room::GlassRoom;
use crate::support::gpu::skipped;

fn eval(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.arg("eval").args(arguments).output().unwrap()
}

#[track_caller]
fn fails(arguments: &[&str], parts: &[&str]) {
    let output = eval(arguments);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && !text.contains("panicked"), "{text}");
    assert!(parts.iter().all(|part| text.contains(part)), "{text}");
}

/// Labels as 3DRef numbers them.
fn label(class: PointClass) -> u32 {
    match class {
        PointClass::Unlabelled => 0,
        PointClass::Inside => 1,
        PointClass::Glass => 2,
        PointClass::Reflection => 5,
        PointClass::Outside => 6,
    }
}

/// Files are stamped by their names.
const NAMES: [&str; 2] = ["1700000000.000000.ply", "1700000000.100000.ply"];

/// Two scans of the analytic room in a folder, 0.1 s apart; `labelled`: with their true classes.
fn write_scans(folder: &Path, labelled: bool) {
    for name in NAMES {
        let (mut scan, truth) = GlassRoom { yaw: 0.0, ..GlassRoom::default() }.scan();
        scan.columns.label = labelled;
        scan.points.iter_mut().zip(&truth).for_each(|(point, truth)| point.label = label(truth.class));
        save_scan(&folder.join(name), &scan).unwrap();
    }
}

#[test]
fn a_folder_of_labelled_scans_gives_a_table_and_figures() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    write_scans(folder.path(), true);
    let [json, poses] = ["scores.json", "poses.txt"].map(|name| folder.path().join(name));
    std::fs::write(&poses, "1700000000.0 0 0 0 0 0 0 1\n1700000000.1 0 0 0 0 0 0 1\n").unwrap();
    let [input, json_path, poses_path] = [folder.path(), &json, &poses].map(|path| path.to_str().unwrap());
    for memory in [true, false] {
        let switch: &[&str] = if memory { &["--poses", poses_path] } else { &["--memory", "off"] };
        let output = eval(&[&[input, "--json", json_path], switch].concat());
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let words = if memory { "2 scans, with memory" } else { "2 scans, every scan by itself" };
        assert!(text.contains(words) && text.contains("baseline"), "{text}");
        let figures: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
        let figure = |path: &str| {
            let value = figures.pointer(path).and_then(Value::as_f64);
            value.unwrap_or_else(|| panic!("{path}: {figures}"))
        };
        for class in ["inside", "glass", "reflection", "outside"] {
            // Reflections of what the sensor does not see directly stay open: they cost recall, and no precision.
            for (score, least) in [("precision", 0.95), ("recall", 0.55), ("iou", 0.55)] {
                assert!(figure(&format!("/classes/{class}/{score}")) > least, "{class} {score}: {figures}");
            }
        }
        assert!(figure("/reflections_left") < 0.05 && figure("/normal_lost") < 0.01, "{figures}");
        assert!(figure("/mirrored_within_0_2_m") > 0.5 && figure("/ms_per_scan") > 0.0, "{figures}");
        assert_eq!((figure("/panes"), figure("/scans"), &figures["memory"]), (1.0, 2.0, &memory.into()));
        // The baseline loses what is really there behind the glass.
        assert_eq!(figure("/baseline/classes/outside/iou"), 0.0);
        assert!(figure("/baseline/reflections_left") < 0.01, "{figures}");
    }
}

#[test]
fn one_file_is_scored_and_memory_without_poses_is_said_to_be_off() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    write_scans(folder.path(), true);
    let output = eval(&[folder.path().join(NAMES[1]).to_str().unwrap()]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("no poses") && text.contains("1 scans, every scan by itself"), "{text}");
}

#[test]
fn scans_that_cannot_be_scored_are_refused_by_name() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().to_str().unwrap().to_owned();
    write_scans(folder.path(), false);
    fails(&[&input, "--memory", "off"], &["2 scans without labels"]);
    write_scans(folder.path(), true);
    let poses = folder.path().join("poses.txt");
    let poses_path = poses.to_str().unwrap();
    std::fs::write(&poses, "7.0 0 0 0 0 0 0 1\n").unwrap();
    fails(&[&input, "--poses", poses_path], &["2 without a pose"]);
    std::fs::write(&poses, "7.0 0 0\n").unwrap();
    fails(&[&input, "--poses", poses_path], &["poses.txt"]);
    fails(&[&input, "--poses", "missing.txt"], &["missing.txt"]);
    let broken = folder.path().join("broken.ply");
    std::fs::write(&broken, "ply\nformat ascii 1.0\nend_header\n").unwrap();
    fails(&[broken.to_str().unwrap(), "--memory", "off"], &["broken.ply", "vertex"]);
}
