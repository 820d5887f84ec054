// Whether a scan shows the ground in a cell. Needs drop_marks.
fn is_ground(cell: u32) -> bool {
    return drop_marks[2u * cell + 1u] != 0u;
}
