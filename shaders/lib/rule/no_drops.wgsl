// A map without drops, for the rule.
fn drops_say(slot: u32) -> Said {
    return Said(0u, 0u, 0u);
}
