// Candidates as texels: x, y, z in metres and the intensity. On lavapipe a texel costs a fraction of a buffer's vector.
const CANDIDATE_ROW = 64u;

fn candidate_texel(number: u32) -> vec2<u32> {
    return vec2(number % CANDIDATE_ROW, number / CANDIDATE_ROW);
}
