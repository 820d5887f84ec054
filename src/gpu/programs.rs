//! Compiled passes of a device: each text is compiled once, whatever plans use it, several at a time.

use std::collections::{HashMap, HashSet};
use std::sync::{Mutex, PoisonError};

use crate::base::{Error, Result};
use crate::gpu::cache::PipelineStore;
use crate::gpu::plan::Step;
use crate::gpu::shader::Shader;

/// What distinguishes one program from another: its WGSL, and its constants by their bits.
type Key = (String, Vec<(&'static str, u64)>);

fn key_of(step: &Step) -> Key {
    let constants = step.constants.iter().map(|&(name, value)| (name, value.to_bits()));
    (step.shader.source.clone(), constants.collect())
}

/// See the module.
#[derive(Debug)]
pub(crate) struct Programs {
    cache: PipelineStore,
    compiled: Mutex<HashMap<Key, wgpu::ComputePipeline>>,
}

impl Programs {
    pub(crate) fn new(cache: PipelineStore) -> Self {
        Self { cache, compiled: Mutex::default() }
    }

    /// The programs of `steps`, in their order. Those that are new are compiled on as many threads as the machine has cores.
    ///
    /// # Errors
    /// [`Error::Gpu`] that names the pass.
    pub(crate) fn of(&self, device: &wgpu::Device, steps: &[Step]) -> Result<Vec<wgpu::ComputePipeline>> {
        let missing = self.missing(steps);
        let threads = std::thread::available_parallelism().map_or(1, usize::from).min(missing.len());
        let next = std::sync::atomic::AtomicUsize::new(0);
        let work = || -> Result<()> {
            while let Some(step) = missing.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                let program = compile(device, step, self.cache.cache())?;
                self.compiled.lock().unwrap_or_else(PoisonError::into_inner).insert(key_of(step), program);
            }
            Ok(())
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            workers.into_iter().try_for_each(|worker| worker.join().unwrap_or_else(|_| Err(panicked())))
        })?;
        let compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let known = |step: &Step| compiled.get(&key_of(step)).cloned().ok_or_else(panicked);
        steps.iter().map(known).collect()
    }

    fn missing<'a>(&self, steps: &'a [Step]) -> Vec<&'a Step> {
        let compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let mut seen = HashSet::new();
        let new = |step: &&Step| !compiled.contains_key(&key_of(step)) && seen.insert(key_of(step));
        steps.iter().filter(new).collect()
    }

    /// Keeps the driver's cache on disk.
    pub(crate) fn save(&self) {
        self.cache.save();
    }
}

fn panicked() -> Error {
    Error::Gpu { what: "compiling".into(), reason: "a compiling thread did not end".into() }
}

fn compile(
    device: &wgpu::Device,
    step: &Step,
    cache: Option<&wgpu::PipelineCache>,
) -> Result<wgpu::ComputePipeline> {
    // Error scopes belong to the thread that opens them.
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = create_module(device, &step.shader);
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(step.shader.name.as_str()),
        layout: None,
        module: &module,
        entry_point: Some(&step.shader.entry_point),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &step.constants,
            zero_initialize_workgroup_memory: false,
        },
        cache,
    });
    match pollster::block_on(scope.pop()) {
        Some(error) => Err(Error::Gpu { what: step.shader.name.clone(), reason: error.to_string() }),
        None => Ok(pipeline),
    }
}

#[expect(
    unsafe_code,
    reason = "only wgpu's guard of loops is left out, and only where all are proven to end"
)]
fn create_module(device: &wgpu::Device, shader: &Shader) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(shader.source.as_str().into());
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(&shader.name), source };
    if !shader.counted_loops {
        return device.create_shader_module(descriptor);
    }
    let mut checks = wgpu::ShaderRuntimeChecks::checked();
    checks.force_loop_bounding = false;
    // SAFETY: all other checks stay on, and `gpu::loops` has proven that every loop ends.
    unsafe { device.create_shader_module_trusted(descriptor, checks) }
}
