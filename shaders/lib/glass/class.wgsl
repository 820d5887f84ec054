// Classes of points (spec 3 §5), as map::glass::PointClass numbers them.
const UNLABELLED = 0u;
const INSIDE = 1u;
const GLASS = 2u;
const REFLECTION = 3u;
const OUTSIDE = 4u;
const CLASSES = 5u;

// A label holds the class in bits 0-7 and the id of its pane in bits 8-31, 0 for none.
fn label_of(kind: u32, pane_id: u32) -> u32 {
    return kind | (pane_id << 8u);
}

// A label that is still open: the beam meets the pane in this slot, and the point lies on it or behind it.
const MEETS = 0x80u;

fn label_meeting(slots: vec4<u32>) -> vec4<u32> {
    return vec4(MEETS) | (slots << vec4(8u));
}

// Per pane counts of a scan (PANE_COUNTS words each).
const PANE_COUNTS = 8u;
const REFLECTIONS = 0u;     // points behind shown to be reflections
const OUTSIDES = 1u;        // points behind shown to be real
const ROOM_DEPTH = 2u;      // how far what was measured reaches before the pane, and so its image behind it, millimetres
const SHOWING = 3u;         // head-on beams that end on it
const PASSING = 4u;         // head-on beams that end behind it

// The list of points whose beams meet a pane, in any order: its length, a word of padding, and two words for each, the point
// and its place.
const MET_COUNT = 0u;

fn met_at(number: u32) -> u32 {
    return 2u + 2u * number;
}
