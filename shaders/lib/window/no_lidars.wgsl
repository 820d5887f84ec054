// A map without lidars.
fn forget_lidars(slot: u32) {}
