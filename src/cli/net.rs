//! `limpid net`.

use std::path::PathBuf;

use clap::Args;
use limpid::weights::{NATIVE_SIZE, Network};
use limpid::{Error, Result};

#[derive(Debug, Args)]
pub(crate) struct NetArguments {
    /// DRM-Net's weights (safetensors)
    #[arg(long, value_name = "FILE")]
    weights: PathBuf,
}

pub(crate) fn execute(arguments: &NetArguments) -> Result<()> {
    let bytes = std::fs::read(&arguments.weights).map_err(Error::file(&arguments.weights))?;
    let network = Network::from_bytes(&bytes)?;
    println!("origin: {}\ndepth scale: {} m\n", network.origin, network.depth_scale_m);
    print!("{}", network.table(NATIVE_SIZE));
    Ok(())
}
