// Labels the points whose beams meet a pane by what the pane mirrors. spec 3 §5, steps 1 and 2.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(2) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(3) var row_texels: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(4) var pane_texels: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(5) var<storage, read> mirrored: array<u32>;
@group(0) @binding(6) var<storage, read> met_points: array<u32>;
@group(0) @binding(7) var<storage, read_write> pane_counts: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> classes: array<u32>;

const M_PER_MM = 0.001;
// A second return proves transmission, so such a return may be this much brighter than glass otherwise is.
const DUAL_BRIGHTER = 3.0;
// Cells of the 3 x 3 around a beam that must have a mirrored surface.
const LEAST_MIRRORED = 2u;

// Nearer to a pane's edge than this a beam may go past it, metres: it does not count for or against the pane.
const EDGE_M = 0.2;

struct Touching {
    matches: bool,      // a mirrored surface lies there
    count: u32,         // cells that have one
}

// Step 1: against the mirrored surfaces next to the beam.
fn touching(column: u32, row: u32, range_m: f32) -> Touching {
    let near = tolerance(range_m);
    var around = cells_around(column, row, 1u, 1u);
    var found = Touching(false, 0u);
    for (var c = 0u; c < 3u; c++) {
        for (var r = around.least_row; r < around.end_row; r++) {
            let range_mm = mirrored[around.column * glass_params.rows + r];
            let some = range_mm != NONE;
            found.matches = found.matches || (some && abs(f32(range_mm) * M_PER_MM - range_m) < near);
            found.count += select(0u, 1u, some);
        }
        around.column = next_column(around.column);
    }
    return found;
}

// Step 1: whether all that is mirrored around the beam is nearer.
fn beyond_mirrored(column: u32, row: u32, range_m: f32) -> bool {
    let reach = vec2(glass_params.half_columns, glass_params.half_rows);
    var around = cells_around(column, row, reach.x, reach.y);
    var seen = 0u;
    var farthest_mm = 0u;
    for (var c = 0u; c < 2u * reach.x + 1u; c++) {
        for (var r = around.least_row; r < around.end_row; r++) {
            let range_mm = mirrored[around.column * glass_params.rows + r];
            let some = range_mm != NONE;
            seen += select(0u, 1u, some);
            farthest_mm = max(farthest_mm, select(0u, range_mm, some));
        }
        around.column = next_column(around.column);
    }
    // At least half of the surroundings must be mirrored: beside the image of one small thing nothing is proven.
    let window = (2u * reach.x + 1u) * (2u * reach.y + 1u);
    return 2u * seen >= window && f32(farthest_mm) * M_PER_MM < range_m - tolerance(range_m);
}

fn class_behind(slot: u32, pane: Pane, p: vec3<f32>, place: u32, over: f32) -> u32 {
    let column = place / glass_params.rows;
    let row = place - column * glass_params.rows;
    let mirror = touching(column, row, length(p));
    let measured = against_measured(mirrored_in(pane, p));
    // Nothing before the pane lies as far from it as this point behind it.
    let deepest_m = f32(atomicLoad(&pane_counts[slot * PANE_COUNTS + ROOM_DEPTH])) * M_PER_MM;
    let too_deep = over > deepest_m + 2.0 * glass_params.match_m;
    let matches = mirror.matches || measured.matches;
    var real = measured.beyond || too_deep;
    for (var turn = 0u; turn < turns_if(!matches && !real && mirror.count >= LEAST_MIRRORED); turn++) {
        real = beyond_mirrored(column, row, length(p));
    }
    return select(select(UNLABELLED, OUTSIDE, real), REFLECTION, matches);
}

fn is_glass(pane: Pane, point: vec4<f32>, place: u32) -> bool {
    let dual = two_returns(beam_cells[2u * place], beam_cells[2u * place + 1u]);
    let limit = pane.level.w * select(1.0, DUAL_BRIGHTER, dual);
    let head_on = dot(pane.normal.xyz, point.xyz) > glass_params.lobe_cos * length(point.xyz);
    return pane.level.w <= 0.0 || head_on || point.w < limit;
}

fn count_in(slot: u32, what: u32) {
    atomicAdd(&pane_counts[slot * PANE_COUNTS + what], 1u);
}

// Nearer to its ends than this a return on a mirror's plane may be of the wall around it, metres.
const MIRROR_EDGE_M = 0.1;

// A mirror returns little of its own, and nothing real stands behind it: what lies there where the sensor sees through the mirrored
// place counts against it.
fn label_in_mirror(slot: u32, pane: Pane, p: vec3<f32>, on: bool) -> u32 {
    let within = cross_pane(pane, p, -MIRROR_EDGE_M).inside;
    if on {
        return select(label_of(INSIDE, 0u), label_of(GLASS, pane.id), within);
    }
    let measured = against_measured(mirrored_in(pane, p));
    if within {
        count_in(slot, select(select(OUTSIDES, PASSING, measured.beyond), SHOWING, measured.matches));
    }
    return label_of(select(REFLECTION, UNLABELLED, measured.beyond && !measured.matches), pane.id);
}

fn label_met(index: u32, place: u32, slot: u32) -> u32 {
    let point = point_at(index);
    let pane = pane_at(slot);
    if is_mirror(pane) {
        return label_in_mirror(slot, pane, point.xyz, dot(pane.normal.xyz, point.xyz) - pane.normal.w < glass_params.plane_tolerance_m);
    }
    let first = slot_of_return(rest_of_point(index)) == 0u;
    let over = dot(pane.normal.xyz, point.xyz) - pane.normal.w;
    let on = over < glass_params.plane_tolerance_m;
    let head_on = dot(pane.normal.xyz, point.xyz) > glass_params.visible_cos * length(point.xyz);
    if first && head_on && cross_pane(pane, point.xyz, -EDGE_M).inside {
        count_in(slot, select(PASSING, SHOWING, on));
    }
    if on {
        return select(label_of(INSIDE, 0u), label_of(GLASS, pane.id), first && is_glass(pane, point, place));
    }
    let kind = class_behind(slot, pane, point.xyz, place, over);
    if kind == REFLECTION {
        count_in(slot, REFLECTIONS);
    }
    if kind == OUTSIDE {
        count_in(slot, OUTSIDES);
    }
    return label_of(kind, pane.id);
}

@compute @workgroup_size(64)
fn label(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let count = met_points[MET_COUNT];
    let turns = turns_from(id.x, count, 64u * groups.x);
    for (var turn = 0u; turn < turns; turn++) {
        let number = id.x + 64u * groups.x * turn;
        let index = met_points[met_at(number)];
        let place = met_points[met_at(number) + 1u];
        classes[index] = label_met(index, place, min(classes[index] >> 8u, KEPT_PANES - 1u));
    }
}
