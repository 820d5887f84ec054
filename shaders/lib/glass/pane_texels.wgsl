// Panes as texels, four to a pane. Needs lib/glass/pane and the texture `pane_texels`.
// On lavapipe a texel costs a fraction of a buffer's vector. Whole numbers in them are exact, as a label has 24 bits for an id.
fn pane_at(slot: u32) -> Pane {
    let last = textureLoad(pane_texels, vec2(3u, slot), 0u);
    return Pane(
        textureLoad(pane_texels, vec2(0u, slot), 0u),
        textureLoad(pane_texels, vec2(1u, slot), 0u),
        textureLoad(pane_texels, vec2(2u, slot), 0u),
        u32(last.x),
        u32(last.y),
        0u,
        0u,
    );
}

// Slots that may hold one.
fn pane_slots() -> u32 {
    return min(u32(textureLoad(pane_texels, vec2(3u, 0u), 0u).z), KEPT_PANES);
}
