//! `limpid config`.

use clap::Args;
use limpid::config::{EXAMPLE, ROBOT};

#[derive(Debug, Args)]
pub(crate) struct ConfigArguments {
    /// Print a robot with two cameras and a lidar, a section for each
    #[arg(long)]
    robot: bool,
}

pub(crate) fn execute(arguments: &ConfigArguments) {
    print!("{}", if arguments.robot { ROBOT } else { EXAMPLE });
}
