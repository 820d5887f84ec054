// Points of a scan in the window, each at its own time where they are deskewed. Needs lib/numbers.
struct IntensityLayersParams {
    window_from_lidar_x: vec4<f32>,     // at the first point's time where deskewed
    window_from_lidar_y: vec4<f32>,
    window_from_lidar_z: vec4<f32>,     // z = 0 is the lidar's height
    turn_axis: vec4<f32>,               // in the lidar's frame; w: angle from the first point to the last, radians
    turn_way: vec4<f32>,                // metres from the first point to the last; w: 1 / its duration, 1/s
    heights: array<vec4<f32>, 5>,       // bounds of the tall layers, ascending
    lidar: vec2<f32>,                   // the lidar in the window at the stamp, metres
    first_s: f32,                       // time of the first point
    points: u32,
    side: u32,
    resolution_m: f32,
    tall: u32,                          // tall layers; the planes follow
    per_unit: f32,                      // 1 / full scale of intensities
    plane_ring: u32,                    // rings of the planes z = 0 and z = -epsilon
    below_ring: u32,
    below_m: f32,                       // height of the lower plane, for slabs
    half_thickness_m: f32,
    clear_steps: u32,                   // intensity from which a return clears transparent cells before it
    standing: u32,                      // 1: a return that stands counts as full scale, whatever its intensity
    floor_m: f32,                       // height up to which a return does not stand
    ground_band_m: f32,                 // what lies this near a ground that was seen is floor
}

// Whether points are placed by the pose at their own times.
override deskewed: bool = false;

@group(0) @binding(0) var<uniform> intensity_layers_params: IntensityLayersParams;

// Rodrigues' rotation of a point of the lidar at its share of the turn.
fn turned(point: vec3<f32>, share: f32) -> vec3<f32> {
    let axis = intensity_layers_params.turn_axis.xyz;
    let angle = intensity_layers_params.turn_axis.w * share;
    let c = cos(angle);
    return point * c + cross(axis, point) * sin(angle) + axis * (dot(axis, point) * (1.0 - c));
}

fn in_window(first: vec4<u32>, time_s: f32) -> vec3<f32> {
    var point = vec3(bitcast<f32>(first.x), bitcast<f32>(first.y), bitcast<f32>(first.z));
    var way = vec3(0.0);
    if deskewed {
        let share = clamp((time_s - intensity_layers_params.first_s) * intensity_layers_params.turn_way.w, 0.0, 1.0);
        point = turned(point, share);
        way = intensity_layers_params.turn_way.xyz * share;
    }
    let at = vec4(point, 1.0);
    return way + vec3(
        dot(intensity_layers_params.window_from_lidar_x, at),
        dot(intensity_layers_params.window_from_lidar_y, at),
        dot(intensity_layers_params.window_from_lidar_z, at),
    );
}

fn all_finite(first: vec4<u32>, time_s: f32) -> bool {
    return is_finite(bitcast<f32>(first.x)) && is_finite(bitcast<f32>(first.y)) && is_finite(bitcast<f32>(first.z))
        && is_finite(bitcast<f32>(first.w)) && is_finite(time_s);
}
