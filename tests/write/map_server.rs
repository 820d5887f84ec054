//! The saved map, byte for byte, and read as nav2's map_server would.

use limpid::frame::FrameOutput;
use limpid::map::Grid;
use limpid::output::save_map;
use tempfile::TempDir;

use crate::support::sample;

fn small_map() -> FrameOutput {
    let grid = Grid { origin_x_m: -1.5, origin_y_m: 2.0, resolution_m: 0.05, width: 3, height: 2 };
    FrameOutput { grid, costmap: vec![0, 254, 255, 253, 1, 252], ..sample::output() }
}

#[test]
fn picture_and_description_are_exact() {
    let folder = TempDir::new().unwrap();
    let [picture, description] = save_map(&folder.path().join("office.v2"), &small_map()).unwrap();
    assert_eq!(picture, folder.path().join("office.v2.pgm"));
    // Top row = largest y: inflated costs are free there; below free, lethal, unknown.
    assert_eq!(std::fs::read(picture).unwrap(), b"P5\n3 2\n255\n\xfe\xfe\xfe\xfe\x00\xcd");
    assert_eq!(
        std::fs::read_to_string(description).unwrap(),
        "image: \"office.v2.pgm\"\nmode: trinary\nresolution: 0.05\norigin: [-1.5, 2.0, 0.0]\n\
         negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    );
}

#[derive(serde::Deserialize)]
struct Description {
    image: String,
    resolution: f64,
    origin: [f64; 3],
    negate: u8,
    occupied_thresh: f64,
    free_thresh: f64,
}

/// What map_server publishes for a grey value in trinary mode.
fn loaded(grey: u8, map: &Description) -> i8 {
    assert_eq!(map.negate, 0);
    let occupancy = f64::from(255 - grey) / 255.0;
    if occupancy > map.occupied_thresh {
        100
    } else if occupancy < map.free_thresh {
        0
    } else {
        -1
    }
}

#[test]
fn map_server_reads_back_what_was_saved() {
    let folder = TempDir::new().unwrap();
    let [picture, description] = save_map(folder.path(), &small_map()).unwrap();
    let map: Description = serde_saphyr::from_str(&std::fs::read_to_string(description).unwrap()).unwrap();
    assert_eq!((map.image.as_str(), map.resolution, map.origin), ("map.pgm", 0.05, [-1.5, 2.0, 0.0]));
    let bytes = std::fs::read(picture).unwrap();
    let cells: Vec<_> = bytes[bytes.len() - 6..].iter().map(|&grey| loaded(grey, &map)).collect();
    assert_eq!(cells, [0, 0, 0, 0, 100, -1]);
    // With the threshold of older releases, unknown would be free: the check above can fail.
    assert_eq!(loaded(205, &Description { free_thresh: 0.25, ..map }), 0);
}
