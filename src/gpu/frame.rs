//! Runs a plan: everything is built once; a frame is one copy in, the passes, one copy out, one submit.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use crate::base::{Error, Result};
use crate::gpu::arena::{Kind, Layout, Place};
use crate::gpu::cache::PipelineStore;
use crate::gpu::context::Context;
use crate::gpu::dispatch::{Dispatch, Memory, allocate, compile, size_of_texture};
use crate::gpu::input::FrameInput;
use crate::gpu::plan::{BufferId, Plan, Role};
use crate::gpu::readback::{Landing, Readback, landings};
use crate::gpu::ring::Slot;
use crate::gpu::timing::Timing;
use crate::gpu::upload::TextureUpload;

/// Frames that may be under way at once, so that upload, compute and readback overlap.
pub const FRAMES_IN_FLIGHT: usize = 3;

/// How long a frame may take before it counts as hung.
const TIMEOUT: Duration = Duration::from_secs(60);

struct InFlight {
    slot: usize,
    index: wgpu::SubmissionIndex,
}

/// A built plan.
pub struct Executor {
    pub(crate) context: Context,
    pub(crate) plan: Plan,
    pub(crate) layout: Layout,
    memory: Memory,
    pub(crate) dispatches: Vec<Dispatch>,
    staging: Vec<Slot>,
    landing: Vec<Slot>,
    landings: Vec<Landing>,
    timing: Option<Timing>,
    host_arena: Option<usize>,
    pub(crate) texture_uploads: Vec<TextureUpload>,
    next_slot: usize,
    in_flight: VecDeque<InFlight>,
}

