//! Cameras as people record them, through the command line: recordings made here, and those in the shape of public reports.

mod field;
mod recorded;
mod topics;
mod world;

use std::path::Path;

use crate::cli::limpid;

/// What a run of the command said, and the map that it wrote (PGM).
pub(crate) struct Ran {
    pub(crate) said: String,
    pub(crate) map: Vec<u8>,
}

impl Ran {
    /// Cells that are lethal or inscribed: map_server's black.
    pub(crate) fn black(&self) -> usize {
        self.pixels().iter().filter(|&&pixel| pixel == 0).count()
    }

    fn pixels(&self) -> &[u8] {
        let header = self.map.windows(5).position(|bytes| bytes == b"\n255\n").unwrap();
        &self.map[header + 5..]
    }

    /// Cells in which two maps differ.
    pub(crate) fn differs_from(&self, other: &Self) -> usize {
        assert_eq!(self.pixels().len(), other.pixels().len());
        self.pixels().iter().zip(other.pixels()).filter(|(a, b)| a != b).count()
    }
}

/// Runs `limpid run` on a recording, which succeeds.
#[track_caller]
pub(crate) fn ran(recording: &Path, more: &[&str]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let stem = folder.path().join("map");
    let fixed = ["run", recording.to_str().unwrap(), "--map", stem.to_str().unwrap()];
    let said = crate::cli::succeeds(&limpid(&[&fixed[..], more].concat()));
    Ran { said, map: std::fs::read(stem.with_extension("pgm")).unwrap() }
}

/// Asserts that what was said holds all of `parts`.
#[track_caller]
pub(crate) fn says(ran: &Ran, parts: &[&str]) {
    for part in parts {
        assert!(ran.said.contains(part), "{part}:\n{}", ran.said);
    }
}
