//! Runs a plan: everything is built once; a frame is one copy in, the passes, one copy out, one submit.

use std::collections::VecDeque;
use std::time::Duration;

use bytemuck::bytes_of;

use crate::error::{Error, Result};
use crate::gpu::arena::{Kind, Layout, Place};
use crate::gpu::cache::PipelineStore;
use crate::gpu::context::Context;
use crate::gpu::plan::{BufferId, Invocations, Plan, Role, Step};
use crate::gpu::ring::Slot;
use crate::gpu::shader::Params;
use crate::gpu::timing::{PassSpan, Timing};

/// Frames that may be under way at once, so that upload, compute and readback overlap.
pub const FRAMES_IN_FLIGHT: usize = 3;

/// How long a frame may take before it counts as hung.
const TIMEOUT: Duration = Duration::from_secs(60);

struct Dispatch {
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
    /// As the plan has it: the most a frame may ask for.
    planned: [u32; 3],
    /// For the frame being written.
    workgroups: [u32; 3],
    workgroup_size: [u32; 3],
    name: &'static str,
}

/// A range of a readback slot.
#[derive(Debug, Clone, Copy)]
struct Landing {
    id: BufferId,
    offset: u64,
    bytes: u64,
}

struct InFlight {
    slot: usize,
    index: wgpu::SubmissionIndex,
}

/// A built plan.
pub struct Executor {
    context: Context,
    plan: Plan,
    layout: Layout,
    allocations: Vec<wgpu::Buffer>,
    dispatches: Vec<Dispatch>,
    staging: Vec<Slot>,
    landing: Vec<Slot>,
    landings: Vec<Landing>,
    timing: Option<Timing>,
    host_arena: Option<usize>,
    next_slot: usize,
    in_flight: VecDeque<InFlight>,
}

/// What came back from one frame.
#[derive(Debug, Clone)]
pub struct Readback {
    data: Vec<u8>,
    landings: Vec<Landing>,
    /// Name and time span of each pass, when the device was opened for profiling.
    pub spans: Vec<(&'static str, PassSpan)>,
}

impl Readback {
    /// The bytes of a buffer that the plan reads back.
    ///
    /// # Errors
    /// [`Error::Gpu`] where the plan does not read it back.
    pub fn bytes(&self, id: BufferId) -> Result<&[u8]> {
        let range = self.landings.iter().find(|landing| landing.id == id).and_then(|landing| {
            let start = usize::try_from(landing.offset).ok()?;
            self.data.get(start..start + usize::try_from(landing.bytes).ok()?)
        });
        range.ok_or_else(|| Error::Gpu { what: "readback".into(), reason: "buffer was not read back".into() })
    }
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
        let allocations = allocate(context, &layout);
        let store = PipelineStore::open(context);
        let dispatches = plan
            .steps()
            .iter()
            .map(|step| compile(context, step, &plan, &layout, &allocations, &store))
            .collect::<Result<Vec<_>>>()?;
        let timing = Timing::new(context, u32::try_from(dispatches.len()).unwrap_or(0));
        let (landings, landing_bytes) = landings(&plan, timing.as_ref());
        let host_arena = layout.arenas.iter().position(|a| a.kind == Kind::Host);
        let host_bytes = host_arena.map_or(4, |a| layout.arenas[a].bytes);
        let mut executor = Self {
            staging: (0..FRAMES_IN_FLIGHT).map(|_| Slot::staging(context, host_bytes)).collect(),
            landing: (0..FRAMES_IN_FLIGHT).map(|_| Slot::landing(context, landing_bytes)).collect(),
            context: context.clone(),
            plan,
            layout,
            allocations,
            dispatches,
            landings,
            timing,
            host_arena,
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
        for (arena, buffer) in self.layout.arenas.iter().zip(&self.allocations) {
            if arena.kind == Kind::State {
                encoder.clear_buffer(buffer, 0, None);
            }
        }
        self.context.queue.submit([encoder.finish()]);
        self.context.check("clearing the map")
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
        let mut padded = data.to_vec();
        padded.resize(data.len().next_multiple_of(4), 0);
        let Place { arena, offset } = self.layout.places[id.0];
        self.context.queue.write_buffer(&self.allocations[arena], offset, &padded);
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
            encoder.copy_buffer_to_buffer(&self.staging[slot].buffer, 0, &self.allocations[host], 0, None);
        }
        match &self.timing {
            None => self.encode_together(&mut encoder),
            Some(timing) => self.encode_timed(&mut encoder, timing),
        }
        for landing in &self.landings {
            let (source, offset) = match (&self.timing, self.plan.buffers().get(landing.id.0)) {
                (_, Some(_)) => {
                    let place = self.layout.places[landing.id.0];
                    (&self.allocations[place.arena], place.offset)
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
            let descriptor = wgpu::ComputePassDescriptor { label: Some(dispatch.name), timestamp_writes };
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
            readback.spans = self.dispatches.iter().map(|d| d.name).zip(spans).collect();
        }
        Ok(Some(readback))
    }

    fn timing_id(&self) -> BufferId {
        BufferId(self.plan.buffers().len())
    }
}

/// The inputs of one frame, written straight into a staging buffer.
pub struct FrameInput<'a> {
    executor: &'a mut Executor,
    view: wgpu::BufferViewMut,
}

impl FrameInput<'_> {
    /// Writes parameters.
    ///
    /// # Errors
    /// [`Error::Input`] where the buffer is not a uniform of that size.
    pub fn set<P: Params>(&mut self, name: &str, params: &P) -> Result<()> {
        self.write(name, bytes_of(params))
    }

