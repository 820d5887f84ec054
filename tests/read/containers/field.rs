//! Recordings as people have them, through the command.

use std::path::Path;

use super::{db3, folder, mcap, messages, read};
use crate::cli::{limpid, succeeds};
use crate::support::data_dir;
use crate::support::gpu::skipped;

/// The map of a recording, and what the run said.
fn map(input: &Path) -> (Vec<u8>, String) {
    let folder = tempfile::tempdir().unwrap();
    let stem = folder.path().join("map");
    let arguments = ["run", input.to_str().unwrap(), "--method", "range", "--map", stem.to_str().unwrap()];
    let said = succeeds(&limpid(&arguments));
    (std::fs::read(stem.with_extension("pgm")).unwrap(), said)
}

#[test]
fn bags_of_rosbag2_give_the_map_of_their_file() {
    let Some(file) = data_dir("field/rosbag2-mcap-folder/bag/bag.mcap") else { return };
    if skipped() {
        return;
    }
    let (expected, _) = map(&file);
    // Six frames are too few for obstacles; a free cell is 254.
    assert!(expected.iter().filter(|&&pixel| pixel == 254).count() > 4000, "cells are free");
    for case in ["field/rosbag2-mcap-folder", "field/rosbag2-db3-folder"] {
        let Some(folder) = data_dir(case) else { continue };
        let (found, said) = map(&folder.join("bag"));
        assert!(found == expected, "{case}: {said}");
    }
}

/// What a run that uses nothing says.
fn nothing_of(input: &Path) -> String {
    let output = limpid(&["run", input.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && !said.contains("panicked"), "{said}");
    said
}

/// Asserts that damage is told before what is missing because of it.
#[track_caller]
fn damage_comes_first(said: &str, missing: &str) {
    let place = |part: &str| said.find(part).unwrap_or_else(|| panic!("{part}: {said}"));
    assert!(place("damaged") < place(missing), "{said}");
}

#[test]
fn a_chunk_of_zeros_is_told_at_once() {
    let Some(file) = data_dir("field/zstd-chunk-of-zeros/in.mcap") else { return };
    let start = std::time::Instant::now();
    damage_comes_first(&nothing_of(&file), "no calibration");
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}

#[test]
fn damage_is_told_before_what_is_missing_because_of_it() {
    let whole = mcap(&messages());
    let sized = |bytes: &[u8]| folder(&[("bag.mcap", bytes.to_vec())]);
    // The chunk of the calibration: without that no image can be used.
    let mut damaged = whole.clone();
    let k = 5.0_f64.to_le_bytes();
    let at = damaged.windows(8).position(|bytes| bytes == k).unwrap();
    damaged[at] ^= 1;
    let bag = sized(&damaged);
    let error = read(&bag.path().join("bag.mcap")).unwrap_err().to_string();
    damage_comes_first(&error, "no usable calibration");
    // Nothing but what is damaged.
    let mut cut = whole[..whole.len() / 2].to_vec();
    let start = cut.iter().position(|&byte| byte == 6).unwrap();
    cut[start + 40..].fill(0xff);
    let bag = sized(&cut);
    let said = nothing_of(&bag.path().join("bag.mcap"));
    assert!(said.contains("damaged"), "{said}");
    // SQLite, cut within its first pages.
    let bytes = db3(&messages());
    for pages in [1, 2, 3, 4, 6] {
        let bag = folder(&[("bag.db3", bytes[..512 * pages].to_vec())]);
        let said = nothing_of(&bag.path().join("bag.db3"));
        assert!(said.contains("cut off") || said.contains("damaged"), "{pages}: {said}");
        for missing in ["no calibration", "no depth image", "tables `topics`"] {
            let place = |part: &str| said.find(part);
            assert!(
                place(missing).is_none_or(|at| place("cut off").is_some_and(|cut| cut < at)),
                "{pages}: {said}"
            );
        }
    }
}

#[test]
fn a_real_bag_of_rosbag2_gives_what_its_mcap_file_gives() {
    let (Some(bag), Some(mcap)) =
        (data_dir("lidar/nebula-vlp16-dual/1673400471837873222"), data_dir("lidar/vlp16-dual.mcap"))
    else {
        return;
    };
    let scans = |path: &Path| {
        let mut reader = limpid::input::points::open(path, &Default::default()).unwrap();
        std::iter::from_fn(|| reader.next_scan().unwrap()).collect::<Vec<_>>()
    };
    let (found, expected) = (scans(&bag), scans(&mcap));
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().zip(&expected).all(|(a, b)| a.points == b.points && a.stamp_ns == b.stamp_ns));
}
