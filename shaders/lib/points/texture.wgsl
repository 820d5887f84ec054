// Points in a texture, as they come from the host: rows of 1024 texels. On lavapipe a texel costs a sixth of a buffer's vector.
@group(0) @binding(1) var points: texture_storage_2d_array<rgba32uint, read>;

fn point_words(index: u32) -> vec4<u32> {
    return textureLoad(points, vec2(index % 1024u, index / 1024u), 0u);
}
