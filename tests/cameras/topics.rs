//! Which topic is depth, which colour, and of which camera.

use limpid::message::ros2::{PointCloud2, PointField};

use super::world::Take;
use super::{ran, says};
use crate::read::synthetic::{Recorder, at_ms, header};
use crate::support::gpu::skipped;

#[test]
fn depth_and_colour_are_known_by_their_encodings() {
    if skipped() {
        return;
    }
    let named = ran(&Take::default().save().path, &[]);
    for (depth_topic, color_topic) in [
        ("/head/a/image", "/head/b/image"),
        ("/head/stereo/image_raw", "/head/left/image_raw"),
        // Each named as the other.
        ("/head/color/image_raw", "/head/stereo/image_raw"),
        ("/range", "/view"),
    ] {
        let got = ran(&Take { depth_topic, color_topic, ..Take::default() }.save().path, &[]);
        says(
            &got,
            &[&format!("topics: depth {depth_topic} "), &format!("colour {color_topic} "), "method drm"],
        );
        assert_eq!(got.differs_from(&named), 0);
    }
}

#[test]
fn infrared_and_confidence_of_16_bits_are_not_depth() {
    if skipped() {
        return;
    }
    let mut recorder = Recorder::new();
    let take = Take::default();
    take.record(&mut recorder);
    for topic in ["/a/infra1/image", "/a/confidence/image", "/a/disparity", "/a/thermal/image_raw"] {
        recorder.image(topic, at_ms(0), &take.depth(0));
    }
    let got = ran(&recorder.save().path, &[]);
    says(&got, &["topics: depth /cam/depth/image_raw "]);
    assert!(!got.said.contains("other depth topics"), "{}", got.said);
}

#[test]
fn of_two_cameras_colour_goes_with_its_own_and_the_other_is_named() {
    if skipped() {
        return;
    }
    let front = Take {
        depth_topic: "/front/depth/image_raw",
        color_topic: "/front/color/image_raw",
        depth_frame: "front_optical",
        color_frame: "front_optical",
        ..Take::default()
    };
    let back = Take {
        depth_topic: "/back/depth/image_raw",
        depth_frame: "back_optical",
        color_ms: Vec::new(),
        back: true,
        ..Take::default()
    };
    let mut recorder = Recorder::new();
    back.place(&mut recorder);
    front.record(&mut recorder);
    back.record(&mut recorder);
    let saved = recorder.save();
    let both = ran(&saved.path, &[]);
    says(
        &both,
        &[
            "topics: depth /front/depth/image_raw ",
            "colour /front/color/image_raw ",
            "other depth topics, not read: /back/depth/image_raw. `depth_topic` takes one of them",
            "`sensors`",
        ],
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("limpid.yaml");
    let run = |text: &str| {
        std::fs::write(&file, text).unwrap();
        ran(&saved.path, &["-c", file.to_str().unwrap()])
    };
    let alone = run("depth_topic: /back/depth/image_raw\n");
    says(&alone, &["colour none", "colour of other cameras", "/front/color/image_raw", "method range"]);
    let named = run("sensors: [front, back]\nfront: {kind: camera, depth_topic: /front/depth/image_raw}\n\
                     back: {kind: camera, depth_topic: /back/depth/image_raw}\n");
    says(&named, &["front: 10 used", "back: 10 used"]);
}

#[test]
fn either_depth_image_of_a_camera_has_its_colour() {
    if skipped() {
        return;
    }
    let raw = Take {
        depth_topic: "/camera/depth/image_rect_raw",
        color_topic: "/camera/color/image_raw",
        depth_frame: "camera_depth_optical",
        color_frame: "camera_color_optical",
        ..Take::default()
    };
    let aligned = Take {
        depth_topic: "/camera/aligned_depth_to_color/image_raw",
        depth_frame: "camera_color_optical",
        color_ms: Vec::new(),
        ..raw.clone()
    };
    let mut recorder = Recorder::new();
    raw.record(&mut recorder);
    aligned.record(&mut recorder);
    let saved = recorder.save();
    let found = ran(&saved.path, &[]);
    says(&found, &["depth /camera/aligned_depth_to_color/image_raw ", "colour /camera/color/image_raw "]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("limpid.yaml");
    std::fs::write(&file, "depth_topic: /camera/depth/image_rect_raw\n").unwrap();
    let stated = ran(&saved.path, &["-c", file.to_str().unwrap()]);
    says(&stated, &["depth /camera/depth/image_rect_raw ", "colour /camera/color/image_raw "]);
}

#[test]
fn the_cloud_that_a_camera_makes_of_its_images_is_no_lidar() {
    if skipped() {
        return;
    }
    let alone = ran(&Take::default().save().path, &[]);
    for (topic, frame, names) in [
        ("/cam/depth/color/points", "cam_optical", &["x", "y", "z", "rgb"][..]),
        ("/points", "cam_link", &["x", "y", "z", "rgb"]),
        ("/cam/depth/points", "cam_link", &["x", "y", "z"]),
        ("/points", "cam_optical", &["x", "y", "z"]),
    ] {
        let mut recorder = Recorder::new();
        Take::default().record(&mut recorder);
        let field = |(at, name): (usize, &&str)| PointField {
            name: (*name).into(),
            offset: 4 * at as u32,
            datatype: 7,
            count: 1,
        };
        let step = 4 * names.len() as u32;
        let cloud = PointCloud2 {
            header: header(at_ms(100), frame),
            height: 1,
            width: 2,
            fields: names.iter().enumerate().map(field).collect(),
            is_bigendian: 0,
            point_step: step,
            row_step: 2 * step,
            data: vec![0x3f; 2 * step as usize],
            is_dense: 1,
        };
        recorder.ros(topic, "sensor_msgs/msg/PointCloud2", at_ms(100), &cloud);
        let got = ran(&recorder.save().path, &[]);
        says(&got, &[&format!("{topic} is left out: it looks like the camera's own cloud")]);
        assert_eq!(got.differs_from(&alone), 0);
    }
}
