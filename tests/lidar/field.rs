//! Recordings in the shape of public bug reports, as their owners would run them.

use std::path::Path;

use crate::cli::{fails, limpid, succeeds};
use crate::support::data_dir;
use crate::support::gpu::skipped;

/// What `limpid run` prints, and how many cells of that class its last map has.
fn run(case: &str, more: &[&str]) -> Option<String> {
    let folder = data_dir(&format!("field/{case}"))?;
    if skipped() {
        return None;
    }
    let path = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let (recording, config) = (path("in.mcap"), path("config.yaml"));
    Some(succeeds(&limpid(&[&["run", &recording, "-c", &config], more].concat())))
}

fn cells(text: &str, class: &str) -> u32 {
    let last = text.lines().find(|line| line.starts_with("map: ")).unwrap();
    let of = |part: &str| part.trim().strip_suffix(class)?.trim().rsplit(' ').next()?.parse().ok();
    last.split(',').find_map(of).unwrap_or_else(|| panic!("{class} in {last}"))
}

#[test]
fn walls_of_clouds_without_intensities_are_solid() {
    let Some(reference) = run("lidar-reference", &[]) else { return };
    let solid = cells(&reference, "solid");
    assert!(solid > 300 && !reference.contains("nothing is passable"), "{reference}");
    for (case, key) in
        [("cloud-xyz-only", "`intensity_field`"), ("lidar-intensity-zero", "is 0 in every return")]
    {
        let Some(text) = run(case, &[]) else { continue };
        assert_eq!(cells(&text, "solid"), solid, "{case}: {text}");
        assert_eq!(text.matches("nothing is passable").count(), 1, "one note: {text}");
        assert!(text.contains(key), "{text}");
    }
}

#[test]
fn a_livox_line_is_no_ring() {
    let (Some(reference), Some(text)) = (run("lidar-reference", &[]), run("livox-line-is-no-ring", &[]))
    else {
        return;
    };
    assert!(text.contains("planes z = 0 and below it: slabs"), "{text}");
    assert_eq!(cells(&text, "solid"), cells(&reference, "solid"), "{text}");
}

#[test]
fn a_scan_that_is_stamped_after_its_points_is_used() {
    let Some(text) = run("lidar-stamped-after-its-points", &[]) else { return };
    assert!(text.contains("2 used, 0 without a pose") && cells(&text, "solid") > 100, "{text}");
}

#[test]
fn a_lidar_s_user_reads_of_lidars() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.pcap");
    std::fs::write(
        &path,
        [0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 1, 0, 0, 0],
    )
    .unwrap();
    let output = limpid(&["run", Path::new(&path).to_str().unwrap()]);
    fails(&output, 1, &["Velodyne data packets"]);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("depth"), "{output:?}");
}
