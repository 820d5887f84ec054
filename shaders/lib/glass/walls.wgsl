// Walls of a scan, and what lies behind each by upright strips of its plane. Needs lib/glass/grid.

// Walls that are looked at in one scan.
const WALLS = 4u;

struct Walls {
    planes: array<vec4<f32>, WALLS>,    // n, d > 0; d = 0: there is none
    levels: array<vec4<f32>, WALLS>,    // axis u
    glazed: array<vec4<f32>, WALLS>,    // least and largest u at which panes of this scan lie in the wall
}

// How far behind a wall a beam ends at least that goes on, metres.
const BEHIND_M = 0.3;
// Beams that graze a wall say nothing about it: cosine of 80 degrees.
const GRAZING_COS = 0.17;

// Strips of a wall, about the foot of the sensor's perpendicular, and their width, metres.
const STRIPS = 256u;
const STRIP_M = 0.125;

// Words of a strip (STRIP_WORDS).
const STRIP_WORDS = 8u;
const GO_ON = 0u;       // beams that end behind the wall
const IMAGES = 1u;      // of them those with a surface at the mirrored place
const PROOFS = 2u;      // of these those with none where a wall before or behind this one would mirror them, and by one return
const REFUTED = 3u;     // of those that end behind it those whose mirrored place the sensor sees through
const TWICE = 4u;       // of those that end behind it those with two returns
const GLAZED = 5u;      // beams that end on the wall and have a second return behind it
const LOWEST = 6u;      // least and largest v of beams that go on and are not refuted, millimetres above -V_ZERO_MM; NONE and 0: none is
const HIGHEST = 7u;
const V_ZERO_MM = 64000.0;

fn strip_at(wall: u32, strip: u32) -> u32 {
    return (wall * STRIPS + strip) * STRIP_WORDS;
}

// The list of beams that go on, in any order: its length, and for each the place and the wall.
const PASSED_COUNT = 0u;
const PLACE_BITS = 24u;
