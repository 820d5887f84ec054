// Depth from disparity in millimetres, 0 where the match fails the left-right check or the window has no texture.
// spec 1 §8 (left-right check 1 px, texture cut).
struct SimDepthParams {
    width: u32,
    height: u32,
    focal_baseline_mm: f32,     // focal length in pixels times the baseline
    left_right_px: f32,         // largest difference of the two images' disparities
    texture: f32,               // least deviation of grey, levels of 255
    step_px: f32,               // disparities are rounded to multiples of this
    largest_px: f32,            // the largest disparity searched; a match there is cut off
    pad0: u32,
}

@group(0) @binding(0) var<uniform> depth_params: SimDepthParams;
@group(0) @binding(1) var<storage, read> left_disparity: array<f32>;    // -1: none
@group(0) @binding(2) var<storage, read> right_disparity: array<f32>;
@group(0) @binding(3) var<storage, read> texture: array<f32>;
@group(0) @binding(4) var<storage, read_write> depth_mm: array<u32>;

const LARGEST_MM = 65535.0;

@compute @workgroup_size(64)
fn depth(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.x;
    let width = depth_params.width;
    if pixel >= width * depth_params.height {
        return;
    }
    let found = left_disparity[pixel];
    let x = i32(pixel % width) - i32(round(max(found, 0.0)));
    let back = right_disparity[pixel - pixel % width + u32(clamp(x, 0, i32(width) - 1))];
    let agreed = found >= 0.0 && x >= 0 && abs(back - found) <= depth_params.left_right_px;
    let inside = found < depth_params.largest_px && texture[pixel] >= depth_params.texture;
    let stepped = round(found / depth_params.step_px) * depth_params.step_px;
    let millimetres = round(depth_params.focal_baseline_mm / max(stepped, 1.0e-3));
    depth_mm[pixel] = select(0u, u32(millimetres), agreed && inside && millimetres < LARGEST_MM);
}
