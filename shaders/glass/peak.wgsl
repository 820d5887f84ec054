// Intensity peaks: in the row nearest the horizontal a run along azimuth that rises to a maximum and falls, confirmed by
// the two rows above and the two below. spec 3 §2.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(2) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(3) var<storage, read_write> peaks: array<atomic<u32>>;

// The run ends where the intensity has fallen to this share of its maximum.
const FOOT_SHARE = 0.4;
// A lobe falls gradually: from one column to the next no more than this share of its maximum, over the columns to its foot
// (a Gaussian's steepest: 0.82), and noise more. A bright face beside dark ones is a plateau that ends in a step.
const STEEPEST = 1.25;
const STEP_NOISE = 0.15;
// How much of the maximum it may rise again on its way down: noise.
const NOISE_SHARE = 0.1;
// Rows above and below must fall to this share of their own maximum.
const ROW_SHARE = 0.75;
// Half the widest run: glass shows within 20 degrees of head on (spec 3 §1).
const WIDEST_RAD = 0.35;
// Fewest columns on each side of the maximum.
const LEAST_COLUMNS = 2u;
// Points of a run lie closer than this many steps of azimuth, plus noise in metres.
const GAP_STEPS = 3.0;
const GAP_NOISE_M = 0.1;

fn at(column: u32, row: u32) -> vec4<f32> {
    let word = beam_cells[2u * (column * glass_params.rows + row)];
    if word == NONE {
        return vec4(0.0, 0.0, 0.0, -1.0);
    }
    return point_at(index_in(word));
}

fn step_column(column: u32, steps: u32, forward: bool) -> u32 {
    let columns = glass_params.columns;
    return select(column + columns - steps, column + steps, forward) % columns;
}

// Columns from the maximum to the foot of the run on one side; 0 where it has none.
fn foot(top_column: u32, top: vec4<f32>, forward: bool) -> u32 {
    let step_rad = 2.0 * PI / f32(glass_params.columns);
    let widest = min(u32(WIDEST_RAD / step_rad), glass_params.columns / 4u);
    var before = top;
    var steepest = 0.0;
    for (var k = 1u; k < widest + 1u; k++) {
        let next = at(step_column(top_column, k, forward), glass_params.level_row);
        let gap = GAP_NOISE_M + GAP_STEPS * step_rad * length(top.xyz);
        if next.w < 0.0 || distance(next.xyz, before.xyz) > gap || next.w > before.w + NOISE_SHARE * top.w {
            return 0u;
        }
        steepest = max(steepest, before.w - next.w);
        if next.w <= FOOT_SHARE * top.w {
            let gradual = steepest <= (STEEPEST / f32(k) + STEP_NOISE) * top.w;
            return select(0u, k, k >= LEAST_COLUMNS && gradual);
        }
        before = next;
    }
    return 0u;
}

fn confirms(row: u32, column: u32, left: u32, right: u32) -> bool {
    let top = at(column, row).w;
    let before = at(step_column(column, left, false), row).w;
    let after = at(step_column(column, right, true), row).w;
    return top > 0.0 && before >= 0.0 && after >= 0.0 && max(before, after) <= ROW_SHARE * top;
}

@compute @workgroup_size(64)
fn peak(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = glass_params.level_row;
    if id.x >= glass_params.columns || row < 2u || row + 2u >= glass_params.rows {
        return;
    }
    let top = at(id.x, row);
    let before = at(step_column(id.x, 1u, false), row);
    let after = at(step_column(id.x, 1u, true), row);
    if top.w <= 0.0 || before.w > top.w || after.w >= top.w {
        return;
    }
    let left = foot(id.x, top, false);
    let right = foot(id.x, top, true);
    if left == 0u || right == 0u {
        return;
    }
    for (var other = row - 2u; other < row + 3u; other++) {
        if other != row && !confirms(other, id.x, left, right) {
            return;
        }
    }
    for (var other = row - 2u; other < row + 3u; other++) {
        for (var k = 0u; k < left + right + 1u; k++) {
            let column = step_column(step_column(id.x, left, false), k, true);
            atomicStore(&peaks[column * glass_params.rows + other], 1u);
        }
    }
}
