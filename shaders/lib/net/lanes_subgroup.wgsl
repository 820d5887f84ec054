// Eight neighbouring texels of weights, read once by eight lanes of a subgroup and passed around; all lanes must take
// part. Needs lib/net/weights_*.
alias Eight = vec4<f32>;

var<private> lane: i32;

fn find_lane() {
    lane = i32(subgroupExclusiveAdd(1u) & 7u);
}

fn load_eight(row: i32, first: i32) -> Eight {
    return load_weights(row, first + lane);
}

fn texel(eight: Eight, k: i32) -> vec4<f32> {
    return subgroupShuffle(eight, u32(k));
}
