// Reference depth of each pixel: what most of the other frames that saw its surface agree on. Empties `seen` for the next frame.
// spec 1 §2 (temporally consistent multi-frame filter of the measured depth).
struct AgreeParams {
    pixels: u32,
    slot_pixels: u32,       // from one view of `seen` to the next
    least_views: u32,       // that must agree
    least_share: f32,       // of the views that saw something there
    share: f32,             // delta as a share of the depth
    noise_per_m: f32,       // sigma_stereo / depth^2
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> agree_params: AgreeParams;
@group(0) @binding(1) var<storage, read_write> seen: array<u32>;
@group(0) @binding(2) var<storage, read_write> reference_m: array<f32>;

const VIEWS = 16;

// Depths of 16 views.
alias Depths = array<vec4<f32>, 4>;

// How many of the views lie within delta of `depth`, and the sum of their depths.
fn support(depths: ptr<function, Depths>, depth: f32) -> vec2<f32> {
    let delta = tolerance_m(depth, agree_params.share, agree_params.noise_per_m);
    var sums = vec2(0.0);
    for (var k = 0; k < 4; k++) {
        let near = abs((*depths)[k] - depth) <= vec4(delta);
        let counted = select(vec4(0.0), vec4(1.0), near & ((*depths)[k] > vec4(0.0)));
        sums += vec2(dot(counted, vec4(1.0)), dot(counted, (*depths)[k]));
    }
    return sums;
}

@compute @workgroup_size(64)
fn agree(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.x;
    if pixel >= agree_params.pixels {
        return;
    }
    var depths: Depths;
    var views = 0.0;
    for (var view = 0; view < VIEWS; view++) {
        let at = u32(view) * agree_params.slot_pixels + pixel;
        let depth = depth_of(seen[at]);
        seen[at] = 0u;
        depths[view / 4][view % 4] = depth;
        views += select(0.0, 1.0, depth > 0.0);
    }
    // The depth with most support; of equals that of the earliest view.
    var best = vec2(0.0);
    for (var view = 0; view < VIEWS; view++) {
        let depth = depths[view / 4][view % 4];
        let sums = support(&depths, depth);
        best = select(best, sums, depth > 0.0 && sums.x > best.x);
    }
    // Once more around their mean.
    let centre = best.y / max(best.x, 1.0);
    let sums = support(&depths, centre);
    let agreed = sums.x >= f32(agree_params.least_views) && sums.x >= agree_params.least_share * views;
    reference_m[pixel] = select(0.0, sums.y / max(sums.x, 1.0), agreed);
}
