//! Any bytes as the file of a recording, of whatever kind its first bytes say: MCAP, a ROS 1 bag, an SQLite bag, one of these
//! packed with zstd, pcap, pcapng, PLY, PCD.
#![no_main]

mod read;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let path = read::written("input", bytes);
    // What is packed may hold more than there are bytes.
    read::read_all(&path, 64 * (bytes.len() + 1));
});
