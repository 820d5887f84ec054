//! Folders: as rosbag2 leaves them, and as people do.

use limpid::Config;
use limpid::input::open_source;

use super::{FRAMES, db3, expected, folder, mcap, messages, metadata, parts, read, refused, says, whole};

type Write = fn(&[super::Message]) -> Vec<u8>;

const KINDS: [(&str, Write); 2] = [("mcap", mcap), ("db3", db3)];

/// The three parts as files of a kind.
fn splits(end: &str, write: Write) -> Vec<(String, Vec<u8>)> {
    let name = |number: usize| format!("run_{}.{end}", [9, 10, 11][number]);
    parts().iter().enumerate().map(|(number, part)| (name(number), write(part))).collect()
}

fn borrowed(files: &[(String, Vec<u8>)]) -> Vec<(&str, Vec<u8>)> {
    files.iter().map(|(name, bytes)| (name.as_str(), bytes.clone())).collect()
}

#[test]
fn a_folder_with_one_file_is_that_file() {
    for (end, write) in KINDS {
        let name = format!("run_0.{end}");
        let metadata = metadata(&[&name]);
        let bag = folder(&[(&name, write(&messages())), ("metadata.yaml", metadata.into())]);
        let notes = whole(bag.path());
        assert_eq!(notes.len(), 1, "only the topics are told: {notes:?}");
        // Who gives the file of metadata means its folder.
        whole(&bag.path().join("metadata.yaml"));
    }
}

#[test]
fn splits_are_one_recording_in_the_order_of_metadata() {
    for (end, write) in KINDS {
        let mut files = splits(end, write);
        // Names that lie about the order.
        for (file, name) in files.iter_mut().zip(["c", "a", "b"]) {
            file.0 = format!("{name}.{end}");
        }
        let metadata = metadata(&files.iter().map(|file| file.0.as_str()).collect::<Vec<_>>());
        let mut files = borrowed(&files);
        files.push(("metadata.yaml", metadata.into()));
        let bag = folder(&files);
        let notes = whole(bag.path());
        says(&notes, &["3 files are one recording", &format!("c.{end}, a.{end}, b.{end}")]);
    }
}

#[test]
fn a_split_alone_says_that_there_are_others() {
    let mut files = splits("mcap", mcap);
    files.push(("metadata.yaml".into(), metadata(&["run_9.mcap", "run_10.mcap", "run_11.mcap"]).into()));
    let bag = folder(&borrowed(&files));
    let (_, report) = read(&bag.path().join("run_9.mcap")).unwrap();
    says(&report.notes, &["run_9.mcap is one of 3 files", "give the folder"]);
}

#[test]
fn the_counts_of_all_splits_are_added() {
    for (end, write) in KINDS {
        let bag = folder(&borrowed(&splits(end, write)));
        let source = open_source(bag.path(), &Config::default()).unwrap();
        assert_eq!(source.count_hint(), Some(FRAMES.into()), "{end}");
    }
}

#[test]
fn without_metadata_names_give_the_order() {
    for (end, write) in KINDS {
        let bag = folder(&borrowed(&splits(end, write)));
        let notes = whole(bag.path());
        says(&notes, &["no metadata.yaml"]);
        says(&notes, &[&format!("run_9.{end}, run_10.{end}, run_11.{end}")]);
        // An empty file is what a recorder leaves that was killed.
        for broken in ["", "rosbag2_bagfile_information: [", "a: 1"] {
            std::fs::write(bag.path().join("metadata.yaml"), broken).unwrap();
            says(&whole(bag.path()), &["metadata.yaml cannot be read"]);
        }
    }
}

#[test]
fn a_missing_split_is_named_and_the_rest_is_read() {
    for (end, write) in KINDS {
        let mut files = borrowed(&[]);
        let all = splits(end, write);
        let names: Vec<&str> = all.iter().map(|file| file.0.as_str()).collect();
        let metadata = metadata(&names);
        files.extend(borrowed(&all));
        files.remove(1);
        files.push(("metadata.yaml", metadata.into()));
        let bag = folder(&files);
        let (frames, report) = read(bag.path()).unwrap();
        says(&report.notes, &["missing", &format!("run_10.{end}"), "lost"]);
        let (there, whole) = (frames.len(), expected());
        assert!(there > 4 && there < whole.len(), "{there} frames");
        assert!(frames.iter().all(|frame| frame.pose.is_some()), "the first split's transforms hold");
        let stamp = |frame: &limpid::sensor::RgbdFrame| frame.depth.stamp_ns;
        assert_eq!(frames.last().map(stamp), whole.last().map(stamp));
    }
}

