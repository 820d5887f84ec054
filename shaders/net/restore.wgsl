// Reliability at the native size: bilinear, 0 where there is no depth. Four pixels of a row at a time.
// spec 1 §1; of a frame without usable colour range gating (§4) in its place.
struct RestoreParams {
    alone: u32,         // 1: the frame has no usable colour, and depth counts by its range alone
    nearest_m: f32,     // that range
    farthest_m: f32,
    pad: u32,
}

@group(0) @binding(0) var<storage, read> reliability_low: array<f32>;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read_write> reliability: array<f32>;
@group(0) @binding(3) var<uniform> restore_params: RestoreParams;

// Pixels of the network across a native one.
const RATIO = vec2<f32>(f32(WIDTH) / f32(NATIVE_WIDTH), f32(HEIGHT) / f32(NATIVE_HEIGHT));
const LAST = vec2<f32>(f32(WIDTH - 1), f32(HEIGHT - 1));

// Where the centre of a native pixel lies among those of the network's, the border repeated.
fn place(x: i32, y: i32) -> vec2<f32> {
    return clamp((vec2(f32(x), f32(y)) + 0.5) * RATIO - 0.5, vec2(0.0), LAST);
}

@compute @workgroup_size(64)
fn restore(@builtin(global_invocation_id) id: vec3<u32>) {
    let word = i32(id.x);
    if word >= WORDS * NATIVE_HEIGHT {
        return;
    }
    let x = word % WORDS * 4;
    let y = word / WORDS;
    let start = place(x, y);
    let first = vec2<i32>(floor(start));
    let below = min(first.y + 1, HEIGHT - 1);
    let share = start.y - f32(first.y);
    let places = vec4(place(x, y).x, place(x + 1, y).x, place(x + 2, y).x, place(x + 3, y).x);
    var sums = vec4(0.0);
    for (var k = 0; k < COLUMNS; k++) {
        let column = min(first.x + k, WIDTH - 1);
        let value = mix(
            reliability_low[first.y * WIDTH + column],
            reliability_low[below * WIDTH + column],
            share,
        );
        sums += value * max(1.0 - abs(places - f32(first.x + k)), vec4(0.0));
    }
    sums = clamp(sums, vec4(0.0), vec4(1.0));
    for (var k = 0; k < 4; k++) {
        if x + k < NATIVE_WIDTH {
            let index = y * NATIVE_WIDTH + x + k;
            let depth = depth_m[index];
            let is_near = depth >= restore_params.nearest_m && depth <= restore_params.farthest_m;
            // Both are computed: lavapipe would compile a branch on a parameter anew for every frame.
            let weight = select(sums[k], select(0.0, 1.0, is_near), restore_params.alone == 1u);
            reliability[index] = select(0.0, weight, depth > 0.0);
        }
    }
}
