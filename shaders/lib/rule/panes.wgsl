// The layer of panes, for the rule. Needs lib/record, the rule.
@group(0) @binding(4) var<storage, read> pane_cells: array<vec2<u32>>;

fn panes_say(slot: u32) -> Said {
    let pane = pane_cells[slot];
    return Said(select(PANES_PANE, PANES_NONE, pane.y == 0u), pane.y, sensor_of(pane.x));
}
