//! Outputs that are inputs are refused before anything is written; older results survive runs that fail or are stopped.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

use crate::cli::{ROOM, fails, limpid, succeeds};
use crate::read::synthetic::{DEPTH, Recorder, at_ms};
use crate::support::data_dir;
use crate::support::gpu::skipped;

/// A folder with copies of the room's recording, one a hard link and one a symbolic link.
struct Folder {
    folder: TempDir,
}

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let room = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(ROOM)).unwrap();
        fs::create_dir(folder.path().join("bag")).unwrap();
        fs::write(folder.path().join("bag/r.mcap"), room).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().into()
    }

    /// Every file and link below, with its content.
    fn listing(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let (mut all, mut folders) = (Vec::new(), vec![self.folder.path().to_owned()]);
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() && !path.is_symlink() {
                    folders.push(path.clone());
                }
                all.push((path.clone(), fs::read(path).unwrap_or_default()));
            }
        }
        all.sort();
        all
    }

    /// Runs the command with names in this folder for those that begin with `@`; it must refuse and write nothing.
    #[track_caller]
    fn refuses(&self, arguments: &[&str], said: &[&str]) {
        let before = self.listing();
        let named = |argument: &&str| match argument.strip_prefix('@') {
            Some(name) => self.text(name),
            None => (*argument).to_owned(),
        };
        let named: Vec<String> = arguments.iter().map(named).collect();
        let output = limpid(&named.iter().map(String::as_str).collect::<Vec<_>>());
        fails(&output, 2, &["nothing was written"]);
        fails(&output, 2, said);
        assert!(self.listing() == before, "{arguments:?} changed files");
    }
}

#[test]
fn an_output_that_is_the_recording_is_refused_by_every_command() {
    let folder = Folder::new();
    let input = "is that of the input, the recording";
    for arguments in [
        ["run", "@bag/r.mcap", "-o", "@bag/r.mcap"].as_slice(),
        &["run", "@bag/r.mcap", "-o", "@bag/../bag/./r.mcap"],
        &["run", "@bag/r.mcap", "--glass", "--panes", "@bag/r.mcap"],
        &["run", "@bag/r.mcap", "--dump", "@bag/r.mcap"],
        &["run", "@bag/r.mcap", "--png", "@bag/r.mcap"],
        &["bench", "@bag/r.mcap", "--json", "@bag/r.mcap"],
        &["profile", "@bag/r.mcap", "-o", "@bag/r.mcap"],
        &["points", "@bag/r.mcap", "-o", "@bag/r.mcap"],
        &["targets", "@bag/r.mcap", "-o", "@bag/r.mcap"],
        &["eval", "@bag/r.mcap", "--json", "@bag/r.mcap"],
        &["eval", "@bag/r.mcap", "--html", "@bag/r.mcap"],
        &["sim", "@bag/r.mcap", "--save-scene", "@bag/r.mcap"],
        &["sim", "@bag/r.mcap", "-o", "@bag/r.mcap"],
        &["net", "--weights", "@w", "--input", "@bag/r.mcap", "-o", "@bag/r.mcap"],
    ] {
        folder.refuses(arguments, &["the input, "]);
    }
    folder.refuses(&["run", "@bag/r.mcap", "-o", "@bag/r.mcap"], &[input, "-o"]);
}

#[cfg(unix)]
#[test]
fn links_of_any_kind_are_seen_through() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    fs::hard_link(folder.path("bag/r.mcap"), folder.path("hard.mcap")).unwrap();
    symlink("bag/r.mcap", folder.path("soft.mcap")).unwrap();
    symlink("soft.mcap", folder.path("soft-of-soft.mcap")).unwrap();
    symlink("bag", folder.path("way")).unwrap();
    for name in ["@hard.mcap", "@soft.mcap", "@soft-of-soft.mcap", "@way/r.mcap"] {
        folder.refuses(&["run", "@bag/r.mcap", "-o", name], &["is that of the input"]);
        folder.refuses(&["run", name, "-o", "@bag/r.mcap"], &["is that of the input"]);
    }
    // Standard input is a file that may be the output too.
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.args(["run", "/dev/stdin", "-o", &folder.text("bag/r.mcap")]);
    let output = command.stdin(fs::File::open(folder.path("bag/r.mcap")).unwrap()).output().unwrap();
    fails(&output, 2, &["is that of the input"]);
}

