// Layers of height above the lower edge of the height band: the edges between them, metres (spec 1 §9); the uppermost ends with the band.
const ABOVE_LAYERS_M = 1.0e9;
const LOW_EDGES_M = vec4(0.1, 0.2, 0.35, 0.5);
const HIGH_EDGES_M = vec4(0.7, 1.0, 1.4, ABOVE_LAYERS_M);

// Lower edge of the layer of a height.
fn layer_floor(height_m: f32) -> f32 {
    let low = select(vec4(0.0), LOW_EDGES_M, vec4(height_m) >= LOW_EDGES_M);
    let high = select(vec4(0.0), HIGH_EDGES_M, vec4(height_m) >= HIGH_EDGES_M);
    let most = max(low, high);
    return max(max(most.x, most.y), max(most.z, most.w));
}

// Upper edge of the layer of a height.
fn layer_ceiling(height_m: f32) -> f32 {
    let low = select(vec4(ABOVE_LAYERS_M), LOW_EDGES_M, vec4(height_m) < LOW_EDGES_M);
    let high = select(vec4(ABOVE_LAYERS_M), HIGH_EDGES_M, vec4(height_m) < HIGH_EDGES_M);
    let least = min(low, high);
    return min(min(least.x, least.y), min(least.z, least.w));
}
