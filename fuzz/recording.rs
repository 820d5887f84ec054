//! Any bytes as the file of a recording, of whatever kind its first bytes say: MCAP, a ROS 1 bag, an SQLite bag, one of these
//! packed with zstd, pcap, pcapng, PLY, PCD. Errors or observations, no more of them than there are bytes.
#![no_main]

use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use limpid::Config;
use limpid::input::points;
use limpid::input::{contents, open};

/// A file in memory where there is one.
static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    folder.join(format!("limpid-fuzz-{}", std::process::id()))
});

fuzz_target!(|bytes: &[u8]| {
    let path = FILE.as_path();
    if std::fs::write(path, bytes).is_err() {
        return;
    }
    let config = Config::default();
    let _ = contents(path, &config);
    // What is packed may hold more than there are bytes.
    let most = 64 * (bytes.len() + 1);
    if let Ok(mut recording) = open(path, &config) {
        let mut frames = 0;
        while let Ok(Some(_)) = recording.next_frame() {
            frames += 1;
        }
        assert!(frames <= most);
        assert!(recording.report().depth_images >= frames as u64);
    }
    if let Ok(mut scans) = points::open(path, &Default::default()) {
        let mut read = 0;
        while let Ok(Some(scan)) = scans.next_scan() {
            assert!(scan.points.iter().all(|point| point.position_m().iter().all(|value| value.is_finite())));
            read += 1;
        }
        assert!(read <= most);
    }
});
