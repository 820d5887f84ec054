//! Adapter and device: which GPU, why, and whether it offers what a plan needs.

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{Adapter, AdapterInfo, DeviceType, Features, Limits};

use crate::error::{Error, Result};

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

/// An adapter chosen to run on, not opened yet.
#[derive(Debug)]
pub struct Chosen {
    adapter: Adapter,
    info: AdapterInfo,
    reason: String,
}

/// Subgroups are used where they hold at least this many invocations.
const SUBGROUP_LANES: u32 = 8;

impl Chosen {
    /// The adapter of that name (part of its name or driver; else `LIMPID_ADAPTER`, else the best: real
    /// GPUs before software).
    ///
    /// # Errors
    /// [`Error::NoAdapter`].
    pub fn find(name: Option<&str>) -> Result<Self> {
        let mut adapters = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::VULKAN));
        let (chosen, reason) = choose(&adapters, wanted_name(name).as_deref())?;
        let adapter = adapters.swap_remove(chosen);
        Ok(Self { info: adapter.get_info(), adapter, reason })
    }

    /// Whether the CPU runs it.
    pub fn is_software(&self) -> bool {
        self.info.device_type == DeviceType::Cpu
    }

    /// Whether passes may exchange values across subgroups of at least eight invocations.
    pub fn has_subgroups(&self) -> bool {
        self.adapter.features().contains(Features::SUBGROUP) && self.info.subgroup_min_size >= SUBGROUP_LANES
    }

    /// Opens it: checks that it offers what `needs` asks for, and takes no features but the pipeline cache,
    /// subgroups where they are needed and, for `profiling`, timestamps. Buffer limits are those of the
    /// adapter, up to 1 GiB.
    ///
    /// # Errors
    /// [`Error::Limit`] where the adapter offers too little, [`Error::Gpu`] where the driver refuses a device.
    pub fn open(self, needs: &Requirements, profiling: bool) -> Result<Context> {
        let Self { adapter, info, reason } = self;
        let limits = needs.limits(&info.name, &adapter.limits())?;
        let mut features = adapter.features() & Features::PIPELINE_CACHE;
        if profiling {
            features |= adapter.features() & Features::TIMESTAMP_QUERY;
        }
        if needs.subgroups {
            features |= Features::SUBGROUP;
        }
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("limpid"),
            required_features: features,
            required_limits: limits,
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| Error::Gpu { what: format!("opening {}", info.name), reason: e.to_string() })?;
        let context = Context { device, queue, info, reason, trouble: Arc::default() };
        context.listen();
        Ok(context)
    }
}

impl Context {
    /// Finds an adapter as [`Chosen::find`] and opens it as [`Chosen::open`].
    ///
    /// # Errors
    /// [`Error::NoAdapter`], [`Error::Limit`], [`Error::Gpu`].
    pub fn open(name: Option<&str>, needs: &Requirements, profiling: bool) -> Result<Self> {
        Chosen::find(name)?.open(needs, profiling)
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
    /// What to ask of a device of the adapter of that name: what is needed, and more of what it offers where that is usual.
    ///
    /// # Errors
    /// [`Error::Limit`] where the adapter offers too little.
    pub fn limits(&self, adapter: &str, offered: &Limits) -> Result<Limits> {
        self.check(adapter, offered)?;
        let mut limits = Limits::downlevel_defaults();
        let bytes = |offered: u64, needed: u64| offered.min(1 << 30).max(needed);
        limits.max_storage_buffer_binding_size =
            bytes(offered.max_storage_buffer_binding_size, self.largest_buffer_bytes);
        limits.max_buffer_size =
            bytes(offered.max_buffer_size, self.upload_bytes.max(self.largest_buffer_bytes));
        let count = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        limits.max_storage_buffers_per_shader_stage =
            offered.max_storage_buffers_per_shader_stage.min(8).max(count(self.storage_buffers));
        limits.max_storage_textures_per_shader_stage =
            limits.max_storage_textures_per_shader_stage.max(count(self.storage_textures));
        limits.max_texture_dimension_2d = limits.max_texture_dimension_2d.max(self.texture_side);
        limits.max_texture_array_layers = limits.max_texture_array_layers.max(self.texture_layers);
        limits.max_compute_invocations_per_workgroup =
            offered.max_compute_invocations_per_workgroup.min(256).max(self.invocations);
        limits.max_compute_workgroups_per_dimension =
            limits.max_compute_workgroups_per_dimension.max(self.workgroups);
        Ok(limits)
    }

    fn check(&self, adapter: &str, offered: &Limits) -> Result<()> {
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
        )?;
        Ok(())
    }
}
