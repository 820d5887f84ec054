// A map without panes, for the rule. Needs the rule.
fn panes_say(slot: u32) -> Said {
    return Said(PANES_NONE, 0u, 0u);
}
