// Median of the valid depths in 5x5 around each valid pixel; holes stay holes.
// spec 1 §4 (spatial median).
struct SpatialMedianParams {
    width: u32,
    height: u32,
}

@group(0) @binding(0) var<uniform> spatial_median_params: SpatialMedianParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read_write> depth_median_m: array<f32>;

const LOW = -3.4028234e38;
const HIGH = 3.4028234e38;    // no finite depth lies above

var<private> values: array<f32, 25>;

fn order(i: u32, j: u32) {
    let low = min(values[i], values[j]);
    values[j] = max(values[i], values[j]);
    values[i] = low;
}

// Batcher's odd-even merge sort of 25 values, without the exchanges that rank 12 does not need.
fn median() -> f32 {
    order(0u, 1u); order(2u, 3u); order(4u, 5u); order(6u, 7u); order(8u, 9u); order(10u, 11u);
    order(12u, 13u); order(14u, 15u); order(16u, 17u); order(18u, 19u); order(20u, 21u); order(22u, 23u);
    order(0u, 2u); order(1u, 3u); order(4u, 6u); order(5u, 7u); order(8u, 10u); order(9u, 11u);
    order(12u, 14u); order(13u, 15u); order(16u, 18u); order(17u, 19u); order(20u, 22u); order(21u, 23u);
    order(1u, 2u); order(5u, 6u); order(9u, 10u); order(13u, 14u); order(17u, 18u); order(21u, 22u);
    order(0u, 4u); order(1u, 5u); order(2u, 6u); order(3u, 7u); order(8u, 12u); order(9u, 13u);
    order(10u, 14u); order(11u, 15u); order(16u, 20u); order(17u, 21u); order(18u, 22u); order(19u, 23u);
    order(2u, 4u); order(3u, 5u); order(10u, 12u); order(11u, 13u); order(18u, 20u); order(19u, 21u);
    order(1u, 2u); order(3u, 4u); order(5u, 6u); order(9u, 10u); order(11u, 12u); order(13u, 14u);
    order(17u, 18u); order(19u, 20u); order(21u, 22u); order(0u, 8u); order(1u, 9u); order(2u, 10u);
    order(3u, 11u); order(4u, 12u); order(5u, 13u); order(6u, 14u); order(7u, 15u); order(16u, 24u);
    order(4u, 8u); order(5u, 9u); order(6u, 10u); order(7u, 11u); order(20u, 24u); order(2u, 4u);
    order(3u, 5u); order(6u, 8u); order(7u, 9u); order(10u, 12u); order(11u, 13u); order(18u, 20u);
    order(19u, 21u); order(22u, 24u); order(1u, 2u); order(3u, 4u); order(5u, 6u); order(7u, 8u);
    order(9u, 10u); order(11u, 12u); order(13u, 14u); order(17u, 18u); order(19u, 20u); order(21u, 22u);
    order(23u, 24u); order(0u, 16u); order(1u, 17u); order(2u, 18u); order(3u, 19u); order(4u, 20u);
    order(5u, 21u); order(6u, 22u); order(7u, 23u); order(8u, 24u); order(8u, 16u); order(9u, 17u);
    order(10u, 18u); order(11u, 19u); order(12u, 20u); order(13u, 21u); order(6u, 10u); order(7u, 11u);
    order(12u, 16u); order(13u, 17u); order(10u, 12u); order(11u, 13u); order(11u, 12u);
    return values[12];
}

@compute @workgroup_size(16, 4)
fn spatial_median(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = spatial_median_params.width;
    let height = spatial_median_params.height;
    if id.x >= width || id.y >= height {
        return;
    }
    let pixel = id.y * width + id.x;
    // Invalid samples go in turn below and above all depths, so that rank 12 of 25 is the (lower)
    // median of the valid ones.
    var below = true;
    for (var i = 0u; i < 25u; i++) {
        let x = i32(id.x + i % 5u) - 2;
        let y = i32(id.y + i / 5u) - 2;
        var depth = 0.0;
        if x >= 0 && y >= 0 && x < i32(width) && y < i32(height) {
            depth = depth_m[u32(y) * width + u32(x)];
        }
        if depth > 0.0 {
            values[i] = depth;
        } else {
            values[i] = select(HIGH, LOW, below);
            below = !below;
        }
    }
    let filtered = median();
    depth_median_m[pixel] = select(0.0, filtered, depth_m[pixel] > 0.0);
}
