// Whether a beam has two returns and the one in the last slot is the farther (spec 3 §1). Needs lib/glass/grid.
fn two_returns(first: u32, last: u32) -> bool {
    return first != NONE && last != NONE
        && f32(steps_in(last)) > f32(steps_in(first)) + glass_params.return_gap_m * RANGE_STEPS_PER_M;
}
