//! Counters of a frame.

use limpid::gpu::Invocations;
use limpid::stage::camera::tally::{TALLY, TallyParams};

use crate::reference::tally::tally as twin;
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

fn fragment(strips: &[u32], state: &[u32], invocations: u32) -> Fragment {
    let params = TallyParams { strips: strips.len() as u32, cells: state.len() as u32, invocations, pad: 0 };
    Fragment::new()
        .params("tally_params", &params)
        .input("strip_counts", strips)
        .input("state", state)
        .changed("counters", &[0_u32; 8])
}

fn tally(strips: &[u32], state: &[u32], invocations: u32) -> Vec<u32> {
    let out = fragment(strips, state, invocations).run(TALLY, Invocations::line(invocations));
    out.words("counters").to_vec()
}

#[test]
fn truth() {
    if skipped() {
        return;
    }
    // Two strips: 3 valid, 1 low, 2 hits; 16 valid, 16 low, 0 hits. Five cells: occupied and hit, free and
    // seen through, free, unknown and hit, unknown.
    let counters = tally(&[0x0002_0103, 0x0000_1010], &[2 | 4, 1 | 8, 1, 4, 0], 64);
    assert_eq!(counters, [19, 17, 2, 2, 1, 1, 2, 0]);
}

#[test]
fn twin_and_edge_sizes() {
    if skipped() {
        return;
    }
    fragment(&[0], &[0], 64).refuses_nothing(TALLY);
    let mut random = Random(71);
    for (strips, cells, invocations) in [(1, 1, 64), (63, 65, 64), (64, 64, 64), (1000, 5000, 128)] {
        let words: Vec<u32> = (0..strips).map(|_| random.below(1 << 24)).collect();
        let state: Vec<u32> = (0..cells).map(|_| random.below(3) | random.below(4) << 2).collect();
        assert_eq!(tally(&words, &state, invocations), twin(&words, &state), "{strips} and {cells}");
    }
}

#[test]
fn poison_words_count_by_their_bits_alone() {
    if skipped() {
        return;
    }
    assert_eq!(tally(&[u32::MAX], &[u32::MAX], 64), [255, 255, 255, 1, 1, 0, 0, 0]);
}
