// A map of one camera that keeps no marks of its cells.
fn is_late(slot: u32) -> bool {
    return false;
}

fn lambda_of(slot: u32) -> f32 {
    return update_params.lambda;
}

fn mark(slot: u32, hit: bool, hits: CellHits, had_hits: bool, keeps_hits: bool) {}
