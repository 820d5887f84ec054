// The ground as each sensor saw it, kept from message to message: the buffer `ground`. Needs lib/ground/ground.
struct Kept {
    plane: vec4<f32>,   // from the local origin
    tick: u32,          // of the last message that showed it; 0: none did
    count: u32,         // of messages that showed it, up to MOST_COUNT
    area_m2: f32,       // of what showed it last
    agrees: u32,        // 1: the stated ground is taken for it
}

const MOST_COUNT = 1000u;

fn is_fresh(kept: Kept) -> bool {
    return kept.tick != 0u && max(ground_params.tick, kept.tick) - kept.tick <= ground_params.keep_ticks;
}

// The plane from the sensor.
fn from_sensor(kept: Kept) -> vec4<f32> {
    return vec4(kept.plane.xyz, kept.plane.w - dot(kept.plane.xyz, sensor_place()));
}

// Whose plane is taken where several have one: the sensor's own, else the one with the most area, the first of equals; none of
// them: the number of sensors.
fn best_kept() -> u32 {
    var best = ground_params.sensors;
    var area_m2 = 0.0;
    for (var k = 0u; k < ground_params.sensors; k++) {
        let kept = ground[k];
        let own = k == ground_params.sensor;
        if is_fresh(kept) && (own || kept.area_m2 > area_m2) {
            area_m2 = select(kept.area_m2, 1.0e9, own);
            best = k;
        }
    }
    return best;
}
