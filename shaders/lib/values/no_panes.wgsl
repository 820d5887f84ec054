// A map without panes.
fn has_pane(slot: u32) -> bool {
    return false;
}
