//! Runs a plan: everything is built once; a frame is one copy in, the passes, one copy out, one submit.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use crate::base::{Error, Result};
use crate::gpu::arena::{Kind, Layout, Place};
use crate::gpu::context::Context;
use crate::gpu::dispatch::{Dispatch, Memory, allocate, bind, size_of_texture};
use crate::gpu::input::FrameInput;
use crate::gpu::plan::{BufferId, Plan, Role, scoped};
use crate::gpu::readback::{Landing, Readback, landings};
use crate::gpu::ring::Slot;
use crate::gpu::store::Store;
use crate::gpu::timing::Timing;
use crate::gpu::upload::TextureUpload;

/// Frames that may be under way at once, so that upload, compute and readback overlap.
pub const FRAMES_IN_FLIGHT: usize = 3;

/// How long a frame may take before it counts as hung.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(60);

struct InFlight {
    slot: usize,
    index: wgpu::SubmissionIndex,
    /// What it reads back, and how much of it.
    landings: Vec<Landing>,
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
    /// Of the frame being written.
    pub(crate) landings_now: Vec<Landing>,
    timing: Option<Timing>,
    host_arena: Option<usize>,
    pub(crate) texture_uploads: Vec<TextureUpload>,
    next_slot: usize,
    in_flight: VecDeque<InFlight>,
}

impl Executor {
    /// Builds a plan on a store of its own; see [`Store::build`].
    ///
    /// # Errors
    /// As [`Store::build`].
    pub fn build(context: &Context, plan: Plan) -> Result<Self> {
        Store::new(context).build(plan)
    }

