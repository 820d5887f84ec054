// Points with their places, as texels: x, y, z and a number that is 0 for a point without a place, else 1 + twice the place,
// and 1 more in the slot of last returns. It stays below 2^23, so that a float holds it.
const PLACED_ROW = 1024u;

fn placed_texel(index: u32) -> vec2<u32> {
    return vec2(index % PLACED_ROW, index / PLACED_ROW);
}
