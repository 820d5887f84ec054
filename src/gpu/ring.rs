//! Rings of mappable buffers: staging for uploads, landing for readback; a slot per frame in flight.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::base::{Error, Result};
use crate::gpu::context::Context;

/// How far the mapping of a slot is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mapping {
    Pending,
    Mapped,
    Failed,
}

/// A mapping, and a bell that rings when it changes: whichever thread polls the device may be the one to hear of it.
#[derive(Debug)]
struct State {
    mapping: Mutex<Mapping>,
    changed: Condvar,
}

impl State {
    fn lock(&self) -> MutexGuard<'_, Mapping> {
        self.mapping.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, mapping: Mapping) {
        *self.lock() = mapping;
        self.changed.notify_all();
    }
}

/// A buffer that the host maps, hands to the GPU, and maps again.
pub(crate) struct Slot {
    pub(crate) buffer: wgpu::Buffer,
    mode: wgpu::MapMode,
    state: Arc<State>,
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
        let mapping = Mutex::new(if mapped_at_creation { Mapping::Mapped } else { Mapping::Pending });
        Self { buffer, mode, state: Arc::new(State { mapping, changed: Condvar::new() }) }
    }

    /// Asks for the mapping; it is there once the work that uses the buffer is done.
    pub(crate) fn request_map(&self) {
        self.state.set(Mapping::Pending);
        let state = Arc::clone(&self.state);
        self.buffer.map_async(self.mode, .., move |result| {
            state.set(if result.is_ok() { Mapping::Mapped } else { Mapping::Failed });
        });
    }

    /// Whether the mapping is there.
    ///
    /// # Errors
    /// [`Error::Gpu`] where it failed.
    pub(crate) fn mapped(&self) -> Result<bool> {
        is_mapped(*self.state.lock())
    }

    /// Waits for the mapping, which the end of the slot's submission brings; whether it came in time.
    ///
    /// # Errors
    /// [`Error::Gpu`] where it failed.
    pub(crate) fn wait_mapped(&self, most: Duration) -> Result<bool> {
        let pending = |mapping: &mut Mapping| *mapping == Mapping::Pending;
        let waited = self.state.changed.wait_timeout_while(self.state.lock(), most, pending);
        is_mapped(*waited.unwrap_or_else(PoisonError::into_inner).0)
    }
}

fn is_mapped(mapping: Mapping) -> Result<bool> {
    match mapping {
        Mapping::Failed => Err(Error::Gpu { what: "mapping a buffer".into(), reason: "refused".into() }),
        other => Ok(other == Mapping::Mapped),
    }
}
