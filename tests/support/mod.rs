//! Helpers that more than one test needs.

use std::path::PathBuf;

pub(crate) mod drive;
pub(crate) mod room;
pub(crate) mod sample;

/// Folder of real recordings: `LIMPID_DATA`, by default `../shared/data`; `None`, said aloud, where absent.
pub(crate) fn data_dir(needed: &str) -> Option<PathBuf> {
    let root = std::env::var_os("LIMPID_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    let path = root.join(needed);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there (set LIMPID_DATA)", path.display());
    None
}

pub(crate) mod scene;
