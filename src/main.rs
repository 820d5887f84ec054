//! The `limpid` command: arguments in, library calls, text out.

mod cli;

use std::process::ExitCode;

use clap::Parser;
use limpid::Error;

fn main() -> ExitCode {
    match cli::execute(cli::Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("limpid: {error}");
            ExitCode::from(match error {
                Error::Config { .. } | Error::Yaml(_) => 2,
                _ => 1,
            })
        }
    }
}
