// A map without lidars: no cell has a strength of its own. Needs lib/scan.
fn lidar_strength(x: u32, y: u32) -> u32 {
    return u32(INTENSITY_STEPS);
}
