// A map without drops.
fn forget_drops(slot: u32) {}
