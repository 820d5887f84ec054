//! Recordings in the shape of public bug reports, as their owners would run them.

use std::path::Path;

use limpid::message::lidar::{CustomMsg, CustomPoint, LaserScan};
use limpid::message::ros2::Header;

use crate::cli::{fails, limpid, succeeds};
use crate::read::synthetic::{Recorder, at_ms};
use crate::support::data_dir;
use crate::support::gpu::skipped;

/// What `limpid run` prints, and how many cells of that class its last map has.
fn run(case: &str, more: &[&str]) -> Option<String> {
    let folder = data_dir(&format!("field/{case}"))?;
    if skipped() {
        return None;
    }
    let path = |name: &str| folder.join(name).to_string_lossy().into_owned();
    // With a gamma, so that intensities decide while they bear the scale out.
    let stated = std::fs::read_to_string(path("config.yaml")).unwrap() + "    gamma: 0.5\n";
    let own = tempfile::NamedTempFile::with_suffix(".yaml").unwrap();
    std::fs::write(own.path(), stated).unwrap();
    let (recording, config) = (path("in.mcap"), own.path().to_string_lossy().into_owned());
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

const NO_ROTATION: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// A robot that stands still with a lidar 0.3 m above the ground.
fn standing() -> Recorder {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.0, 0.0, 0.3], NO_ROTATION);
    for ms in [0, 100, 200] {
        recorder.transform("/tf", at_ms(ms), ["map", "base_link"], [0.0; 3], NO_ROTATION);
    }
    recorder
}

#[test]
fn a_flat_scan_marks_what_it_meets_and_clears_the_way_to_it() {
    if skipped() {
        return;
    }
    // All around 2 m away, but nothing came back of the rays to the left.
    let ranges = (0..720).map(|ray| if (170..190).contains(&ray) { f32::INFINITY } else { 2.0 });
    let message = LaserScan {
        header: Header::new(at_ms(100), "lidar"),
        angle_min: 0.0,
        angle_max: std::f32::consts::TAU,
        angle_increment: std::f32::consts::TAU / 720.0,
        range_min: 0.1,
        range_max: 12.0,
        ranges: ranges.collect(),
        ..LaserScan::default()
    };
    let mut recorder = standing();
    recorder.ros("/scan", "sensor_msgs/msg/LaserScan", at_ms(100), &message);
    let saved = recorder.save();
    let path = saved.path.to_str().unwrap();
    let text = succeeds(&limpid(&["run", path]));
    // A circle of 2 m crosses some 160 cells of 0.1 m and holds 1256, of which inflation takes a part.
    assert!((120..200).contains(&cells(&text, "solid")), "{text}");
    assert!(
        (900..1256).contains(&(cells(&text, "free") + cells(&text, "inflated")))
            && cells(&text, "transparent") == 0,
        "{text}"
    );
    let why = |at: &str| succeeds(&limpid(&["why", path, "--at", at]));
    assert!(why("2.0,0.05").contains("solid") && why("1.0,0.05").starts_with('0'), "{}", why("1.0,0.05"));
    assert!(
        why("0.05,1.5").contains("unknown"),
        "nothing is known of rays that do not come back: {}",
        why("0.05,1.5")
    );
}

#[test]
fn a_livox_message_makes_walls_solid() {
    if skipped() {
        return;
    }
    let point = |at: usize| {
        let [y, z] = [at % 40, at / 40].map(|step| step as f32 * 0.05);
        let place =
            CustomPoint { x: 2.05, y: y - 1.0, z: z - 0.2, reflectivity: 30, ..CustomPoint::default() };
        CustomPoint { offset_time: 1000 * at as u32, line: (at % 4) as u8, ..place }
    };
    let points: Vec<CustomPoint> = (0..400).map(point).collect();
    let header = Header::new(at_ms(100), "lidar");
    let message = CustomMsg { header, timebase: at_ms(100), point_num: 400, points, ..CustomMsg::default() };
    let mut recorder = standing();
    recorder.ros("/livox/lidar", "livox_ros_driver2/msg/CustomMsg", at_ms(100), &message);
    let saved = recorder.save();
    let text = succeeds(&limpid(&["run", saved.path.to_str().unwrap()]));
    assert!(cells(&text, "solid") >= 20 && cells(&text, "passable") == 0, "{text}");
    assert!(text.contains("slabs") && text.contains("(solidity: learned)"), "{text}");
}
