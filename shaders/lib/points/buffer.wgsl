// Points in a buffer, as a pass before left them.
@group(0) @binding(1) var<storage, read> points: array<vec4<u32>>;

fn point_words(index: u32) -> vec4<u32> {
    return points[index];
}
