//! The texts of the passes of glass.

use crate::gpu::ShaderSource;

const NUMBERS: &str = include_str!("../../../shaders/lib/numbers.wgsl");
const GROUND: &str = include_str!("../../../shaders/lib/ground/ground.wgsl");
const GRID: &str = include_str!("../../../shaders/lib/glass/grid.wgsl");
const POINTS: &str = include_str!("../../../shaders/lib/points/texture.wgsl");
const POINT: &str = include_str!("../../../shaders/lib/glass/points.wgsl");
const COUNTERS: &str = include_str!("../../../shaders/lib/glass/counters.wgsl");
const RETURNS: &str = include_str!("../../../shaders/lib/glass/returns.wgsl");
const FOUND: &str = include_str!("../../../shaders/lib/glass/found.wgsl");
const HASH: &str = include_str!("../../../shaders/lib/hash.wgsl");
const HYPOTHESIS: &str = include_str!("../../../shaders/lib/glass/hypothesis.wgsl");
const LINES: &str = include_str!("../../../shaders/lib/glass/lines.wgsl");
const PANE: &str = include_str!("../../../shaders/lib/glass/pane.wgsl");
const CANDIDATES: &str = include_str!("../../../shaders/lib/glass/candidates.wgsl");
const CANDIDATE_AT: &str = include_str!("../../../shaders/lib/glass/candidate_at.wgsl");
const ROW_TEXELS: &str = include_str!("../../../shaders/lib/glass/row_texels.wgsl");
const PANE_TEXELS: &str = include_str!("../../../shaders/lib/glass/pane_texels.wgsl");
const PLACED: &str = include_str!("../../../shaders/lib/glass/placed.wgsl");
const MEASURED: &str = include_str!("../../../shaders/lib/glass/measured.wgsl");
const WALL_STRIPS: &str = include_str!("../../../shaders/lib/glass/walls.wgsl");
const CLASS: &str = include_str!("../../../shaders/lib/glass/class.wgsl");
const PREFIX: &str = include_str!("../../../shaders/lib/glass/prefix.wgsl");

/// Empties what the others count in.
pub const CLEAR: ShaderSource =
    ShaderSource { name: "glass/clear", parts: &[GRID, include_str!("../../../shaders/glass/clear.wgsl")] };
