//! Sources of several sensors: one pass, in order of stamps, and what goes wrong with one costs the others nothing.

use std::path::Path;

use glam::DVec2;
use limpid::Config;
use limpid::config::{SensorConfig, SensorKind};
use limpid::input::{SourceReport, open_source};
use limpid::message::ros2::{Pose, PoseStamped, Vector3};
use limpid::sensor::Observation;
use limpid::sensor::SensorModel;

use super::source::read_source;
use super::synthetic::{Recorder, at_ms, camera_info, depth_image, header};
use super::trio::{ALL_FRAMES, Drive, Message, camera, cloud, lidar, three, write};
use super::{noted, skipped};
use crate::support::data_dir;

/// How many observations each sensor gave.
fn counts(observations: &[Observation]) -> [usize; 3] {
    std::array::from_fn(|at| observations.iter().filter(|o| o.sensor == at).count())
}

fn late(report: &SourceReport) -> Vec<u64> {
    report.sensors.iter().map(|sensor| sensor.late).collect()
}

/// Checks that every sensor's observations are numbered from 0 without a gap.
fn assert_numbered(observations: &[Observation]) {
    for at in 0..3 {
        let numbers = observations.iter().filter(|o| o.sensor == at).map(Observation::index);
        assert!(numbers.eq(0..counts(observations)[at] as u64), "sensor {at}");
    }
}

fn assert_posed(observations: &[Observation]) {
    for observation in observations {
        let pose = observation.pose.unwrap_or_else(|| panic!("{observation:?}"));
        let seconds = (observation.stamp_ns() - at_ms(0)) as f64 * 1e-9;
        assert!((pose.map_from_base.translation_m.x - seconds).abs() < 1e-9, "{seconds} {pose:?}");
        assert!((pose.base_from_sensor.translation_m.z - 1.0).abs() < 1e-12);
    }
}

#[test]
fn two_cameras_and_a_lidar_come_in_order_of_stamps() {
    let saved = Drive::of(3).save(&ALL_FRAMES);
    let source = open_source(&saved.path, &three()).unwrap();
    let names: Vec<_> = source.sensors().iter().map(|info| info.name.as_str()).collect();
    assert_eq!(names, ["front", "rear", "top"]);
    assert_eq!(source.count_hint(), Some(90 + 60 + 30));
    let [front, rear, top] = source.sensors() else { panic!("three") };
    assert!(
        matches!(&front.model, SensorModel::Camera(camera) if camera.color.is_some() && camera.color_aligned)
    );
    assert!(
        matches!(&rear.model, SensorModel::Camera(camera) if camera.color.is_none()),
        "colour of the other"
    );
    assert!(matches!(&top.model, SensorModel::Lidar(lidar) if lidar.first.points.len() == 2));
    assert_eq!(
        (rear.frame_id.as_str(), top.frame_id.as_str(), top.timeout_s),
        ("rear_optical", "lidar", 0.3)
    );
    let (observations, report) = read_source(&saved.path, &three());
    assert_eq!(counts(&observations), [90, 60, 30]);
    assert!(observations.is_sorted_by_key(Observation::stamp_ns));
    assert_numbered(&observations);
    assert_posed(&observations);
    assert!(
        observations
            .iter()
            .filter_map(Observation::frame)
            .all(|f| f.color.is_some() == (f.depth.frame_id == "front_optical"))
    );
    assert_eq!(late(&report), [0, 0, 0]);
    assert!(report.read.skipped.is_empty(), "{report:?}");
    assert!(!noted(&report.read, "clocks differ"), "{:?}", report.read.notes);
    assert_eq!(read_source(&saved.path, &three()).0, observations, "the same again");
}

#[test]
fn the_camera_and_the_lidar_of_a_recording_are_found() {
    let saved = Drive::of(1).save(&ALL_FRAMES);
    let (observations, report) = read_source(&saved.path, &Config::default());
    let names: Vec<_> = report.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
    assert_eq!((names, counts(&observations)), (vec!["camera", "lidar"], [30, 10, 0]));
    assert!(observations.is_sorted_by_key(Observation::stamp_ns));
}

#[test]
fn a_late_message_is_given_and_counted() {
    let mut drive = Drive::of(2);
    for (log_ms, message) in &mut drive.messages {
        if matches!(message, Message::Scan(1000)) {
            *log_ms = 1600;
        }
    }
    // A lidar keeps its own order, so the scans that were logged before it come before it.
    let (observations, report) = read_source(&drive.save(&ALL_FRAMES).path, &three());
    assert_eq!(counts(&observations), [60, 40, 20]);
    assert_posed(&observations);
    assert_eq!(late(&report), [0, 0, 1]);
    let scans: Vec<u64> = observations.iter().filter_map(|o| Some(o.scan()?.stamp_ns)).collect();
    let at = scans.iter().position(|&ns| ns == at_ms(1000)).unwrap();
    assert_eq!(scans[at - 1], at_ms(1400));
}

