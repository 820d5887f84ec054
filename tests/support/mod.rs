//! Helpers that more than one test needs.

use std::io::Write as _;
use std::path::PathBuf;

pub(crate) mod camera_job;
pub(crate) mod compare;
pub(crate) mod drive;
pub(crate) mod glass_room;
pub(crate) mod gpu;
pub(crate) mod mirror_hall;
pub(crate) mod random;
pub(crate) mod room;
pub(crate) mod run;
pub(crate) mod sample;
pub(crate) mod scan;
pub(crate) mod scene;

/// Writes a line to standard error past libtest's capture.
pub(crate) fn say(line: &str) {
    std::io::stderr().write_all(format!("{line}\n").as_bytes()).unwrap();
}

/// Where a recording lies under the folder of real recordings: `LIMPID_DATA`, by default `../shared/data`.
pub(crate) fn data_path(needed: &str) -> PathBuf {
    let root = std::env::var_os("LIMPID_DATA").map_or_else(|| PathBuf::from("../shared/data"), PathBuf::from);
    root.join(needed)
}

/// [`data_path`]; `None`, said aloud (past libtest's capture), where absent.
pub(crate) fn data_dir(needed: &str) -> Option<PathBuf> {
    let path = data_path(needed);
    if path.exists() {
        return Some(path);
    }
    say(&format!("skipped: {} is not there (set LIMPID_DATA)", path.display()));
    None
}

/// What the README shows between the markers of that name; empty where it has none.
pub(crate) fn readme_part(marker: &str) -> String {
    let readme =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/README.md")).unwrap_or_default();
    let shown = readme.split(&format!("<!-- {marker} -->")).nth(1).unwrap_or_default();
    shown.split(&format!("<!-- /{marker} -->")).next().unwrap_or_default().trim().into()
}