    /// Checks the plan, allocates, compiles the passes and runs them once on zeros (drivers compile at the first dispatch);
    /// what is resident holds afterwards what it held before.
    ///
    /// # Errors
    /// [`Error::Plan`], [`Error::Limit`], [`Error::Gpu`], [`Error::DeviceLost`].
    pub(crate) fn on(store: &Store, plan: Plan) -> Result<Self> {
        plan.check()?;
        let context = store.context();
        context.check_limits(&plan.requirements())?;
        let alignment = context.device.limits().min_storage_buffer_offset_alignment;
        let uniform_alignment = context.device.limits().min_uniform_buffer_offset_alignment;
        let layout = Layout::pack(&plan, u64::from(alignment.max(uniform_alignment)));
        let memory = allocate(store, &plan, &layout)?;
        let programs = context.programs.of(&context.device, plan.steps())?;
        let dispatches = plan
            .steps()
            .iter()
            .zip(programs)
            .map(|(step, program)| bind(context, step, program, &plan, &layout, &memory))
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
            landings_now: landings.clone(),
            landings,
            timing,
            host_arena,
            texture_uploads,
            next_slot: 0,
            in_flight: VecDeque::new(),
        };
        executor.fill_fixed()?;
        executor.warm_up()?;
        context.programs.save();
        Ok(executor)
    }

    fn fill_fixed(&self) -> Result<()> {
        for buffer in self.plan.buffers() {
            if let Role::Fixed(data) = &buffer.role {
                self.rewrite_fixed("", &buffer.name, data)?;
            }
        }
        Ok(())
    }

    /// The buffer of that name, of no scope.
    ///
    /// # Errors
    /// [`Error::Plan`] where the plan has none.
    pub fn find(&self, name: &str) -> Result<BufferId> {
        self.find_in("", name)
    }

    /// The buffer of that name: of `scope`, else of none.
    ///
    /// # Errors
    /// [`Error::Plan`] where the plan has none.
    pub fn find_in(&self, scope: &str, name: &str) -> Result<BufferId> {
        let missing = || Error::Plan { pass: scoped(scope, name), reason: "is no buffer of the plan".into() };
        self.plan.find_in(scope, name).ok_or_else(missing)
    }

    /// Runs the plan on zeros, and gives what is resident back what it held.
    fn warm_up(&mut self) -> Result<()> {
        let kept: Vec<_> = self.residents().cloned().collect();
        let copies: Vec<_> = kept.iter().map(|buffer| self.copy_of(buffer)).collect();
        for _ in 0..FRAMES_IN_FLIGHT {
            self.begin()?.submit()?;
        }
        while self.receive()?.is_some() {}
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        for (buffer, copy) in kept.iter().zip(&copies) {
            encoder.copy_buffer_to_buffer(copy, 0, buffer, 0, Some(buffer.size()));
        }
        self.context.queue.submit([encoder.finish()]);
        self.context.check("warming up")
    }

    fn residents(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        let arenas = self.layout.arenas.iter().zip(&self.memory.buffers);
        arenas.filter(|(arena, _)| arena.kind == Kind::Resident).map(|(_, buffer)| buffer)
    }

    fn copy_of(&self, buffer: &wgpu::Buffer) -> wgpu::Buffer {
        let copy = self.context.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("kept while warming up"),
            size: buffer.size(),
            usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, Some(buffer.size()));
        self.context.queue.submit([encoder.finish()]);
        copy
    }

    /// Sets every resident buffer of the plan back to zero.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn reset(&mut self) -> Result<()> {
        let mut encoder = self.context.device.create_command_encoder(&Default::default());
        for buffer in self.residents() {
            encoder.clear_buffer(buffer, 0, None);
        }
        self.context.queue.submit([encoder.finish()]);
        self.context.check("clearing the map")
    }

    /// Replaces the content of a fixed buffer of `scope`, else of none, from the next frame on.
    ///
    /// # Errors
    /// [`Error::Plan`] where the buffer is not fixed or the size differs.
    pub fn rewrite_fixed(&self, scope: &str, name: &str, data: &[u8]) -> Result<()> {
        let id = self.find_in(scope, name)?;
        let buffer = &self.plan.buffers()[id.0];
        if !matches!(buffer.role, Role::Fixed(_)) || buffer.bytes != data.len().next_multiple_of(4) as u64 {
            let reason = format!("{} bytes do not fit a fixed buffer of {}", data.len(), buffer.bytes);
            return Err(Error::Plan { pass: buffer.name.clone(), reason });
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
        if !slot.mapped()? {
            // The submission that used the slot is over, as fewer than all are in flight; its mapping may not be.
            self.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(TIMEOUT) })?;
        }
        if !slot.wait_mapped(TIMEOUT)? {
            let reason = "staging did not come free".into();
            return Err(Error::Gpu { what: "starting a frame".into(), reason });
        }
        let view = slot.buffer.slice(..).get_mapped_range_mut();
        let view = view.map_err(|e| Error::Gpu { what: "staging".into(), reason: e.to_string() })?;
        Ok(FrameInput { executor: self, view, scope: String::new() })
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
        for landing in &self.landings_now {
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

    /// Waits for the oldest frame under way, at most a minute; `None` when there is none.
    ///
    /// # Errors
    /// [`Error::Gpu`] where it does not end in time: that frame is given up, and frames submitted later can still be
    /// received; [`Error::DeviceLost`].
    pub fn receive(&mut self) -> Result<Option<Readback>> {
        let Some(InFlight { slot, index, landings }) = self.in_flight.pop_front() else { return Ok(None) };
        self.poll(wgpu::PollType::Wait { submission_index: Some(index), timeout: Some(TIMEOUT) })?;
        // Another thread's poll may be the one that hears of the mapping.
        if !self.landing[slot].wait_mapped(TIMEOUT)? {
            return Err(Error::Gpu { what: "readback".into(), reason: "not mapped after its frame".into() });
        }
        self.read(slot, landings).map(Some)
    }

    /// The oldest frame under way if it has ended; never waits.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn try_receive(&mut self) -> Result<Option<Readback>> {
        let Some(front) = self.in_flight.front() else { return Ok(None) };
        self.poll(wgpu::PollType::Poll)?;
        if !self.landing[front.slot].mapped()? {
            return Ok(None);
        }
        let Some(InFlight { slot, landings, .. }) = self.in_flight.pop_front() else { return Ok(None) };
        self.read(slot, landings).map(Some)
    }

    /// What landed in a slot.
    fn read(&self, slot: usize, landings: Vec<Landing>) -> Result<Readback> {
        let view = self.landing[slot].buffer.slice(..).get_mapped_range();
        let view = view.map_err(|e| Error::Gpu { what: "readback".into(), reason: e.to_string() })?;
        let mut readback = Readback::of(&view, landings);
        drop(view);
        self.landing[slot].buffer.unmap();
        if let Some(timing) = &self.timing {
            let spans = timing.spans(readback.bytes(self.timing_id())?);
            readback.spans = self.dispatches.iter().map(|d| Arc::clone(&d.name)).zip(spans).collect();
        }
        Ok(readback)
    }

    fn timing_id(&self) -> BufferId {
        BufferId(self.plan.buffers().len())
    }

    /// Encodes and submits the frame whose inputs are written.
    pub(crate) fn launch(&mut self) -> Result<()> {
        let slot = self.next_slot;
        // What wgpu refuses here is this frame's error, and not that of another user of the device.
        let scope = self.context.device.push_error_scope(wgpu::ErrorFilter::Validation);
        self.staging[slot].buffer.unmap();
        let commands = self.encode(slot);
        for dispatch in &mut self.dispatches {
            dispatch.workgroups = dispatch.planned;
        }
        self.texture_uploads.iter_mut().for_each(TextureUpload::reset);
        let index = self.context.queue.submit([commands]);
        self.staging[slot].request_map();
        self.landing[slot].request_map();
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(Error::Gpu { what: "submitting a frame".into(), reason: error.to_string() });
        }
        self.next_slot = (slot + 1) % FRAMES_IN_FLIGHT;
        let landings = std::mem::replace(&mut self.landings_now, self.landings.clone());
        self.in_flight.push_back(InFlight { slot, index, landings });
        self.context.check("submitting a frame")
    }
}
