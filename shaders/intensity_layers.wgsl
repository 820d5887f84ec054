// Adds the intensity of every point to the layers that its height lies in, and its reach to the sector of its beam.
// spec 2 §2 (Eq. 1-2 of the paper), §3 (a cell is free only where a beam crossed it); spec 6 §2 (layers lie along the ground; what
// lies on it or below it is in no layer).
// Whether the planes are rings; else slabs.
override ringed: bool = true;
// Whether returns of high intensity clear transparent cells before them.
override clearing: bool = false;

@group(0) @binding(2) var<storage, read_write> layer_sums: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read_write> sector_range: array<atomic<u32>>;
// 0: height of a place of the window above the ground, as a scalar product with (place, 1); 1: x: above 0 where it was seen
// (spec 6 §2).
@group(0) @binding(5) var<storage, read> ground_now: array<vec4<f32>>;

fn height(bound: u32) -> f32 {
    return intensity_layers_params.heights[bound / 4u][bound % 4u];
}

// The tall layer of a height; the number of tall layers where there is none. The last one's upper bound belongs to it.
fn tall_layer(z: f32) -> u32 {
    let tall = intensity_layers_params.tall;
    var bounds_below = vec4(0u);
    for (var v = 0u; v < 5u; v++) {
        bounds_below += select(vec4(0u), vec4(1u), vec4(z) >= intensity_layers_params.heights[v]);
    }
    // Bounds beyond the last repeat it.
    let below = min(bounds_below.x + bounds_below.y + bounds_below.z + bounds_below.w, tall + 1u);
    if below == 0u || (below > tall && z > height(tall)) {
        return tall;
    }
    return min(below, tall) - 1u;
}

fn add(cell: u32, layer: u32, intensity: u32) {
    let word = 2u * (cell * (intensity_layers_params.tall + 2u) + layer);
    atomicAdd(&layer_sums[word], intensity);
    atomicAdd(&layer_sums[word + 1u], 1u);
}

// How far out the beam stayed between the lowest and the highest layer, as seen from the lidar.
fn reach(range: f32, z: f32) -> f32 {
    let low = height(0u);
    let high = height(intensity_layers_params.tall);
    if z > high {
        return range * high / z;
    }
    if z < low {
        return range * low / z;
    }
    return range;
}

fn add_to_layers(at: vec3<f32>, ring: u32, intensity: u32) {
    let column = at.x / intensity_layers_params.resolution_m;
    let row = at.y / intensity_layers_params.resolution_m;
    let side = intensity_layers_params.side;
    if !(column >= 0.0 && row >= 0.0 && column < f32(side) && row < f32(side)) {
        return;
    }
    let cell = min(u32(row), side - 1u) * side + min(u32(column), side - 1u);
    let tall = intensity_layers_params.tall;
    let layer = tall_layer(at.z);
    if layer < tall {
        add(cell, layer, intensity);
    }
    var in_plane = ring == intensity_layers_params.plane_ring;
    var in_below = ring == intensity_layers_params.below_ring;
    if !ringed {
        in_plane = abs(at.z) <= intensity_layers_params.half_thickness_m;
        in_below = abs(at.z - intensity_layers_params.below_m) <= intensity_layers_params.half_thickness_m;
    }
    if ringed {
        // No point has two rings, so that one pair of atomics is enough.
        if in_plane || in_below {
            add(cell, select(tall + 1u, tall, in_plane), intensity);
        }
        return;
    }
    if in_plane {
        add(cell, tall, intensity);
    }
    if in_below {
        add(cell, tall + 1u, intensity);
    }
}

// Intensity in steps; where intensities say nothing, full scale of what stands and 0 of the floor.
fn intensity_of(measured: f32, stands: bool) -> u32 {
    let share = clamp(measured * intensity_layers_params.per_unit, 0.0, 1.0);
    let full = select(0.0, 1.0, stands);
    return u32(select(share, full, intensity_layers_params.standing == 1u) * INTENSITY_STEPS + 0.5);
}

@compute @workgroup_size(64)
fn intensity_layers(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= intensity_layers_params.points {
        return;
    }
    let first = point_words(2u * id.x);
    let second = point_words(2u * id.x + 1u);
    let time_s = bitcast<f32>(second.x);
    if !all_finite(first, time_s) {
        return;
    }
    let placed = in_window(first, time_s);
    let seen = placed.xy - intensity_layers_params.lidar;
    // From the lidar's height on, across the ground: layers lie along it.
    let up = ground_now[0];
    let at = vec3(placed.xy, dot(up.xy, seen) + up.z * placed.z);
    let lidar_m = dot(up.xy, intensity_layers_params.lidar) + up.w;
    let above_m = at.z + lidar_m;
    let on_ground = ground_now[1].x > 0.5;
    // What lies below the ground is no thing that stands: a beam goes no farther than the ground.
    let below = on_ground && above_m < -intensity_layers_params.ground_band_m && lidar_m > 0.0;
    let crossing = select(1.0, lidar_m / max(lidar_m - above_m, 1.0e-6), below);
    let stands = select(at.z > intensity_layers_params.floor_m, above_m >= intensity_layers_params.ground_band_m, on_ground);
    let intensity = intensity_of(bitcast<f32>(first.w), stands);
    if !(on_ground && above_m < intensity_layers_params.ground_band_m) {
        add_to_layers(at, second.y & 0xffffu, intensity);
    }
    let sector = 2u * sector_of(seen.x, seen.y);
    let away = length(seen) * crossing;
    let range = u32(clamp(reach(away, at.z * crossing), 0.0, 4.0e6) * SECTOR_STEPS_PER_M);
    atomicMax(&sector_range[sector], range);
    add_beam(sector / 2u, away, at.z * crossing);
    if clearing && intensity >= intensity_layers_params.clear_steps {
        atomicMax(&sector_range[sector + 1u], range);
    }
}
