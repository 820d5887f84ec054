//! The picture of the hall that the README shows.

use std::path::Path;

use super::{CONFIG, recording, run};
use crate::support::gpu::skipped;

/// Share of a picture's pixels that another adapter may draw otherwise: cells at the edges of what is seen.
const OTHER_PIXELS: f64 = 0.01;

/// Share of pixels that differ; 1 for pictures of different sizes.
fn difference(a: &[u8], b: &[u8]) -> f64 {
    let [a, b] = [a, b].map(|bytes| image::load_from_memory(bytes).unwrap().to_rgb8());
    if a.dimensions() != b.dimensions() {
        return 1.0;
    }
    let other = a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count();
    other as f64 / f64::from(a.width() * a.height())
}

#[test]
fn the_committed_picture_shows_the_halls_last_map() {
    if skipped() {
        return;
    }
    let hall = run(&recording(), CONFIG);
    let pictures = hall.files("png");
    let maps: Vec<_> = pictures.iter().filter(|name| name.starts_with("map-")).collect();
    let [first, last] = [maps[0], maps[maps.len() - 1]].map(|name| hall.bytes(&format!("png/{name}")));
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/hall-map.png");
    if std::env::var_os("LIMPID_WRITE_TESTDATA").is_some() {
        std::fs::write(&committed, &last).unwrap();
    }
    let committed = std::fs::read(committed).unwrap();
    assert!(committed.len() < 100_000, "{} bytes", committed.len());
    let other = difference(&committed, &last);
    assert!(other < OTHER_PIXELS, "{other} of the pixels are others");
    assert!(difference(&committed, &first) > OTHER_PIXELS, "the control: the first map");
}
