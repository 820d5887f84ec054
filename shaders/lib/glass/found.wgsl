// What the search for panes in one scan holds from pass to pass.
const MOST_CANDIDATES = 4096u;
const MOST_HYPOTHESES = 512u;

struct Found {
    candidates: u32,        // left to explain
    panes: u32,             // accepted so far
    inliers: u32,           // of the plane under test; 0: there is none
    mirrors: u32,           // found so far; they stand behind the panes
    plane: vec4<f32>,       // under test: n, d
    level: vec4<f32>,       // its axis u; w: intensity above which a return on it is frame and no glass, 0: not known
}

// The survey of a plane: squares of SQUARE_M around the foot of the sensor, five counts each.
const SURVEY_WIDE = 128u;
const SURVEY_HIGH = 64u;
const SURVEY_SQUARES = 8192u;
const SQUARE_M = 0.25;

// Glass shows no farther from head on than this many times the angle at which it always does, as tangents.
const SHOWS_TO = 2.2;

const SHOWN = 0u;       // beams that end on the plane and have a second return
const DIM = 1u;         // others that end on it as weak as glass
const BRIGHT = 2u;      // others that end on it
const BEYOND = 3u;      // beams that end behind it
const SHINING = 4u;     // beams that end on it in an intensity peak, without a second return
const SURVEY_COUNTS = 5u;
