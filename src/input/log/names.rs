//! Which files of a folder are bags, and which of them are splits of one recording, by their names.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};

use crate::base::{Error, Result};

/// How bags are called.
const ENDS: [&str; 4] = [".mcap", ".db3", ".bag", ".bag.active"];

/// What is put to the name of a packed file.
const PACKINGS: [&str; 2] = [".zstd", ".zst"];

/// Most names of a list in a message.
const MAX_LISTED: usize = 8;

/// A file's name without its folder.
pub(super) fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Names in words.
pub(super) fn listing(names: &[String]) -> String {
    let more = names.len().saturating_sub(MAX_LISTED);
    let shown = names[..names.len() - more].join(", ");
    if more == 0 { shown } else { format!("{shown} and {more} more") }
}

/// A name without the ending of a packed file.
fn bare(name: &str) -> &str {
    PACKINGS.iter().find_map(|packing| name.strip_suffix(packing)).unwrap_or(name)
}

/// The files in a folder.
fn files(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).map_err(Error::file(folder))?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>();
    let paths = paths.map_err(Error::file(folder))?;
    Ok(paths.into_iter().filter(|path| path.is_file()).collect())
}

/// Whether a folder has PLY or PCD files.
pub(super) fn has_scans(folder: &Path) -> Result<bool> {
    let is_scan = |path: &PathBuf| path.extension().is_some_and(|end| end == "ply" || end == "pcd");
    Ok(files(folder)?.iter().any(is_scan))
}

/// The bag files in a folder in order of their names, numbers in these counted; of a packed file that lies there unpacked,
/// too, as rosbag2 leaves it, the unpacked one.
///
/// # Errors
/// [`Error::File`].
pub(super) fn bag_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut paths = files(folder)?;
    paths.retain(|path| ENDS.iter().any(|end| bare(&name_of(path)).ends_with(end)));
    let all: Vec<String> = paths.iter().map(|path| name_of(path)).collect();
    paths.retain(|path| {
        let name = name_of(path);
        bare(&name) == name || !all.iter().any(|other| other == bare(&name))
    });
    paths.sort_by(|a, b| in_order(&name_of(a), &name_of(b)));
    Ok(paths)
}

/// The files, where their names differ in numbers alone: the splits of one recording.
///
/// # Errors
/// [`Error::Format`] where they are several recordings.
pub(super) fn one_recording(folder: &Path, files: Vec<PathBuf>) -> Result<Vec<PathBuf>> {
    if files.iter().skip(1).all(|file| is_split_of(file, &files[0])) {
        return Ok(files);
    }
    let names: Vec<String> = files.iter().map(|path| name_of(path)).collect();
    let reason = format!("holds several recordings, by their names: {}; give one of them", listing(&names));
    Err(Error::Format { path: folder.into(), reason })
}

/// Whether two files of a folder hold the same, packed or not.
pub(super) fn are_the_same(path: &Path, other: &Path) -> bool {
    bare(&name_of(path)) == bare(&name_of(other))
}

/// Whether two files' names differ in numbers alone.
pub(super) fn is_split_of(path: &Path, other: &Path) -> bool {
    let [name, other] = [path, other].map(name_of);
    let [texts, others] =
        [bare(&name), bare(&other)].map(|name| pieces(name).filter(|piece| !is_number(piece)));
    texts.eq(others)
}

fn is_number(piece: &str) -> bool {
    piece.starts_with(|letter: char| letter.is_ascii_digit())
}

/// A name's numbers and what stands between them.
fn pieces(name: &str) -> impl Iterator<Item = &str> {
    let mut rest = name;
    std::iter::from_fn(move || {
        let digits = is_number(rest);
        let end = rest.find(|letter: char| letter.is_ascii_digit() != digits).unwrap_or(rest.len());
        let (piece, after) = rest.split_at(end);
        rest = after;
        (!piece.is_empty()).then_some(piece)
    })
}

/// The order of two names in which `bag_10` comes after `bag_9`.
fn in_order(a: &str, b: &str) -> Ordering {
    let key = |piece: &str| {
        let digits = if is_number(piece) { piece.trim_start_matches('0') } else { "" };
        (digits.len(), digits.to_owned())
    };
    let by_piece = |(a, b): (&str, &str)| {
        if is_number(a) && is_number(b) { key(a).cmp(&key(b)) } else { a.cmp(b) }
    };
    let first = pieces(a).zip(pieces(b)).map(by_piece).find(|order| order.is_ne());
    first.unwrap_or_else(|| pieces(a).count().cmp(&pieces(b).count())).then_with(|| a.cmp(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count() {
        let mut names = ["bag_10.mcap", "bag_9.mcap", "bag_0.mcap", "bag_09.mcap", "bag.mcap"];
        names.sort_by(|a, b| in_order(a, b));
        assert_eq!(names, ["bag.mcap", "bag_0.mcap", "bag_09.mcap", "bag_9.mcap", "bag_10.mcap"]);
    }

    #[test]
    fn splits_differ_in_numbers_alone() {
        let alike = |a: &str, b: &str| is_split_of(Path::new(a), Path::new(b));
        assert!(alike("x/run_0.mcap", "x/run_11.mcap"));
        assert!(alike("2024-01-02-10-00-00_0.bag", "2024-01-02-10-05-00_1.bag"));
        assert!(alike("run_0.mcap.zstd", "run_1.mcap"));
        assert!(!alike("run_0.mcap", "run_0.db3"));
        assert!(!alike("kitchen_0.mcap", "hall_0.mcap"));
    }
}