#[test]
fn a_split_that_is_damaged_costs_its_own_messages() {
    for (end, write) in KINDS {
        let mut files = splits(end, write);
        files[1].1 = b"nothing of the kind".to_vec();
        let bag = folder(&borrowed(&files));
        let (frames, report) = read(bag.path()).unwrap();
        says(&report.notes, &[&format!("run_10.{end}"), "is neither MCAP nor a bag", "missing"]);
        assert!(frames.len() > 4, "{} frames", frames.len());
        files[2].1 = Vec::new();
        files[0].1 = Vec::new();
        refused(folder(&borrowed(&files)).path(), &[&format!("run_9.{end}")]);
    }
}

#[test]
fn files_that_metadata_does_not_name_are_read_where_they_are_splits() {
    for (end, write) in KINDS {
        let mut files = splits(end, write);
        files.push((format!("other.{end}"), write(&messages())));
        let metadata = metadata(&[&files[0].0, &files[1].0]);
        let mut files = borrowed(&files);
        files.push(("metadata.yaml", metadata.into()));
        let bag = folder(&files);
        let notes = whole(bag.path());
        says(&notes, &[&format!("does not name run_11.{end}"), "read after the others"]);
        says(&notes, &[&format!("does not name other.{end}"), "left out"]);
    }
}

#[test]
fn files_that_were_renamed_or_packed_since_are_found() {
    let whole_file = mcap(&messages());
    let old = "rosbag2_bagfile_information:\n  version: 3\n  relative_file_paths: [before/run_0.mcap]\n";
    let bag = folder(&[("run_0.mcap", whole_file.clone()), ("metadata.yaml", old.into())]);
    whole(bag.path());
    let packed = zstd::encode_all(&whole_file[..], 1).unwrap();
    let named = metadata(&["run_0.mcap"]);
    let bag = folder(&[("run_0.mcap.zstd", packed.clone()), ("metadata.yaml", named.into())]);
    whole(bag.path());
    let named = metadata(&["run_0.mcap.zstd"]);
    let bag = folder(&[("run_0.mcap", whole_file.clone()), ("metadata.yaml", named.into())]);
    whole(bag.path());
    // Played back, both lie there.
    std::fs::write(bag.path().join("run_0.mcap.zstd"), packed).unwrap();
    let notes = whole(bag.path());
    assert!(!notes.iter().any(|note| note.contains("left out")), "{notes:?}");
    let renamed = metadata(&["run_0.mcap"]);
    let bag = folder(&[("kitchen.mcap", whole_file), ("metadata.yaml", renamed.into())]);
    says(&whole(bag.path()), &["names run_0.mcap", "nothing is there"]);
}

#[test]
fn folders_that_are_no_recording_say_what_is_there() {
    let named = metadata(&["run_0.mcap", "run_1.mcap"]);
    refused(
        folder(&[("metadata.yaml", named.into())]).path(),
        &["run_0.mcap, run_1.mcap", "nothing is there"],
    );
    let several = folder(&[("hall.mcap", mcap(&messages())), ("kitchen.mcap", mcap(&messages()))]);
    refused(several.path(), &["several recordings", "hall.mcap, kitchen.mcap", "give one of them"]);
    let above = tempfile::tempdir().unwrap();
    let inside = above.path().join("bag");
    std::fs::create_dir(&inside).unwrap();
    std::fs::write(inside.join("metadata.yaml"), metadata(&["x.mcap"])).unwrap();
    refused(above.path(), &["there are", "/bag", "give one of them"]);
    refused(folder(&[("notes.txt", b"1".to_vec())]).path(), &["depth.txt", "without bags"]);
}

#[test]
fn splits_of_ros_1_are_one_recording_too() {
    use super::super::ros1::{Bag, Compression, IMAGE, INFO, camera_info, depth_image};
    use super::super::synthetic::{DEPTH, DEPTH_INFO, FRAME, at_ms};
    let bag = |from: u64| {
        let mut bag = Bag::new(Compression::None);
        for ms in [from, from + 100] {
            if ms == 0 {
                bag.message(DEPTH_INFO, INFO, at_ms(0), &camera_info(at_ms(0), FRAME));
            }
            bag.message(DEPTH, IMAGE, at_ms(ms), &depth_image(at_ms(ms), FRAME, 900));
        }
        bag.finish()
    };
    let files = folder(&[("2024-05-01-10-00-00_0.bag", bag(0)), ("2024-05-01-10-05-00_1.bag", bag(200))]);
    let (frames, report) = read(files.path()).unwrap();
    assert_eq!(frames.len(), 4, "{report:?}");
}

#[test]
fn a_folder_of_scans_with_a_bag_beside_is_one_of_scans() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
               property float intensity\nend_header\n1 2 3 4\n";
    let files = folder(&[("a.ply", ply.into()), ("run_0.mcap", mcap(&messages()))]);
    let mut scans = limpid::input::points::open(files.path(), &Default::default()).unwrap();
    assert_eq!(scans.next_scan().unwrap().map(|scan| scan.points.len()), Some(1));
    // The metadata of a bag says that it is one.
    std::fs::write(files.path().join("metadata.yaml"), metadata(&["run_0.mcap"])).unwrap();
    whole(files.path());
}
