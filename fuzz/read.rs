//! What all targets of files check: everything that reads a recording gives errors or observations, no more of them than there
//! are bytes.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use limpid::Config;
use limpid::input::{Inventory, contents, open, open_source, points};

/// A folder in memory where there is one.
pub static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    let folder = folder.join(format!("limpid-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the inputs");
    folder
});

/// Writes a file of [`FOLDER`].
pub fn written(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.join(name);
    std::fs::write(&path, bytes).expect("an input");
    path
}

/// Reads a recording in every way; `bytes`: how many it may hold once it is unpacked.
pub fn read_all(path: &Path, bytes: usize) {
    let config = Config::default();
    let _ = contents(path, &config);
    let _ = Inventory::of(path, &config);
    if let Ok(mut recording) = open(path, &config) {
        let mut frames = 0;
        while let Ok(Some(_)) = recording.next_frame() {
            frames += 1;
        }
        assert!(frames <= bytes);
        assert!(recording.report().depth_images >= frames as u64);
    }
    if let Ok(mut scans) = points::open(path, &Default::default()) {
        let mut read = 0;
        while let Ok(Some(scan)) = scans.next_scan() {
            assert!(scan.points.iter().all(|point| point.position_m().iter().all(|value| value.is_finite())));
            read += 1;
        }
        assert!(read <= bytes);
    }
    if let Ok(mut source) = open_source(path, &config) {
        let mut read = 0;
        while let Ok(Some(_)) = source.next() {
            read += 1;
        }
        assert!(read <= bytes);
    }
}
