//! Rings of mappable buffers: staging for uploads, landing for readback; a slot per frame in flight.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use crate::base::{Error, Result};
use crate::gpu::context::Context;

const PENDING: u8 = 0;
const MAPPED: u8 = 1;
const FAILED: u8 = 2;

/// A buffer that the host maps, hands to the GPU, and maps again.
pub(crate) struct Slot {
    pub(crate) buffer: wgpu::Buffer,
    mode: wgpu::MapMode,
    state: Arc<AtomicU8>,
}

impl Slot {
    /// Staging slots start mapped, ready to be written.
    pub(crate) fn staging(context: &Context, bytes: u64) -> Self {
        let usage = wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC;
        Self::new(context, "staging", bytes, usage, wgpu::MapMode::Write)
    }

    /// Landing slots start unmapped, ready to be copied into.
    pub(crate) fn landing(context: &Context, bytes: u64) -> Self {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        Self::new(context, "readback", bytes, usage, wgpu::MapMode::Read)
    }

    fn new(
        context: &Context,
        label: &str,
        bytes: u64,
        usage: wgpu::BufferUsages,
        mode: wgpu::MapMode,
    ) -> Self {
        let mapped_at_creation = mode == wgpu::MapMode::Write;
        let descriptor =
            wgpu::BufferDescriptor { label: Some(label), size: bytes.max(4), usage, mapped_at_creation };
        let buffer = context.device.create_buffer(&descriptor);
        let state = Arc::new(AtomicU8::new(if mapped_at_creation { MAPPED } else { PENDING }));
        Self { buffer, mode, state }
    }

    /// Asks for the mapping; it is there once the work that uses the buffer is done.
    pub(crate) fn request_map(&self) {
        self.state.store(PENDING, Ordering::Release);
        let state = Arc::clone(&self.state);
        self.buffer.map_async(self.mode, .., move |result| {
            state.store(if result.is_ok() { MAPPED } else { FAILED }, Ordering::Release);
        });
    }

    /// Whether the mapping is there.
    ///
    /// # Errors
    /// [`Error::Gpu`] where it failed.
    pub(crate) fn mapped(&self) -> Result<bool> {
        match self.state.load(Ordering::Acquire) {
            FAILED => Err(Error::Gpu { what: "mapping a buffer".into(), reason: "refused".into() }),
            state => Ok(state == MAPPED),
        }
    }
}
