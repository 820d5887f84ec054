// A map without panes.
fn forget_panes(slot: u32) {}
