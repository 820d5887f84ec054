//! Files that are cut off, damaged, without a summary or empty.

use limpid::Config;
use limpid::input::{LogReader, Recording, open};
use mcap::{Compression, WriteOptions};

use super::synthetic::{DEPTH, DEPTH_INFO, Recorder, Saved, at_ms, save};
use super::{noted, read_mcap};

const FRAMES: u16 = 12;

/// Twelve frames in small chunks.
fn recording(compression: Option<Compression>) -> Vec<u8> {
    let mut recorder = Recorder::compressed(compression);
    for number in 0..FRAMES {
        recorder.depth(at_ms(100 * u64::from(number)), 1000 + number);
    }
    recorder.finish()
}

fn count(saved: &Saved) -> usize {
    read_mcap(saved, &Config::default()).map_or(0, |(frames, _)| frames.len())
}

#[test]
fn every_compression_gives_the_same_frames() {
    let plain = read_mcap(&save(&recording(None)), &Config::default()).unwrap();
    assert_eq!(plain.0.len(), usize::from(FRAMES));
    for compression in [Compression::Zstd, Compression::Lz4] {
        let packed = read_mcap(&save(&recording(Some(compression))), &Config::default()).unwrap();
        assert_eq!(packed, plain, "{compression:?}");
    }
}

/// Depth images that the mcap crate's own reader gives before it fails.
fn depth_messages(bytes: &[u8]) -> usize {
    let messages = mcap::io::MessageReader::new(bytes).map_while(|message| message.ok());
    messages.filter(|message| message.channel.topic == DEPTH).count()
}

#[test]
fn a_cut_off_file_keeps_the_frames_before_the_cut() {
    for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
        let whole = recording(compression);
        assert_eq!(depth_messages(&whole), usize::from(FRAMES));
        for cut in (0..whole.len()).step_by(7) {
            let (found, sure) = (count(&save(&whole[..cut])), depth_messages(&whole[..cut]));
            // An LZ4 block that is stored as it is gives what there is of it.
            let more = usize::from(matches!(compression, Some(Compression::Lz4)));
            assert!((sure..=sure + more).contains(&found), "frames before the cut at {cut}, {compression:?}");
        }
    }
}

#[test]
fn a_cut_off_file_says_where_it_ends() {
    let whole = recording(None);
    let cut = whole.len() / 2;
    let (frames, report) = read_mcap(&save(&whole[..cut]), &Config::default()).unwrap();
    assert!(!frames.is_empty() && frames.len() < usize::from(FRAMES));
    assert!(noted(&report, &format!("ends at byte {cut}")), "{:?}", report.notes);
    assert!(noted(&report, "no summary"), "{:?}", report.notes);
    let (_, report) = read_mcap(&save(&whole), &Config::default()).unwrap();
    assert!(!noted(&report, "cut off"), "{:?}", report.notes);
}

#[test]
fn a_file_without_summary_is_read_in_full() {
    let options =
        WriteOptions::new().compression(None).emit_summary_records(false).emit_summary_offsets(false);
    let mut recorder = Recorder::with(options);
    for number in 0..FRAMES {
        recorder.depth(at_ms(100 * u64::from(number)), 1000 + number);
    }
    let saved = recorder.save();
    assert_eq!(LogReader::mcap(&saved.path, &Config::default()).unwrap().frame_count_hint(), None);
    let (frames, report) = read_mcap(&saved, &Config::default()).unwrap();
    assert_eq!(frames.len(), usize::from(FRAMES));
    assert!(noted(&report, "no summary") && !noted(&report, "cut off"), "{:?}", report.notes);
}

#[test]
fn a_damaged_chunk_costs_its_own_messages_only() {
    for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
        let mut bytes = recording(compression);
        let chunks = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes;
        let middle = &chunks[chunks.len() / 2];
        let inside = usize::try_from(middle.chunk_start_offset + middle.chunk_length - 9).unwrap();
        bytes[inside] ^= 0x55;
        let (frames, report) = read_mcap(&save(&bytes), &Config::default()).unwrap();
        let part = format!("chunk at byte {} is damaged", middle.chunk_start_offset);
        assert!(noted(&report, &part), "{compression:?}: {:?}", report.notes);
        let lost = usize::from(FRAMES) - frames.len();
        assert!((1..=2).contains(&lost), "{compression:?}: {lost} frames lost");
        assert_eq!(frames.last().unwrap().depth.stamp_ns, at_ms(1100));
    }
}

#[test]
fn an_empty_recording_names_what_is_missing() {
    let error = LogReader::mcap(&Recorder::new().save().path, &Config::default()).err().unwrap().to_string();
    assert!(error.contains("no depth image") && error.contains("no topics"), "{error}");
}

#[test]
fn a_recording_with_topics_but_no_messages_has_no_frames() {
    let options = WriteOptions::new().emit_statistics(false);
    let mut recorder = Recorder::with(options);
    recorder.channel(DEPTH, "sensor_msgs/msg/Image", "cdr");
    recorder.channel(DEPTH_INFO, "sensor_msgs/msg/CameraInfo", "cdr");
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!((frames.len(), report.depth_images), (0, 0));
}

#[test]
fn other_files_are_named_for_what_they_look_like() {
    for (start, part) in [
        (&b"#ROSBAG V1.2\n"[..], "ROS 1 bag"),
        (b"PK\x03\x04", "zip archive"),
        (b"", "empty"),
        (b"\x7fELF", "no known format"),
    ] {
        let error = open(&save(start).path, &Config::default()).err().unwrap().to_string();
        assert!(error.contains(part) && error.contains("MCAP files, ROS 1 bags, TUM"), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let error = open(folder.path(), &Config::default()).err().unwrap().to_string();
    assert!(error.contains("depth.txt"), "{error}");
    let error = open(&folder.path().join("absent"), &Config::default()).err().unwrap().to_string();
    assert!(error.contains("absent"), "{error}");
}
