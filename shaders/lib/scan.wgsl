// Points as they are uploaded (sensor::Point): two vec4 of 32 bits each.
//   points[2 i]      x, y, z in metres, intensity in the sensor's unit, as floats
//   points[2 i + 1]  time in seconds as a float; ring, column << 16; return type, strength << 8; label

// Sectors of the horizontal around the lidar, in which the farthest beam is kept.
const SECTORS = 720u;

// Fixed-point scale of distances in sectors: 1/1024 m.
const SECTOR_STEPS_PER_M = 1024.0;

// Fixed-point one of intensities: a multiple of 255, so that bytes of full scale 255 are exact, and small enough for the
// sum of a million points to fit in 32 bits.
const INTENSITY_STEPS = 4080.0;

// Sector of a direction: quarters by sign, evenly in |y| / (|x| + |y|) within, so that no angle function is needed.
fn sector_of(x: f32, y: f32) -> u32 {
    let length = abs(x) + abs(y);
    let share = select(abs(y) / length, 0.0, length == 0.0);
    var turn = select(share, 2.0 - share, x < 0.0);
    turn = select(turn, 4.0 - turn, y < 0.0);
    return min(u32(turn * f32(SECTORS) / 4.0), SECTORS - 1u);
}

// A cell's word: class in bits 0-7, steps of glass in bits 8-19, steps of what is spread around it in bits 20-31.
const GLASS_SHIFT = 8u;
const STRENGTH_SHIFT = 20u;
const GLASS_MASK = 0xfffu;

// Classes of cells (map::CellClass).
const UNKNOWN = 0u;
const FREE = 1u;
const SOLID = 2u;
const PASSABLE = 3u;
const TRANSPARENT = 4u;
const INFLATED = 5u;

// Returns of beams that have two (sensor::ReturnType).
const FIRST_RETURN = 1u;
const LAST_RETURN = 2u;
const STRONGEST_RETURN = 4u;
