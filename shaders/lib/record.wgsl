// What the records of all layers share: where a sensor stands in a word, and how heights are kept.

// Sensor + 1 in bits 24-28; 0: none.
const SENSOR_SHIFT = 24u;
const SENSOR_MASK = 0x1fu;

fn sensor_of(word: u32) -> u32 {
    return (word >> SENSOR_SHIFT) & SENSOR_MASK;
}

// Fixed-point scale of the heights in records: 1/1024 m, in 16 bits.
const RECORD_STEPS_PER_M = 1024.0;
const MOST_RECORD_STEPS = 65535.0;

// Heights between which beams crossed count from this far below the ground, metres.
const CROSSING_ZERO_M = 32.0;
