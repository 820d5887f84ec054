// Whether some trusted ray passes through a cell without hits: the walk ends at the first one (spec 1 §3). Needs see_through/gather.
@group(0) @binding(5) var<storage, read> around_far_m: array<f32>;

// Pixels walked between looks at the tiles: half a tile, so that a bend by the lens stays within one.
const RUN = 8.0;

// Whether any trusted pixel within a tile's side of the stretch at s can look that far.
fn may_pass(stretch: Stretch, s: f32, inverse_z: f32, behind: f32) -> bool {
    let last = vec2(f32(see_through_gather_params.width - 1u), f32(see_through_gather_params.height - 1u));
    let p = vec2<u32>(clamp(pixel_of(mix(stretch.from_ray, stretch.to_ray, s)), vec2(0.0), last)) / TILE;
    return around_far_m[p.y * see_through_gather_params.tiles_x + p.x] * inverse_z > behind;
}

// Walks the stretch from pixel `first` in runs of RUN pixels to one whose surroundings reach far enough.
fn next_run(stretch: Stretch, first: f32, behind: f32) -> f32 {
    var at = first;
    while at < stretch.samples {
        let s = (vec2(at, min(at + RUN, stretch.samples))) / stretch.samples;
        let inverse_z = mix(vec2(stretch.inverse_z.x), vec2(stretch.inverse_z.y), s);
        if may_pass(stretch, 0.5 * (s.x + s.y), max(inverse_z.x, inverse_z.y), behind) {
            break;
        }
        at += RUN;
    }
    return at;
}

// Whether some pixel along the stretch looks past `behind` times its own depth there.
fn any_ray_passes(stretch: Stretch, behind: f32) -> bool {
    var run = next_run(stretch, 0.0, behind);
    while run < stretch.samples {
        let end = min(run + RUN, stretch.samples);
        for (var i = run; i < end; i += 1.0) {
            if ray_passes(pixel_on(stretch, (i + 0.5) / stretch.samples), stretch, (i + 0.5) / stretch.samples, behind) {
                return true;
            }
        }
        run = next_run(stretch, end, behind);
    }
    return false;
}

// Height up to which a ray through the cell clears it: the band, but no higher than what was hit there.
fn clearing_height(place: Place) -> f32 {
    let top = to_cell(cells[place.slot]).top;
    if top == 0u {
        return see_through_gather_params.height_max_m;
    }
    return min(see_through_gather_params.height_max_m, see_through_gather_params.height_min_m + steps_to_height(top));
}

// 1 where the cell is seen through, or a trusted floor point lies in it; else 0.
fn looked_through(place: Place) -> u32 {
    if cell_hits[place.cell].count >= see_through_gather_params.min_hits {
        return 0u;
    }
    var seen = select(0u, 1u, cell_hits[place.cell].top == FLOOR);
    if seen == 0u && place.behind > 0.0 {
        let stretch = stretch_of(place.centre, see_through_gather_params.height_min_m, clearing_height(place));
        seen = select(0u, 1u, any_ray_passes(stretch, place.behind));
    }
    return seen;
}