impl Executor {
    /// Checks the plan, allocates, compiles every pass and runs them once on zeros (drivers compile at
    /// the first dispatch), then clears what is kept.
    ///
    /// # Errors
    /// [`Error::Plan`], [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn build(context: &Context, plan: Plan) -> Result<Self> {
        plan.check()?;
        let alignment = context.device.limits().min_storage_buffer_offset_alignment;
        let uniform_alignment = context.device.limits().min_uniform_buffer_offset_alignment;
        let layout = Layout::pack(&plan, u64::from(alignment.max(uniform_alignment)));
        let memory = allocate(context, &plan, &layout);
        let store = PipelineStore::open(context);
        let dispatches = plan
            .steps()
            .iter()
            .map(|step| compile(context, step, &plan, &layout, &memory, &store))
            .collect::<Result<Vec<_>>>()?;
        let timing = Timing::new(context, u32::try_from(dispatches.len()).unwrap_or(0));
        let (landings, landing_bytes) = landings(&plan, timing.as_ref());
        let host_arena = layout.arenas.iter().position(|a| a.kind == Kind::Host);
        let host_bytes = host_arena.map_or(4, |a| layout.arenas[a].bytes);
        let (texture_uploads, staging_bytes) = TextureUpload::all(&plan, host_bytes);
        let mut executor = Self {
            staging: (0..FRAMES_IN_FLIGHT).map(|_| Slot::staging(context, staging_bytes)).collect(),
            landing: (0..FRAMES_IN_FLIGHT).map(|_| Slot::landing(context, landing_bytes)).collect(),
            context: context.clone(),
            plan,
            layout,
            memory,
            dispatches,
            landings,
            timing,
            host_arena,
            texture_uploads,
            next_slot: 0,
            in_flight: VecDeque::new(),
        };
        executor.fill_fixed()?;
        executor.warm_up()?;
        store.save();
        Ok(executor)
    }

    fn fill_fixed(&self) -> Result<()> {
        for buffer in self.plan.buffers() {
            if let Role::Fixed(data) = &buffer.role {
                self.rewrite_fixed(&buffer.name, data)?;
            }
        }
        Ok(())
    }

    /// The buffer of that name.
    ///
    /// # Errors
    /// [`Error::Input`] where the plan has none.
    pub fn find(&self, name: &str) -> Result<BufferId> {
        let missing = || Error::Input { what: name.into(), reason: "the plan has no such buffer".into() };
        self.plan.find(name).ok_or_else(missing)
    }

    fn warm_up(&mut self) -> Result<()> {
        for _ in 0..FRAMES_IN_FLIGHT {
            self.begin()?.submit()?;
        }
        while self.receive()?.is_some() {}
        self.reset()
    }

    /// Sets every buffer that is kept from frame to frame back to zero.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn reset(&mut self) -> Result<()> {
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        for (arena, buffer) in self.layout.arenas.iter().zip(&self.memory.buffers) {
            if arena.kind == Kind::State {
                encoder.clear_buffer(buffer, 0, None);
            }
        }
        self.context.queue.submit([encoder.finish()]);
        self.context.check("clearing the map")
    }

    /// Takes over what is kept from frame to frame from another executor on the same device: every buffer of the
    /// same name and size.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn take_state(&mut self, before: &Self) -> Result<()> {
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        for (id, buffer) in self.plan.buffers().iter().enumerate().filter(|(_, b)| b.role == Role::State) {
            let Some(old) = before.plan.find(&buffer.name) else { continue };
            if before.plan.buffers()[old.0].bytes == buffer.bytes {
                let [to, from] = [self.layout.places[id], before.layout.places[old.0]];
                let source = &before.memory.buffers[from.arena];
                let target = &self.memory.buffers[to.arena];
                encoder.copy_buffer_to_buffer(source, from.offset, target, to.offset, Some(buffer.bytes));
            }
        }
        self.context.queue.submit([encoder.finish()]);
        self.context.check("keeping the map")
    }

    /// Replaces the content of a fixed buffer, from the next frame on.
    ///
    /// # Errors
    /// [`Error::Input`] where the buffer is not fixed or the size differs.
    pub fn rewrite_fixed(&self, name: &str, data: &[u8]) -> Result<()> {
        let id = self.find(name)?;
        let buffer = &self.plan.buffers()[id.0];
        if !matches!(buffer.role, Role::Fixed(_)) || buffer.bytes != data.len().next_multiple_of(4) as u64 {
            let reason = format!("{} bytes do not fit a fixed buffer of {}", data.len(), buffer.bytes);
            return Err(Error::Input { what: buffer.name.clone(), reason });
        }
        if let (Some(extent), Some(texture)) = (buffer.texture, &self.memory.textures[id.0]) {
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(extent.width * 16),
                rows_per_image: Some(extent.height),
            };
            self.context.queue.write_texture(texture.as_image_copy(), data, layout, size_of_texture(extent));
            return self.context.check(&buffer.name);
        }
        let mut padded = data.to_vec();
        padded.resize(data.len().next_multiple_of(4), 0);
        let Place { arena, offset } = self.layout.places[id.0];
        self.context.queue.write_buffer(&self.memory.buffers[arena], offset, &padded);
        self.context.check(&buffer.name)
    }

    /// Frames submitted and not yet received.
    pub fn in_flight(&self) -> usize {
        self.in_flight.len()
    }

    /// The device.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// The plan that this runs.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Sizes of the GPU allocations in bytes, without the staging rings.
    pub fn allocation_bytes(&self) -> Vec<u64> {
        self.layout.arenas.iter().map(|a| a.bytes).collect()
    }

    /// Opens the next frame for writing its inputs. Receive first when [`FRAMES_IN_FLIGHT`] are under way.
    ///
    /// # Errors
    /// [`Error::Gpu`] where all slots are taken or mapping fails; [`Error::DeviceLost`].
    pub fn begin(&mut self) -> Result<FrameInput<'_>> {
        self.context.check("starting a frame")?;
        if self.in_flight.len() >= FRAMES_IN_FLIGHT {
            return Err(Error::Gpu {
                what: "starting a frame".into(),
                reason: "all slots are in flight".into(),
            });
        }
        let slot = &self.staging[self.next_slot];
        let deadline = std::time::Instant::now() + TIMEOUT;
        while !slot.mapped()? {
            self.poll(wgpu::PollType::Poll)?;
            if std::time::Instant::now() > deadline {
                return Err(Error::Gpu {
                    what: "starting a frame".into(),
                    reason: "staging never came free".into(),
                });
            }
            std::thread::yield_now();
        }
        let view = slot.buffer.slice(..).get_mapped_range_mut();
        let view = view.map_err(|e| Error::Gpu { what: "staging".into(), reason: e.to_string() })?;
        Ok(FrameInput { executor: self, view })
    }

    fn poll(&self, how: wgpu::PollType) -> Result<()> {
        let polled = self.context.device.poll(how);
        self.context.check("waiting")?;
        polled.map(|_| ()).map_err(|e| Error::Gpu { what: "waiting".into(), reason: e.to_string() })
    }

    fn encode(&self, slot: usize) -> wgpu::CommandBuffer {
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        if let Some(host) = self.host_arena {
            let (staging, bytes) = (&self.staging[slot].buffer, self.layout.arenas[host].bytes);
            encoder.copy_buffer_to_buffer(staging, 0, &self.memory.buffers[host], 0, Some(bytes));
        }
        for upload in &self.texture_uploads {
            upload.encode(&mut encoder, &self.staging[slot].buffer, &self.memory);
        }
        for (buffer, place) in self.plan.buffers().iter().zip(&self.layout.places).filter(|(b, _)| b.zeroed) {
            encoder.clear_buffer(&self.memory.buffers[place.arena], place.offset, Some(buffer.bytes));
        }
        match &self.timing {
            None => self.encode_together(&mut encoder),
            Some(timing) => self.encode_timed(&mut encoder, timing),
        }
        for landing in &self.landings {
            let (source, offset) = match (&self.timing, self.plan.buffers().get(landing.id.0)) {
                (_, Some(_)) => {
                    let place = self.layout.places[landing.id.0];
                    (&self.memory.buffers[place.arena], place.offset)
                }
                (Some(timing), None) => (&timing.resolved, 0),
                (None, None) => continue,
            };
            let target = &self.landing[slot].buffer;
            encoder.copy_buffer_to_buffer(source, offset, target, landing.offset, Some(landing.bytes));
        }
        encoder.finish()
    }

    fn encode_together(&self, encoder: &mut wgpu::CommandEncoder) {
        let descriptor = wgpu::ComputePassDescriptor { label: Some("frame"), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        for dispatch in &self.dispatches {
            dispatch.encode(&mut pass);
        }
    }

    fn encode_timed(&self, encoder: &mut wgpu::CommandEncoder, timing: &Timing) {
        for (index, dispatch) in (0..).zip(&self.dispatches) {
            let timestamp_writes = Some(timing.writes(index));
            let descriptor = wgpu::ComputePassDescriptor { label: Some(&*dispatch.name), timestamp_writes };
            dispatch.encode(&mut encoder.begin_compute_pass(&descriptor));
        }
        timing.resolve(encoder);
    }

    /// Waits for the oldest frame under way; `None` when there is none.
    ///
    /// # Errors
    /// [`Error::Gpu`] where it does not end in time, [`Error::DeviceLost`].
    pub fn receive(&mut self) -> Result<Option<Readback>> {
        let Some(InFlight { slot, index }) = self.in_flight.pop_front() else { return Ok(None) };
        self.poll(wgpu::PollType::Wait { submission_index: Some(index), timeout: Some(TIMEOUT) })?;
        if !self.landing[slot].mapped()? {
            return Err(Error::Gpu { what: "readback".into(), reason: "not mapped after its frame".into() });
        }
        let view = self.landing[slot].buffer.slice(..).get_mapped_range();
        let view = view.map_err(|e| Error::Gpu { what: "readback".into(), reason: e.to_string() })?;
        let mut readback =
            Readback { data: view.to_vec(), landings: self.landings.clone(), spans: Vec::new() };
        drop(view);
        self.landing[slot].buffer.unmap();
        if let Some(timing) = &self.timing {
            let spans = timing.spans(readback.bytes(self.timing_id())?);
            readback.spans = self.dispatches.iter().map(|d| Arc::clone(&d.name)).zip(spans).collect();
        }
        Ok(Some(readback))
    }

    fn timing_id(&self) -> BufferId {
        BufferId(self.plan.buffers().len())
    }

    /// Encodes and submits the frame whose inputs are written.
    pub(crate) fn launch(&mut self) -> Result<()> {
        let slot = self.next_slot;
        self.staging[slot].buffer.unmap();
        let commands = self.encode(slot);
        for dispatch in &mut self.dispatches {
            dispatch.workgroups = dispatch.planned;
        }
        self.texture_uploads.iter_mut().for_each(TextureUpload::reset);
        let index = self.context.queue.submit([commands]);
        self.staging[slot].request_map();
        self.landing[slot].request_map();
        self.next_slot = (slot + 1) % FRAMES_IN_FLIGHT;
        self.in_flight.push_back(InFlight { slot, index });
        self.context.check("submitting a frame")
    }
}
