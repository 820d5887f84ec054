//! The resident buffers of a device, by name: what plans keep from submission to submission, and share.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use crate::base::{Error, Result};
use crate::gpu::context::Context;
use crate::gpu::executor::{Executor, TIMEOUT};
use crate::gpu::plan::Plan;
use crate::gpu::ring::Slot;

/// Resident buffers, zero at first. Cheap to clone; clones share the buffers. Plans built on one store share the buffers
/// that bear one name, and run on one queue in the order of their submission.
#[derive(Debug, Clone)]
pub struct Store {
    context: Context,
    buffers: Arc<Mutex<HashMap<String, wgpu::Buffer>>>,
}

impl Store {
    /// An empty store on a device.
    pub fn new(context: &Context) -> Self {
        Self { context: context.clone(), buffers: Arc::default() }
    }

    /// The device.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// Builds a plan whose resident buffers are those of this store; what they hold stays.
    ///
    /// # Errors
    /// [`Error::Plan`], also where a resident buffer of another size bears the name; [`Error::Limit`], [`Error::Gpu`],
    /// [`Error::DeviceLost`].
    pub fn build(&self, plan: Plan) -> Result<Executor> {
        Executor::on(self, plan)
    }

    /// The resident buffer of that name, made where it is missing.
    pub(crate) fn resident(&self, name: &str, bytes: u64) -> Result<wgpu::Buffer> {
        let mut buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(buffer) = buffers.get(name) {
            if buffer.size() == bytes {
                return Ok(buffer.clone());
            }
            let reason = format!("needs {bytes} bytes, and the resident buffer has {}", buffer.size());
            return Err(Error::Plan { pass: name.into(), reason });
        }
        use wgpu::BufferUsages as U;
        let buffer = self.context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(name),
            size: bytes,
            usage: U::STORAGE | U::COPY_DST | U::COPY_SRC,
            mapped_at_creation: false,
        });
        buffers.insert(name.into(), buffer.clone());
        Ok(buffer)
    }

    /// Bytes of the resident buffer of that name, once all that was submitted is done; `None`: there is no such buffer.
    ///
    /// # Errors
    /// [`Error::Gpu`], also where it takes more than a minute; [`Error::DeviceLost`].
    pub fn read(&self, name: &str, offset: u64, bytes: u64) -> Result<Option<Vec<u8>>> {
        let buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(buffer) = buffers.get(name) else { return Ok(None) };
        let slot = Slot::landing(&self.context, bytes);
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, offset, &slot.buffer, 0, Some(bytes));
        let index = self.context.queue.submit([encoder.finish()]);
        slot.request_map();
        let failed = |reason: String| Error::Gpu { what: format!("reading `{name}`"), reason };
        let polled = self
            .context
            .device
            .poll(wgpu::PollType::Wait { submission_index: Some(index), timeout: Some(TIMEOUT) });
        self.context.check("waiting")?;
        polled.map_err(|e| failed(e.to_string()))?;
        if !slot.wait_mapped(TIMEOUT)? {
            return Err(failed("not mapped in time".into()));
        }
        let view = slot.buffer.slice(..).get_mapped_range().map_err(|e| failed(e.to_string()))?;
        Ok(Some(view.to_vec()))
    }

    /// Sets every resident buffer back to zero.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn clear(&self) -> Result<()> {
        let buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        for buffer in buffers.values() {
            encoder.clear_buffer(buffer, 0, None);
        }
        self.context.queue.submit([encoder.finish()]);
        self.context.check("clearing what is kept")
    }
}