#[cfg(unix)]
#[test]
fn nothing_is_written_into_a_folder_that_is_read() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    symlink("bag", folder.path("way")).unwrap();
    fs::hard_link(folder.path("bag/r.mcap"), folder.path("hard.mcap")).unwrap();
    symlink("bag/not-there.mcap", folder.path("dangling.mcap")).unwrap();
    for arguments in [
        ["run", "@bag", "-o", "@bag/out.mcap"].as_slice(),
        &["run", "@bag", "-o", "@way/out.mcap"],
        &["run", "@way", "-o", "@bag/out.mcap"],
        &["run", "@bag", "-o", "@hard.mcap"],
        &["run", "@bag", "-o", "@dangling.mcap"],
        &["run", "@bag", "--map", "@bag"],
        &["run", "@bag", "--map", "@bag/map"],
        &["run", "@bag", "--png", "@bag"],
        &["run", "@bag", "--png", "@way"],
        &["run", "@bag", "--dump", "@bag/dump"],
        &["points", "@bag", "-o", "@bag"],
        &["targets", "@bag", "-o", "@bag/samples"],
        &["eval", "@bag", "--json", "@bag/figures.txt"],
        &["eval", "@bag", "--html", "@bag"],
        &["eval", "@bag", "--keep", "@bag/kept"],
    ] {
        folder.refuses(arguments, &["the input, "]);
    }
}

#[test]
fn a_folder_that_holds_the_input_is_refused_where_it_could_be_overwritten() {
    let folder = Folder::new();
    fs::write(folder.path("bag/000000.ply"), "ply").unwrap();
    fs::create_dir(folder.path("bag/000003")).unwrap();
    fs::write(folder.path("scene.yaml"), "").unwrap();
    folder.refuses(&["points", "@bag/000000.ply", "-o", "@bag"], &["could be overwritten"]);
    folder.refuses(&["run", "@bag/000003/x.exr", "--dump", "@bag"], &["could be overwritten"]);
    folder.refuses(&["sim", "@scene.yaml", "-o", "@."], &["could be overwritten"]);
    // Pictures beside a recording overwrite nothing.
    let beside = limpid(&["points", &folder.text("bag/r.mcap"), "-o", &folder.text("bag")]);
    fails(&beside, 1, &["r.mcap"]);
}

#[test]
fn other_inputs_are_kept_too() {
    let folder = Folder::new();
    fs::write(folder.path("c.yaml"), "tau: 0.3\n").unwrap();
    fs::write(folder.path("scene.yaml"), "").unwrap();
    folder.refuses(&["run", ROOM, "-c", "@c.yaml", "-o", "@c.yaml"], &["the input, -c"]);
    folder.refuses(&["bench", ROOM, "-c", "@c.yaml", "--json", "@c.yaml"], &["the input, -c"]);
    folder.refuses(&["run", ROOM, "-c", "@c.yaml", "--map", "@c"], &["--map", "the input, -c"]);
    folder.refuses(&["run", ROOM, "--weights", "@w.bin", "-o", "@w.bin"], &["the input, weights"]);
    let panes = folder.text("panes.yaml");
    fs::write(folder.path("glass.yaml"), format!("glass_panes: {panes}\n")).unwrap();
    let arguments = ["run", ROOM, "-c", "@glass.yaml", "--glass", "--panes", "@panes.yaml"];
    folder.refuses(&arguments, &["the input, glass_panes"]);
    folder.refuses(&["sim", "@scene.yaml", "--save-scene", "@scene.yaml"], &["the input, the scene"]);
    folder.refuses(&["eval", "@f", "--pairs", "@c.yaml", "--json", "@c.yaml"], &["the input, --pairs"]);
}

#[test]
fn two_outputs_that_are_one_file_are_refused() {
    let folder = Folder::new();
    for arguments in [
        ["run", ROOM, "-o", "@x.yaml", "--map", "@x"].as_slice(),
        &["run", ROOM, "--glass", "--panes", "@x.yaml", "--map", "@x"],
        &["run", ROOM, "--glass", "--panes", "@x", "-o", "@bag/../x"],
        &["run", ROOM, "-o", "@x", "--png", "@x"],
        &["sim", "--seed", "1", "-o", "@x.mcap", "--save-scene", "@x.mcap"],
        &["eval", "--json", "@x", "--html", "@x"],
    ] {
        folder.refuses(arguments, &["is also "]);
    }
    if !skipped() {
        // Nothing is lost in a device.
        succeeds(&limpid(&[
            "run",
            ROOM,
            "--frames",
            "0..1",
            "--method",
            "range",
            "-o",
            "/dev/null",
            "--dump",
            &folder.text("d"),
        ]));
    }
}

