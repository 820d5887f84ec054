// The network's input at its own size: colour by area average, depth by the nearest valid sample, its change since the frame before.
// spec 1 §1.
struct ResizeParams {
    per_metre: f32,         // 1 / metres that depth is divided by
    change_per_metre: f32,  // the same for its change; 0: no frame came right before
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> resize_params: ResizeParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> color: array<u32>;
@group(0) @binding(4) var<storage, read_write> depth_before: array<f32>;

// Native pixels across one of the network's.
const SCALE = vec2<f32>(f32(NATIVE_WIDTH) / f32(WIDTH), f32(NATIVE_HEIGHT) / f32(HEIGHT));

// Rounding leaves slivers of pixels that only touch.
const SLIVER = 1e-3;

struct Area {
    color: vec4<f32>,       // sum of the colours, weight of those that there are
    depth_m: f32,           // of the nearest valid sample, 0 where there is none
    distance: f32,          // squared, in native pixels
}

fn add_pixel(area: ptr<function, Area>, p: vec2<i32>, low: vec2<f32>) {
    let corner = vec2<f32>(p);
    let covered = max(min(low + SCALE, corner + 1.0) - max(low, corner), vec2(0.0));
    let weight = covered.x * covered.y;
    let inside = min(p, vec2(NATIVE_WIDTH, NATIVE_HEIGHT) - 1);
    let index = inside.y * NATIVE_WIDTH + inside.x;
    let seen = unpack4x8unorm(color[index]);
    (*area).color += weight * seen.a * vec4(seen.rgb, 1.0);
    let depth = depth_m[index];
    let offset = corner + 0.5 - low - 0.5 * SCALE;
    let distance = dot(offset, offset);
    let nearer = weight > SLIVER && depth > 0.0 && distance < (*area).distance;
    (*area).depth_m = select((*area).depth_m, depth, nearer);
    (*area).distance = select((*area).distance, distance, nearer);
}

@compute @workgroup_size(64)
fn resize(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = i32(id.x);
    if pixel >= WIDTH * HEIGHT {
        return;
    }
    let at = vec2(pixel % WIDTH, pixel / WIDTH);
    let low = vec2<f32>(at) * SCALE;
    let first = vec2<i32>(floor(low + SLIVER));
    var area = Area(vec4(0.0), 0.0, 1e9);
    for (var y = 0; y < SPAN_Y; y++) {
        for (var x = 0; x < SPAN_X; x++) {
            add_pixel(&area, first + vec2(x, y), low);
        }
    }
    let depth = area.depth_m;
    let before = depth_before[pixel];
    depth_before[pixel] = depth;
    let change = select(0.0, abs(depth - before), depth > 0.0 && before > 0.0);
    let mean = area.color.rgb / max(area.color.a, 1e-6);
    store_sink(at, 0, vec4(mean, depth * resize_params.per_metre));
    store_sink(at, 1, vec4(change * resize_params.change_per_metre, 0.0, 0.0, 0.0));
}
