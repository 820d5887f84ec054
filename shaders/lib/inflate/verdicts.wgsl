// Obstacles and costs before inflation, from the rule's verdicts (spec 4 §2). Needs lib/verdict.
@group(0) @binding(1) var<storage, read> verdicts: array<u32>;

fn is_obstacle(cell: u32) -> bool {
    return verdict_cost(verdicts[cell]) == COST_LETHAL;
}

fn base_cost(cell: u32) -> u32 {
    return verdict_cost(verdicts[cell]);
}
