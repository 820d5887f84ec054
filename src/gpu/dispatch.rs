//! Allocations and compiled passes of a plan.

use crate::error::{Error, Result};
use crate::gpu::arena::{Arena, Kind, Layout};
use crate::gpu::cache::PipelineStore;
use crate::gpu::context::Context;
use crate::gpu::plan::{Plan, Step};

/// A compiled pass with its buffers.
pub(crate) struct Dispatch {
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) bind_group: wgpu::BindGroup,
    /// As the plan has it: the most a frame may ask for.
    pub(crate) planned: [u32; 3],
    /// For the frame being written.
    pub(crate) workgroups: [u32; 3],
    pub(crate) workgroup_size: [u32; 3],
    pub(crate) name: &'static str,
}

impl Dispatch {
    pub(crate) fn encode(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        let [x, y, z] = self.workgroups;
        pass.dispatch_workgroups(x, y, z);
    }
}

/// The buffers that back the arenas.
pub(crate) fn allocate(context: &Context, layout: &Layout) -> Vec<wgpu::Buffer> {
    use wgpu::BufferUsages as U;
    let buffer = |arena: &Arena| {
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

/// Compiles the pass of `step` and binds its buffers.
///
/// # Errors
/// [`Error::Gpu`] that names the pass.
pub(crate) fn compile(
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
