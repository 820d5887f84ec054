//! What is played is what was recorded.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use limpid::config::Config;
use limpid::input::playback::{Playback, Purpose};
use limpid::message::ros2::{CameraInfo, Image, PointCloud2, TFMessage, decode_cdr};
use limpid::ros2::Quality;

use super::peer::{PATIENCE, Peer, domain, no_network, play_options, played};
use crate::cli::{ROOM, fails, limpid};
use crate::support::data_dir;

/// All messages of a recording, by topic.
fn messages(path: &str, config: &Config) -> BTreeMap<String, Vec<Vec<u8>>> {
    let mut playback = Playback::open(path.as_ref(), config).unwrap();
    let mut messages: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
    while let Some(played) = playback.next_message().unwrap() {
        let name = playback.topics()[played.topic].name.clone();
        messages.entry(name).or_default().push(played.payload);
    }
    messages
}

#[test]
fn every_message_of_a_recording_arrives_as_it_was_recorded() {
    if no_network() {
        return;
    }
    let environment = domain();
    let mut peer = Peer::join(&environment);
    let playback = Playback::open(ROOM.as_ref(), &Config::default()).unwrap();
    let topics = playback.topics().to_vec();
    for (number, topic) in (0..).zip(&topics) {
        let quality = match topic.purpose {
            Purpose::Fixed => Quality::Latched { depth: 100 },
            _ => Quality::Stream { depth: 1000 },
        };
        peer.listen(number, &topic.name, &topic.type_name, quality);
    }
    let started = Instant::now();
    let report = played(&environment, ROOM, &play_options()).unwrap();
    let wanted = messages(ROOM, &Config::default());
    assert_eq!(report.sent, wanted.values().map(|all| all.len() as u64).sum::<u64>());
    assert!(started.elapsed() >= Duration::from_millis(2_900), "30 frames at 10 Hz take 2.9 s");
    let mut arrived: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
    let until = Instant::now() + PATIENCE;
    while arrived.values().map(Vec::len).sum::<usize>() < report.sent as usize {
        let (topic, payload) = peer.next(until).expect("all messages arrive");
        arrived.entry(topics[topic as usize].name.clone()).or_default().push(payload);
    }
    for (name, wanted) in &wanted {
        // RTPS fills messages up to whole words.
        let same = |(arrived, wanted): (&Vec<u8>, &Vec<u8>)| {
            arrived.starts_with(wanted) && arrived.len() - wanted.len() < 4
        };
        let arrived = &arrived[name];
        assert_eq!(arrived.len(), wanted.len(), "{name}");
        assert!(arrived.iter().zip(wanted).all(same), "{name}: other bytes, or another order");
    }
}

/// The raw payloads of an MCAP file as the mcap crate reads them.
#[test]
fn cdr_is_passed_on_byte_by_byte() {
    let bytes = std::fs::read(ROOM).unwrap();
    let mut recorded: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
        recorded.entry(message.channel.topic.clone()).or_default().push(message.data.into_owned());
    }
    assert!(recorded.len() >= 5 && messages(ROOM, &Config::default()) == recorded);
}

#[test]
fn a_recording_of_the_realsense_sdk_becomes_what_a_node_understands() {
    let Some(bag) = data_dir("rgbd/librealsense-d435-bag") else { return };
    let bag = std::fs::read_dir(bag).unwrap().map(|entry| entry.unwrap().path());
    let bag =
        bag.into_iter().find(|path| path.extension().is_some_and(|extension| extension == "bag")).unwrap();
    let bag = messages(bag.to_str().unwrap(), &Config::default());
    let depths = &bag["/camera/depth/image_raw"];
    assert_eq!(depths.len(), bag["/camera/depth/camera_info"].len());
    let depth: Image = decode_cdr("Image", &depths[0]).unwrap();
    assert_eq!((depth.encoding.as_str(), depth.header.frame_id.is_empty()), ("16UC1", false));
    assert_eq!(depth.data.len(), depth.step as usize * depth.height as usize);
}

