// Samples of a depth image for the ground: every so many pixels along rows and columns, those that lie below the camera.
// spec 6 §2.
@group(0) @binding(0) var<uniform> ground_params: GroundParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> reliability: array<f32>;
@group(0) @binding(3) var<storage, read> rays: array<vec2<f32>>;
@group(0) @binding(4) var ground_samples: texture_storage_2d_array<rgba32float, write>;

// Whether rays come from the table (a lens with distortion), else from the pinhole.
override distorted: bool = true;

// Rays outside the lens model's field are stored this large.
const NO_RAY = 1.0e6;

fn ray_of(pixel: u32) -> vec2<f32> {
    if distorted {
        return rays[pixel];
    }
    let at = vec2(f32(pixel % ground_params.width), f32(pixel / ground_params.width));
    return (at - ground_params.centre_px) / ground_params.focal_px;
}

@compute @workgroup_size(64)
fn pixels(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= MOST_SAMPLES {
        return;
    }
    var taken = vec4(0.0);
    let u = (id.x % ground_params.columns) * ground_params.stride + ground_params.stride / 2u;
    let v = (id.x / ground_params.columns) * ground_params.stride + ground_params.stride / 2u;
    let pixel = v * ground_params.width + u;
    if id.x < ground_params.columns * ground_params.rows && u < ground_params.width && pixel < ground_params.measured {
        let depth = depth_m[pixel];
        let ray = ray_of(pixel);
        if is_finite(depth) && depth > 0.0 && ray.x < NO_RAY && reliability[pixel] > ground_params.tau {
            taken = sample_of(turned(vec3(ray * depth, depth)));
        }
    }
    textureStore(ground_samples, sample_texel(id.x), 0u, taken);
}
