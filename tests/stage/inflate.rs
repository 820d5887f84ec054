//! Inflation against SciPy's exact distance transform, cell by cell.

use limpid::Config;
use limpid::gpu::Invocations;
use limpid::map::{CellClass, Verdict};
use limpid::stage::map::inflate::*;

use crate::reference;
use crate::support::compare::{EXACT, assert_close, compare};
use crate::support::gpu::{Fragment, cells_of_quads, skipped};
use crate::support::random::Random;

const GOLDEN: &[u8] = include_bytes!("../../testdata/reference/inflation.bin");
const UNKNOWN: u32 = 0;
const FREE: u32 = 1;
const OCCUPIED: u32 = 2;

struct Case {
    config: Config,
    costs: Vec<u8>,
}

struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_first_chunk::<N>().unwrap();
        self.0 = rest;
        *first
    }

    fn float(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    fn grid(&mut self) -> Vec<u8> {
        let runs = u32::from_le_bytes(self.take());
        let run = |_| {
            let [value] = self.take();
            std::iter::repeat_n(value, usize::from(u16::from_le_bytes(self.take())))
        };
        (0..runs).flat_map(run).collect()
    }
}

/// SciPy's grid as states, and its cases.
fn golden() -> (Vec<u32>, Vec<Case>) {
    let mut bytes = Bytes(GOLDEN);
    let states = bytes.grid().iter().map(|&g| [FREE, OCCUPIED, UNKNOWN][usize::from(g)]).collect();
    let count = u32::from_le_bytes(bytes.take());
    let case = |_| {
        let [resolution_m, inflation_radius_m, inscribed_radius_m, cost_scaling_factor] =
            [0; 4].map(|_| bytes.float());
        let config = Config {
            resolution_m,
            map_size_m: 240.0 * resolution_m,
            inflation_radius_m,
            inscribed_radius_m,
            cost_scaling_factor,
            ..Config::default()
        };
        Case { config, costs: bytes.grid() }
    };
    (states, (0..count).map(case).collect())
}

fn packed_bits(side: usize, verdicts: &[u32]) -> Vec<u32> {
    let words = side.div_ceil(32);
    let mut bits = vec![0; side * words];
    for (i, _) in verdicts.iter().enumerate().filter(|(_, verdict)| **verdict & 0xff == 254) {
        bits[i / side * words + i % side / 32] |= 1 << (i % side % 32);
    }
    bits
}

/// From states, as a map of cameras alone decides them.
fn inflate(config: &Config, side: usize, state: &[u32]) -> Vec<u8> {
    let cost = |state: &u32| match *state {
        FREE => 0,
        OCCUPIED => 254,
        _ => 255,
    };
    inflate_costs(config, side, &state.iter().map(cost).collect::<Vec<_>>())
}

/// From costs before inflation.
fn inflate_costs(config: &Config, side: usize, costs: &[u8]) -> Vec<u8> {
    let verdicts: Vec<u32> = costs.iter().map(|&cost| Verdict::pack(cost, 6, Some(2), 99).0).collect();
    inflate_verdicts(config, side, &verdicts)
}

/// The three passes one after the other, each on the other's output.
fn inflate_verdicts(config: &Config, side: usize, verdicts: &[u32]) -> Vec<u8> {
    let row_words = side.div_ceil(32);
    let (side, words, radius) = (side as u32, row_words as u32, radius_cells(config).min(side as u32));
    let quads = side.div_ceil(4);
    let bits = Fragment::new()
        .params("inflate_pack_params", &InflatePackParams { side, words })
        .input("verdicts", verdicts)
        .output("occupied_bits", row_words * side as usize)
        .run(PACK, Invocations::line(side * words));
    assert_eq!(bits.words("occupied_bits"), packed_bits(side as usize, verdicts));
    let rows = Fragment::new()
        .params("inflate_rows_params", &InflateRowsParams { side, words, radius, quads })
        .input("occupied_bits", bits.words("occupied_bits"))
        .output("row_distance", (side * quads) as usize)
        .run(ROWS, Invocations::line(side * quads));
    let costs = Fragment::new()
        .params("inflate_columns_params", &InflateColumnsParams { side, radius, quads, pad: 0 })
        .input("verdicts", verdicts)
        .input("row_distance", rows.words("row_distance"))
        .input("cost_by_squared_distance", &cost_table(config))
        .output("costmap", (side * quads) as usize)
        .run(COLUMNS, Invocations::line(side * quads));
    let cells = cells_of_quads(costs.words("costmap"), side);
    let both = Fragment::new()
        .params("inflate_columns_params", &InflateColumnsParams { side, radius, quads, pad: 0 })
        .input("verdicts", verdicts)
        .input("row_distance", rows.words("row_distance"))
        .input("cost_by_squared_distance", &cost_table(config))
        .output("costmap", (side * quads) as usize)
        .output("cell_classes", (side * quads) as usize)
        .run(COLUMNS_AND_CLASSES, Invocations::line(side * quads));
    assert_eq!(cells_of_quads(both.words("costmap"), side), cells, "classes change no cost");
    let of = |(&verdict, &cost): (&u32, &u8)| CellClass::of(Verdict(verdict), cost) as u8;
    let classes: Vec<u8> = verdicts.iter().zip(&cells).map(of).collect();
    assert_eq!(cells_of_quads(both.words("cell_classes"), side), classes);
    cells
}

