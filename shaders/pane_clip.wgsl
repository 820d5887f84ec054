// Ends the depth of a pixel at the first known pane that its ray crosses: minus the depth of the pane, as what lies beyond may be
// mirrored. Other depths stay as they are.
// spec 4 §1 (a pixel whose ray crosses a pane before it ends marks nothing and clears nothing beyond it).
struct PaneClipParams {
    local_from_camera_x: vec4<f32>,     // in the map's axes, from the origin of map_panes
    local_from_camera_y: vec4<f32>,
    local_from_camera_z: vec4<f32>,
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    width: u32,
    pixels: u32,
    panes: u32,                         // in map_panes
    pad: u32,
}

@group(0) @binding(0) var<uniform> pane_clip_params: PaneClipParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> rays: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read> map_panes: array<Pane>;
@group(0) @binding(4) var<storage, read_write> depth_clipped_m: array<f32>;

// Whether rays come from the table (a lens with distortion), else from the pinhole.
override distorted: bool = true;

// Rays outside the lens model's field are stored this large.
const NO_RAY = 1.0e6;

// A ray this nearly along a pane does not cross it: cosine of the angle to its normal, times the ray's length.
const ALONG = 1.0e-6;

fn ray_of(pixel: u32) -> vec2<f32> {
    if distorted {
        return rays[pixel];
    }
    let at = vec2(f32(pixel % pane_clip_params.width), f32(pixel / pane_clip_params.width));
    return (at - pane_clip_params.centre_px) / pane_clip_params.focal_px;
}

fn turned(v: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(pane_clip_params.local_from_camera_x.xyz, v),
        dot(pane_clip_params.local_from_camera_y.xyz, v),
        dot(pane_clip_params.local_from_camera_z.xyz, v),
    );
}

fn is_within(pane: Pane, at: vec3<f32>) -> bool {
    let u = dot(at, pane.level.xyz);
    let v = dot(at, cross(pane.normal.xyz, pane.level.xyz));
    return u >= pane.extent.x && u <= pane.extent.y && v >= pane.extent.z && v <= pane.extent.w;
}

// Depth at which a ray from `eye` along `way`, which is 1 deep, first meets a pane; `depth` where it meets none before.
fn first_pane(eye: vec3<f32>, way: vec3<f32>, depth: f32) -> f32 {
    var nearest = depth;
    for (var k = 0u; k < pane_clip_params.panes; k++) {
        let pane = map_panes[k];
        let toward = dot(pane.normal.xyz, way);
        if pane.id != 0u && abs(toward) > ALONG {
            let at = (pane.normal.w - dot(pane.normal.xyz, eye)) / toward;
            if at > 0.0 && at < nearest && is_within(pane, eye + at * way) {
                nearest = at;
            }
        }
    }
    return nearest;
}

@compute @workgroup_size(64)
fn pane_clip(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= pane_clip_params.pixels {
        return;
    }
    let depth = depth_m[id.x];
    let ray = ray_of(id.x);
    var clipped = depth;
    if depth > 0.0 && ray.x < NO_RAY {
        let eye = vec3(
            pane_clip_params.local_from_camera_x.w,
            pane_clip_params.local_from_camera_y.w,
            pane_clip_params.local_from_camera_z.w,
        );
        let first = first_pane(eye, turned(vec3(ray, 1.0)), depth);
        clipped = select(depth, -first, first < depth);
    }
    depth_clipped_m[id.x] = clipped;
}
