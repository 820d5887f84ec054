// The pane that the way to a point meets first. spec 3 §5 (per pane).
struct Met {
    slot: u32,      // NONE where it meets none
    over: f32,      // how far the point lies behind it, metres; within the tolerance it lies on it
}

fn first_met(p: vec3<f32>) -> Met {
    var met = Met(NONE, 0.0);
    var least = 3.0e38;
    let slots = pane_slots();
    for (var k = 0u; k < slots; k++) {
        let pane = pane_at(k);
        if pane.id != 0u {
            let crossing = cross_pane(pane, p, MARGIN_M);
            let reached = crossing.inside && crossing.over > -glass_params.plane_tolerance_m;
            if reached && crossing.share < least {
                least = crossing.share;
                met = Met(k, crossing.over);
            }
        }
    }
    return met;
}
