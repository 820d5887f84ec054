//! Gaps between occupied cells.

use limpid::gpu::Invocations;
use limpid::map::Verdict;
use limpid::map::rule::{BRIDGED_ROW, ROWS};
use limpid::stage::map::bridge::{gaps_shader, occupied_shader, params};

use crate::reference::bridge::gaps;
use crate::support::compare::{EXACT, assert_close, compare};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

/// The verdict of a row, by the third sensor 0.7 s ago.
fn word(row: u32) -> u32 {
    let cost = [254, 254, 254, 254, 0, 254, 50, 0, 0, 255, 255, 254, 254][row as usize - 1];
    Verdict::pack(cost, row, Some(2), 7).0
}

fn bits(verdicts: &[u32], side: u32) -> Vec<u32> {
    let words = (side * side.div_ceil(32)) as usize;
    let fragment = Fragment::new()
        .params("bridge_occupied_params", &params(side).0)
        .input("verdicts", verdicts)
        .output("camera_bits", words);
    fragment.run(occupied_shader(), Invocations::line(words as u32)).words("camera_bits").to_vec()
}

fn fragment(verdicts: &[u32], bits: &[u32], side: u32) -> Fragment {
    Fragment::new()
        .params("bridge_gaps_params", &params(side).1)
        .input("camera_bits", bits)
        .changed("verdicts", verdicts)
}

/// The verdicts after both passes.
fn bridged(verdicts: &[u32], side: u32) -> Vec<u32> {
    let bits = bits(verdicts, side);
    let count = Invocations::line(bits.len() as u32);
    fragment(verdicts, &bits, side).run(gaps_shader(), count).words("verdicts").to_vec()
}

/// Rows of a 5x5 map of unknown cells but for some.
fn rows(some: &[(usize, u32)]) -> Vec<u32> {
    let mut verdicts = vec![word(10); 25];
    some.iter().for_each(|&(cell, row)| verdicts[cell] = word(row));
    bridged(&verdicts, 5).into_iter().map(|word| Verdict(word).row()).collect()
}

#[test]
fn truth_pairs_that_face_each_other_across_and_diagonally() {
    if skipped() {
        return;
    }
    for (pair, between) in
        [([11, 13], 12), ([7, 17], 12), ([6, 18], 12), ([8, 16], 12), ([0, 2], 1), ([14, 24], 19)]
    {
        let got = rows(&[(pair[0], 6), (pair[1], 6)]);
        let found: Vec<usize> = (0..25).filter(|cell| got[*cell] == BRIDGED_ROW).collect();
        assert_eq!(found, [between], "{pair:?}");
    }
    // Over the window's border, two cells apart, or round a corner: none.
    for pair in [[4, 5], [10, 13], [11, 7], [0, 4], [1, 21]] {
        assert!(!rows(&[(pair[0], 6), (pair[1], 6)]).contains(&BRIDGED_ROW), "{pair:?}");
    }
}

#[test]
fn truth_only_cameras_bridge_and_only_what_no_lidar_knows() {
    if skipped() {
        return;
    }
    for row in 1..=ROWS.len() as u32 {
        let by_row = rows(&[(11, row), (13, 6)])[12] == BRIDGED_ROW;
        assert_eq!(by_row, [4, 6].contains(&row), "a pair of row {row}");
        let over_row = rows(&[(11, 6), (12, row), (13, 4)])[12];
        let open = [9, 10, 11].contains(&row);
        assert_eq!(over_row, if open { BRIDGED_ROW } else { row }, "a gap of row {row}");
    }
    let mut verdicts = vec![word(10); 9];
    (verdicts[3], verdicts[4], verdicts[5]) = (word(6), word(9), word(6));
    let verdict = Verdict(bridged(&verdicts, 3)[4]);
    let said = (verdict.cost(), verdict.row(), verdict.sensor(), verdict.age_s());
    assert_eq!(said, (254, 13, Some(2), 0.7), "sensor and age stay");
}

#[test]
fn twin_at_all_sizes() {
    if skipped() {
        return;
    }
    let mut found = 0;
    for side in [1, 2, 3, 31, 32, 33, 64, 65, 120] {
        let mut random = Random(70 + u64::from(side));
        let occupied: Vec<bool> = (0..side * side).map(|_| random.chance(0.2)).collect();
        let verdicts: Vec<u32> = occupied.iter().map(|&o| word(if o { 6 } else { 10 })).collect();
        let got: Vec<u32> = bridged(&verdicts, side)
            .iter()
            .map(|&word| u32::from(Verdict(word).row() == BRIDGED_ROW))
            .collect();
        let want: Vec<u32> = gaps(&occupied, side as usize).into_iter().map(u32::from).collect();
        found += want.iter().sum::<u32>();
        assert_close("bridged", &got, &want, EXACT);
    }
    assert!(found > 1000, "{found}");
    let bits = vec![0; 1];
    fragment(&[word(10)], &bits, 1).refuses_nothing(gaps_shader());
}

#[test]
fn control_and_poison() {
    if skipped() {
        return;
    }
    let lone = gaps(&[true, false, false], 1);
    assert_eq!(lone, [false], "the reference itself");
    assert!(compare("bridged", &[0_u32], &[1_u32], EXACT).is_err());
    // Words of no row, and bits all set: nothing leaves the map.
    let words = bridged(&[u32::MAX; 9], 3);
    assert_eq!(words, [u32::MAX; 9], "row 15 is none");
    let out = fragment(&[word(10); 9], &[u32::MAX; 3], 3).run(gaps_shader(), Invocations::line(3));
    assert_eq!(out.words("verdicts"), [word(10); 9], "a cell that is occupied is no gap");
}
