//! The inputs of one frame.

use bytemuck::bytes_of;

use crate::base::{Error, Result};
use crate::gpu::executor::Executor;
use crate::gpu::plan::{Invocations, Role};
use crate::gpu::shader::Params;

/// The inputs of one frame, written straight into a staging buffer.
pub struct FrameInput<'a> {
    pub(crate) executor: &'a mut Executor,
    pub(crate) view: wgpu::BufferViewMut,
    pub(crate) scope: String,
}

impl FrameInput<'_> {
    /// Names are looked up in `scope` first from here on; empty: in none.
    pub fn enter(&mut self, scope: &str) {
        self.scope = scope.into();
    }

    /// Writes parameters.
    ///
    /// # Errors
    /// [`Error::Plan`] where the buffer is not a uniform of that size.
    pub fn set<P: Params>(&mut self, name: &str, params: &P) -> Result<()> {
        self.write(name, bytes_of(params))
    }

    /// Writes the first `data.len()` bytes of an upload buffer or texture.
    ///
    /// # Errors
    /// [`Error::Plan`] where the buffer is not written by the host or is smaller.
    pub fn write(&mut self, name: &str, data: &[u8]) -> Result<()> {
        let id = self.executor.find_in(&self.scope, name)?;
        let buffer = &self.executor.plan.buffers()[id.0];
        let host = matches!(buffer.role, Role::Uniform(..) | Role::Upload);
        if !host || data.len() as u64 > buffer.bytes {
            let reason = format!("{} bytes do not fit an upload of {}", data.len(), buffer.bytes);
            return Err(Error::Plan { pass: buffer.name.clone(), reason });
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
    /// [`Error::Plan`] where the buffer is not written by the host.
    pub fn clear(&mut self, name: &str) -> Result<()> {
        let bytes = self.executor.plan.buffers()[self.executor.find_in(&self.scope, name)?.0].bytes;
        self.write(name, &vec![0; usize::try_from(bytes).unwrap_or(0)])
    }

    /// Runs a pass over fewer invocations than planned, in this frame alone.
    ///
    /// # Errors
    /// [`Error::Plan`] where there is no such pass or the plan has fewer.
    pub fn limit(&mut self, pass: &str, invocations: Invocations) -> Result<()> {
        let bad = |reason: &str| Error::Plan { pass: pass.into(), reason: reason.into() };
        let scope = &self.scope;
        let mut dispatches = self.executor.dispatches.iter_mut();
        let dispatch = dispatches.find(|dispatch| *dispatch.name == *pass && *dispatch.scope == **scope);
        let dispatch = dispatch.ok_or_else(|| bad("the plan has no such pass"))?;
        let workgroups = invocations.workgroups(dispatch.workgroup_size);
        if workgroups.iter().zip(&dispatch.planned).any(|(now, planned)| now > planned) {
            return Err(bad("is asked for more invocations than planned"));
        }
        dispatch.workgroups = workgroups;
        Ok(())
    }

    /// Reads only the first `bytes` of a buffer back, in this frame alone.
    ///
    /// # Errors
    /// [`Error::Plan`] where the plan does not read so much of it back.
    pub fn read_back_first(&mut self, name: &str, bytes: u64) -> Result<()> {
        let id = self.executor.find_in(&self.scope, name)?;
        let bytes = bytes.next_multiple_of(4).max(4);
        let mut landings = self.executor.landings_now.iter_mut();
        let landing = landings.find(|landing| landing.id == id && bytes <= landing.bytes);
        let missing =
            || Error::Plan { pass: name.into(), reason: format!("reads back fewer than {bytes} bytes") };
        landing.ok_or_else(missing)?.bytes = bytes;
        Ok(())
    }

    /// Leaves a buffer that the plan reads back on the GPU, in this frame alone.
    ///
    /// # Errors
    /// [`Error::Plan`] where there is no such buffer.
    pub fn leave(&mut self, name: &str) -> Result<()> {
        let id = self.executor.find_in(&self.scope, name)?;
        self.executor.landings_now.retain(|landing| landing.id != id);
        Ok(())
    }

    /// Hands the frame to the GPU: one command buffer, one submit.
    ///
    /// # Errors
    /// [`Error::Gpu`] from wgpu's validation, [`Error::DeviceLost`].
    pub fn submit(self) -> Result<()> {
        let Self { executor, view, .. } = self;
        drop(view);
        executor.launch()
    }
}
