//! What a user is told where a sensor has no pose: the frames that there are, what is wrong with them, and the keys to set.

use limpid::message::ros2::{OdometryPose, Pose, PoseWithCovariance, Quaternion, Vector3};

use crate::cli::{fails, limpid, succeeds};
use crate::read::synthetic::{FRAME, Recorder, Saved, at_ms, header};
use crate::support::data_dir;

const NO_ROTATION: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Runs a recording of which nothing can be used; it must fail and say all of `parts`, in few words.
#[track_caller]
fn run_says(saved: &Saved, parts: &[&str]) -> String {
    let output = limpid(&["run", saved.path.to_str().unwrap()]);
    fails(&output, 1, parts);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.lines().count() == 1 && said.len() < 2500, "{said}");
    said
}

/// A recording with transforms on `/tf` (moving) and on `/tf_static`, and three depth images.
fn recording(moving: &[[&str; 2]], fixed: &[[&str; 2]]) -> Saved {
    let mut recorder = Recorder::new();
    for pair in fixed {
        recorder.transform("/tf_static", at_ms(0), *pair, [0.0; 3], NO_ROTATION);
    }
    for ms in [0, 100, 200, 300] {
        for pair in moving {
            recorder.transform("/tf", at_ms(ms), *pair, [0.0; 3], NO_ROTATION);
        }
        recorder.depth(at_ms(ms), 1000);
    }
    recorder.save()
}

#[test]
fn without_any_transforms_the_message_says_how_to_state_one() {
    let said = run_says(
        &recording(&[], &[]),
        &[
            "the recording has no transforms",
            "static_transforms",
            "{parent: map, child: cam_optical",
            "4 times",
        ],
    );
    assert!(!said.contains("the recording's frames"), "{said}");
}

#[test]
fn odometry_alone_is_named_with_the_keys_that_use_it() {
    let mut recorder = Recorder::new();
    for ms in [0, 100] {
        let rotation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
        let pose = Pose { position: Vector3::default(), orientation: rotation };
        let message = OdometryPose {
            header: header(at_ms(ms), "/odom"),
            child_frame_id: "base_footprint".into(),
            pose: PoseWithCovariance { pose, covariance: [[0.0; 6]; 6] },
        };
        recorder.ros("/wheel/odometry", "nav_msgs/msg/Odometry", at_ms(ms), &message);
        recorder.depth(at_ms(ms), 1000);
    }
    let said = ["odometry_topic: /wheel/odometry", "map_frame: odom", "base_frame: base_footprint"];
    run_says(&recorder.save(), &said);
}

#[test]
fn where_nothing_moves_no_frame_is_proposed_as_the_map() {
    let said = run_says(
        &recording(&[], &[["color_optical", FRAME]]),
        &["color_optical -> cam_optical", "none of them moves", "{parent: map, child: color_optical"],
    );
    assert!(!said.contains("set map_frame"), "{said}");
    // Odometry that is not used says how the robot moves.
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", FRAME], [0.0; 3], NO_ROTATION);
    let rotation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
    let message = OdometryPose {
        header: header(at_ms(0), "odom"),
        child_frame_id: "base_link".into(),
        pose: PoseWithCovariance {
            pose: Pose { position: Vector3::default(), orientation: rotation },
            covariance: [[0.0; 6]; 6],
        },
    };
    recorder.ros("/odom", "nav_msgs/msg/Odometry", at_ms(0), &message);
    recorder.depth(at_ms(0), 1000);
    run_says(&recorder.save(), &["none of them moves", "set odometry_topic: /odom, map_frame: odom"]);
}

#[test]
fn other_names_are_listed_as_a_tree_with_the_keys() {
    let saved = recording(
        &[["odom", "base_footprint"]],
        &[["base_footprint", "base_link"], ["base_link", FRAME], ["base_link", "laser"]],
    );
    run_says(
        &saved,
        &[
            "odom -> base_footprint -> base_link -> {cam_optical, laser}",
            "there is no `map`: set map_frame: odom",
        ],
    );
    // Without the usual base too.
    let saved = recording(&[["odom", "base_footprint"]], &[["base_footprint", FRAME]]);
    run_says(&saved, &["set map_frame: odom", "there is no `base_link`: set base_frame: base_footprint"]);
    // The keys do what the message says.
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("c.yaml");
    std::fs::write(&config, "map_frame: odom\nbase_frame: base_footprint\n").unwrap();
    let arguments = ["info", saved.path.to_str().unwrap(), "-c", config.to_str().unwrap()];
    let text = succeeds(&limpid(&arguments));
    assert!(text.contains("a pose in `odom`") && !text.contains("missing:"), "{text}");
}

