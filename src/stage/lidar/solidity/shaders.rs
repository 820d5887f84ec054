//! The texts of the passes of learned solidity.

use crate::gpu::ShaderSource;

const NUMBERS: &str = include_str!("../../../../shaders/lib/numbers.wgsl");
const SCAN: &str = include_str!("../../../../shaders/lib/scan.wgsl");
const BINS: &str = include_str!("../../../../shaders/lib/crossing/bins.wgsl");
const TEXTURE: &str = include_str!("../../../../shaders/lib/points/texture.wgsl");
const BUFFER: &str = include_str!("../../../../shaders/lib/points/buffer.wgsl");
const PLACED: &str = include_str!("../../../../shaders/lib/points/placed.wgsl");
const PARAMS: &str = include_str!("../../../../shaders/lib/solidity/params.wgsl");
const COUNTS_PASS: &str = include_str!("../../../../shaders/solidity/counts.wgsl");

/// Counts of points as the host uploads them.
pub const COUNTS: ShaderSource = ShaderSource {
    name: "solidity/counts",
    parts: &[NUMBERS, SCAN, TEXTURE, PLACED, BINS, PARAMS, COUNTS_PASS],
};
/// The same of points that another pass left in a buffer.
pub const COUNTS_OF_BUFFER: ShaderSource = ShaderSource {
    name: "solidity/counts",
    parts: &[NUMBERS, SCAN, BUFFER, PLACED, BINS, PARAMS, COUNTS_PASS],
};
/// Beams before and behind each cell.
pub const BEAMS: ShaderSource = ShaderSource {
    name: "solidity/beams",
    parts: &[SCAN, BINS, PARAMS, include_str!("../../../../shaders/solidity/beams.wgsl")],
};
/// Whether a robot can pass what stands in each cell.
pub const JUDGE: ShaderSource = ShaderSource {
    name: "solidity/judge",
    parts: &[PARAMS, include_str!("../../../../shaders/solidity/judge.wgsl")],
};

/// All of them.
pub const ALL: [ShaderSource; 4] = [COUNTS, COUNTS_OF_BUFFER, BEAMS, JUDGE];
