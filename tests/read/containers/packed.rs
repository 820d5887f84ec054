//! Files and messages that are packed with zstd.

use super::{FRAMES, Message, db3, folder, mcap, messages, metadata, read, refused, says, whole};

/// As rosbag2 and `zstd` name them.
const ENDS: [&str; 2] = ["zstd", "zst"];

fn pack(bytes: &[u8]) -> Vec<u8> {
    zstd::encode_all(bytes, 3).unwrap()
}

#[test]
fn files_packed_as_a_whole_are_unpacked_as_they_are_read() {
    for end in ENDS {
        let [file, db] = [format!("run_0.mcap.{end}"), format!("run_0.db3.{end}")];
        let packed = folder(&[(&file, pack(&mcap(&messages()))), (&db, pack(&db3(&messages())))]);
        whole(&packed.path().join(&file));
        whole(&packed.path().join(&db));
        let bag = folder(&[(&file, pack(&mcap(&messages()))), ("metadata.yaml", metadata(&[&file]).into())]);
        whole(bag.path());
    }
}

#[test]
fn a_packed_file_may_have_several_frames() {
    let plain = mcap(&messages());
    let (first, second) = plain.split_at(plain.len() / 2);
    let packed = folder(&[("run.mcap.zstd", [pack(first), pack(second)].concat())]);
    whole(&packed.path().join("run.mcap.zstd"));
}

#[test]
fn packed_messages_are_unpacked() {
    let packed: Vec<Message> = messages().into_iter().map(Message::packed).collect();
    let files = folder(&[("run.mcap", mcap(&packed)), ("run.db3", db3(&packed))]);
    whole(&files.path().join("run.mcap"));
    whole(&files.path().join("run.db3"));
}

#[test]
fn a_damaged_message_is_counted_and_costs_itself() {
    let mut packed: Vec<Message> = messages().into_iter().map(Message::packed).collect();
    let image = packed.iter_mut().rev().find(|message| message.type_name.ends_with("Image")).unwrap();
    image.data.truncate(20);
    let files = folder(&[("run.mcap", mcap(&packed))]);
    let (frames, report) = read(&files.path().join("run.mcap")).unwrap();
    assert_eq!(frames.len(), usize::from(FRAMES) - 1);
    let [skipped] = &report.skipped[..] else { panic!("{report:?}") };
    assert!(
        skipped.count == 1 && skipped.source.contains("depth") && skipped.reason.contains("zstd"),
        "{skipped:?}"
    );
}

#[test]
fn a_packed_file_that_is_cut_off_gives_what_comes_before() {
    // Random samples, so that the packed bytes are spread over the recording.
    let mut state = 1_u32;
    let mut messages = messages();
    for message in messages.iter_mut().filter(|message| message.type_name.ends_with("Image")) {
        let start = message.data.len() - 24;
        for byte in &mut message.data[start..] {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *byte = (state >> 24) as u8;
        }
    }
    let whole = mcap(&messages);
    // In small frames, as zstd gives a frame's first bytes only with its first block.
    let packed: Vec<u8> = whole.chunks(500).flat_map(pack).collect();
    let mut most = 0;
    for cut in (packed.len() / 2..packed.len()).step_by(97) {
        let files = folder(&[("run.mcap.zstd", packed[..cut].to_vec())]);
        let (frames, report) = read(&files.path().join("run.mcap.zstd")).unwrap();
        assert!(frames.len() >= most, "more is there, not less, cut at {cut}");
        most = frames.len();
        if most < usize::from(FRAMES) {
            says(&report.notes, &["cut off or damaged"]);
        }
    }
    assert_eq!(most, usize::from(FRAMES));
}

#[test]
fn packed_files_of_other_kinds_say_what_to_do() {
    let files = folder(&[
        ("drive.pcap.zst", pack(&[0xd4, 0xc3, 0xb2, 0xa1, 0, 0])),
        ("bad.mcap.zstd", pack(b"x")[..6].into()),
    ]);
    refused(&files.path().join("drive.pcap.zst"), &["drive.pcap.zst", "packed with zstd", "unzstd"]);
    refused(&files.path().join("bad.mcap.zstd"), &["bad.mcap.zstd", "zstd"]);
    for (name, start, word) in [
        ("a.mcap.gz", &[0x1f, 0x8b, 8][..], "gunzip"),
        ("a.bag.bz2", b"BZh9", "bunzip2"),
        ("a.zip", b"PK\x03\x04", "unzip"),
    ] {
        refused(&folder(&[(name, start.to_vec())]).path().join(name), &[name, word]);
    }
}
