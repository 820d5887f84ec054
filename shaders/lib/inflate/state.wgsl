// Obstacles and costs before inflation, from the cameras' states alone. Needs lib/cell.
@group(0) @binding(1) var<storage, read> state: array<u32>;

fn is_obstacle(cell: u32) -> bool {
    return see_state(state[cell]) == OCCUPIED;
}

fn base_cost(cell: u32) -> u32 {
    return select(0u, 255u, see_state(state[cell]) == UNKNOWN);
}
