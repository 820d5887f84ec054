//! Writers: what they wrote, read back by other code than theirs.
//!
//! With `LIMPID_KEEP_OUTPUT=DIR` samples of every output stay in `DIR`;
//! `python tests/reference/read_output.py --check DIR/sample-mcap` reads one with the reference readers.

mod dump;
mod map_server;
mod mcap;
mod pictures;
mod room;
mod several;
mod staged;
mod unseekable;
mod unwritable;
