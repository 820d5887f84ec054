//! What a frame's counters add up.

/// Valid, low-reliability and hit pixels from packed strips; hit, seen-through, occupied and free cells.
pub(crate) fn tally(strips: &[u32], state: &[u32]) -> Vec<u32> {
    let pixels = |byte: usize| strips.iter().map(|word| u32::from(word.to_le_bytes()[byte])).sum();
    let cells = |which: &dyn Fn(u32) -> bool| state.iter().filter(|&&word| which(word)).count() as u32;
    vec![
        pixels(0),
        pixels(1),
        pixels(2),
        cells(&|word| word & 4 != 0),
        cells(&|word| word & 8 != 0),
        cells(&|word| word % 4 == 2),
        cells(&|word| word % 4 == 1),
        0,
    ]
}
