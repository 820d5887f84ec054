// How near a scan sees something, by direction: the buffer `drop_view`. Needs lib/scan, lib/drops/drops.
const VIEW_BINS = 128u;

// The direction of a place from the lidar in the window's axes: sector, and bin of the slope, dense near the horizontal.
fn view_of(off: vec3<f32>) -> vec2<u32> {
    let slope = off.z / max(length(off.xy), 1.0e-6);
    let bin = (0.5 + 0.5 * slope / (1.0 + abs(slope))) * f32(VIEW_BINS);
    return vec2(sector_of(off.x, off.y), min(u32(max(bin, 0.0)), VIEW_BINS - 1u));
}

// Distances are kept inverted, so that the nearest is the largest; 0: nothing is seen there.
fn view_steps(off: vec3<f32>) -> u32 {
    return ~u32(min(length(off), 1000.0) * SECTOR_STEPS_PER_M);
}
