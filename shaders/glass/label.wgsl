// Labels every point by the pane that its beam meets first, and by what the pane mirrors. spec 3 §5, steps 1 and 2.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> places: array<u32>;
@group(0) @binding(3) var<storage, read> cells: array<u32>;
@group(0) @binding(4) var<storage, read> elevation_rows: array<u32>;
@group(0) @binding(5) var<storage, read> panes: Panes;
@group(0) @binding(6) var<storage, read> around: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> pane_counts: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> labels: array<u32>;

const M_PER_MM = 0.001;
// A second return proves transmission, so such a return may be this much brighter than glass otherwise is.
const DUAL_BRIGHTER = 3.0;
// Cells of the 3 x 3 around a beam that must have a mirrored surface, and that must be measured for a place to be free.
const LEAST_MIRRORED = 2u;
const LEAST_MEASURED = 4u;

struct Shown {
    matches: bool,      // a surface lies there
    beyond: bool,       // every surface around lies nearer
}

fn tolerance(range_m: f32) -> f32 {
    return glass_params.match_m + glass_params.match_per_m * range_m;
}

fn neighbour(place: u32, column_step: i32, row_step: i32) -> u32 {
    let rows = i32(glass_params.rows);
    let columns = i32(glass_params.columns);
    let row = i32(place) % rows + row_step;
    if row < 0 || row >= rows {
        return NONE;
    }
    let column = (i32(place) / rows + column_step + columns) % columns;
    return u32(column * rows + row);
}

// Step 1: against the mirrored surfaces around the beam.
fn against_mirrored(place: u32, range_m: f32) -> Shown {
    let near = tolerance(range_m);
    var matches = false;
    var count = 0u;
    for (var c = -1; c <= 1; c++) {
        for (var r = -1; r <= 1; r++) {
            let other = neighbour(place, c, r);
            if other != NONE {
                let range_mm = around[other].x;
                let some = range_mm != NONE;
                matches = matches || (some && abs(f32(range_mm) * M_PER_MM - range_m) < near);
                count += select(0u, 1u, some);
            }
        }
    }
    let reach = i32(glass_params.half_rows);
    var seen = vec2(0u);
    for (var r = -reach; r <= reach; r++) {
        let other = neighbour(place, 0, r);
        if other != NONE {
            let word = around[other].y;
            seen = vec2(max(seen.x, word >> COUNT_BITS), seen.y + (word & ((1u << COUNT_BITS) - 1u)));
        }
    }
    // At least half of the surroundings must be mirrored: beside the image of one small thing nothing is proven.
    let window = (2u * glass_params.half_rows + 1u) * (2u * glass_params.half_columns + 1u);
    let beyond = count >= LEAST_MIRRORED && 2u * seen.y >= window && f32(seen.x) * M_PER_MM < range_m - near;
    return Shown(matches, beyond);
}

// Step 2: against what is measured along the ray to the mirrored place.
fn against_measured(image: vec3<f32>) -> Shown {
    let range_m = length(image);
    let near = tolerance(range_m);
    let row = elevation_rows[elevation_bin(image)];
    if row >= glass_params.rows {
        return Shown(false, false);
    }
    let place = column_of(image, glass_params.columns) * glass_params.rows + row;
    var matches = false;
    var passes = cells[2u * place] != NONE;
    var count = 0u;
    for (var c = -1; c <= 1; c++) {
        for (var r = -1; r <= 1; r++) {
            let other = neighbour(place, c, r);
            if other != NONE && cells[2u * other] != NONE {
                let measured_m = f32(steps_in(cells[2u * other])) / RANGE_STEPS_PER_M;
                matches = matches || abs(measured_m - range_m) < near;
                passes = passes && measured_m > range_m + near;
                count += 1u;
            }
        }
    }
    return Shown(matches, passes && count >= LEAST_MEASURED);
}

fn class_behind(slot: u32, p: vec3<f32>, place: u32, over: f32) -> u32 {
    let mirror = against_mirrored(place, length(p));
    let measured = against_measured(mirrored_in(panes.list[slot], p));
    if mirror.matches || measured.matches {
        return REFLECTION;
    }
    // Nothing before the pane lies as far from it as this point behind it.
    let deepest_m = f32(atomicLoad(&pane_counts[slot * PANE_COUNTS + ROOM_DEPTH])) * M_PER_MM;
    let too_deep = over > deepest_m + 2.0 * glass_params.match_m;
    return select(UNLABELLED, OUTSIDE, mirror.beyond || measured.beyond || too_deep);
}

fn is_glass(pane: Pane, point: vec4<f32>, place: u32) -> bool {
    let dual = two_returns(cells[2u * place], cells[2u * place + 1u]);
    let limit = pane.level.w * select(1.0, DUAL_BRIGHTER, dual);
    let head_on = dot(pane.normal.xyz, point.xyz) > glass_params.lobe_cos * length(point.xyz);
    return pane.level.w <= 0.0 || head_on || point.w < limit;
}

fn count_in(slot: u32, what: u32) {
    atomicAdd(&pane_counts[slot * PANE_COUNTS + what], 1u);
}

@compute @workgroup_size(64)
fn label(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= glass_params.points {
        return;
    }
    let place = places[id.x];
    labels[id.x] = label_of(select(INSIDE, UNLABELLED, place == NONE), 0u);
    if place == NONE {
        return;
    }
    let point = points[2u * id.x];
    let met = first_met(point.xyz);
    if met.slot == NONE {
        return;
    }
    let pane = panes.list[met.slot];
    let first = slot_of_return(points[2u * id.x + 1u]) == 0u;
    let on = met.over < glass_params.plane_tolerance_m;
    if first && dot(pane.normal.xyz, point.xyz) > glass_params.visible_cos * length(point.xyz) {
        count_in(met.slot, select(PASSING, SHOWING, on));
    }
    if !on {
        let kind = class_behind(met.slot, point.xyz, place, met.over);
        if kind == REFLECTION {
            count_in(met.slot, REFLECTIONS);
        }
        if kind == OUTSIDE {
            count_in(met.slot, OUTSIDES);
        }
        labels[id.x] = label_of(kind, pane.id);
    } else if first && is_glass(pane, point, place) {
        labels[id.x] = label_of(GLASS, pane.id);
    }
}
