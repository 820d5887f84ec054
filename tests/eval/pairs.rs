//! Still pairs with a reference.

use std::path::Path;

use image::{ExtendedColorType, ImageEncoder};
use limpid::offline::eval::pairs::{PairList, PairReport, evaluate_pairs, file_name};
use limpid::{Config, Error};

use crate::support::data_dir;
use crate::support::gpu::skipped;

const LIST: &str = "camera_matrix: [146.0, 0.0, 7.5, 0.0, 146.0, 5.5, 0.0, 0.0, 1.0]\npairs:\n  - {name: one pair, color: color.png, depth: depth.png, reference: reference.png, mask: mask.png}\n";

fn grey16(path: &Path, values: &[u16], width: u32) {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
    let height = values.len() as u32 / width;
    let mut file = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut file);
    encoder.write_image(&bytes, width, height, ExtendedColorType::L16).unwrap();
    std::fs::write(path, file).unwrap();
}

fn color(path: &Path, rgb: &[u8], width: u32) {
    let mut file = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut file);
    let height = rgb.len() as u32 / 3 / width;
    encoder.write_image(rgb, width, height, ExtendedColorType::Rgb8).unwrap();
    std::fs::write(path, file).unwrap();
}

/// 16 x 12 pixels at 1 m; the first row 2 cm off, the second missing, the third without reference. The mask has the left half.
fn write(folder: &Path) {
    let pixels = 16 * 12;
    let rows = |special: [u16; 3]| {
        let value = |i: usize| special.get(i / 16).copied().unwrap_or(1000);
        (0..pixels).map(value).collect::<Vec<u16>>()
    };
    grey16(&folder.join("depth.png"), &rows([1020, 0, 1000]), 16);
    grey16(&folder.join("reference.png"), &rows([1000, 1000, 0]), 16);
    color(&folder.join("color.png"), &vec![90; 3 * pixels], 16);
    let mask: Vec<u8> = (0..pixels).flat_map(|i| [if i % 16 < 8 { 255 } else { 0 }; 3]).collect();
    color(&folder.join("mask.png"), &mask, 16);
    std::fs::write(folder.join("pairs.yaml"), LIST).unwrap();
}

fn evaluate(folder: &Path, config: &Config) -> Result<PairReport, Error> {
    let list = PairList::read(&folder.join("pairs.yaml"))?;
    evaluate_pairs(folder, &list, config, None, Some(folder))
}

#[test]
fn counts_by_hand() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let report = evaluate(folder.path(), &Config::default()).unwrap();
    let names: Vec<&str> = report.rows.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["one pair", "one pair in mask", "all", "all in mask"]);
    for (row, pixels) in [(0, 11 * 16), (1, 11 * 8), (2, 11 * 16), (3, 11 * 8)] {
        let tally = &report.rows[row].1;
        assert_eq!((tally.pixels, tally.bad), (pixels, pixels / 11 * 2), "{row}");
        let (_, depth) = tally.rankings.iter().find(|(name, _)| name == "depth").unwrap();
        assert_eq!(depth.counts(), [pixels / 11 * 9, pixels / 11], "missing depth is not ranked");
        // All bad pixels are the farthest: depth alone finds them.
        assert_eq!(depth.auprc(), Some(1.0));
    }
    let json = report.json();
    assert_eq!(json["pairs"]["all"]["depth"]["auprc"], 1.0);
    assert_eq!(json["pairs"]["one pair"]["bad_share"], 2.0 / 11.0);
    assert!(report.html().contains("one-pair.png") && folder.path().join("one-pair.png").exists());
    assert!(report.table().text().contains("hole_nearness"));
}

#[test]
fn the_network_is_scored_too() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let config = Config { weights: "testdata/reference/network.safetensors".into(), ..Config::default() };
    let report = evaluate(folder.path(), &config).unwrap();
    let (name, ranking) = &report.rows[0].1.rankings[0];
    assert_eq!((name.as_str(), ranking.counts()), ("drm", [9 * 16, 16]));
    assert!(report.rows[0].1.decision.f1().is_some());
}

#[test]
fn unreadable_pairs_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |parts: &[&str]| {
        let error = evaluate(folder.path(), &Config::default()).unwrap_err().to_string();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    };
    refused(&["pairs.yaml"]);
    write(folder.path());
    grey16(&folder.path().join("reference.png"), &[1000; 8 * 12], 8);
    refused(&["reference.png", "8x12", "16x12"]);
    write(folder.path());
    color(&folder.path().join("mask.png"), &[0; 3 * 8 * 12], 8);
    refused(&["mask.png", "8x12"]);
    write(folder.path());
    std::fs::write(folder.path().join("depth.png"), b"no picture").unwrap();
    refused(&["depth.png"]);
    std::fs::remove_file(folder.path().join("depth.png")).unwrap();
    refused(&["depth.png"]);
    for (text, part) in [
        ("camera_matrix: [1.0]\npairs: []\n", "camera_matrix"),
        (&LIST.replace("mask:", "masks:"), "masks"),
        (&format!("tolerance_m: .nan\n{LIST}"), "tolerance_m"),
        ("camera_matrix: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\npairs: []\n", "`pairs` is empty"),
    ] {
        std::fs::write(folder.path().join("pairs.yaml"), text).unwrap();
        refused(&["pairs.yaml", part]);
    }
}

#[test]
fn names_become_files() {
    assert_eq!(file_name("../a b/ü.png"), "---a-b---png");
}

#[test]
fn the_example_list_reads_the_clear_objects() {
    let list = PairList::read("testdata/config/cleargrasp-pairs.yaml".as_ref()).unwrap();
    assert_eq!((list.pairs.len(), list.tolerance_m), (3, 0.01));
    let Some(folder) = data_dir("rgbd/cleargrasp-d435").filter(|_| !skipped()) else { return };
    let report = evaluate_pairs(&folder, &list, &Config::default(), None, None).unwrap();
    // Shares of SOURCE.txt: holes within the masks are 29 to 61 %, so bad pixels are at least that.
    for (name, tally) in report.rows.iter().filter(|(name, _)| name.ends_with("in mask")) {
        let bad = tally.bad_share().unwrap();
        assert!((0.25..0.99).contains(&bad) && tally.pixels > 1000, "{name}: {bad}");
    }
}
