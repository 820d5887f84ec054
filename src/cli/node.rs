//! `limpid node`.

use std::io::Write;
use std::thread;
use std::time::Duration;

use clap::Args;
use limpid::live::{NodeOptions, Stop, run_node};
use limpid::ros2::Environment;
use limpid::{Config, Error, Result};

use super::Common;
use super::ros_args::RosArgs;

/// How long the end may take: who asks for it may not wait longer.
const LONGEST_END: Duration = Duration::from_millis(900);

#[derive(Debug, Args)]
pub(crate) struct NodeArguments {
    #[command(flatten)]
    common: Common,
    /// ROS 2 arguments come after `--ros-args`: -r FROM:=TO, -r __node:=NAME, -r __ns:=NAMESPACE, --params-file FILE
    #[arg(skip)]
    pub(super) ros: RosArgs,
}

pub(crate) fn execute(arguments: &NodeArguments) -> Result<()> {
    let environment = Environment::read()?;
    let options = NodeOptions {
        config: config(arguments)?,
        adapter: arguments.common.adapter.clone(),
        naming: arguments.ros.naming("limpid")?,
        context: None,
    };
    arguments.ros.notes.iter().for_each(|note| println!("note: {note}"));
    let stop = Stop::on_signals()?;
    end_in_time(&stop);
    run_node(&options, &environment, &stop, &mut |line| println!("{line}"))?;
    leave()
}

/// Leaves at once, with all that was said written: passes may still be compiled, and a driver that is taken down under its
/// compiler falls over.
fn leave() -> ! {
    // Nobody may read it any more.
    let _ = std::io::stdout().flush();
    signal_hook::low_level::exit(0)
}

/// The parameters of `-c`, or of the one `--params-file`, with those that `-p` states one by one.
fn config(arguments: &NodeArguments) -> Result<Config> {
    let mut config = match (&arguments.ros.files[..], &arguments.common.config) {
        ([], _) => arguments.common.config()?,
        ([file], None) => arguments.common.config_of(Some(file))?,
        _ => {
            let reason = "parameters come from one file: -c or one --params-file".into();
            return Err(Error::Config { key: "--params-file".into(), reason });
        }
    };
    for (key, value) in &arguments.ros.parameters {
        config.set(key, value)?;
    }
    config.validate()?;
    Ok(config)
}

/// Ends the process where its end takes too long, as while passes are compiled.
fn end_in_time(stop: &Stop) {
    let stop = stop.clone();
    thread::spawn(move || {
        while !stop.is_set() {
            thread::sleep(Duration::from_millis(20));
        }
        thread::sleep(LONGEST_END);
        leave();
    });
}
