//! Printing that outlives its reader: `limpid info bag | head` closes the pipe early, and a run still has its map to save.
//!
//! The macros take the places of the standard ones, which panic there, in all of the command.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

/// Prints to `to`. Where nobody reads any more nothing is printed; any other failure is told on standard error.
pub(super) fn print(mut to: impl Write, text: Arguments<'_>) {
    if let Err(error) = to.write_fmt(text)
        && error.kind() != ErrorKind::BrokenPipe
    {
        // There is nowhere else to tell it.
        let _ = writeln!(std::io::stderr(), "limpid: standard output: {error}");
    }
}

macro_rules! print {
    ($($text:tt)*) => { $crate::cli::print::print(std::io::stdout(), format_args!($($text)*)) };
}

macro_rules! println {
    () => { print!("\n") };
    ($($text:tt)*) => {
        $crate::cli::print::print(std::io::stdout(), format_args!("{}\n", format_args!($($text)*)))
    };
}

macro_rules! eprintln {
    ($($text:tt)*) => {
        $crate::cli::print::print(std::io::stderr(), format_args!("{}\n", format_args!($($text)*)))
    };
}
