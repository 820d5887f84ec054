//! `limpid node`.

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr};
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

/// The port that Foxglove proposes.
const FOXGLOVE_PORT: u16 = 8765;

#[derive(Debug, Args)]
pub(crate) struct NodeArguments {
    #[command(flatten)]
    common: Common,
    /// Serve Foxglove over WebSocket, on this machine alone unless an address is given: IP, PORT or IP:PORT
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "127.0.0.1:8765", value_parser = address)]
    foxglove: Option<SocketAddr>,
    /// ROS 2 arguments come after `--ros-args`: -r FROM:=TO, -r __node:=NAME, -r __ns:=NAMESPACE, --params-file FILE
    #[arg(skip)]
    pub(super) ros: RosArgs,
}

/// Where Foxglove is served: its usual port, and this machine, where either is left out.
fn address(text: &str) -> std::result::Result<SocketAddr, String> {
    let socket = text.parse().ok();
    let ip = || text.parse().ok().map(|ip| SocketAddr::new(ip, FOXGLOVE_PORT));
    let port = || text.parse().ok().map(|port| SocketAddr::new(Ipv4Addr::LOCALHOST.into(), port));
    socket.or_else(ip).or_else(port).ok_or_else(|| format!("`{text}` is none of IP, PORT and IP:PORT"))
}

pub(crate) fn execute(arguments: &NodeArguments) -> Result<()> {
    let environment = Environment::read()?;
    let options = NodeOptions {
        config: config(arguments)?,
        adapter: arguments.common.adapter.clone(),
        naming: arguments.ros.naming("limpid")?,
        foxglove: arguments.foxglove,
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
    let node = arguments.ros.naming("limpid")?.full_name();
    let mut config = match (&arguments.ros.files[..], &arguments.common.config) {
        ([], file) => arguments.common.config_of(file.as_deref(), &node)?,
        ([file], None) => arguments.common.config_of(Some(file), &node)?,
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
