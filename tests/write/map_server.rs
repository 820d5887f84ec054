//! The saved map, byte for byte, and read as nav2's map_server would.

use limpid::map::{CellClass, Grid, MapUpdate, Verdict};
use limpid::output::save_map;
use tempfile::TempDir;

use crate::support::sample;

fn small_map() -> MapUpdate {
    let grid = Grid { origin_x_m: -1.5, origin_y_m: 2.0, resolution_m: 0.05, width: 3, height: 2 };
    MapUpdate { grid, costmap: vec![0, 254, 255, 253, 1, 252], ..sample::output().map.unwrap() }
}

#[test]
fn picture_and_description_are_exact() {
    let folder = TempDir::new().unwrap();
    let [picture, description] = save_map(&folder.path().join("office.v2"), &small_map()).unwrap();
    assert_eq!(picture, folder.path().join("office.v2.pgm"));
    // Top row = largest y: inscribed, which may be unknown, and inflated, which is free; below free, lethal, unknown.
    assert_eq!(std::fs::read(picture).unwrap(), b"P5\n3 2\n255\n\xcd\xfe\xfe\xfe\x00\xcd");
    assert_eq!(
        std::fs::read_to_string(description).unwrap(),
        "image: \"office.v2.pgm\"\nmode: trinary\nresolution: 0.05\norigin: [-1.5, 2.0, 0.0]\n\
         negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    );
}

/// The greys of a saved picture of 3x2 cells, in order of the costs.
fn greys(picture: &std::path::Path) -> Vec<u8> {
    let bytes = std::fs::read(picture).unwrap();
    bytes[bytes.len() - 6..].rchunks_exact(3).flatten().copied().collect()
}

#[test]
fn an_inscribed_cell_of_which_nothing_more_is_known_is_unknown() {
    let folder = TempDir::new().unwrap();
    let map = MapUpdate { costmap: vec![253, 253, 254, 255, 0, 252], ..small_map() };
    let [picture, _] = save_map(folder.path(), &map).unwrap();
    assert_eq!(greys(&picture), [205, 205, 0, 205, 254, 254]);
}

#[test]
fn inscribed_cells_of_a_lidar_s_map_are_unknown_unless_passable() {
    let folder = TempDir::new().unwrap();
    let [unknown, free, solid, passable, _, inflated] = CellClass::ALL.map(|class| class as u8);
    let map = MapUpdate {
        costmap: vec![253, 252, 253, 254, 255, 0],
        classes: vec![inflated, inflated, passable, solid, unknown, free],
        ..small_map()
    };
    let [picture, _] = save_map(folder.path(), &map).unwrap();
    assert_eq!(greys(&picture), [205, 254, 254, 0, 205, 254]);
    let short = MapUpdate { classes: vec![free; 5], ..map };
    let error = save_map(folder.path(), &short).unwrap_err().to_string();
    assert!(error.contains("6 costs and 5 classes"), "{error}");
}

#[test]
fn verdicts_say_what_is_free_under_inflation() {
    let folder = TempDir::new().unwrap();
    let verdict = |cost, row| Verdict::pack(cost, row, Some(0), 1);
    let map = MapUpdate {
        costmap: vec![253, 253, 253, 253, 253, 254],
        // Free, passable, unknown, stale, not asked, occupied.
        verdicts: vec![
            verdict(0, 8),
            verdict(50, 7),
            verdict(255, 10),
            verdict(255, 11),
            Verdict::default(),
            verdict(254, 6),
        ],
        // What the classes say is not asked for.
        classes: vec![CellClass::Inflated as u8; 6],
        ..small_map()
    };
    let [picture, _] = save_map(folder.path(), &map).unwrap();
    assert_eq!(greys(&picture), [254, 254, 205, 205, 205, 0]);
    let short = MapUpdate { verdicts: vec![verdict(0, 8); 7], ..map };
    let error = save_map(folder.path(), &short).unwrap_err().to_string();
    assert!(error.contains("6 costs and 7 verdicts"), "{error}");
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
    assert_eq!(cells, [-1, 0, 0, 0, 100, -1]);
    // With the threshold of older releases, unknown would be free: the check above can fail.
    assert_eq!(loaded(205, &Description { free_thresh: 0.25, ..map }), 0);
}
