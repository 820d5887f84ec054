// Which share of the pixels that look at a cell look through it, hits or not (spec 1 §9, step 3). Needs lib/layers, see_through/gather.

// Pixels looked at along a vertical, at most: a near cell has hundreds, and the share is kept to a few hundredths.
const MOST_LOOKS = 64.0;

// Share of the pixels in view along the stretch that are trusted and look past `behind` times their own depth there.
fn share_that_passes(stretch: Stretch, behind: f32) -> f32 {
    let looks = u32(min(stretch.samples, MOST_LOOKS));
    var in_view = 0.0;
    var passing = 0.0;
    for (var i = 0u; i < looks; i++) {
        let s = (f32(i) + 0.5) / f32(looks);
        let pixel = pixel_on(stretch, s);
        in_view += select(0.0, 1.0, pixel != NO_PIXEL);
        passing += select(0.0, 1.0, ray_passes(pixel, stretch, s, behind));
    }
    return passing / max(in_view, 1.0);
}

// Heights above the ground between which looks through count: the layers of the frame's hits; without hits up to that of the
// highest hit recorded; else the whole band.
fn heights_that_count(hit: bool, hits: CellHits, top: u32) -> vec2<f32> {
    let low_m = see_through_gather_params.height_min_m;
    let high_m = see_through_gather_params.height_max_m;
    if hit {
        let lowest = steps_to_height(max(~hits.low, FLOOR + 1u));
        let highest = steps_to_height(max(hits.top, FLOOR + 1u));
        return vec2(low_m + layer_floor(lowest), min(high_m, low_m + layer_ceiling(highest)));
    }
    if top > FLOOR {
        return vec2(low_m, min(high_m, low_m + layer_ceiling(steps_to_height(top))));
    }
    return vec2(low_m, high_m);
}

// Whether one of the eight neighbours was occupied by enough evidence of its own before this frame. Cells are not written in this pass.
fn is_beside_occupied(x: u32, y: u32) -> bool {
    let side = see_through_gather_params.side;
    var beside = false;
    for (var i = 0u; i < 9u; i++) {
        // Clamped to the window, where a place outside of it stands for one inside; the cell itself is none of its neighbours.
        let near = clamp(vec2(x, y) + vec2(i % 3u, i / 3u), vec2(1u), vec2(side)) - 1u;
        let slot = slot_of(near.x, near.y, see_through_gather_params.origin_slot_x, see_through_gather_params.origin_slot_y, side);
        let cell = to_cell(cells[slot]);
        let occupied = see_state(cell.state) == OCCUPIED && cell.occupancy >= NEED;
        beside = beside || (occupied && any(near != vec2(x, y)));
    }
    return beside;
}

// The share in SHARE_ONE, rounded up so that any look counts, and BESIDE.
fn looked_through(place: Place) -> u32 {
    let hits = cell_hits[place.cell];
    let hit = hits.count >= see_through_gather_params.min_hits;
    let cell = to_cell(cells[place.slot]);
    var word = 0u;
    if place.behind > 0.0 {
        let heights = heights_that_count(hit, hits, cell.top);
        let share = share_that_passes(stretch_of(place.centre, heights.x, heights.y), place.behind);
        word = u32(ceil(share * f32(SHARE_ONE)));
    }
    if (hit || cell.occupancy >= NEED_BESIDE) && see_state(cell.state) != OCCUPIED && is_beside_occupied(place.x, place.y) {
        word |= BESIDE;
    }
    return word;
}
