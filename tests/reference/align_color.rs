//! Colour on the depth grid, byte by byte (spec 1 §1).

/// Pixels as R, G, B, 255 from the lowest byte up; black and 0 where there is no colour.
pub(crate) fn align_color(rgb: &[u8], present: bool) -> Vec<u32> {
    let pixel = |p: &[u8]| if present { u32::from_le_bytes([p[0], p[1], p[2], 255]) } else { 0 };
    rgb.chunks_exact(3).map(pixel).collect()
}
