// Joins inflated and passable cells to the plan map, with its costs in Nav2's scale and a class per cell, four cells a word.
// spec 2 §4 (Eq. 11 of the paper).
struct PlanMapParams {
    side: u32,
    quads: u32,             // words of four cells a row
    passable_cost: u32,
    solid_value: f32,       // value of a layer that counts fully
}

// Whether the values are kept for the host.
override keep_layers: bool = true;

@group(0) @binding(0) var<uniform> plan_map_params: PlanMapParams;
@group(0) @binding(1) var<storage, read> cell_class: array<u32>;
@group(0) @binding(2) var<storage, read> inflation: array<u32>;
@group(0) @binding(3) var<storage, read> obstacle_value: array<f32>;
@group(0) @binding(4) var<storage, read_write> plan_costs: array<u32>;
@group(0) @binding(5) var<storage, read_write> plan_classes: array<u32>;
@group(0) @binding(6) var<storage, read_write> cell_values: array<vec4<f32>>;

const COST_INSCRIBED = 253u;
const COST_LETHAL = 254u;
const COST_UNKNOWN = 255u;

// Cost of an inflated cell: 1 to 252 by its value, 253 within the inscribed radius.
fn inflated_cost(steps: u32, inscribed: bool) -> u32 {
    return select(1u + 251u * steps / u32(INTENSITY_STEPS), COST_INSCRIBED, inscribed);
}

// Class and cost, in bits 0-7 and 8-15. Unknown is overwritten only within the inscribed radius, as in `inflate/columns`.
fn plan_cell(kind: u32, steps: u32, inscribed: bool) -> u32 {
    if kind == SOLID || kind == TRANSPARENT {
        return kind | (COST_LETHAL << 8u);
    }
    let passable = select(0u, plan_map_params.passable_cost, kind == PASSABLE);
    if steps > 0u {
        let cost = inflated_cost(steps, inscribed);
        if cost >= select(passable, COST_INSCRIBED, kind == UNKNOWN) {
            return INFLATED | (cost << 8u);
        }
    }
    return kind | (select(passable, COST_UNKNOWN, kind == UNKNOWN) << 8u);
}

// I_TP, I_FP, I_FN and I_inflate.
fn keep(cell: u32, kind: u32, steps: u32) {
    let per_step = plan_map_params.solid_value / INTENSITY_STEPS;
    let value = obstacle_value[cell];
    let solid = (kind & 0xffu) == SOLID;
    let glass = f32((kind >> GLASS_SHIFT) & GLASS_MASK) * per_step;
    cell_values[cell] = vec4(select(0.0, value, solid), select(value, 0.0, solid), glass, f32(steps) * per_step);
}

@compute @workgroup_size(8, 8)
fn plan_map(@builtin(global_invocation_id) id: vec3<u32>) {
    let quads = plan_map_params.quads;
    let side = plan_map_params.side;
    if id.x >= quads || id.y >= side {
        return;
    }
    let first = 4u * id.x;
    var costs = 0u;
    var classes = 0u;
    for (var i = 0u; i < 4u; i++) {
        let column = first + i;
        let cell = id.y * side + min(column, side - 1u);
        let spread = inflation[cell];
        let steps = min(spread & 0x7fffffffu, u32(INTENSITY_STEPS));
        let kind = cell_class[cell];
        let planned = plan_cell(kind & 0xffu, steps, spread > 0x7fffffffu);
        if keep_layers && column < side {
            keep(cell, kind, steps);
        }
        classes |= (planned & 0xffu) << (8u * i);
        costs |= (planned >> 8u) << (8u * i);
    }
    plan_costs[id.y * quads + id.x] = costs;
    plan_classes[id.y * quads + id.x] = classes;
}