#[test]
fn what_a_window_covers_is_brought_in_order() {
    // Rear frames are logged a tenth of a second after front ones of the same time.
    let mut drive = Drive::of(2);
    for (log_ms, message) in &mut drive.messages {
        *log_ms += if matches!(message, Message::Depth("rear", _)) { 90 } else { 0 };
    }
    let saved = drive.save(&ALL_FRAMES);
    let (observations, report) = read_source(&saved.path, &three());
    assert!(observations.is_sorted_by_key(Observation::stamp_ns));
    assert_eq!(late(&report), [0, 0, 0]);
}

#[test]
fn a_sensor_that_the_recording_lacks_is_missing() {
    let mut drive = Drive::of(12);
    drive.messages.retain(|(log_ms, message)| match message {
        Message::Depth("rear", _) => *log_ms > 11_000,
        _ => true,
    });
    let saved = drive.save(&ALL_FRAMES);
    let mut config = three();
    config.sensors.push(camera("left"));
    let source = open_source(&saved.path, &config).unwrap();
    let models: Vec<_> = source.sensors().iter().map(|info| info.model.clone()).collect();
    assert!(matches!(models[0], SensorModel::Camera(_)) && matches!(models[2], SensorModel::Lidar(_)));
    assert_eq!(models[1], SensorModel::Missing(SensorKind::Camera), "it comes after 11 s");
    assert_eq!(models[3], SensorModel::Missing(SensorKind::Camera), "no such topic");
    let (observations, report) = read_source(&saved.path, &config);
    assert_eq!(counts(&observations), [360, 20, 120]);
    assert!(observations.is_sorted_by_key(Observation::stamp_ns));
    assert!(noted(&report.read, "`left` is missing"), "{:?}", report.read.notes);
    assert_eq!((report.sensors[3].seen, report.sensors[3].given), (0, 0));
    let config = Config { sensors: vec![camera("left")], ..Config::default() };
    let error = open_source(&saved.path, &config).err().unwrap().to_string();
    assert!(error.contains("/left/depth/image_raw"), "{error}");
}

#[test]
fn a_sensor_that_comes_within_ten_seconds_is_known() {
    let mut drive = Drive::of(6);
    drive.messages.retain(|(log_ms, message)| !matches!(message, Message::Scan(_)) || *log_ms > 5000);
    let saved = drive.save(&ALL_FRAMES);
    let source = open_source(&saved.path, &three()).unwrap();
    assert!(matches!(source.sensors()[2].model, SensorModel::Lidar(_)), "more than is kept comes before it");
    let (observations, _) = read_source(&saved.path, &three());
    assert_eq!(counts(&observations), [180, 120, 11]);
    assert!(observations.is_sorted_by_key(Observation::stamp_ns));
}

#[test]
fn stamps_that_jump_in_one_sensor_cost_the_others_nothing() {
    for (frame, at) in [("rear", 1), ("lidar", 2)] {
        // A sensor whose clock starts at 500 s before its own time, and is set 100 s back.
        let back =
            |ms: &mut u64, log_ms: u64| *ms = if log_ms > 1500 { *ms + 400_000 } else { *ms + 500_000 };
        let drive = Drive::of(3).restamped(|log_ms, message| match message {
            Message::Depth("rear", ms) if at == 1 => back(ms, log_ms),
            Message::Scan(ms) if at == 2 => back(ms, log_ms),
            _ => {}
        });
        let (observations, report) = read_source(&drive.save(&ALL_FRAMES).path, &three());
        assert_eq!(counts(&observations), [90, 60, 30], "{frame}");
        assert_numbered(&observations);
        let others: Vec<_> = observations.into_iter().filter(|o| o.sensor != at).collect();
        assert_posed(&others);
        assert!(others.is_sorted_by_key(Observation::stamp_ns));
        let jumps: Vec<u64> = report.sensors.iter().map(|sensor| sensor.jumps).collect();
        assert_eq!(jumps, std::array::from_fn::<u64, 3, _>(|i| u64::from(i == at)), "{frame}");
        assert!(noted(&report.read, "jumped back by more than a second"), "{:?}", report.read.notes);
        let name = ["front", "rear", "top"][at];
        assert!(noted(&report.read, &format!("`{name}`: ")), "{:?}", report.read.notes);
    }
}

