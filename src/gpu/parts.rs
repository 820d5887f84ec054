//! What a plan is made of: buffers and textures by name, and one dispatch.

use crate::gpu::shader::{Binding, Shader};

/// A buffer of the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BufferId(pub(crate) usize);

/// Where a buffer's content comes from and how long it lives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Role {
    /// Parameters written by the host before every frame, with struct name, field names and offsets.
    Uniform(&'static str, &'static [(&'static str, usize)]),
    /// Data written by the host before every frame.
    Upload,
    /// Written once when the plan is built, and on request.
    Fixed(Vec<u8>),
    /// Kept from frame to frame; zero at first.
    State,
    /// Lives within a frame, from its first step to its last.
    Scratch,
}

/// Texels of a two-dimensional texture array, four 32-bit values each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent {
    /// Texels along x.
    pub width: u32,
    /// Texels along y.
    pub height: u32,
    /// Layers of the array.
    pub layers: u32,
}

impl Extent {
    /// Bytes of all texels.
    pub fn bytes(self) -> u64 {
        u64::from(self.width) * u64::from(self.height) * u64::from(self.layers) * 16
    }
}

/// A declared buffer, or texture.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BufferDecl {
    /// The name by which passes bind it, after the scope that it was declared in, as in `front/depth_m`.
    pub name: String,
    /// Size in bytes, a multiple of 4.
    pub bytes: u64,
    /// Set where it is a texture and no buffer.
    pub texture: Option<Extent>,
    /// Whether a texture's texels are whole numbers (rgba32uint), else floats (rgba32float).
    pub whole: bool,
    /// Origin and lifetime.
    pub role: Role,
    /// Whether the host reads it back after every frame.
    pub read_back: bool,
    /// Whether it is a result that the host may leave unread.
    pub product: bool,
    /// Whether every frame begins with it filled with zeros.
    pub zeroed: bool,
}

/// How many invocations a step needs along x, y and z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Invocations(pub [u32; 3]);

impl Invocations {
    /// `count` in a row.
    pub fn line(count: u32) -> Self {
        Self([count, 1, 1])
    }

    /// Workgroups of `size` that cover them.
    pub(crate) fn workgroups(self, size: [u32; 3]) -> [u32; 3] {
        let [x, y, z] = self.0;
        let [size_x, size_y, size_z] = size.map(|size| size.max(1));
        [x.div_ceil(size_x), y.div_ceil(size_y), z.div_ceil(size_z)]
    }

    /// `width` x `height`.
    pub fn area(width: u32, height: u32) -> Self {
        Self([width, height, 1])
    }
}

/// One dispatch.
#[derive(Debug, Clone)]
pub struct Step {
    /// Scope in which its buffers were looked up first; empty: none.
    pub scope: String,
    /// The pass.
    pub shader: Shader,
    /// Workgroups along x, y and z.
    pub workgroups: [u32; 3],
    /// Buffer of each of the shader's bindings, in their order.
    pub buffers: Vec<BufferId>,
    /// Values of the shader's `override` constants.
    pub constants: Vec<(&'static str, f64)>,
}

impl Step {
    /// Bindings with the buffers they are bound to.
    pub fn uses(&self) -> impl Iterator<Item = (&Binding, BufferId)> {
        self.shader.bindings.iter().zip(self.buffers.iter().copied())
    }
}

/// How the WGSL struct of `binding` differs from the host's, in words.
pub(super) fn layout_difference(
    binding: &Binding,
    name: &str,
    fields: &[(&str, usize)],
    bytes: u64,
) -> Option<String> {
    if binding.type_name != name {
        return Some(format!("is a `{}` in WGSL and a `{name}` on the host", binding.type_name));
    }
    let same = binding.fields.len() == fields.len()
        && binding.fields.iter().zip(fields).all(|(a, b)| a.0 == b.0 && a.1 as usize == b.1);
    if !same {
        return Some(format!("has fields {:?} in WGSL and {fields:?} on the host", binding.fields));
    }
    (binding.min_bytes != bytes)
        .then(|| format!("spans {} bytes in WGSL and {bytes} on the host", binding.min_bytes))
}
