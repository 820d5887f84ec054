//! Any bytes as the `metadata.yaml` of a rosbag2 folder with two files.
#![no_main]

mod read;

use libfuzzer_sys::fuzz_target;

const BAG: &[u8] = include_bytes!("../testdata/room.mcap");

fuzz_target!(|bytes: &[u8]| {
    for name in ["bag_0.mcap", "bag_1.mcap"] {
        if !read::FOLDER.join(name).exists() {
            // The start of a recording is enough.
            read::written(name, &BAG[..BAG.len().min(40_000)]);
        }
    }
    let path = read::written("metadata.yaml", bytes);
    let Some(folder) = path.parent() else { return };
    let config = limpid::Config::default();
    let _ = limpid::input::contents(folder, &config);
    let _ = limpid::input::Inventory::of(folder, &config);
    let _ = limpid::open_source(folder, &config);
});
