// Classifies every cell by its layers, joins what glass there is with what was remembered, and keeps the class in the solidity
// layer. spec 2 §3 (Eq. 3-7 of the paper): solid, passable, transparent, free, unknown; spec 4 §1 (the layer).
struct IntensityClassesParams {
    heights: array<vec4<f32>, 5>,   // bounds of the tall layers, ascending, above the lidar
    lidar: vec2<f32>,               // the lidar in the window, metres
    side: u32,
    tall: u32,                      // tall layers; the planes follow
    origin_slot_x: u32,
    origin_slot_y: u32,
    resolution_m: f32,
    gamma: f32,
    transparent_threshold: f32,
    solid_value: f32,               // value of a layer that counts fully
    keep_share: f32,                // share of a remembered value that is kept
    min_returns: u32,
    rays_per_rad: f32,              // firings per radian of azimuth, for the expected number of beams
    rings_per_rad: f32,             // rings per radian of elevation
    elevation_low: f32,             // radians
    elevation_high: f32,
    shift_x: i32,                   // cells moved since the scan before
    shift_y: i32,
    forget: u32,                    // 1: nothing is remembered
    standing: u32,                  // 1: a layer with any intensity counts fully, as only what stands has some
}

struct SolidCellsParams {
    tick: u32,
    sensor: u32,                // + 1
    lidar_height_m: f32,        // above the stated ground
    pad: u32,
}

// Fraction bits of remembered steps, so that rounding does not speed up or stop a slow decay.
const REMEMBERED_BITS = 20u;

// What a layer's value is: 0 the paper's sum over the area, 1 the mean, 2 the sum over the expected number of beams.
override measure: u32 = 1u;
// Whether returns of high intensity clear remembered glass before them.
override clearing: bool = false;
// Whether the layers' values are kept for the host.
override keep_layers: bool = true;

@group(0) @binding(0) var<uniform> intensity_classes_params: IntensityClassesParams;
@group(0) @binding(1) var<storage, read> layer_sums: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> sector_range: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> remembered: array<u32>;
// The solidity layer.
//   x: the cell's word; y: tick of the last evidence; z: heights between which beams crossed a free cell, 16 bits each, from
//   CROSSING_ZERO_M below the ground, 0: not known; w: largest gap between two of these beams, and sensor + 1
@group(0) @binding(4) var<storage, read_write> solid_cells: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> obstacle_value: array<f32>;
@group(0) @binding(6) var<storage, read_write> layer_values: array<f32>;
@group(0) @binding(7) var<uniform> solid_cells_params: SolidCellsParams;
// 1: x: above 0 where the ground was seen, y: the lidar's height above it (spec 6 §2).
@group(0) @binding(9) var<storage, read> ground_now: array<vec4<f32>>;

// A cell as the lidar sees it.
struct Place {
    sector: u32,
    range: f32,     // of its centre, metres
    behind: u32,    // range from which a beam has left it, steps
}

fn height(bound: u32) -> f32 {
    return intensity_classes_params.heights[bound / 4u][bound % 4u];
}

// Beams that a wall at that range would return into a layer: firings across the cell times rings within its heights.
fn expected_beams(range: f32, layer: u32) -> f32 {
    let away = max(range, 0.5 * intensity_classes_params.resolution_m);
    let across = intensity_classes_params.resolution_m / away * intensity_classes_params.rays_per_rad;
    if layer >= intensity_classes_params.tall {
        return max(across, 1.0);
    }
    let low = max(atan2(height(layer), away), intensity_classes_params.elevation_low);
    let high = min(atan2(height(layer + 1u), away), intensity_classes_params.elevation_high);
    return max(across * max(high - low, 0.0) * intensity_classes_params.rings_per_rad, 1.0);
}

// Value of a layer in a cell at that range of the lidar.
fn value_of(sums: vec2<u32>, layer: u32, range: f32) -> f32 {
    if intensity_classes_params.standing == 1u {
        return select(0.0, intensity_classes_params.solid_value, sums.x > 0u);
    }
    let sum = f32(sums.x) / INTENSITY_STEPS;
    if measure == 0u {
        return sum / (intensity_classes_params.resolution_m * intensity_classes_params.resolution_m);
    }
    if measure == 1u {
        return sum / f32(max(sums.y, 1u));
    }
    return sum / expected_beams(range, layer);
}

// A value as a share of that of a solid cell, in fixed point.
fn steps_of(value: f32) -> u32 {
    return u32(clamp(value / intensity_classes_params.solid_value, 0.0, 1.0) * INTENSITY_STEPS + 0.5);
}

struct Values {
    tall: f32,      // largest of the tall layers
    plane: f32,
    below: f32,
    returns: u32,
}

