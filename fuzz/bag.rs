//! Any bytes as a ROS 1 bag.
#![no_main]

mod read;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let path = read::written("input.bag", &[b"#ROSBAG V2.0\n", bytes].concat());
    read::read_all(&path, 64 * (bytes.len() + 1));
});