#[test]
fn field_output_is_input() {
    let Some(input) = data_dir("field/reference/in.mcap") else { return };
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("r.mcap");
    fs::write(&copy, fs::read(&input).unwrap()).unwrap();
    let name = copy.to_str().unwrap();
    fails(&limpid(&["run", name, "-o", name]), 2, &["r.mcap", "is that of the input"]);
    assert!(fs::read(&copy).unwrap() == fs::read(&input).unwrap());
}

/// What stands in a folder, by name.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn an_old_result_survives_a_run_that_fails_and_nothing_is_left_beside_it() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut recorder = Recorder::new();
    recorder.depth(at_ms(0), 1000);
    let recording = recorder.save();
    for name in ["out.mcap", "map.pgm", "map.yaml"] {
        fs::write(folder.path().join(name), "old").unwrap();
    }
    let [out, map] = ["out.mcap", "map"].map(|name| folder.path().join(name).to_str().unwrap().to_owned());
    let failed = limpid(&["run", recording.path.to_str().unwrap(), "-o", &out, "--map", &map]);
    fails(&failed, 1, &[DEPTH]);
    assert_eq!(names(folder.path()), ["map.pgm", "map.yaml", "out.mcap"]);
    for name in names(folder.path()) {
        assert_eq!(fs::read_to_string(folder.path().join(name)).unwrap(), "old");
    }
    // One that works takes its place.
    succeeds(&limpid(&["run", ROOM, "--frames", "0..2", "--method", "range", "-o", &out, "--map", &map]));
    assert_eq!(names(folder.path()), ["map.pgm", "map.yaml", "out.mcap"]);
    assert!(names(folder.path()).iter().all(|name| fs::read(folder.path().join(name)).unwrap() != b"old"));
}

/// Starts a simulation that would last for hours, stops it after some frames, and gives what it said.
#[cfg(unix)]
fn stopped_simulation(output: &Path) -> Output {
    let corridor =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/corridor.yaml")).unwrap();
    let slow = corridor.replace("step_m: 0.035", "step_m: 0.0001");
    assert!(slow != corridor);
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("slow.yaml");
    fs::write(&scene, slow).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.arg("sim").arg(scene).args(["--size", "64x48", "--frames", "20000", "-o"]);
    let mut child = command.arg(output).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().starts_with("frame    2")));
    let number = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &number]).status().unwrap().success());
    lines.for_each(drop);
    let mut stderr = Vec::new();
    child.stderr.take().unwrap().read_to_end(&mut stderr).unwrap();
    Output { status: child.wait().unwrap(), stdout: Vec::new(), stderr }
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_was_written_and_what_was_there() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sim.mcap");
    fails(&stopped_simulation(&path), 130, &["stopped", "is in", "sim.mcap"]);
    assert_eq!(names(folder.path()), ["sim.mcap"]);
    let first = fs::read(&path).unwrap();
    assert!(first.ends_with(b"\x89MCAP0\r\n"), "a finished MCAP");
    fails(&stopped_simulation(&path), 130, &["stopped", "sim.partial.mcap"]);
    assert_eq!(names(folder.path()), ["sim.mcap", "sim.partial.mcap"]);
    assert!(fs::read(&path).unwrap() == first);
    assert!(fs::read(folder.path().join("sim.partial.mcap")).unwrap().ends_with(b"\x89MCAP0\r\n"));
    // A partial file is never written over, as it may be an input, or the work of hours.
    fails(&stopped_simulation(&path), 130, &["stopped", "sim.partial-2.mcap"]);
}

#[test]
fn no_complaint_of_a_missing_desktop_reaches_the_user() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.arg("info").env_remove("XDG_RUNTIME_DIR").env_remove("WAYLAND_DISPLAY");
    let said = String::from_utf8(command.output().unwrap().stderr).unwrap();
    assert!(!said.contains("XDG_RUNTIME_DIR"), "{said}");
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    let mut child = command.arg("config").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(child.wait().unwrap().success() && said.is_empty(), "{said}");
}
