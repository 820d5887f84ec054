//! Textures that the host fills before every frame: where their texels lie in a staging slot.

use crate::gpu::dispatch::Memory;
use crate::gpu::plan::{BufferId, Extent, Plan, Role};

/// Bytes of a texel.
const TEXEL_BYTES: u64 = 16;

/// A texture's place in a staging slot, and how much of it the frame being written has filled.
pub(crate) struct TextureUpload {
    pub(crate) id: BufferId,
    pub(crate) offset: u64,
    extent: Extent,
    rows: u32,
}

impl TextureUpload {
    /// The uploads of a plan behind `after` bytes of buffers, and the bytes of all.
    pub(crate) fn all(plan: &Plan, after: u64) -> (Vec<Self>, u64) {
        let mut end = after;
        let mut uploads = Vec::new();
        for (index, decl) in plan.buffers().iter().enumerate().filter(|(_, b)| b.role == Role::Upload) {
            let Some(extent) = decl.texture else { continue };
            let offset = end.next_multiple_of(TEXEL_BYTES);
            end = offset + decl.bytes;
            uploads.push(Self { id: BufferId(index), offset, extent, rows: 0 });
        }
        (uploads, end)
    }

    /// Notes that the first `bytes` are filled; rows beyond keep what they hold.
    pub(crate) fn filled(&mut self, bytes: usize) {
        let row_bytes = usize::try_from(u64::from(self.extent.width) * TEXEL_BYTES).unwrap_or(usize::MAX);
        self.rows = u32::try_from(bytes.div_ceil(row_bytes)).unwrap_or(u32::MAX).min(self.extent.height);
    }

    /// Copies the filled rows.
    pub(crate) fn encode(&self, encoder: &mut wgpu::CommandEncoder, staging: &wgpu::Buffer, to: &Memory) {
        let Some(texture) = to.textures[self.id.0].as_ref().filter(|_| self.rows > 0) else { return };
        let layout = wgpu::TexelCopyBufferLayout {
            offset: self.offset,
            bytes_per_row: Some(self.extent.width * 16),
            rows_per_image: Some(self.rows),
        };
        let size = wgpu::Extent3d { width: self.extent.width, height: self.rows, depth_or_array_layers: 1 };
        let source = wgpu::TexelCopyBufferInfo { buffer: staging, layout };
        encoder.copy_buffer_to_texture(source, texture.as_image_copy(), size);
    }

    /// Ready for the next frame.
    pub(crate) fn reset(&mut self) {
        self.rows = 0;
    }
}
