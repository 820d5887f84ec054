//! `limpid info`.

mod recording;

use std::path::PathBuf;

use clap::Args;
use limpid::Result;
use limpid::gpu::{AdapterReport, adapters};

#[derive(Debug, Args)]
pub(crate) struct InfoArguments {
    /// Recording to look into: its topics, rates and frames, what would be used, and what is missing; nothing is run
    recording: Option<PathBuf>,
    /// Parameters in YAML that the recording would be run with
    #[arg(short, long, value_name = "FILE", requires = "recording")]
    config: Option<PathBuf>,
    /// Print what is known of the recording as JSON
    #[arg(long, requires = "recording")]
    json: bool,
    /// Mark the adapter whose name or driver contains this
    #[arg(long, value_name = "NAME", conflicts_with = "recording")]
    adapter: Option<String>,
}

pub(crate) fn execute(arguments: &InfoArguments) -> Result<()> {
    if let Some(path) = &arguments.recording {
        return recording::execute(path, arguments.config.as_deref(), arguments.json);
    }
    println!("limpid {}", env!("CARGO_PKG_VERSION"));
    for report in adapters(arguments.adapter.as_deref())? {
        print_adapter(&report);
    }
    Ok(())
}

fn print_adapter(report: &AdapterReport) {
    let AdapterReport { info, features, limits, chosen } = report;
    let mark = if chosen.is_some() { "*" } else { " " };
    println!("{mark} {} ({:?}, {:?})", info.name, info.device_type, info.backend);
    if let Some(reason) = chosen {
        println!("    used: {reason}");
    }
    println!("    driver: {} {}", info.driver, info.driver_info);
    let yes = |feature| if features.contains(feature) { "yes" } else { "no" };
    println!(
        "    timestamps (for bench and profile): {}, pipeline cache: {}",
        yes(wgpu::Features::TIMESTAMP_QUERY),
        yes(wgpu::Features::PIPELINE_CACHE)
    );
    println!(
        "    largest buffer binding: {} MiB, storage buffers a pass: {}, invocations a workgroup: {}",
        limits.max_storage_buffer_binding_size >> 20,
        limits.max_storage_buffers_per_shader_stage,
        limits.max_compute_invocations_per_workgroup
    );
}
