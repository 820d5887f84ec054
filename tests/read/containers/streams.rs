//! What is not a file: it is refused by name, and never waited for.

use super::{folder, mcap, messages, refused};
use crate::cli::{fails, limpid};

#[test]
fn folders_in_place_of_files_are_named() {
    let folder = folder(&[]);
    refused(folder.path(), &["depth.txt"]);
    refused("-".as_ref(), &["standard input", "read more than once"]);
    fails(&limpid(&["run", "-"]), 1, &["standard input", "read more than once"]);
}

#[test]
#[cfg(unix)]
fn pipes_and_devices_are_named() {
    let folder = folder(&[]);
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let bag = folder.path().join("bag");
    std::fs::create_dir(&bag).unwrap();
    std::os::unix::fs::symlink(&pipe, bag.join("run_0.mcap")).unwrap();
    std::fs::write(bag.join("run_1.mcap"), mcap(&messages())).unwrap();
    for verb in ["run", "points"] {
        let more = if verb == "points" { vec!["-o", "nowhere"] } else { vec![] };
        for (path, what) in [(pipe.to_str().unwrap(), "a pipe"), ("/dev/null", "a device")] {
            let arguments = [vec![verb, path], more.clone()].concat();
            fails(&limpid(&arguments), 1, &[path, what, "read more than once", "save it as a file"]);
        }
    }
    // In a folder it is no bag.
    super::whole(&bag);
    std::fs::write(bag.join("metadata.yaml"), super::metadata(&["run_0.mcap", "run_1.mcap"])).unwrap();
    let (_, report) = super::read(&bag).unwrap();
    super::says(&report.notes, &["run_0.mcap", "missing"]);
    let socket = folder.path().join("socket");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    refused(&socket, &["a socket"]);
}

#[test]
#[cfg(target_os = "linux")]
fn standard_input_is_refused_where_it_is_a_pipe() {
    use std::process::{Command, Stdio};
    let run = |stdin: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
        command.args(["points", "/dev/stdin", "-o", "nowhere"]).stdin(stdin).output().unwrap()
    };
    fails(&run(Stdio::piped()), 1, &["/dev/stdin", "a pipe", "read more than once"]);
}
