//! Recordings as people have them, through the command.

use std::path::Path;

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

#[test]
fn a_chunk_of_zeros_is_told_at_once() {
    let Some(file) = data_dir("field/zstd-chunk-of-zeros/in.mcap") else { return };
    let start = std::time::Instant::now();
    let output = limpid(&["run", file.to_str().unwrap()]);
    let said =
        String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    assert!(output.status.code() == Some(1) && !said.contains("panicked"), "{said}");
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
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
