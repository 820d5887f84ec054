//! `limpid eval` as a user meets it.

use std::process::{Command, Output};

use crate::sim::record_small_room;
use crate::support::gpu::skipped;

fn eval(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.arg("eval").args(arguments).current_dir(env!("CARGO_MANIFEST_DIR"));
    command.output().unwrap()
}

#[track_caller]
fn fails(arguments: &[&str], code: i32, parts: &[&str]) {
    let output = eval(arguments);
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{text}");
    assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    assert!(!text.contains("panicked"), "{text}");
}

#[test]
fn a_recording_with_truth_gives_figures_page_and_pictures() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [recording, json, page] = ["drive.mcap", "eval.json", "report"].map(|name| folder.path().join(name));
    record_small_room(&recording, 20);
    let [input, json_path, page_path] = [&recording, &json, &page].map(|path| path.to_str().unwrap());
    let room = "testdata/room.mcap,testdata/config/limpid.yaml";
    let output = eval(&[input, "--json", json_path, "--html", page_path, "--show", room]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("recordings: 1 scenes, 10 frames scored"), "{text}");
    let figures: serde_json::Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    let level = &figures["levels"]["recordings"];
    assert_eq!((&level["scenes"], &level["frames"]), (&1.into(), &10.into()));
    let figure = |method: &str, name: &str| {
        level[method][name].as_f64().unwrap_or_else(|| panic!("{method} {name}: {level}"))
    };
    for method in ["naive", "range", "median", "temporal", "naive_3_hits"] {
        for name in
            ["for", "fsr", "or", "for_strict", "fsr_strict", "hole_rate", "spike_rate", "rmse_m", "auprc"]
        {
            assert!(figure(method, name).is_finite());
            assert_eq!(level[method]["over_scenes"][name]["deviation"], 0.0);
        }
        // Patterned walls are seen well; the map is right where it says something.
        assert!(figure(method, "for") < 0.05 && figure(method, "fsr") > 0.6, "{method}: {level}");
        assert!(figure(method, "or_near") > 0.3, "{method}: {level}");
        assert!(figure(method, "for") + figure(method, "fsr") <= 1.0);
    }
    assert!(figure("naive", "hole_rate") < 0.3 && figure("naive", "spike_rate") < 0.15, "{level}");
    assert!(level["predictors"]["gradient"]["auprc"].as_f64().unwrap() > 0.0);
    let html = std::fs::read_to_string(page.join("index.html")).unwrap();
    assert!(html.contains("drive-mcap.png") && html.contains("naive_3_hits"), "{html}");
    assert!(html.contains("testdata/room.mcap (no ground truth; after "), "{html}");
    let [picture, shown] = ["drive-mcap.png", "shown-testdata-room-mcap.png"]
        .map(|name| image::load_from_memory(&std::fs::read(page.join(name)).unwrap()).unwrap());
    assert!(picture.width() > 1200 && picture.height() > 600);
    assert!(shown.width() >= 800 && shown.height() == picture.height(), "{}", shown.width());
}

#[test]
fn what_was_scored_is_kept_and_recordings_of_generated_scenes_come_under_their_level() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [recording, counts] = ["scene.mcap", "counts"].map(|name| folder.path().join(name));
    let [input, keep] = [&recording, &counts].map(|path| path.to_str().unwrap());
    let mut sim = Command::new(env!("CARGO_BIN_EXE_limpid"));
    sim.args(["sim", "--seed", "6000", "--level", "L0", "--frames", "12", "--size", "160x96", "-o", input]);
    assert!(sim.output().unwrap().status.success());
    let table = || {
        let output = eval(&[input, "--keep", keep]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let first = table();
    assert!(first.contains("L0: 1 scenes, 2 frames scored"), "{first}");
    // The counts are taken from the file, as an altered one shows.
    let file = counts.join("scene-mcap.json");
    let kept = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, kept.replace("\"frames\":2", "\"frames\":7")).unwrap();
    assert!(table().contains("7 frames scored"), "{kept}");
    // Another recording of that name is scored again.
    let other = std::fs::File::options().append(true).open(&recording).unwrap();
    other.set_modified(std::time::SystemTime::UNIX_EPOCH).unwrap();
    assert_eq!(table(), first);
}

#[test]
fn wrong_usage_says_what_is_right() {
    fails(&["--levels", "L7"], 2, &["L7", "L0, L1, L2"]);
    fails(&["--frames", "10"], 2, &["10", "--frames"]);
    fails(&["--quick", "--scenes", "2"], 2, &["--quick"]);
    fails(&["some.mcap", "--scenes", "2"], 2, &["--scenes"]);
    fails(&["--pairs", "list.yaml"], 2, &["INPUTS"]);
    fails(&["--show", "some.mcap"], 2, &["--html"]);
    fails(&["--family", "other"], 2, &["held-out"]);
    fails(&["--size", "801x480", "--scenes", "1"], 2, &["camera.width"]);
    fails(&["--scenes", "1", "--weights", "no/such.safetensors"], 1, &["no/such.safetensors"]);
}

#[test]
fn recordings_without_truth_are_named() {
    let page = tempfile::tempdir().unwrap();
    let page_path = page.path().to_str().unwrap();
    // What is to be shown is looked at before anything is scored.
    fails(&["--show", "no/such.mcap", "--html", page_path], 1, &["no/such.mcap"]);
    fails(&["--show", "testdata/room.mcap,no/such.yaml", "--html", page_path], 1, &["no/such.yaml"]);
    fails(&["testdata/room.mcap"], 1, &["testdata/room.mcap", "no ground truth", "limpid sim"]);
    fails(&["no/such.mcap"], 1, &["no/such.mcap"]);
    fails(&["Cargo.toml"], 1, &["Cargo.toml", "MCAP"]);
    fails(&["testdata/reference"], 1, &["testdata/reference", "depth.txt"]);
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let short = folder.path().join("short.mcap");
    record_small_room(&short, 10);
    fails(&[short.to_str().unwrap()], 1, &["short.mcap", "10 posed frames", "after 10"]);
    // A folder whose truth ends before its frames.
    let tum = folder.path().join("tum");
    record_small_room(&tum, 3);
    let list = tum.join("truth.txt");
    let text = std::fs::read_to_string(&list).unwrap();
    let first = text.lines().find(|line| !line.starts_with('#')).unwrap();
    std::fs::write(&list, format!("{first}\n")).unwrap();
    fails(&[tum.to_str().unwrap()], 1, &["tum", "frame 1", "has no ground truth"]);
    std::fs::remove_file(&list).unwrap();
    fails(&[tum.to_str().unwrap()], 1, &["tum", "no ground truth"]);
}
