//! `metadata.yaml` of a rosbag2 folder.

use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::input::start::open_file;

/// Name of the file.
pub(super) const METADATA: &str = "metadata.yaml";

/// Largest file that is read, bytes.
const MAX_BYTES: u64 = 16 << 20;

#[derive(Deserialize)]
struct Document {
    rosbag2_bagfile_information: Metadata,
}

/// What is read of it.
#[derive(Debug, Deserialize)]
pub(super) struct Metadata {
    /// Below 4, the files' names begin with the folder's.
    #[serde(default)]
    version: u32,
    /// The files in the order of their recording.
    #[serde(default)]
    relative_file_paths: Vec<String>,
    #[serde(default)]
    compression_format: Option<String>,
}

impl Metadata {
    /// # Errors
    /// Why the file is not rosbag2's.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let mut text = String::new();
        let file = open_file(path).map_err(|error| error.to_string())?;
        file.take(MAX_BYTES).read_to_string(&mut text).map_err(|error| error.to_string())?;
        let document: Document = serde_saphyr::from_str(&text).map_err(|error| {
            // The first line says what is wrong, the others quote the file.
            error.to_string().lines().next().unwrap_or_default().to_owned()
        })?;
        Ok(document.rosbag2_bagfile_information)
    }

    /// Names of the files, for messages.
    pub(super) fn names(&self) -> &[String] {
        &self.relative_file_paths
    }

    /// The compression, where it is one that is not read.
    pub(super) fn unread_compression(&self) -> Option<&str> {
        self.compression_format.as_deref().filter(|format| !["", "none", "zstd"].contains(format))
    }

    /// Where a file may lie that is named `name`: as it is named, with its packing put on or taken off since, or in `folder`
    /// whatever its folder was called.
    pub(super) fn places(&self, folder: &Path, name: &str) -> Vec<PathBuf> {
        let below = Path::new(name).file_name().map(|name| folder.join(name));
        let beside = folder.parent().filter(|_| self.version < 4).map(|parent| parent.join(name));
        let stated = [Some(folder.join(name)), beside, below].into_iter().flatten();
        stated.flat_map(|place| packings(&place)).collect()
    }
}

/// A file as named, and with its packing put on or taken off.
fn packings(place: &Path) -> Vec<PathBuf> {
    let name = place.as_os_str().to_string_lossy();
    let bare = [".zstd", ".zst"].iter().find_map(|packing| name.strip_suffix(packing));
    let others: Vec<String> = match bare {
        Some(bare) => vec![bare.into()],
        None => [".zstd", ".zst"].map(|packing| format!("{name}{packing}")).into(),
    };
    std::iter::once(place.to_owned()).chain(others.into_iter().map(PathBuf::from)).collect()
}
