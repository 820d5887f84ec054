//! The texts of the passes of drops.

use crate::gpu::ShaderSource;

const HASH: &str = include_str!("../../../shaders/lib/hash.wgsl");
const NUMBERS: &str = include_str!("../../../shaders/lib/numbers.wgsl");
const SCAN: &str = include_str!("../../../shaders/lib/scan.wgsl");
const SLOT: &str = include_str!("../../../shaders/lib/slot.wgsl");
const RECORD: &str = include_str!("../../../shaders/lib/record.wgsl");
const LENS: &str = include_str!("../../../shaders/lib/lens.wgsl");
const DROPS: &str = include_str!("../../../shaders/lib/drops/drops.wgsl");
const HEIGHT: &str = include_str!("../../../shaders/lib/drops/height.wgsl");
const VOTE: &str = include_str!("../../../shaders/lib/drops/vote.wgsl");
const SEEN: &str = include_str!("../../../shaders/lib/drops/view.wgsl");
const POINT: &str = include_str!("../../../shaders/lib/drops/point.wgsl");
const TEXTURE: &str = include_str!("../../../shaders/lib/points/texture.wgsl");
const BUFFER: &str = include_str!("../../../shaders/lib/points/buffer.wgsl");
const VIEW_PASS: &str = include_str!("../../../shaders/drops/view.wgsl");
const RETURNS_PASS: &str = include_str!("../../../shaders/drops/returns.wgsl");

/// Votes of pixels.
pub const PIXELS: ShaderSource = ShaderSource {
    name: "drops/pixels",
    parts: &[LENS, DROPS, HEIGHT, VOTE, include_str!("../../../shaders/drops/pixels.wgsl")],
};
/// How near a scan sees something, by direction.
pub const VIEW: ShaderSource = ShaderSource {
    name: "drops/view",
    parts: &[HASH, NUMBERS, SCAN, TEXTURE, DROPS, POINT, SEEN, VIEW_PASS],
};
/// The same over points that another pass left in a buffer.
pub const VIEW_OF_BUFFER: ShaderSource =
    ShaderSource { name: "drops/view", parts: &[HASH, NUMBERS, SCAN, BUFFER, DROPS, POINT, SEEN, VIEW_PASS] };
/// Votes of points.
pub const RETURNS: ShaderSource = ShaderSource {
    name: "drops/returns",
    parts: &[HASH, NUMBERS, SCAN, TEXTURE, DROPS, HEIGHT, POINT, SEEN, VOTE, RETURNS_PASS],
};
/// The same over points that another pass left in a buffer.
pub const RETURNS_OF_BUFFER: ShaderSource = ShaderSource {
    name: "drops/returns",
    parts: &[HASH, NUMBERS, SCAN, BUFFER, DROPS, HEIGHT, POINT, SEEN, VOTE, RETURNS_PASS],
};
/// What a message says of each cell.
pub const JUDGE: ShaderSource = ShaderSource {
    name: "drops/judge",
    parts: &[SLOT, DROPS, HEIGHT, include_str!("../../../shaders/drops/judge.wgsl")],
};
/// What becomes of the layer.
pub const DECIDE: ShaderSource = ShaderSource {
    name: "drops/decide",
    parts: &[SLOT, RECORD, DROPS, include_str!("../../../shaders/drops/decide.wgsl")],
};

/// All of them.
pub const ALL: [ShaderSource; 7] = [PIXELS, VIEW, VIEW_OF_BUFFER, RETURNS, RETURNS_OF_BUFFER, JUDGE, DECIDE];
