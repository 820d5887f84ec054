// Rows of the organized cloud as texels, by number. Needs the texture `row_texels`.
// x of the bin of elevation, y of the ring; what has no row has more than there are.
const ROW_TEXELS = 64u;

fn row_texel(number: u32) -> vec2<u32> {
    return vec2<u32>(textureLoad(row_texels, vec2(number % ROW_TEXELS, number / ROW_TEXELS), 0u).xy);
}

fn row_of_bin(bin: u32) -> u32 {
    return row_texel(bin).x;
}

fn row_of_ring(ring: u32) -> u32 {
    return row_texel(ring).y;
}
