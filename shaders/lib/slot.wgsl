// Where window cell (x, y) lies in a ring buffer of kept cells.
fn slot_of(x: u32, y: u32, origin_slot_x: u32, origin_slot_y: u32, side: u32) -> u32 {
    let sx = x + origin_slot_x;
    let sy = y + origin_slot_y;
    return select(sy, sy - side, sy >= side) * side + select(sx, sx - side, sx >= side);
}
