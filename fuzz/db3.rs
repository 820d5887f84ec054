//! Any bytes as an SQLite bag of rosbag2.
#![no_main]

mod read;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let path = read::written("input.db3", &[b"SQLite format 3\0", bytes].concat());
    read::read_all(&path, bytes.len() + 1);
});
