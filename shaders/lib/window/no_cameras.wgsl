// A map without cameras.
fn forget_cameras(slot: u32) {}
