// Reads a candidate. Needs lib/glass/candidates and the texture `candidates`, open for reading.
fn candidate_at(number: u32) -> vec4<f32> {
    return textureLoad(candidates, candidate_texel(number), 0u);
}