#[test]
fn clocks_that_differ_are_named_with_how_much() {
    let drive = Drive::of(3).restamped(|_, message| {
        if let Message::Scan(ms) = message {
            *ms += 30_000;
        }
    });
    let (observations, report) = read_source(&drive.save(&ALL_FRAMES).path, &three());
    assert_eq!(counts(&observations), [90, 60, 30]);
    let told: Vec<_> = report.read.notes.iter().filter(|note| note.contains("clocks differ")).collect();
    let both = ["front", "rear"].map(|name| format!("stamps of `top` are ahead of those of `{name}` by "));
    assert!(
        told.len() == 2 && both.iter().all(|part| told.iter().any(|note| note.contains(part))),
        "{told:?}"
    );
    let by_s =
        |note: &str| note.split(" by ").nth(1).unwrap().split(' ').next().unwrap().parse::<f64>().unwrap();
    assert!(told.iter().all(|note| (by_s(note) - 30.0).abs() < 0.2), "{told:?}");
    assert_posed(&observations.into_iter().filter(|o| o.sensor != 2).collect::<Vec<_>>());
}

#[test]
fn a_pause_of_one_sensor_is_no_other_clock() {
    let mut drive = Drive::of(6);
    drive.messages.retain(|(log_ms, message)| {
        !matches!(message, Message::Depth("rear", _)) || !(1000..5000).contains(log_ms)
    });
    let (observations, report) = read_source(&drive.save(&ALL_FRAMES).path, &three());
    assert!(!noted(&report.read, "clocks differ"), "{:?}", report.read.notes);
    assert!(observations.is_sorted_by_key(Observation::stamp_ns));
}

#[test]
fn a_sensor_whose_frame_is_not_connected_is_counted() {
    for (frame, at) in [("rear_optical", 1), ("lidar", 2)] {
        let frames: Vec<&str> = ALL_FRAMES.into_iter().filter(|&other| other != frame).collect();
        let (observations, report) = read_source(&Drive::of(3).save(&frames).path, &three());
        assert_eq!(counts(&observations), [90, 60, 30], "{frame}");
        let (lost, posed): (Vec<_>, Vec<_>) = observations.into_iter().partition(|o| o.sensor == at);
        assert!(lost.iter().all(|o| o.pose.is_none()));
        assert_posed(&posed);
        assert!(posed.is_sorted_by_key(Observation::stamp_ns));
        let without: Vec<u64> = report.sensors.iter().map(|sensor| sensor.without_pose).collect();
        assert_eq!(without[at], lost.len() as u64);
        assert_eq!(without.iter().sum::<u64>(), lost.len() as u64);
        assert_eq!(skipped(&report.read, "the frames are not connected"), lost.len() as u64, "{report:?}");
    }
}

#[test]
fn a_camera_that_changes_size_costs_the_others_nothing() {
    let saved = Drive::of(1).save(&ALL_FRAMES);
    let larger = |recorder: &mut Recorder| {
        for i in 0..10 {
            let ms = 1100 + 33 * i;
            let stamp_ns = at_ms(ms);
            // So that no image waits for what comes after a later calibration.
            write(recorder, stamp_ns, &Message::Base(ms + 20));
            write(recorder, stamp_ns, &Message::Color("front", ms));
            let mut image = depth_image(stamp_ns, 900);
            (image.height, image.data) = (6, vec![1; 48]);
            image.header.frame_id = "front_optical".into();
            if i >= 5 {
                let mut info = camera_info(stamp_ns, "front_optical");
                info.height = 6;
                recorder.info("/front/depth/camera_info", stamp_ns, &info);
            }
            recorder.image("/front/depth/image_raw", stamp_ns, &image);
        }
    };
    let mut recorder = Recorder::new();
    copy(&saved.path, &mut recorder);
    larger(&mut recorder);
    let (observations, report) = read_source(&recorder.save().path, &three());
    assert_eq!(counts(&observations), [35, 20, 10]);
    let heights = observations.iter().filter_map(|o| Some(o.frame()?.depth.camera.height));
    assert_eq!(heights.filter(|&height| height == 6).count(), 5);
    assert_eq!((report.sensors[0].seen, report.sensors[0].unusable), (40, 5));
    assert_eq!(skipped(&report.read, "its calibration is for 4x3, but it is 4x6"), 5);
}

/// Writes the messages of a recording anew.
fn copy(path: &Path, recorder: &mut Recorder) {
    let bytes = std::fs::read(path).unwrap();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let channel = &message.channel;
        let schema = channel.schema.as_ref().unwrap().name.clone();
        recorder.bytes(&channel.topic, &schema, &channel.message_encoding, message.log_time, &message.data);
    }
}

#[test]
fn a_looped_recording_comes_round_by_round() {
    let mut drive = Drive::of(5);
    let round = Drive::of(5).messages.into_iter().map(|(log_ms, message)| (log_ms + 5300, message));
    drive.messages.extend(round);
    let (observations, report) = read_source(&drive.save(&ALL_FRAMES).path, &three());
    assert_eq!(counts(&observations), [300, 200, 100]);
    assert_posed(&observations);
    let half = observations.len() / 2;
    assert!(observations[..half].is_sorted_by_key(Observation::stamp_ns));
    assert!(observations[half..].is_sorted_by_key(Observation::stamp_ns));
    assert_eq!(late(&report), [0, 0, 0]);
    assert!(report.sensors.iter().all(|sensor| sensor.jumps == 1), "{report:?}");
    assert!(!noted(&report.read, "clocks differ"), "{:?}", report.read.notes);
}

