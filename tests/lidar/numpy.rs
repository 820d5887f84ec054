//! Real scans, cell by cell against the NumPy program tests/reference/lidar_intensity.py.

use std::path::Path;

use limpid::Config;
use limpid::config::GroundSource;
use limpid::input::PosedScans;

use crate::support::data_dir;
use crate::support::gpu::skipped;
use crate::support::scan::ScanFrame;
use crate::support::scan::{grid, run_one};

const REFERENCE: &[u8] = include_bytes!("../../testdata/reference/lidar_intensity.bin");

/// Cells that may differ: points whose place rounds to either side of a border, on the GPU and in NumPy.
const ROUNDED_CELLS: usize = 2;

/// Half of a 1/65536, in which values are stored, and f32 against f64.
const VALUE: f64 = 1.0e-5;

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn word(&mut self) -> u32 {
        let (head, rest) = self.0.split_first_chunk::<4>().unwrap();
        self.0 = rest;
        u32::from_le_bytes(*head)
    }

    fn runs(&mut self) -> Vec<u32> {
        let mut values = Vec::new();
        for _ in 0..self.word() {
            let value = self.word();
            let (length, rest) = self.0.split_first_chunk::<2>().unwrap();
            self.0 = rest;
            values.extend(std::iter::repeat_n(value, u16::from_le_bytes(*length).into()));
        }
        values
    }
}

/// The reference of a recording: cells a side, values by layer, classes, costs.
fn reference(number: usize) -> (usize, Vec<Vec<u32>>, Vec<u32>, Vec<u32>) {
    let mut reader = Reader(REFERENCE);
    for _ in 0..number {
        reader.word();
        for _ in 0..reader.word() + 2 {
            reader.runs();
        }
    }
    let (side, layers) = (reader.word() as usize, reader.word());
    let values = (0..layers).map(|_| reader.runs()).collect();
    (side, values, reader.runs(), reader.runs())
}

fn different<T>(got: &[T], want: &[u32], same: impl Fn(&T, u32) -> bool) -> usize {
    assert_eq!(got.len(), want.len());
    got.iter().zip(want).filter(|&(g, &w)| !same(g, w)).count()
}

fn compare_with(number: usize, recording: &Path, config: &str) {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/config").join(config);
    // The program knows no floor: layers lie level, and what lies on the floor is in them.
    let ground = GroundSource::Stated;
    let config = Config { static_transforms: Vec::new(), ground, ..Config::read(&example).unwrap() };
    let mut scans = PosedScans::open(recording, &config).unwrap();
    let first = scans.next_observation().unwrap().map(ScanFrame::from).unwrap();
    let out = run_one(&config, &first);
    let (side, values, classes, costs) = reference(number);
    assert_eq!(out.grid.width as usize, side);
    assert!(classes.iter().filter(|&&class| class >= 2).count() > 300, "there is something to compare");
    let byte = |got: &u8, want: u32| u32::from(*got) == want;
    for (name, want) in ["0", "1", "plane", "below"].into_iter().zip(&values) {
        let got = grid(&out, &format!("intensity_{name}"));
        let wrong = different(got, want, |g, w| (f64::from(*g) - f64::from(w) / 65536.0).abs() <= VALUE);
        assert!(wrong <= ROUNDED_CELLS, "{name}: {wrong} cells");
        // The control: another layer's values do not pass.
        let other = &values[usize::from(name == "0")];
        assert!(different(got, other, |g, w| (f64::from(*g) - f64::from(w) / 65536.0).abs() <= VALUE) > 100);
    }
    let wrong = different(&out.classes, &classes, byte);
    // A rounded point moves what is inflated around it too.
    assert!(wrong <= 20 * ROUNDED_CELLS, "{wrong} classes");
    let wrong = different(&out.costmap, &costs, |g, w| u32::from(*g).abs_diff(w) <= 1);
    assert!(wrong <= 20 * ROUNDED_CELLS, "{wrong} costs");
    let turned = Config { goal_m: vec![0.0, 50.0], ..config };
    let turned = run_one(&turned, &first);
    assert!(different(&turned.classes, &classes, byte) > 100, "another goal shows");
}

#[test]
fn vlp16_dual() {
    let Some(path) = data_dir("lidar/vlp16-dual.mcap") else { return };
    if !skipped() {
        compare_with(0, &path, "vlp16-dual.yaml");
    }
}

#[test]
fn three_d_ref() {
    let Some(path) = data_dir("lidar/3dref-hesai-qt64-dual") else { return };
    if !skipped() {
        compare_with(1, &path, "3dref.yaml");
    }
}

#[test]
fn rellis() {
    let Some(path) = data_dir("lidar/rellis3d-os1-64-labelled/frame000104-1581624663_170.ply") else {
        return;
    };
    if !skipped() {
        compare_with(2, &path, "rellis.yaml");
    }
}
