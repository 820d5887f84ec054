//! Allocations and compiled passes of a plan.

use std::sync::Arc;

use crate::base::{Error, Result};
use crate::gpu::arena::{Arena, Kind, Layout};
use crate::gpu::context::Context;
use crate::gpu::plan::{BufferDecl, Extent, Plan, Step};
use crate::gpu::store::Store;

/// A compiled pass with its buffers.
pub(crate) struct Dispatch {
    pub(crate) pipeline: wgpu::ComputePipeline,
    pub(crate) bind_group: wgpu::BindGroup,
    /// As the plan has it: the most a frame may ask for.
    pub(crate) planned: [u32; 3],
    /// For the frame being written.
    pub(crate) workgroups: [u32; 3],
    pub(crate) workgroup_size: [u32; 3],
    /// Scope in which the step was appended.
    pub(crate) scope: Arc<str>,
    pub(crate) name: Arc<str>,
}

impl Dispatch {
    pub(crate) fn encode(&self, pass: &mut wgpu::ComputePass<'_>) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        let [x, y, z] = self.workgroups;
        pass.dispatch_workgroups(x, y, z);
    }
}

/// The memory of a plan: buffers that back its arenas, and its textures.
pub(crate) struct Memory {
    pub(crate) buffers: Vec<wgpu::Buffer>,
    /// Counted as the plan's buffers; `None` where that is no texture.
    pub(crate) textures: Vec<Option<wgpu::Texture>>,
}

/// Allocates all of it but the resident buffers, which are the store's.
///
/// # Errors
/// [`Error::Plan`] where the store has a resident buffer of another size.
pub(crate) fn allocate(store: &Store, plan: &Plan, layout: &Layout) -> Result<Memory> {
    let texture = |decl: &BufferDecl| Some(allocate_texture(store.context(), decl, decl.texture?));
    let buffer = |arena: &Arena| match arena.resident() {
        Some(id) => store.resident(&plan.buffers()[id.0].name, arena.bytes),
        None => Ok(allocate_arena(store.context(), arena)),
    };
    Ok(Memory {
        buffers: layout.arenas.iter().map(buffer).collect::<Result<_>>()?,
        textures: plan.buffers().iter().map(texture).collect(),
    })
}

fn allocate_arena(context: &Context, arena: &Arena) -> wgpu::Buffer {
    use wgpu::BufferUsages as U;
    let (label, uniform) = match arena.kind {
        Kind::Host => ("host", U::UNIFORM),
        Kind::Fixed => ("fixed", U::empty()),
        Kind::Resident => ("resident", U::empty()),
        Kind::Scratch => ("scratch", U::empty()),
    };
    context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: arena.bytes,
        usage: U::STORAGE | U::COPY_DST | U::COPY_SRC | uniform,
        mapped_at_creation: false,
    })
}

fn allocate_texture(context: &Context, decl: &BufferDecl, extent: Extent) -> wgpu::Texture {
    use wgpu::TextureFormat as F;
    context.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&decl.name),
        size: size_of_texture(extent),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: if decl.whole { F::Rgba32Uint } else { F::Rgba32Float },
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// In wgpu's terms.
pub(crate) fn size_of_texture(extent: Extent) -> wgpu::Extent3d {
    let Extent { width, height, layers } = extent;
    wgpu::Extent3d { width, height, depth_or_array_layers: layers }
}

/// Binds the buffers of `step` to its program.
///
/// # Errors
/// [`Error::Gpu`] that names the pass.
pub(crate) fn bind(
    context: &Context,
    step: &Step,
    pipeline: wgpu::ComputePipeline,
    plan: &Plan,
    layout: &Layout,
    memory: &Memory,
) -> Result<Dispatch> {
    let device = &context.device;
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let views: Vec<_> = step.uses().map(|(_, id)| memory.textures[id.0].as_ref().map(view)).collect();
    let entries: Vec<_> = step
        .uses()
        .zip(&views)
        .map(|((binding, id), view)| {
            let place = layout.places[id.0];
            let resource = match view {
                Some(view) => wgpu::BindingResource::TextureView(view),
                None => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &memory.buffers[place.arena],
                    offset: place.offset,
                    size: std::num::NonZeroU64::new(plan.buffers()[id.0].bytes),
                }),
            };
            wgpu::BindGroupEntry { binding: binding.slot, resource }
        })
        .collect();
    let bind_layout = pipeline.get_bind_group_layout(0);
    let label = Some(step.shader.name.as_str());
    let descriptor = wgpu::BindGroupDescriptor { label, layout: &bind_layout, entries: &entries };
    let bind_group = device.create_bind_group(&descriptor);
    match pollster::block_on(scope.pop()) {
        Some(error) => Err(Error::Gpu { what: step.shader.name.clone(), reason: error.to_string() }),
        None => Ok(Dispatch {
            pipeline,
            bind_group,
            planned: step.workgroups,
            workgroups: step.workgroups,
            workgroup_size: step.shader.workgroup_size,
            scope: step.scope.as_str().into(),
            name: step.shader.name.as_str().into(),
        }),
    }
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}
