//! What fails on a robot: the GPU, messages that are none, sensors that are not there.

use std::time::{Duration, Instant};

use limpid::Config;
use limpid::gpu::Context;
use limpid::live::NodeOptions;
use limpid::message::ros2::decode_cdr;
use limpid::ros2::Quality;

use super::node::{config, listener};
use super::peer::{
    Costs, Diagnostics, Node, PATIENCE, Peer, domain, no_network, node_options, play_options, played,
};
use crate::cli::ROOM;
use crate::support::gpu::skipped;

const RAW: u32 = 2;
const DIAGNOSTICS: u32 = 3;

#[test]
fn a_lost_gpu_leaves_no_free_cell_and_is_opened_again() {
    if no_network() || skipped() {
        return;
    }
    let environment = domain();
    let peer = listener(&environment);
    let context = Context::open(None, false).unwrap();
    let options =
        NodeOptions { context: Some(context.clone()), ..node_options(Config { timeout_s: 0.0, ..config() }) };
    let node = Node::start(&environment, options);
    let room = {
        let environment = environment.clone();
        std::thread::spawn(move || played(&environment, ROOM, &play_options()).unwrap())
    };
    peer.wait_for::<Costs>(RAW, |costs| costs.data.contains(&0));
    context.destroy();
    let blind = peer.wait_for::<Costs>(RAW, |costs| !costs.data.contains(&0));
    assert!(blind.data.iter().all(|&cost| cost >= 253), "only what is lethal or inscribed stays");
    let said = peer.wait_for::<Diagnostics>(DIAGNOSTICS, |said| said.status[0].message.starts_with("FAULT"));
    assert_eq!(said.status[0].level, 2);
    room.join().unwrap();
    played(&environment, ROOM, &play_options()).unwrap();
    peer.wait_for::<Costs>(RAW, |costs| costs.data.contains(&0));
    peer.wait_for::<Diagnostics>(DIAGNOSTICS, |said| said.status[0].level == 0);
    node.end();
}

/// Whether the node has counted messages of each of these topics that it did not understand.
fn all_counted(topics: &[(String, &str)], said: &Diagnostics) -> bool {
    let messages = said.status.iter().find(|status| status.name == "limpid: messages");
    let of = |name: &str| {
        let values = messages.iter().flat_map(|status| &status.values);
        let counts = values.filter(|(key, _)| key.starts_with(&format!("{name}: ")));
        counts.filter_map(|(_, count)| count.parse::<u64>().ok()).sum::<u64>()
    };
    topics.iter().all(|(name, _)| of(name) > 0)
}

/// Sends a thousand messages that are none on each topic, and more until those are counted that a busy machine did not lose.
fn send_nonsense(peer: &Peer, topics: &[(String, &str)]) {
    let publish = |(name, kind): &(String, &str)| {
        let fixed = name.contains("static");
        let quality = if fixed { Quality::Latched { depth: 1 } } else { Quality::Stream { depth: 200 } };
        peer.participant.publish(name, kind, quality).unwrap()
    };
    let publications: Vec<_> = topics.iter().map(publish).collect();
    let mut random = crate::support::random::Random(7);
    let until = Instant::now() + PATIENCE;
    let (mut rounds, mut told) = (0, false);
    while rounds < 50 || !told {
        assert!(Instant::now() < until, "they are not counted");
        for (publication, at) in publications.iter().flat_map(|one| (0..20_usize).map(move |at| (one, at))) {
            let length = 4 + (at * 37) % 300;
            let mut payload: Vec<u8> = (0..length).map(|_| random.below(256) as u8).collect();
            payload[..4].copy_from_slice(&[0, 1, 0, 0]);
            // A size that lies.
            if payload.len() > 8 && at % 2 == 0 {
                payload[4..8].copy_from_slice(&u32::MAX.to_le_bytes());
            }
            publication.send(payload).unwrap();
        }
        rounds += 1;
        while let Some((topic, payload)) = peer.next(Instant::now() + Duration::from_millis(10)) {
            told |=
                topic == DIAGNOSTICS && all_counted(topics, &decode_cdr("diagnostics", &payload).unwrap());
        }
    }
}

#[test]
fn messages_that_are_none_are_counted_and_end_nothing() {
    if no_network() || skipped() {
        return;
    }
    let environment = domain();
    let peer = listener(&environment);
    let node = Node::start(&environment, node_options(config()));
    let camera = "/camera/camera/aligned_depth_to_color";
    send_nonsense(
        &peer,
        &[
            (format!("{camera}/image_raw"), "sensor_msgs/msg/Image"),
            (format!("{camera}/camera_info"), "sensor_msgs/msg/CameraInfo"),
            ("/camera/camera/color/image_raw/compressed".into(), "sensor_msgs/msg/CompressedImage"),
            ("/tf".into(), "tf2_msgs/msg/TFMessage"),
            ("/tf_static".into(), "tf2_msgs/msg/TFMessage"),
        ],
    );
    node.wait_for("reads /camera", 1);
    // What comes afterwards is used.
    played(&environment, ROOM, &play_options()).unwrap();
    peer.wait_for::<Costs>(RAW, |costs| costs.data.contains(&0));
    node.end();
}

#[test]
fn nonsense_of_every_other_type_is_counted_too() {
    if no_network() || skipped() {
        return;
    }
    let environment = domain();
    let peer = listener(&environment);
    let robot = "
use_sim_time: true
odometry_topic: /odom
goal_topic: /goal
sensors: [cloud, packets, flat, echoes, livox]
cloud: {kind: lidar, topic: /cloud}
packets: {kind: lidar, topic: /packets}
flat: {kind: lidar, topic: /flat}
echoes: {kind: lidar, topic: /echoes}
livox: {kind: lidar, topic: /livox}
";
    let node = Node::start(&environment, node_options(Config::from_yaml(robot).unwrap()));
    send_nonsense(
        &peer,
        &[
            ("/cloud".into(), "sensor_msgs/msg/PointCloud2"),
            ("/packets".into(), "velodyne_msgs/msg/VelodyneScan"),
            ("/flat".into(), "sensor_msgs/msg/LaserScan"),
            ("/echoes".into(), "sensor_msgs/msg/MultiEchoLaserScan"),
            ("/livox".into(), "livox_ros_driver2/msg/CustomMsg"),
            ("/odom".into(), "nav_msgs/msg/Odometry"),
            ("/goal".into(), "geometry_msgs/msg/PoseStamped"),
            ("/clock".into(), "rosgraph_msgs/msg/Clock"),
        ],
    );
    node.end();
}

#[test]
fn a_sensor_that_is_not_there_is_told_with_the_nearest_names() {
    if no_network() || skipped() {
        return;
    }
    let environment = domain();
    let peer = listener(&environment);
    let name = "/camera/depth/image_raw";
    let publication = peer.participant.publish(name, "sensor_msgs/msg/Image", Quality::Sensor).unwrap();
    let node = Node::start(
        &environment,
        node_options(Config { depth_topic: "/camra/depth/image".into(), ..config() }),
    );
    node.wait_for("still waits", 1);
    node.wait_for(name, 1);
    let said = peer
        .wait_for::<Diagnostics>(DIAGNOSTICS, |said| said.status[0].message.contains("/camra/depth/image"));
    assert_eq!(said.status[0].level, 2);
    drop(publication);
    node.end();
}