#[test]
fn lidars_without_any_transforms_have_no_common_map() {
    let cloud_of = |recorder: &mut Recorder, topic: &str, ms: u64| {
        recorder.ros(topic, "sensor_msgs/msg/PointCloud2", at_ms(ms), &cloud(at_ms(ms)));
    };
    let mut recorder = Recorder::new();
    for i in 0..5 {
        cloud_of(&mut recorder, "/a", 100 * i);
        cloud_of(&mut recorder, "/b", 100 * i + 50);
    }
    let saved = recorder.save();
    let sensors = vec![lidar("/a"), SensorConfig { name: "low".into(), ..lidar("/b") }];
    let (both, report) = read_source(&saved.path, &Config { sensors: sensors.clone(), ..Config::default() });
    assert!(both.len() == 10 && both.iter().all(|o| o.pose.is_none() && o.map_frame == "map"));
    assert_eq!(report.sensors[0].without_pose, 5);
    let config = Config { sensors: sensors[..1].to_vec(), ..Config::default() };
    let (one, _) = read_source(&saved.path, &config);
    assert!(one.len() == 5 && one.iter().all(|o| o.pose.is_some() && o.map_frame == "lidar"));
}

#[test]
fn lidars_with_packets_have_a_decoder_each() {
    let Some(path) = data_dir("lidar/vlp16-dual.mcap") else { return };
    let (alone, _) = read_source(&path, &Config::default());
    let bytes = std::fs::read(&path).unwrap();
    let mut recorder = Recorder::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let (channel, schema) = (&message.channel, message.channel.schema.as_ref().unwrap());
        for side in ["left", "right"] {
            let topic = format!("/{side}{}", channel.topic);
            let encoding = &channel.message_encoding;
            recorder.bytes(&topic, &schema.name, encoding, message.log_time, &message.data);
        }
    }
    let saved = recorder.save();
    let (found, _) = read_source(&saved.path, &Config::default());
    assert_eq!(found, alone, "the first of both");
    let source = open_source(&saved.path, &Config::default()).unwrap();
    let noted = source.report().read.notes.join(" ");
    let topic = noted.split("topic: /left").nth(1).unwrap().split(' ').next().unwrap().to_owned();
    let sensor = |side: &str| SensorConfig { name: side.into(), ..lidar(&format!("/{side}{topic}")) };
    let config = Config { sensors: vec![sensor("left"), sensor("right")], ..Config::default() };
    let (both, report) = read_source(&saved.path, &config);
    for at in 0..2 {
        let of_one = both.iter().filter(|o| o.sensor == at).map(Observation::scan);
        assert!(of_one.eq(alone.iter().map(Observation::scan)), "{at}");
    }
    assert!(both.is_sorted_by_key(Observation::stamp_ns));
    assert_eq!(late(&report), [0, 0]);
}

#[test]
fn a_sensor_has_its_own_tolerance_for_transforms() {
    let mut drive = Drive::of(2);
    drive.messages.retain(|(_, message)| !matches!(message, Message::Base(ms) if *ms > 1500));
    let saved = drive.save(&ALL_FRAMES);
    let mut config = three();
    config.sensors[1].parameters.transform_tolerance_s = 0.21;
    let (observations, _) = read_source(&saved.path, &config);
    let newest = |at: usize| {
        observations.iter().filter(|o| o.sensor == at && o.pose.is_some()).map(Observation::stamp_ns).max()
    };
    assert_eq!([newest(0), newest(1), newest(2)], [at_ms(1485), at_ms(1700), at_ms(1500)].map(Some));
}

#[test]
fn a_goal_holds_for_all_sensors_from_its_stamp_on() {
    let saved = Drive::of(1).save(&ALL_FRAMES);
    let mut recorder = Recorder::new();
    let pose = Pose { position: Vector3 { x: 2.0, y: 1.0, z: 0.0 }, ..Pose::default() };
    let goal = PoseStamped { header: header(at_ms(500), "map"), pose };
    recorder.ros("/goal", "geometry_msgs/msg/PoseStamped", at_ms(0), &goal);
    copy(&saved.path, &mut recorder);
    let config = Config { goal_topic: "/goal".into(), ..three() };
    let (observations, _) = read_source(&recorder.save().path, &config);
    for observation in observations {
        let expected = (observation.stamp_ns() >= at_ms(500)).then_some(DVec2::new(2.0, 1.0));
        assert_eq!(observation.goal_m, expected);
    }
}