fn read_layers(cell: u32, range: f32) -> Values {
    let tall = intensity_classes_params.tall;
    let cells = intensity_classes_params.side * intensity_classes_params.side;
    var values = Values(0.0, 0.0, 0.0, 0u);
    var plane_returns = 0u;
    for (var layer = 0u; layer < 65536u; layer++) {
        // Left early; a bound that is a constant needs no guard, and one this high is not unrolled.
        if layer >= tall + 2u {
            break;
        }
        let sums = layer_sums[cell * (tall + 2u) + layer];
        let value = value_of(sums, layer, range);
        if keep_layers {
            layer_values[layer * cells + cell] = value;
        }
        if layer < tall {
            values.tall = max(values.tall, value);
            values.returns += sums.y;
        } else if layer == tall {
            values.plane = value;
            plane_returns = sums.y;
        } else {
            values.below = value;
        }
    }
    values.returns = max(values.returns, plane_returns);
    return values;
}

// Whether the cell was outside of the window of the scan before, so that its slot holds another cell's past.
fn entered(x: u32, y: u32) -> bool {
    let before = vec2(i32(x), i32(y)) + vec2(intensity_classes_params.shift_x, intensity_classes_params.shift_y);
    let side = vec2(i32(intensity_classes_params.side));
    return intensity_classes_params.forget == 1u || any(before < vec2(0)) || any(before >= side);
}

// Eq. 6-7: what was remembered, joined with what the horizontal plane alone saw now.
fn join_memory(slot: u32, seen_now: u32, forgotten: bool) -> u32 {
    let most = u32(INTENSITY_STEPS) << REMEMBERED_BITS;
    let kept = min(u32(round(f32(remembered[slot]) * intensity_classes_params.keep_share)), most);
    let joined = max(select(kept, 0u, forgotten), seen_now << REMEMBERED_BITS);
    remembered[slot] = joined;
    return joined >> REMEMBERED_BITS;
}

// Whether what another lidar saw stays: solid wins where the two disagree on how solid a thing is (spec 2 §3), and glass that
// one lidar saw head on is what another sees through.
fn other_wins(old: vec4<u32>, kind: u32) -> bool {
    let before = old.x & 0xffu;
    let other = old.y != 0u && sensor_of(old.w) != solid_cells_params.sensor;
    return other
        && ((before == SOLID && (kind == PASSABLE || kind == TRANSPARENT))
            || (before == TRANSPARENT && (kind == PASSABLE || kind == FREE)));
}

// What the layer holds stays where the scan says nothing of the cell, or says it late.
fn keep_class(slot: u32, word: u32, said: bool, place: Place) {
    let old = solid_cells[slot];
    if old.y > solid_cells_params.tick || (said && other_wins(old, word & 0xffu)) {
        return;
    }
    if !said {
        // Glass that only this lidar remembers fades as its memory does, from when it was seen.
        let mine = sensor_of(old.w) == solid_cells_params.sensor && old.y != 0u;
        if mine && (old.x & 0xffu) == TRANSPARENT {
            solid_cells[slot] = select(vec4(0u), vec4(word, old.yzw), (word & 0xffu) == TRANSPARENT);
        }
        return;
    }
    var beams = vec2(0u);
    if (word & 0xffu) == FREE {
        let seen = ground_now[1];
        beams = beams_across(place, select(solid_cells_params.lidar_height_m, seen.y, seen.x > 0.5));
    }
    solid_cells[slot] = vec4(
        word,
        solid_cells_params.tick,
        beams.x,
        beams.y | (solid_cells_params.sensor << SENSOR_SHIFT),
    );
}

@compute @workgroup_size(8, 8)
fn intensity_classes(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = intensity_classes_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let cell = id.y * side + id.x;
    let centre = (vec2(f32(id.x), f32(id.y)) + 0.5) * intensity_classes_params.resolution_m - intensity_classes_params.lidar;
    let range = length(centre);
    let values = read_layers(cell, range);
    let sector = sector_of(centre.x, centre.y);
    let behind = u32((range + intensity_classes_params.resolution_m) * SECTOR_STEPS_PER_M);

    let value = max(values.tall, values.plane);
    let decided = values.returns >= intensity_classes_params.min_returns;
    let excess = max(values.plane - values.below, 0.0);
    let glass = decided && excess > intensity_classes_params.transparent_threshold
        && !(values.tall > intensity_classes_params.gamma);
    let solid = decided && is_solid(cell, value, glass);
    let seen_now = select(0u, max(steps_of(excess), 1u), glass);
    var forgotten = entered(id.x, id.y);
    if clearing {
        forgotten |= values.returns == 0u && sector_range[sector].y > behind;
    }
    let slot = slot_of(id.x, id.y, intensity_classes_params.origin_slot_x, intensity_classes_params.origin_slot_y, side);
    let glass_steps = join_memory(slot, seen_now, forgotten);

    var kind = UNKNOWN;
    if values.returns == 0u && sector_range[sector].x > behind {
        kind = FREE;
    }
    if decided {
        kind = PASSABLE;
    }
    if glass_steps > 0u {
        kind = TRANSPARENT;
    }
    if solid {
        kind = SOLID;
    }
    let strength = max(glass_steps, select(0u, max(steps_of(solid_strength(value)), 1u), solid));
    let said = decided || seen_now > 0u || kind == FREE;
    let word = kind | (glass_steps << GLASS_SHIFT) | (strength << STRENGTH_SHIFT);
    keep_class(slot, word, said, Place(sector, range, behind));
    if keep_layers {
        obstacle_value[cell] = select(0.0, value, decided);
    }
}