#[test]
fn a_namespace_is_seen_through() {
    let saved =
        recording(&[["robot1/odom", "robot1/base_link"]], &[["robot1/base_link", "robot1/cam_optical"]]);
    run_says(
        &saved,
        &[
            "set camera_frame: robot1/cam_optical",
            "set map_frame: robot1/odom",
            "set base_frame: robot1/base_link",
        ],
    );
    let saved =
        recording(&[["t1/map", "t1/base_link"], ["t2/map", "t2/base_link"]], &[["t2/base_link", FRAME]]);
    run_says(&saved, &["and apart", "set map_frame: t2/map"]);
}

#[test]
fn missing_static_transforms_are_told_apart_from_other_parts() {
    let saved = recording(&[["map", "odom"], ["odom", "base_link"]], &[]);
    run_says(
        &saved,
        &[
            "map -> odom -> base_link",
            "nothing says where `cam_optical` is",
            "no static transforms were recorded (/tf_static)",
            "{parent: base_link, child: cam_optical",
        ],
    );
    let saved = recording(&[["map", "base_link"]], &[["camera_link", FRAME]]);
    let said = run_says(
        &saved,
        &[
            "camera_link -> cam_optical; and apart: map -> base_link",
            "in parts that nothing connects",
            "{parent: base_link, child: camera_link",
        ],
    );
    assert!(!said.contains("no static"), "{said}");
}

#[test]
fn clocks_that_differ_are_named_with_the_difference() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf", at_ms(0), ["map", FRAME], [0.0; 3], NO_ROTATION);
    recorder.transform("/tf", at_ms(1000), ["map", FRAME], [0.0; 3], NO_ROTATION);
    recorder.depth(at_ms(43_500), 1000);
    run_says(&recorder.save(), &["42.500 s after the last transform", "clocks"]);

    let mut recorder = Recorder::new();
    recorder.depth(at_ms(0), 1000);
    recorder.transform("/tf", at_ms(7_250), ["map", FRAME], [0.0; 3], NO_ROTATION);
    run_says(&recorder.save(), &["7.250 s before the first transform", "clocks"]);

    let mut recorder = Recorder::new();
    recorder.transform("/tf", at_ms(0), ["map", FRAME], [0.0; 3], NO_ROTATION);
    recorder.depth(1_700_000_000_000_000_000, 1000);
    run_says(&recorder.save(), &["use_sim_time"]);

    let mut recorder = Recorder::new();
    recorder.transform("/tf", at_ms(0), ["map", FRAME], [0.0; 3], NO_ROTATION);
    recorder.depth(at_ms(30), 1000);
    run_says(&recorder.save(), &["0.030 s after the last transform", "transform_tolerance_s"]);
}

#[test]
fn a_loop_is_drawn() {
    let saved = recording(&[["map", "odom"], ["odom", "map"], ["odom", FRAME]], &[]);
    run_says(&saved, &["form a loop", "odom -> map -> odom"]);
}

#[test]
fn hostile_trees_give_short_messages() {
    let mut recorder = Recorder::new();
    for number in 0..5000 {
        let [parent, child] = [number, number + 1].map(|number| format!("frame_with_a_long_name_{number}"));
        recorder.transform("/tf", at_ms(0), [&parent, &child], [0.0; 3], NO_ROTATION);
    }
    recorder.depth(at_ms(0), 1000);
    run_says(&recorder.save(), &["more frames", "set map_frame: frame_with_a_long_name_0"]);
}

#[test]
fn leading_slashes_of_configured_frames_mean_nothing() {
    let saved = recording(&[["/odom", "base_link"]], &[["base_link", "/cam_optical"]]);
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("c.yaml");
    std::fs::write(&config, "map_frame: /odom\nbase_frame: /base_link\n").unwrap();
    let arguments = ["info", saved.path.to_str().unwrap(), "-c", config.to_str().unwrap(), "--json"];
    let report: serde_json::Value = serde_json::from_str(&succeeds(&limpid(&arguments))).unwrap();
    assert!(report["sensors"][0]["with_pose"].as_u64().unwrap() > 0, "{report}");
    assert_eq!(report["frame_tree"], "odom -> base_link -> cam_optical");
}

#[test]
fn field_no_tf() {
    let Some(input) = data_dir("field/no-tf/in.bag") else { return };
    let output = limpid(&["run", input.to_str().unwrap()]);
    fails(&output, 1, &["the recording has no transforms", "static_transforms"]);
}

#[test]
fn field_odom_base_footprint() {
    let Some(input) = data_dir("field/odom-base_footprint/in.mcap") else { return };
    let output = limpid(&["run", input.to_str().unwrap()]);
    fails(&output, 1, &["odom -> base_footprint", "map_frame: odom", "base_frame: base_footprint"]);
}