fn twin(config: &Config, side: usize, state: &[u32]) -> Vec<u8> {
    let is = |wanted: u32| state.iter().map(|&s| s == wanted).collect::<Vec<_>>();
    reference::inflate::inflate(config, side, &is(OCCUPIED), &is(UNKNOWN))
}

#[test]
fn truth_scipy_cell_by_cell() {
    if skipped() {
        return;
    }
    let (state, cases) = golden();
    assert_eq!((state.len(), cases.len()), (240 * 240, 6));
    for Case { config, costs } in cases {
        let what = format!("radius {} at {}", config.inflation_radius_m, config.resolution_m);
        assert_close(&what, &inflate(&config, 240, &state), &costs, EXACT);
    }
}

#[test]
fn control_another_radius_turns_red() {
    let (state, cases) = golden();
    for Case { config, costs } in &cases[..2] {
        assert_close("twin", &twin(config, 240, &state), costs, EXACT);
        let narrow = Config { inflation_radius_m: config.inflation_radius_m - 0.05, ..config.clone() };
        assert!(compare("narrow", &twin(&narrow, 240, &state), costs, EXACT).is_err());
    }
}

#[test]
fn truth_nav2_law_by_hand() {
    let config = Config { cost_scaling_factor: 3.0, inscribed_radius_m: 0.2, ..Config::default() };
    let costs: Vec<u32> = [0.0, 1.0, 4.0, 5.0, 11.0].iter().map(|&cells| cost(&config, cells)).collect();
    // 252 exp(-0.15) = 216.9, 252 exp(-1.05) = 88.2
    assert_eq!(costs, [254, 253, 253, 216, 88]);
    let cells = |radius: f64| radius_cells(&Config { inflation_radius_m: radius, ..Config::default() });
    assert_eq!([0.0, 0.01, 0.05, 0.55, 0.551, 100.0].map(cells), [0, 1, 1, 11, 12, 254]);
}

#[test]
fn edge_sizes_against_the_twin() {
    if skipped() {
        return;
    }
    let fragment = Fragment::new()
        .params("inflate_pack_params", &InflatePackParams { side: 8, words: 1 })
        .input("verdicts", &[0_u32; 64])
        .output("occupied_bits", 8);
    fragment.refuses_nothing(PACK);
    let mut random = Random(51);
    for side in [1, 2, 31, 32, 33, 63, 65] {
        let config = Config { map_size_m: f64::from(side) * 0.05, ..Config::default() };
        let wide = Config { inflation_radius_m: 0.05 * f64::from(side.min(40)), ..config };
        let cells = (side * side) as usize;
        let state: Vec<u32> =
            (0..cells).map(|_| if random.chance(0.01) { OCCUPIED } else { random.below(2) }).collect();
        // A map so small is refused by the configuration; the passes are right all the same.
        let wide = if side < 8 { Config { map_size_m: 12.0, ..wide } } else { wide };
        assert_close(
            "costs",
            &inflate(&wide, side as usize, &state),
            &twin(&wide, side as usize, &state),
            EXACT,
        );
    }
}

#[test]
fn poison_verdicts() {
    if skipped() {
        return;
    }
    let config = Config { map_size_m: 0.45, ..Config::default() };
    assert_eq!(inflate(&config, 9, &[OCCUPIED; 81]), [254; 81]);
    assert_eq!(inflate(&config, 9, &[UNKNOWN; 81]), [255; 81]);
    assert_eq!(inflate(&config, 9, &[FREE; 81]), [0; 81]);
    let mut verdicts = [u32::MAX; 81];
    assert_eq!(inflate_verdicts(&config, 9, &verdicts), [255; 81], "rows and sensors that there are not");
    verdicts[40] = 0xffff_fffe;
    let costs = inflate_verdicts(&config, 9, &verdicts);
    assert_eq!((costs[40], costs[41], costs[0]), (254, 253, 255));
    let odd: Vec<u8> = inflate_verdicts(&config, 9, &[0xffff_fffd; 81]);
    assert_eq!(odd, [253; 81], "a cost that is not lethal is no obstacle");
}

#[test]
fn truth_passable_cells_keep_their_cost_where_nothing_near_costs_more() {
    if skipped() {
        return;
    }
    let config = Config { map_size_m: 0.45, inflation_radius_m: 0.2, ..Config::default() };
    let mut costs = [50; 81];
    costs[40] = 254;
    let got = inflate_costs(&config, 9, &costs);
    let along: Vec<u8> = got[36..45].to_vec();
    // 252 exp(-10 (0.15 - 0.1)) = 152, 252 exp(-1) = 92; beyond the radius the passable cost is left.
    assert_eq!(along, [92, 152, 253, 253, 254, 253, 253, 152, 92]);
    assert_eq!((got[0], got[8]), (50, 50));
    costs[36] = 255;
    assert_eq!(inflate_costs(&config, 9, &costs)[36], 255, "unknown is overwritten only from 253 up");
}