#[test]
fn rosbag2_folders_and_databases_are_played_as_the_file_in_them() {
    for name in ["field/rosbag2-mcap-folder/bag", "field/rosbag2-db3-folder/bag"] {
        let Some(folder) = data_dir(name) else { return };
        let folder_messages = messages(folder.to_str().unwrap(), &Config::default());
        let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        let files = files.filter(|path| path.extension().is_some_and(|kind| kind != "yaml"));
        let mut of_files: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
        let mut files: Vec<_> = files.collect();
        files.sort();
        for file in files {
            for (topic, more) in messages(file.to_str().unwrap(), &Config::default()) {
                of_files.entry(topic).or_default().extend(more);
            }
        }
        assert!(folder_messages.values().any(|all| all.len() > 5), "{name}");
        assert!(folder_messages == of_files, "{name}");
    }
}

#[test]
fn a_tum_folder_is_played_with_calibration_and_transforms() {
    let Some(folder) = data_dir("rgbd/kitchen-tum") else { return };
    let folder = messages(folder.to_str().unwrap(), &Config::default());
    let count = |name: &str| folder.get(name).map_or(0, Vec::len);
    assert_eq!(count("/camera/depth/image_raw"), 100);
    assert_eq!([count("/camera/depth/camera_info"), count("/tf")], [100, 100]);
    let info: CameraInfo = decode_cdr("CameraInfo", &folder["/camera/depth/camera_info"][0]).unwrap();
    let tf: TFMessage = decode_cdr("TFMessage", &folder["/tf"][0]).unwrap();
    assert_eq!(tf.transforms.last().unwrap().child_frame_id, info.header.frame_id);
}

#[test]
fn packets_become_clouds_with_all_that_a_point_has() {
    let Some(folder) = data_dir("lidar") else { return };
    let folders = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let veloview = folders.into_iter().find(|path| path.to_string_lossy().contains("veloview")).unwrap();
    let files = std::fs::read_dir(veloview).unwrap().map(|entry| entry.unwrap().path());
    let pcap =
        files.into_iter().find(|path| path.extension().is_some_and(|extension| extension == "pcap")).unwrap();
    let pcap = messages(pcap.to_str().unwrap(), &Config::default());
    let cloud: PointCloud2 = decode_cdr("PointCloud2", &pcap["/points"][0]).unwrap();
    assert!(cloud.width > 1000 && cloud.data.len() == cloud.width as usize * cloud.point_step as usize);
    let names: Vec<_> = cloud.fields.iter().map(|field| field.name.as_str()).collect();
    assert!(
        ["x", "y", "z", "intensity", "time", "ring"].iter().all(|name| names.contains(name)),
        "{names:?}"
    );
}

#[test]
fn wrong_usage_is_named() {
    fails(&limpid(&["play", ROOM, "--rate", "0"]), 2, &["--rate", "not above 0"]);
    fails(&limpid(&["play", "no/such.mcap"]), 1, &["no/such.mcap"]);
    fails(&limpid(&["play", ROOM, "--ros-args", "-r", "a"]), 2, &["NAME:=VALUE"]);
    fails(&limpid(&["run", ROOM, "--ros-args", "-r", "a:=b"]), 2, &["--ros-args", "limpid node"]);
    fails(&limpid(&["play", ROOM, "--ros-args", "-r", "__node:=a-b"]), 1, &["a-b"]);
    fails(&limpid(&["node", "--ros-args", "-p", "taux:=0.4"]), 2, &["`taux`", "`tau`"]);
    fails(&limpid(&["node", "--ros-args", "-p", "tau:=3"]), 2, &["`tau`", "not in [0, 1]"]);
    fails(&limpid(&["node", "--ros-args", "--params-file", "no-such.yaml"]), 2, &["no-such.yaml"]);
}
