//! Adapter and device: which GPU, why, and whether it offers what a plan needs.

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{Adapter, AdapterInfo, DeviceType, Features, Limits};

use crate::base::{Error, Result};
use crate::gpu::cache::PipelineStore;
use crate::gpu::programs::Programs;

/// What a device must offer to run a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Requirements {
    /// Size of the largest buffer bound to a pass.
    pub largest_buffer_bytes: u64,
    /// Bytes uploaded per frame.
    pub upload_bytes: u64,
    /// Storage buffers of the pass that binds most.
    pub storage_buffers: usize,
    /// Storage textures of the pass that binds most.
    pub storage_textures: usize,
    /// Texels along the longest side of a texture.
    pub texture_side: u32,
    /// Layers of the deepest texture.
    pub texture_layers: u32,
    /// Whether a pass uses subgroup operations.
    pub subgroups: bool,
    /// Invocations of the largest workgroup.
    pub invocations: u32,
    /// Workgroups of the longest dispatch along one axis.
    pub workgroups: u32,
}

/// An adapter as `limpid info` lists it.
#[derive(Debug, Clone)]
pub struct AdapterReport {
    /// wgpu's description.
    pub info: AdapterInfo,
    /// Features that limpid can use.
    pub features: Features,
    /// Its limits.
    pub limits: Limits,
    /// Set for the adapter that would be used: the reason.
    pub chosen: Option<String>,
}

/// What went wrong on the device outside of any call's own result.
#[derive(Debug, Default)]
struct Trouble {
    lost: Option<String>,
    first_error: Option<String>,
}

/// An open device. Cheap to clone; clones share the device.
#[derive(Debug, Clone)]
pub struct Context {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    info: AdapterInfo,
    reason: String,
    trouble: Arc<Mutex<Trouble>>,
    pub(crate) programs: Arc<Programs>,
}

fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN;
    wgpu::Instance::new(descriptor)
}

/// Real GPUs first, software last.
fn rank(info: &AdapterInfo) -> u8 {
    match info.device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

fn describe(info: &AdapterInfo) -> String {
    format!("{} ({} {})", info.name, info.driver, info.driver_info).replace("( ", "(").replace(" )", ")")
}

/// The adapter of that name (part of its name or driver, any case), else the best, with the reason.
fn choose(adapters: &[Adapter], wanted: Option<&str>) -> Result<(usize, String)> {
    let infos: Vec<_> = adapters.iter().map(Adapter::get_info).collect();
    let found = if infos.is_empty() {
        "none".into()
    } else {
        infos.iter().map(describe).collect::<Vec<_>>().join("; ")
    };
    if let Some(name) = wanted.filter(|name| !name.is_empty()) {
        let matches = |info: &AdapterInfo| describe(info).to_lowercase().contains(&name.to_lowercase());
        return match infos.iter().position(matches) {
            Some(index) => Ok((index, format!("its name contains `{name}`, as asked"))),
            None => Err(Error::NoAdapter { wanted: format!(" named `{name}`"), found }),
        };
    }
    let best = infos.iter().enumerate().min_by_key(|(index, info)| (rank(info), *index));
    let (index, info) = best.ok_or(Error::NoAdapter { wanted: String::new(), found })?;
    let reason = match info.device_type {
        DeviceType::Cpu => "no GPU was found, so the software driver runs it".into(),
        kind if infos.len() == 1 => format!("the only adapter ({kind:?})"),
        kind => format!("best of {} adapters ({kind:?})", infos.len()),
    };
    Ok((index, reason))
}

/// The name asked for by argument, else by `LIMPID_ADAPTER`.
fn wanted_name(argument: Option<&str>) -> Option<String> {
    argument.map(str::to_owned).or_else(|| std::env::var("LIMPID_ADAPTER").ok())
}

/// Every adapter that wgpu reaches, the one that would be used marked.
///
/// # Errors
/// [`Error::NoAdapter`] where there is none, or none of the name asked for.
pub fn adapters(name: Option<&str>) -> Result<Vec<AdapterReport>> {
    let adapters = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::VULKAN));
    let (chosen, reason) = choose(&adapters, wanted_name(name).as_deref())?;
    let report = |(index, adapter): (usize, &Adapter)| AdapterReport {
        info: adapter.get_info(),
        features: adapter.features()
            & (Features::TIMESTAMP_QUERY | Features::PIPELINE_CACHE | Features::SUBGROUP),
        limits: adapter.limits(),
        chosen: (index == chosen).then(|| reason.clone()),
    };
    Ok(adapters.iter().enumerate().map(report).collect())
}

/// Subgroups are used where they hold at least this many invocations.
const SUBGROUP_LANES: u32 = 8;

/// Largest buffer that is asked for, bytes.
const MOST_BUFFER_BYTES: u64 = 1 << 30;

