//! The inputs of one frame.

use bytemuck::bytes_of;

use crate::base::{Error, Result};
use crate::gpu::frame::Executor;
use crate::gpu::plan::{Invocations, Role};
use crate::gpu::shader::Params;

/// The inputs of one frame, written straight into a staging buffer.
pub struct FrameInput<'a> {
    pub(crate) executor: &'a mut Executor,
    pub(crate) view: wgpu::BufferViewMut,
}

impl FrameInput<'_> {
    /// Writes parameters.
    ///
    /// # Errors
    /// [`Error::Input`] where the buffer is not a uniform of that size.
    pub fn set<P: Params>(&mut self, name: &str, params: &P) -> Result<()> {
        self.write(name, bytes_of(params))
    }

    /// Writes the first `data.len()` bytes of an upload buffer or texture.
    ///
    /// # Errors
    /// [`Error::Input`] where the buffer is not written by the host or is smaller.
    pub fn write(&mut self, name: &str, data: &[u8]) -> Result<()> {
        let id = self.executor.find(name)?;
        let buffer = &self.executor.plan.buffers()[id.0];
        let host = matches!(buffer.role, Role::Uniform(..) | Role::Upload);
        if !host || data.len() as u64 > buffer.bytes {
            let reason = format!("{} bytes do not fit an upload of {}", data.len(), buffer.bytes);
            return Err(Error::Input { what: buffer.name.clone(), reason });
        }
        let texture = self.executor.texture_uploads.iter_mut().find(|upload| upload.id == id);
        let start = texture.map_or(self.executor.layout.places[id.0].offset, |upload| {
            upload.filled(data.len());
            upload.offset
        });
        let start = usize::try_from(start).unwrap_or(usize::MAX);
        self.view.slice(start..start + data.len()).copy_from_slice(data);
        Ok(())
    }

    /// Fills an upload buffer with zeros.
    ///
    /// # Errors
    /// [`Error::Input`] where the buffer is not written by the host.
    pub fn clear(&mut self, name: &str) -> Result<()> {
        let bytes = self.executor.plan.buffers()[self.executor.find(name)?.0].bytes;
        self.write(name, &vec![0; usize::try_from(bytes).unwrap_or(0)])
    }

    /// Runs a pass over fewer invocations than planned, in this frame alone.
    ///
    /// # Errors
    /// [`Error::Input`] where there is no such pass or the plan has fewer.
    pub fn limit(&mut self, pass: &str, invocations: Invocations) -> Result<()> {
        let bad = |reason: &str| Error::Input { what: pass.into(), reason: reason.into() };
        let dispatch = self.executor.dispatches.iter_mut().find(|dispatch| *dispatch.name == *pass);
        let dispatch = dispatch.ok_or_else(|| bad("the plan has no such pass"))?;
        let workgroups = invocations.workgroups(dispatch.workgroup_size);
        if workgroups.iter().zip(&dispatch.planned).any(|(now, planned)| now > planned) {
            return Err(bad("is asked for more invocations than planned"));
        }
        dispatch.workgroups = workgroups;
        Ok(())
    }

    /// Hands the frame to the GPU: one command buffer, one submit.
    ///
    /// # Errors
    /// [`Error::Gpu`] from wgpu's validation, [`Error::DeviceLost`].
    pub fn submit(self) -> Result<()> {
        let Self { executor, view } = self;
        drop(view);
        executor.launch()
    }
}
