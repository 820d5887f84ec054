//! The texts of the passes of the ground.

use crate::gpu::ShaderSource;

const NUMBERS: &str = include_str!("../../../shaders/lib/numbers.wgsl");
const HASH: &str = include_str!("../../../shaders/lib/hash.wgsl");
const GROUND: &str = include_str!("../../../shaders/lib/ground/ground.wgsl");
const PLANE: &str = include_str!("../../../shaders/lib/ground/plane.wgsl");
const FIELD: &str = include_str!("../../../shaders/lib/ground/field.wgsl");
const KEPT: &str = include_str!("../../../shaders/lib/ground/kept.wgsl");
const POINTS: &str = include_str!("../../../shaders/lib/points/texture.wgsl");

/// Samples of a depth image.
pub const PIXELS: ShaderSource = ShaderSource {
    name: "ground/pixels",
    parts: &[NUMBERS, GROUND, include_str!("../../../shaders/ground/pixels.wgsl")],
};
/// Samples of a scan.
pub const RETURNS: ShaderSource = ShaderSource {
    name: "ground/returns",
    parts: &[HASH, NUMBERS, GROUND, POINTS, include_str!("../../../shaders/ground/returns.wgsl")],
};
/// Planes through them.
pub const DRAW: ShaderSource = ShaderSource {
    name: "ground/draw",
    parts: &[HASH, GROUND, KEPT, include_str!("../../../shaders/ground/draw.wgsl")],
};
/// Samples on each.
pub const SCORE: ShaderSource = ShaderSource {
    name: "ground/score",
    parts: &[GROUND, include_str!("../../../shaders/ground/score.wgsl")],
};
/// Least squares, what is no ground, what is kept.
pub const SETTLE: ShaderSource = ShaderSource {
    name: "ground/settle",
    parts: &[GROUND, PLANE, FIELD, KEPT, include_str!("../../../shaders/ground/settle.wgsl")],
};

/// All of them.
pub const ALL: [ShaderSource; 5] = [PIXELS, RETURNS, DRAW, SCORE, SETTLE];