    /// Writes the first `data.len()` bytes of an upload buffer.
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
        let start = usize::try_from(self.executor.layout.places[id.0].offset).unwrap_or(usize::MAX);
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
        let dispatch = self.executor.dispatches.iter_mut().find(|dispatch| dispatch.name == pass);
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
        let slot = executor.next_slot;
        executor.staging[slot].buffer.unmap();
        let commands = executor.encode(slot);
        for dispatch in &mut executor.dispatches {
            dispatch.workgroups = dispatch.planned;
        }
        let index = executor.context.queue.submit([commands]);
        executor.staging[slot].request_map();
        executor.landing[slot].request_map();
        executor.next_slot = (slot + 1) % FRAMES_IN_FLIGHT;
        executor.in_flight.push_back(InFlight { slot, index });
        executor.context.check("submitting a frame")
    }
}

impl Dispatch {
    fn encode(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        let [x, y, z] = self.workgroups;
        pass.dispatch_workgroups(x, y, z);
    }
}

fn allocate(context: &Context, layout: &Layout) -> Vec<wgpu::Buffer> {
    use wgpu::BufferUsages as U;
    let buffer = |arena: &crate::gpu::arena::Arena| {
        let usage = match arena.kind {
            Kind::Host => U::UNIFORM | U::STORAGE | U::COPY_DST | U::COPY_SRC,
            Kind::Fixed => U::STORAGE | U::COPY_DST | U::COPY_SRC,
            Kind::State | Kind::Scratch => U::STORAGE | U::COPY_DST | U::COPY_SRC,
        };
        let descriptor = wgpu::BufferDescriptor {
            label: Some(match arena.kind {
                Kind::Host => "host",
                Kind::Fixed => "fixed",
                Kind::State => "state",
                Kind::Scratch => "scratch",
            }),
            size: arena.bytes,
            usage,
            mapped_at_creation: false,
        };
        context.device.create_buffer(&descriptor)
    };
    layout.arenas.iter().map(buffer).collect()
}

fn compile(
    context: &Context,
    step: &Step,
    plan: &Plan,
    layout: &Layout,
    allocations: &[wgpu::Buffer],
    store: &PipelineStore,
) -> Result<Dispatch> {
    let device = &context.device;
    let label = Some(step.shader.name);
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Wgsl(step.shader.source.as_str().into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label,
        layout: None,
        module: &module,
        entry_point: Some(&step.shader.entry_point),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &step.constants,
            zero_initialize_workgroup_memory: false,
        },
        cache: store.cache(),
    });
    let entries: Vec<_> = step
        .uses()
        .map(|(binding, id)| {
            let place = layout.places[id.0];
            let resource = wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &allocations[place.arena],
                offset: place.offset,
                size: std::num::NonZeroU64::new(plan.buffers()[id.0].bytes),
            });
            wgpu::BindGroupEntry { binding: binding.slot, resource }
        })
        .collect();
    let bind_layout = pipeline.get_bind_group_layout(0);
    let descriptor = wgpu::BindGroupDescriptor { label, layout: &bind_layout, entries: &entries };
    let bind_group = device.create_bind_group(&descriptor);
    match pollster::block_on(scope.pop()) {
        Some(error) => Err(Error::Gpu { what: step.shader.name.into(), reason: error.to_string() }),
        None => Ok(Dispatch {
            pipeline,
            bind_group,
            planned: step.workgroups,
            workgroups: step.workgroups,
            workgroup_size: step.shader.workgroup_size,
            name: step.shader.name,
        }),
    }
}

/// Where each buffer that is read back lands, the pass times last, and the bytes of all.
fn landings(plan: &Plan, timing: Option<&Timing>) -> (Vec<Landing>, u64) {
    let mut offset = 0;
    let mut list = Vec::new();
    let read_back = plan.buffers().iter().enumerate().filter(|(_, buffer)| buffer.read_back);
    let times = timing.map(|t| (plan.buffers().len(), t.resolved.size()));
    for (index, bytes) in read_back.map(|(index, buffer)| (index, buffer.bytes)).chain(times) {
        list.push(Landing { id: BufferId(index), offset, bytes });
        offset = (offset + bytes).next_multiple_of(16);
    }
    (list, offset)
}
