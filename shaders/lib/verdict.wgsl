// The rule's word of a cell (map::Verdict): cost in bits 0-7, row in 8-11, sensor + 1 in 12-16, age in tenths of a second in 17-31.
const COST_FREE = 0u;
const COST_INSCRIBED = 253u;
const COST_LETHAL = 254u;
const COST_UNKNOWN = 255u;
const MOST_AGE = 32767u;

fn verdict_of(cost: u32, row: u32, sensor: u32, age_tenths: u32) -> u32 {
    return cost | (row << 8u) | (sensor << 12u) | (min(age_tenths, MOST_AGE) << 17u);
}

fn verdict_cost(verdict: u32) -> u32 {
    return verdict & 0xffu;
}

fn verdict_row(verdict: u32) -> u32 {
    return (verdict >> 8u) & 0xfu;
}
