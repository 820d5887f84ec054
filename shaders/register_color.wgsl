// Samples the colour image at the depth camera's pixels: nearest colour pixel, black where the colour camera does not see.
// spec 1 §1 (colour is sampled at the depth camera's pixels).
struct RegisterColorParams {
    color_from_depth_x: vec4<f32>,      // rows of the transform between the optical frames
    color_from_depth_y: vec4<f32>,
    color_from_depth_z: vec4<f32>,
    lens_a: vec4<f32>,                  // colour lens: k1, k2, p1, p2
    lens_b: vec4<f32>,                  // k3, k4, k5, k6
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    color_width: u32,
    color_height: u32,
    pixels: u32,                        // of the depth image
    aligned: u32,                       // 1: colour lies on the depth grid already
    present: u32,                       // 0: this frame has no colour
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> register_color_params: RegisterColorParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> rays: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read> color_raw: array<u32>;
@group(0) @binding(4) var<storage, read_write> color: array<u32>;

fn byte(index: u32) -> u32 {
    return (color_raw[index / 4u] >> (8u * (index % 4u))) & 0xffu;
}

// Branches on parameters would make lavapipe compile the pass anew for every frame, so both ways are
// computed and one is selected.
fn color_pixel_of(pixel: u32) -> i32 {
    return select(projected(pixel), i32(pixel), register_color_params.aligned == 1u);
}

fn projected(pixel: u32) -> i32 {
    let depth = depth_m[pixel];
    if depth <= 0.0 {
        return -1;
    }
    let point = vec4(rays[pixel] * depth, depth, 1.0);
    let z = dot(register_color_params.color_from_depth_z, point);
    if z <= 0.01 {
        return -1;
    }
    let ideal = vec2(
        dot(register_color_params.color_from_depth_x, point),
        dot(register_color_params.color_from_depth_y, point),
    ) / z;
    let distorted = distort(ideal, register_color_params.lens_a, register_color_params.lens_b);
    let p = floor(distorted * register_color_params.focal_px + register_color_params.centre_px + 0.5);
    let size = vec2(f32(register_color_params.color_width), f32(register_color_params.color_height));
    if any(p < vec2(0.0)) || any(p >= size) {
        return -1;
    }
    return i32(p.y) * i32(register_color_params.color_width) + i32(p.x);
}

@compute @workgroup_size(64)
fn register_color(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= register_color_params.pixels {
        return;
    }
    let source = color_pixel_of(id.x);
    var packed = 0u;
    if register_color_params.present == 1u && source >= 0 {
        let first = 3u * u32(source);
        packed = byte(first) | (byte(first + 1u) << 8u) | (byte(first + 2u) << 16u) | 0xff000000u;
    }
    color[id.x] = packed;
}
