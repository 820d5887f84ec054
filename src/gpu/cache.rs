//! The pipeline cache on disk, for drivers that keep none of their own.

use std::path::PathBuf;

/// A pipeline cache with the file it is kept in; empty where the driver offers none.
#[derive(Debug)]
pub(crate) struct PipelineStore {
    cache: Option<wgpu::PipelineCache>,
    file: Option<PathBuf>,
}

impl PipelineStore {
    /// Reads `$XDG_CACHE_HOME/limpid/<adapter key>` (or `~/.cache/...`) where it exists.
    pub(crate) fn open(device: &wgpu::Device, info: &wgpu::AdapterInfo) -> Self {
        if !device.features().contains(wgpu::Features::PIPELINE_CACHE) {
            return Self { cache: None, file: None };
        }
        let file = wgpu::util::pipeline_cache_key(info).and_then(|key| Some(cache_dir()?.join(key)));
        let data = file.as_ref().and_then(|path| std::fs::read(path).ok());
        let descriptor =
            wgpu::PipelineCacheDescriptor { label: Some("limpid"), data: data.as_deref(), fallback: true };
        #[expect(
            unsafe_code,
            reason = "wgpu checks the header; only files this type wrote for this adapter are read"
        )]
        // SAFETY: the data comes from `get_data` of the same adapter key, written by `save` below.
        let cache = unsafe { device.create_pipeline_cache(&descriptor) };
        Self { cache: Some(cache), file }
    }

    pub(crate) fn cache(&self) -> Option<&wgpu::PipelineCache> {
        self.cache.as_ref()
    }

    /// Writes the cache beside its place and moves it there. A cache that cannot be kept costs only time,
    /// so failure is not an error.
    pub(crate) fn save(&self) {
        let (Some(cache), Some(file)) = (&self.cache, &self.file) else { return };
        let (Some(data), Some(dir)) = (cache.get_data(), file.parent()) else { return };
        let fresh = file.with_extension(std::process::id().to_string());
        let written = std::fs::create_dir_all(dir)
            .and_then(|()| std::fs::write(&fresh, data))
            .and_then(|()| std::fs::rename(&fresh, file));
        if written.is_err() {
            let _ = std::fs::remove_file(&fresh);
        }
    }
}

fn cache_dir() -> Option<PathBuf> {
    let base = std::env::var_os("XDG_CACHE_HOME").filter(|dir| !dir.is_empty()).map(PathBuf::from);
    let home = || Some(PathBuf::from(std::env::var_os("HOME")?).join(".cache"));
    Some(base.or_else(home)?.join("limpid"))
}
