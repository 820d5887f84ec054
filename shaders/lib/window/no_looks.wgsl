// For maps without map reliability.
fn forget_looks(slot: u32) {}