impl Context {
    /// Opens the adapter of that name (part of its name or driver; else `LIMPID_ADAPTER`, else the best: real GPUs before
    /// software) with the limits it offers, buffers of up to 1 GiB, and of its features the pipeline cache, subgroups and,
    /// for `profiling`, timestamps.
    ///
    /// # Errors
    /// [`Error::NoAdapter`], [`Error::Gpu`] where the driver refuses a device.
    pub fn open(name: Option<&str>, profiling: bool) -> Result<Self> {
        let mut adapters = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::VULKAN));
        let (chosen, reason) = choose(&adapters, wanted_name(name).as_deref())?;
        let adapter = adapters.swap_remove(chosen);
        let info = adapter.get_info();
        let mut features = Features::PIPELINE_CACHE | Features::SUBGROUP;
        if profiling {
            features |= Features::TIMESTAMP_QUERY;
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("limpid"),
            required_features: adapter.features() & features,
            required_limits: limits_of(&adapter.limits()),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| Error::Gpu { what: format!("opening {}", info.name), reason: e.to_string() })?;
        let programs = Arc::new(Programs::new(PipelineStore::open(&device, &info)));
        let context = Self { device, queue, info, reason, trouble: Arc::default(), programs };
        context.listen();
        Ok(context)
    }

    /// Whether the CPU runs it.
    pub fn is_software(&self) -> bool {
        self.info.device_type == DeviceType::Cpu
    }

    /// Whether passes may exchange values across subgroups of at least eight invocations.
    pub fn has_subgroups(&self) -> bool {
        self.device.features().contains(Features::SUBGROUP) && self.info.subgroup_min_size >= SUBGROUP_LANES
    }

    /// Refuses a plan that needs more than the device offers.
    ///
    /// # Errors
    /// [`Error::Limit`] that names the limit.
    pub(crate) fn check_limits(&self, needs: &Requirements) -> Result<()> {
        needs.check(&self.info.name, &self.device.limits())?;
        if needs.subgroups && !self.has_subgroups() {
            let mend = "use another adapter (`limpid info` lists them)";
            let adapter = self.info.name.clone();
            return Err(Error::Limit { adapter, limit: "subgroup size", available: 0, needed: 8, mend });
        }
        Ok(())
    }

    /// Keeps errors that wgpu reports outside of any call, so that the next call returns them.
    fn listen(&self) {
        let trouble = Arc::clone(&self.trouble);
        self.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let mut trouble = trouble.lock().unwrap_or_else(PoisonError::into_inner);
            trouble.first_error.get_or_insert_with(|| error.to_string());
        }));
        let trouble = Arc::clone(&self.trouble);
        self.device.set_device_lost_callback(move |reason, message| {
            let mut trouble = trouble.lock().unwrap_or_else(PoisonError::into_inner);
            trouble.lost.get_or_insert_with(|| format!("{reason:?}: {message}"));
        });
    }

    /// Name, driver and kind of the adapter.
    pub fn info(&self) -> &AdapterInfo {
        &self.info
    }

    /// Adapter and driver in one line, with why it was chosen.
    pub fn describe(&self) -> String {
        format!("{}: {}", describe(&self.info), self.reason)
    }

    /// wgpu's counters of objects and memory, to prove that frames allocate nothing.
    pub fn counters(&self) -> wgpu::InternalCounters {
        self.device.get_internal_counters()
    }

    /// Drops the device as a driver crash would: every later call gives [`Error::DeviceLost`].
    pub fn destroy(&self) {
        self.device.destroy();
    }

    /// The first error since the device was opened, if any; `what` says what was being done.
    pub(crate) fn check(&self, what: &str) -> Result<()> {
        let trouble = self.trouble.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(lost) = &trouble.lost {
            return Err(Error::DeviceLost(lost.clone()));
        }
        match &trouble.first_error {
            Some(error) => Err(Error::Gpu { what: what.into(), reason: error.clone() }),
            None => Ok(()),
        }
    }
}

impl Requirements {
    /// Whether the adapter of that name offers enough.
    ///
    /// # Errors
    /// [`Error::Limit`] that names the first limit that is too small.
    pub fn check(&self, adapter: &str, offered: &Limits) -> Result<()> {
        let smaller = "use a smaller image or map, or another adapter (`limpid info` lists them)";
        let check = |limit, available: u64, needed: u64| {
            if available >= needed {
                return Ok(());
            }
            Err(Error::Limit { adapter: adapter.into(), limit, available, needed, mend: smaller })
        };
        check(
            "max_storage_buffer_binding_size",
            offered.max_storage_buffer_binding_size,
            self.largest_buffer_bytes,
        )?;
        check("max_buffer_size", offered.max_buffer_size, self.upload_bytes)?;
        check(
            "max_storage_buffers_per_shader_stage",
            offered.max_storage_buffers_per_shader_stage.into(),
            self.storage_buffers as u64,
        )?;
        check(
            "max_storage_textures_per_shader_stage",
            offered.max_storage_textures_per_shader_stage.into(),
            self.storage_textures as u64,
        )?;
        check("max_texture_dimension_2d", offered.max_texture_dimension_2d.into(), self.texture_side.into())?;
        check(
            "max_texture_array_layers",
            offered.max_texture_array_layers.into(),
            self.texture_layers.into(),
        )?;
        check(
            "max_compute_invocations_per_workgroup",
            offered.max_compute_invocations_per_workgroup.into(),
            self.invocations.into(),
        )?;
        check(
            "max_compute_workgroups_per_dimension",
            offered.max_compute_workgroups_per_dimension.into(),
            self.workgroups.into(),
        )
    }
}

/// What is asked for of what an adapter offers.
fn limits_of(offered: &Limits) -> Limits {
    let defaults = Limits::downlevel_defaults();
    Limits {
        max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size.min(MOST_BUFFER_BYTES),
        max_buffer_size: offered.max_buffer_size.min(MOST_BUFFER_BYTES),
        max_storage_buffers_per_shader_stage: offered.max_storage_buffers_per_shader_stage,
        max_storage_textures_per_shader_stage: offered.max_storage_textures_per_shader_stage,
        max_texture_dimension_2d: offered.max_texture_dimension_2d,
        max_texture_array_layers: offered.max_texture_array_layers,
        max_compute_invocations_per_workgroup: offered.max_compute_invocations_per_workgroup,
        max_compute_workgroup_size_x: offered.max_compute_workgroup_size_x,
        max_compute_workgroup_size_y: offered.max_compute_workgroup_size_y,
        max_compute_workgroups_per_dimension: offered.max_compute_workgroups_per_dimension,
        ..defaults
    }
}
