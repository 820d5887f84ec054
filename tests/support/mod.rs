//! Helpers that more than one test needs.

use std::io::Write as _;
use std::path::PathBuf;

pub(crate) mod camera_job;
pub(crate) mod compare;
pub(crate) mod gpu;
pub(crate) mod random;
pub(crate) mod run;
pub(crate) mod scene;

/// Folder of real recordings: `LIMPID_DATA`, by default `../shared/data`; `None`, said aloud (past libtest's
/// capture), where absent.
pub(crate) fn data_dir(needed: &str) -> Option<PathBuf> {
    let root = std::env::var_os("LIMPID_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    let path = root.join(needed);
    if path.exists() {
        return Some(path);
    }
    writeln!(std::io::stderr(), "skipped: {} is not there (set LIMPID_DATA)", path.display()).unwrap();
    None
}
