//! Outputs that cannot seek: written in one go, or refused before anything runs.

use std::process::{Command, Stdio};

use crate::cli::{ROOM, fails, limpid, succeeds};
use crate::support::gpu::skipped;

const RUN: [&str; 6] = ["run", ROOM, "--method", "range", "--frames", "0..3"];

/// Topics with their numbers of messages, by an MCAP file's index.
fn counts(bytes: &[u8]) -> Vec<(String, u64)> {
    let summary = mcap::Summary::read(bytes).unwrap().expect("an index");
    let counts = summary.stats.expect("counts").channel_message_counts;
    let mut counts: Vec<_> =
        summary.channels.iter().map(|(id, channel)| (channel.topic.clone(), counts[id])).collect();
    counts.sort();
    counts
}

#[test]
#[cfg(unix)]
fn a_pipe_takes_a_whole_file() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let [pipe, file] = ["pipe", "file.mcap"].map(|name| folder.path().join(name));
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let piped = pipe.clone();
    let reader = std::thread::spawn(move || std::fs::read(piped).unwrap());
    succeeds(&limpid(&[&RUN[..], &["-o", pipe.to_str().unwrap()]].concat()));
    let bytes = reader.join().unwrap();
    succeeds(&limpid(&[&RUN[..], &["-o", file.to_str().unwrap()]].concat()));
    let expected = counts(&std::fs::read(&file).unwrap());
    assert!(expected.iter().any(|(topic, count)| topic == "/limpid/costmap" && *count == 3), "{expected:?}");
    assert_eq!(counts(&bytes), expected);
    let read = |bytes: &[u8]| {
        let messages =
            mcap::MessageStream::new(bytes).unwrap().map(|message| message.unwrap().data.into_owned());
        messages.collect::<Vec<_>>()
    };
    assert!(read(&bytes) == read(&std::fs::read(&file).unwrap()), "the same messages in the same order");
}

#[test]
#[cfg(target_os = "linux")]
fn where_limpid_prints_nothing_is_written() {
    for stream in ["/dev/stdout", "/dev/stderr", "/proc/self/fd/1"] {
        fails(&limpid(&[&RUN[..], &["-o", stream]].concat()), 2, &[stream, "prints", "mkfifo"]);
    }
    // A file that standard output goes to is one, too.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("costmap.mcap");
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.args(RUN).args(["-o", path.to_str().unwrap()]).current_dir(env!("CARGO_MANIFEST_DIR"));
    let output =
        command.stdout(std::fs::File::create(&path).unwrap()).stderr(Stdio::piped()).output().unwrap();
    fails(&output, 2, &["prints"]);
    assert_eq!(std::fs::metadata(&path).unwrap().len(), 0);
}
