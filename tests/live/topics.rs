//! One list of topics: what a node publishes is what `limpid run` writes, byte by byte, while somebody listens.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use limpid::message::ros2::{Header, decode_cdr};
use limpid::output::McapSink;
use limpid::ros2::Quality;
use limpid::{Options, open_source, run};

use super::node::config;
use super::peer::{Node, PATIENCE, Peer, domain, no_network, node_options, play_options, played};
use crate::cli::ROOM;
use crate::support::gpu::skipped;

/// Topics of a node that no file has: what Nav2 reads live.
const LIVE: [&str; 3] = ["/limpid/clearing", "/limpid/costmap_updates", "/limpid/marking"];

/// What a file of the replay holds, by topic and stamp.
fn written() -> BTreeMap<String, BTreeMap<u64, Vec<u8>>> {
    let config = config();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.mcap");
    let mut room = open_source(ROOM.as_ref(), &config).unwrap();
    let sink = McapSink::create(&path, &config, room.sensors()).unwrap();
    let options = Options { images: true, verdicts: true, ..Options::default() };
    run(room.as_mut(), 0..u64::MAX, &config, &options, &mut [Box::new(sink)], &mut |_| ()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let mut written: BTreeMap<String, BTreeMap<u64, Vec<u8>>> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
        let of_topic = written.entry(message.channel.topic.clone()).or_default();
        of_topic.insert(message.log_time, message.data.into_owned());
    }
    written
}

#[test]
fn a_node_publishes_what_a_file_holds_while_somebody_listens() {
    if no_network() || skipped() {
        return;
    }
    let written = written();
    let environment = domain();
    let mut peer = Peer::join(&environment);
    let heard = [
        ("/limpid/depth_filtered/image", "sensor_msgs/msg/Image"),
        ("/limpid/depth_filtered/camera_info", "sensor_msgs/msg/CameraInfo"),
        ("/limpid/points_trusted", "sensor_msgs/msg/PointCloud2"),
        ("/limpid/reliability", "sensor_msgs/msg/Image"),
        ("/limpid/reliability_float", "sensor_msgs/msg/Image"),
        ("/limpid/verdicts", "foxglove_msgs/msg/Grid"),
    ];
    for (number, (name, kind)) in (0..).zip(heard) {
        peer.listen(number, name, kind, Quality::Stream { depth: 1000 });
    }
    let node = Node::start(&environment, node_options(config()));
    // The topics come with the sensors; what is found late misses the first frames.
    played(&environment, ROOM, &play_options()).unwrap();
    let offered: BTreeSet<String> =
        peer.participant.graph().topics.into_iter().map(|topic| topic.name).collect();
    let offered: BTreeSet<&str> =
        offered.iter().map(String::as_str).filter(|name| name.starts_with("/limpid/")).collect();
    let mut listed: BTreeSet<&str> =
        written.keys().map(String::as_str).filter(|name| name.starts_with("/limpid/")).collect();
    assert!(listed.remove("/limpid/diagnostics"), "they have a topic of their own live");
    listed.extend(LIVE);
    assert_eq!(offered, listed);

    let mut counts = BTreeMap::new();
    let until = Instant::now() + PATIENCE;
    while heard.iter().any(|(name, _)| counts.get(name).is_none_or(|&count| count < 5)) {
        let (topic, payload) = peer.next(until).unwrap_or_else(|| panic!("so far {counts:?}"));
        let name = heard[topic as usize].0;
        let stamp_ns = decode_cdr::<Header>("header", &payload).unwrap().stamp.stamp_ns().unwrap();
        let Some(file) = written[name].get(&stamp_ns) else { panic!("{name} of {stamp_ns} is in no file") };
        // RTPS fills messages up to whole words.
        assert!(payload.starts_with(file) && payload.len() - file.len() < 4, "{name} of {stamp_ns} differs");
        *counts.entry(name).or_insert(0) += 1;
    }
    node.end();
}

#[test]
fn what_nobody_listens_to_is_not_sent() {
    if no_network() || skipped() {
        return;
    }
    let environment = domain();
    let mut peer = Peer::join(&environment);
    let node = Node::start(&environment, node_options(super::robot::eye()));
    let _robot = super::robot::Robot::start(&environment, Default::default(), false);
    peer.listen(0, "/limpid/costmap_raw", "nav2_msgs/msg/Costmap", Quality::Stream { depth: 10 });
    peer.wait_for_topic("/limpid/reliability");
    for _ in 0..30 {
        peer.next(Instant::now() + PATIENCE).expect("maps come");
    }
    // Nobody listened to the images of these maps: the numbers of messages begin with 1 now.
    peer.listen(1, "/limpid/reliability", "sensor_msgs/msg/Image", Quality::Stream { depth: 10 });
    let until = Instant::now() + PATIENCE;
    loop {
        assert!(peer.inbox.wait(until), "no image comes");
        let Some(parcel) = peer.inbox.take(None).filter(|parcel| parcel.topic == 1) else { continue };
        assert!(parcel.origin.number < 15, "{} images were sent to nobody", parcel.origin.number);
        break;
    }
    node.end();
}