/// Points into cells.
pub const ORGANIZE: ShaderSource = ShaderSource {
    name: "glass/organize",
    parts: &[
        NUMBERS,
        GRID,
        POINTS,
        POINT,
        PLACED,
        ROW_TEXELS,
        COUNTERS,
        include_str!("../../../shaders/glass/organize.wgsl"),
    ],
};
/// Intensity peaks.
pub const PEAK: ShaderSource = ShaderSource {
    name: "glass/peak",
    parts: &[GRID, POINTS, POINT, include_str!("../../../shaders/glass/peak.wgsl")],
};
/// Beams that may end on glass.
pub const CANDIDATE: ShaderSource = ShaderSource {
    name: "glass/candidate",
    parts: &[GRID, COUNTERS, RETURNS, include_str!("../../../shaders/glass/candidate.wgsl")],
};
/// Their list.
pub const GATHER: ShaderSource = ShaderSource {
    name: "glass/gather",
    parts: &[
        GRID,
        CANDIDATES,
        POINTS,
        POINT,
        COUNTERS,
        FOUND,
        PREFIX,
        include_str!("../../../shaders/glass/gather.wgsl"),
    ],
};
/// Hypotheses.
pub const SCORE: ShaderSource = ShaderSource {
    name: "glass/score",
    parts: &[
        GRID,
        CANDIDATES,
        CANDIDATE_AT,
        PANE,
        FOUND,
        HASH,
        HYPOTHESIS,
        include_str!("../../../shaders/glass/score.wgsl"),
    ],
};
/// Least squares.
pub const FIT: ShaderSource = ShaderSource {
    name: "glass/fit",
    parts: &[
        GRID,
        CANDIDATES,
        CANDIDATE_AT,
        PANE,
        FOUND,
        HASH,
        HYPOTHESIS,
        include_str!("../../../shaders/glass/fit.wgsl"),
    ],
};
/// What beams show of a plane.
pub const SURVEY: ShaderSource = ShaderSource {
    name: "glass/survey_plane",
    parts: &[GRID, POINTS, POINT, RETURNS, FOUND, include_str!("../../../shaders/glass/survey_plane.wgsl")],
};
/// Panes and their boundaries.
pub const ACCEPT: ShaderSource = ShaderSource {
    name: "glass/accept",
    parts: &[
        GRID,
        CANDIDATES,
        CANDIDATE_AT,
        COUNTERS,
        PANE,
        FOUND,
        PREFIX,
        LINES,
        include_str!("../../../shaders/glass/accept.wgsl"),
    ],
};
/// Upright planes with many returns.
pub const WALLS: ShaderSource = ShaderSource {
    name: "glass/walls",
    parts: &[
        GRID,
        POINTS,
        POINT,
        HASH,
        PANE,
        FOUND,
        WALL_STRIPS,
        include_str!("../../../shaders/glass/walls.wgsl"),
    ],
};
/// Beams that go on behind them.
pub const OPENINGS: ShaderSource = ShaderSource {
    name: "glass/openings",
    parts: &[GRID, POINTS, POINT, RETURNS, WALL_STRIPS, include_str!("../../../shaders/glass/openings.wgsl")],
};
/// Images among what these show.
pub const IMAGES: ShaderSource = ShaderSource {
    name: "glass/images",
    parts: &[
        GRID,
        POINTS,
        POINT,
        RETURNS,
        ROW_TEXELS,
        MEASURED,
        WALL_STRIPS,
        include_str!("../../../shaders/glass/images.wgsl"),
    ],
};
/// Mirrors on them.
pub const MIRRORS: ShaderSource = ShaderSource {
    name: "glass/mirrors",
    parts: &[GRID, COUNTERS, PANE, FOUND, WALL_STRIPS, include_str!("../../../shaders/glass/mirrors.wgsl")],
};
/// Panes over time.
pub const REMEMBER: ShaderSource = ShaderSource {
    name: "glass/remember",
    parts: &[GRID, PANE, FOUND, CLASS, include_str!("../../../shaders/glass/remember.wgsl")],
};
/// Mirrored surfaces.
pub const MIRROR: ShaderSource = ShaderSource {
    name: "glass/mirror",
    parts: &[
        GRID,
        PLACED,
        PANE,
        PANE_TEXELS,
        ROW_TEXELS,
        CLASS,
        include_str!("../../../shaders/glass/mirror.wgsl"),
    ],
};
/// Labels by steps 1 and 2.
pub const LABEL: ShaderSource = ShaderSource {
    name: "glass/label",
    parts: &[
        GRID,
        POINTS,
        POINT,
        RETURNS,
        PANE,
        PANE_TEXELS,
        ROW_TEXELS,
        CLASS,
        MEASURED,
        include_str!("../../../shaders/glass/label.wgsl"),
    ],
};
/// Labels by step 3.
pub const SETTLE: ShaderSource = ShaderSource {
    name: "glass/settle",
    parts: &[
        GRID,
        POINTS,
        POINT,
        COUNTERS,
        PANE,
        PANE_TEXELS,
        CLASS,
        include_str!("../../../shaders/glass/settle.wgsl"),
    ],
};

/// Mirror images in a glossy floor.
pub const FLOOR_IMAGES: ShaderSource = ShaderSource {
    name: "glass/floor_images",
    parts: &[
        GRID,
        GROUND,
        PLACED,
        ROW_TEXELS,
        COUNTERS,
        CLASS,
        MEASURED,
        include_str!("../../../shaders/glass/floor_images.wgsl"),
    ],
};

/// The cloud as the map takes it.
pub const CLEAN: ShaderSource = ShaderSource {
    name: "glass/clean",
    parts: &[GRID, POINTS, POINT, PANE, CLASS, include_str!("../../../shaders/glass/clean.wgsl")],
};

/// All passes of [`super::Glass`].
pub const LABELLING: [ShaderSource; 18] = [
    CLEAR,
    ORGANIZE,
    PEAK,
    CANDIDATE,
    GATHER,
    SCORE,
    FIT,
    SURVEY,
    ACCEPT,
    WALLS,
    OPENINGS,
    IMAGES,
    MIRRORS,
    REMEMBER,
    MIRROR,
    LABEL,
    SETTLE,
    FLOOR_IMAGES,
];
