//! The command as a user meets it: exit codes, messages, files.

use std::path::Path;
use std::process::{Command, Output};

use crate::support::gpu::skipped;

pub(crate) fn limpid(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("LIMPID_ADAPTER");
    command
}

/// Asserts the exit code and that standard error holds all of `parts`.
#[track_caller]
pub(crate) fn fails(output: &Output, code: i32, parts: &[&str]) {
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{text}");
    assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    assert!(!text.contains("panicked"), "{text}");
}

#[track_caller]
pub(crate) fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub(crate) fn json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

pub(crate) const ROOM: &str = "testdata/room.mcap";

#[test]
fn wrong_usage_and_wrong_configuration_exit_with_2() {
    fails(&limpid(&["run"]), 2, &["Usage"]);
    fails(&limpid(&["run", ROOM, "--frames", "5..2"]), 2, &["`5..2` is not of the form"]);
    fails(&limpid(&["run", ROOM, "--method", "best"]), 2, &["possible values", "range"]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("limpid.yaml");
    std::fs::write(&file, "taux: 0.3\n").unwrap();
    let said = ["taux", "nearest key is `tau`", "line 1", "limpid.yaml"];
    fails(&limpid(&["run", ROOM, "-c", file.to_str().unwrap()]), 2, &said);
    std::fs::write(&file, "sensors: [front]\nfront: {kind: sonar}\n").unwrap();
    let said = ["`front.kind`", "sonar", "line 2", "limpid.yaml"];
    fails(&limpid(&["run", ROOM, "-c", file.to_str().unwrap()]), 2, &said);
    std::fs::write(&file, "tau: [0.3\n").unwrap();
    fails(&limpid(&["run", ROOM, "-c", file.to_str().unwrap()]), 2, &["line 1", "limpid.yaml"]);
    std::fs::write(&file, "tau: 3\n").unwrap();
    fails(&limpid(&["run", ROOM, "-c", file.to_str().unwrap()]), 2, &["`tau`", "not in [0, 1]"]);
}

#[test]
fn config_prints_a_robot_with_several_sensors() {
    let printed = String::from_utf8(limpid(&["config", "--robot"]).stdout).unwrap();
    let robot = limpid::Config::from_yaml(&printed).unwrap();
    let names: Vec<_> = robot.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
    assert_eq!(names, ["front", "rear", "top"]);
}

#[test]
fn inputs_that_cannot_be_used_exit_with_1_and_say_why() {
    fails(&limpid(&["run", "no/such/file.mcap"]), 1, &["no/such/file.mcap"]);
    fails(&limpid(&["run", "Cargo.toml"]), 1, &["Cargo.toml", "MCAP"]);
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().join("empty.mcap");
    std::fs::write(&empty, b"").unwrap();
    fails(&limpid(&["run", empty.to_str().unwrap()]), 1, &["empty.mcap"]);
    if !skipped() {
        fails(&limpid(&["run", ROOM, "--frames", "900.."]), 1, &["none of its 30 depth images"]);
    }
}

#[test]
fn without_an_adapter_the_message_says_what_to_install() {
    let mut without = command(&["info"]);
    without.env("VK_DRIVER_FILES", "/nonexistent.json").env("VK_ICD_FILENAMES", "/nonexistent.json");
    fails(&without.output().unwrap(), 1, &["no GPU adapter", "Found: none", "mesa-vulkan-drivers"]);
    if !skipped() {
        let text = limpid(&["run", ROOM, "--adapter", "Voodoo 2"]);
        fails(&text, 1, &["no GPU adapter named `Voodoo 2`", "Found: "]);
    }
}

#[test]
fn an_unwritable_output_is_named() {
    fails(&limpid(&["run", ROOM, "-o", "/proc/limpid.mcap"]), 1, &["/proc/limpid.mcap"]);
    fails(&limpid(&["run", ROOM, "--png", "no/such/parent/pictures"]), 1, &["no/such/parent/pictures"]);
}

#[test]
fn a_cut_off_recording_gives_the_frames_before_the_cut() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let cut = folder.path().join("cut.mcap");
    let whole = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(ROOM)).unwrap();
    std::fs::write(&cut, &whole[..whole.len() * 2 / 3]).unwrap();
    let text = succeeds(&limpid(&["run", cut.to_str().unwrap()]));
    let frames: u32 = text
        .lines()
        .find_map(|line| line.split_once(" frames and scans in ").and_then(|(count, _)| count.parse().ok()))
        .unwrap();
    assert!((10..30).contains(&frames), "{text}");
    assert!(text.contains("note: ") && text.contains("cut"), "{text}");
}

#[test]
fn run_writes_what_it_is_asked_for() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [mcap, png, dump, map] = ["out.mcap", "png", "dump", "map"].map(|name| folder.path().join(name));
    let text = succeeds(&limpid(&[
        "run",
        ROOM,
        "--frames",
        "3..6",
        "--timing",
        "-o",
        mcap.to_str().unwrap(),
        "--png",
        png.to_str().unwrap(),
        "--dump",
        dump.to_str().unwrap(),
        "--map",
        map.to_str().unwrap(),
    ]));
    assert!(text.contains("3 frames and scans in") && text.contains("adapter: "), "{text}");
    assert!(std::fs::read(&mcap).unwrap().ends_with(b"\x89MCAP0\r\n"), "a finished MCAP");
    for number in ["000003", "000004", "000005"] {
        assert!(png.join(format!("{number}-costmap.png")).exists());
        let frame = json(&dump.join(number).join("frame.json"));
        assert_eq!(frame["state"], "OK");
        assert_eq!(frame["counters"]["pixels"], 160 * 120);
        assert!(frame["pass_ms"]["back_project"].as_f64().unwrap() > 0.0, "{frame}");
        for buffer in ["depth_m", "reliability", "evidence", "occupancy", "occupied", "costmap"] {
            assert!(dump.join(number).join(format!("{buffer}.exr")).exists(), "{buffer}");
        }
    }
    assert!(!dump.join("000006").exists() && !dump.join("000002").exists());
    assert!(map.with_extension("pgm").exists() && map.with_extension("yaml").exists());
}

#[test]
fn bench_and_profile_write_json() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [figures, trace] = ["bench.json", "trace.json"].map(|name| folder.path().join(name));
    let table = succeeds(&limpid(&["bench", ROOM, "--samples", "5", "--json", figures.to_str().unwrap()]));
    assert!(table.contains("| back_project |") && table.contains("**frame, wall**"), "{table}");
    let figures = json(&figures);
    assert!(figures["wall"]["median_ms"].as_f64().unwrap() > 0.0);
    assert_eq!(figures["wall"]["samples"], 5);
    succeeds(&limpid(&["profile", ROOM, "--samples", "4", "-o", trace.to_str().unwrap()]));
    let trace = json(&trace);
    let events = trace["traceEvents"].as_array().unwrap();
    let spans = |name: &str| events.iter().filter(|e| e["ph"] == "X" && e["name"] == name).count();
    assert_eq!(["submit", "receive", "update"].map(spans), [4, 4, 4]);
    let complete = |e: &serde_json::Value| e["ts"].is_number() && e["dur"].as_f64().unwrap() >= 0.0;
    assert!(events.iter().filter(|e| e["ph"] == "X").all(complete));
}

#[test]
fn config_prints_a_file_that_reads_back() {
    let text = succeeds(&limpid(&["config"]));
    assert_eq!(limpid::Config::from_yaml(&text).unwrap(), limpid::Config::default());
    let missing = limpid(&["run", ROOM, "-c", "no-such.yaml"]);
    fails(&missing, 2, &["no-such.yaml"]);
}
