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
const STRIP_WORDS = 9u;
const GO_ON = 0u;       // beams that end behind the wall
const TWICE = 1u;       // of them those with two returns
const GLAZED = 2u;      // beams that end on the wall and have a second return behind it
const IMAGES = 3u;      // of those that go on those with a surface at the mirrored place
const MISSING = 4u;     // those without, where the scan shows something else
const REFUTED = 5u;     // of these those whose mirrored place the sensor sees through
const PROOFS = 6u;      // images by one return that would not be there if the wall stood before or behind where it stands
const LOWEST = 7u;      // least and largest v of beams that go on and are not refuted, millimetres above -V_ZERO_MM; NONE and 0: none is
const HIGHEST = 8u;
const V_ZERO_MM = 64000.0;

fn strip_at(wall: u32, strip: u32) -> u32 {
    return (wall * STRIPS + strip) * STRIP_WORDS;
}

// The list of beams that go on, in any order: its length, and for each the place and the wall.
const PASSED_COUNT = 0u;
const PLACE_BITS = 24u;
