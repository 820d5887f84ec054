// When, by whom and how a cell was last seen by a camera (spec 4 §1). Needs lib/cell, lib/record, lib/weight.
//   x: tick; y: lowest hit above the height band's lower edge in bits 0-15, in steps of 1/1024 m, 0 where it is not known;
//   mean R of the last hit in bits 16-23, in 1/255; sensor + 1
struct CellMarksParams {
    tick: u32,
    sensor: u32,                    // + 1
    log2_lambda_per_tick: f32,      // of the share of the old occupancy that a tick leaves
    pad: u32,
}

// Whether the old occupancy counts less the longer ago it is, else by the number of observations.
override timed: bool = false;
// Whether back_project keeps the lowest hits.
override lowest: bool = false;

@group(0) @binding(7) var<uniform> cell_marks_params: CellMarksParams;
@group(0) @binding(8) var<storage, read_write> cell_marks: array<vec2<u32>>;

// Whether the cell was seen since, which only another camera can have done: then this frame changes nothing of it.
fn is_late(slot: u32) -> bool {
    return timed && cell_marks[slot].x > cell_marks_params.tick;
}

fn lambda_of(slot: u32) -> f32 {
    let last = cell_marks[slot].x;
    if !timed || last == 0u {
        return update_params.lambda;
    }
    let since = max(cell_marks_params.tick, last) - last;
    return exp2(cell_marks_params.log2_lambda_per_tick * f32(since));
}

// Mean R of the frame's hits in 1/255.
fn mean_reliability(hits: CellHits) -> u32 {
    if !weighted || (gated && !lowest) {
        return 255u;
    }
    let mean = f32(hits.weight) / (f32(max(hits.count, 1u)) * update_params.weight_scale);
    return u32(clamp(mean, 0.0, 1.0) * 255.0 + 0.5);
}

// Lowest hit of the frame.
fn low_of(hits: CellHits) -> u32 {
    return u32(min(steps_to_height(max(~hits.low, FLOOR + 1u)) * RECORD_STEPS_PER_M, MOST_RECORD_STEPS));
}

// Marks a cell that was hit, or else seen through. `had_hits`: hits before this frame are remembered; `keeps_hits`: they stay so
// when it is seen through.
fn mark(slot: u32, hit: bool, hits: CellHits, had_hits: bool, keeps_hits: bool) {
    var low = 0u;
    var reliability = select(0u, mean_reliability(hits), hit);
    if lowest {
        let old = cell_marks[slot].y;
        let kept = old & 0xffffu;
        let hit_low = select(low_of(hits), min(low_of(hits), kept), had_hits);
        low = select(select(0u, kept, keeps_hits), hit_low, hit);
        reliability = select(select(0u, (old >> 16u) & 0xffu, keeps_hits), reliability, hit);
    }
    let sensor = cell_marks_params.sensor << SENSOR_SHIFT;
    cell_marks[slot] = vec2(cell_marks_params.tick, low | (reliability << 16u) | sensor);
}
