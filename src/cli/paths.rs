//! What a command reads and what it writes: no output may take the place of an input or of another output.

use std::fs::Metadata;
use std::path::{Path, PathBuf};

use limpid::{Config, Error, Result};

/// Most entries of an input folder that are compared with an output.
const MAX_ENTRIES: usize = 100_000;

/// Tells whether a name in an output folder is one that the command writes there.
type Writes = fn(&Path) -> bool;

/// The files and folders of a command, each with the argument that names it.
#[derive(Default)]
pub(super) struct Paths<'a> {
    inputs: Vec<(&'static str, &'a Path)>,
    files: Vec<(&'static str, PathBuf)>,
    folders: Vec<(&'static str, &'a Path, Writes)>,
}

impl<'a> Paths<'a> {
    /// Adds a file or a folder that is read.
    pub(super) fn reads(mut self, what: &'static str, path: &'a Path) -> Self {
        self.inputs.push((what, path));
        self
    }

    /// Adds what is read where it is asked for.
    pub(super) fn may_read(self, what: &'static str, path: Option<&'a Path>) -> Self {
        match path {
            Some(path) => self.reads(what, path),
            None => self,
        }
    }

    /// Adds the files that a configuration names.
    pub(super) fn reads_of(mut self, config: &'a Config) -> Self {
        let sensors = config.sensors.iter().map(|sensor| &sensor.parameters);
        for parameters in [config].into_iter().chain(sensors) {
            for (what, name) in [
                ("weights", &parameters.weights),
                ("learned_weights", &parameters.learned_weights),
                ("glass_panes", &parameters.glass_panes),
            ] {
                self = self.may_read(what, Some(Path::new(name)).filter(|_| !name.is_empty()));
            }
        }
        self
    }

    /// Adds a file that is written where it is asked for.
    pub(super) fn may_write(mut self, what: &'static str, path: Option<impl Into<PathBuf>>) -> Self {
        self.files.extend(path.map(|path| (what, path.into())));
        self
    }

    /// Adds a folder that files are written into where it is asked for; `writes` tells by a path in the folder whether the
    /// command may write there.
    pub(super) fn may_fill(mut self, what: &'static str, folder: Option<&'a Path>, writes: Writes) -> Self {
        self.folders.extend(folder.map(|folder| (what, folder, writes)));
        self
    }

    /// Refuses an output that is an input, lies in one or would be written over one, and two outputs that are one file.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub(super) fn check(&self) -> Result<()> {
        for (at, (what, file)) in self.files.iter().enumerate() {
            if is_told_on(file) {
                let reason = "is where limpid prints; a named pipe (`mkfifo`) takes what is to be passed on";
                return Err(refuse(what, file, reason));
            }
            for input in &self.inputs {
                check_file(what, file, input)?;
            }
            for (other_what, other) in &self.files[..at] {
                if is_same(file, other) && !is_device(file) {
                    return Err(refuse(what, file, &format!("is also that of {other_what}")));
                }
            }
            for (folder_what, folder, _) in &self.folders {
                if is_same(file, folder) {
                    return Err(refuse(what, file, &format!("is also the folder of {folder_what}")));
                }
            }
        }
        let all = self.folders.iter().flat_map(|folder| self.inputs.iter().map(move |input| (folder, input)));
        all.into_iter().try_for_each(|(folder, input)| check_folder(folder, input))
    }
}

/// Whether a name ends in one of these.
pub(super) fn ends_in(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().unwrap_or_default();
    extensions.iter().any(|known| extension.eq_ignore_ascii_case(known))
}

fn refuse(what: &str, path: &Path, reason: &str) -> Error {
    let reason = format!("the path of {what} {reason}; give another path (nothing was written)");
    Error::Output { path: path.into(), reason }
}

fn check_file(what: &str, file: &Path, &(input_what, input): &(&str, &Path)) -> Result<()> {
    if is_same(file, input) && !is_device(file) {
        return Err(refuse(what, file, &format!("is that of the input, {input_what} {}", input.display())));
    }
    // No reader takes a JSON file for a part of a recording: figures may lie beside the scans that they are of.
    let lies_in = || !ends_in(file, &["json"]) && folder_of(file, input).is_some();
    if input.is_dir() && (lies_in() || holds(input, file)) {
        return Err(refuse(what, file, &format!("lies in the input, {input_what} {}", input.display())));
    }
    Ok(())
}

fn check_folder(
    &(what, folder, writes): &(&str, &Path, Writes),
    &(input_what, input): &(&str, &Path),
) -> Result<()> {
    let named = format!("the input, {input_what} {}", input.display());
    if is_same(folder, input) || input.is_dir() && folder_of(folder, input).is_some() {
        return Err(refuse(what, folder, &format!("is, or lies in, {named}")));
    }
    match folder_of(input, folder) {
        Some(inside) if writes(&inside) => {
            Err(refuse(what, folder, &format!("holds {named}, which could be overwritten")))
        }
        _ => Ok(()),
    }
}

/// Whether two paths name one file or folder, by links of any kind too.
fn is_same(a: &Path, b: &Path) -> bool {
    match (std::fs::metadata(a), std::fs::metadata(b)) {
        (Ok(a_about), Ok(b_about)) => is_one(a, &a_about, b, &b_about),
        (Err(_), Err(_)) => settled(a) == settled(b),
        _ => false,
    }
}

#[cfg(unix)]
fn is_one(_: &Path, a: &Metadata, _: &Path, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_one(a: &Path, _: &Metadata, b: &Path, _: &Metadata) -> bool {
    settled(a) == settled(b)
}

/// Whether a path is a device such as `/dev/null`, which nothing is overwritten in.
fn is_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|about| !about.is_file() && !about.is_dir())
}

/// Whether a path is this process's standard output or error, on which what is told would mix with what is written.
fn is_told_on(path: &Path) -> bool {
    let is = |stream: &str| is_same(path, Path::new(stream));
    ["/dev/stdout", "/dev/stderr"].into_iter().any(is) && !is("/dev/null")
}

/// A path without links and dots; what is not there yet is kept as it is written.
fn settled(path: &Path) -> PathBuf {
    let followed = std::fs::read_link(path).map(|to| path.parent().unwrap_or(Path::new("")).join(to));
    let path = followed.as_deref().unwrap_or(path);
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.into());
    let there = absolute.ancestors().find_map(|above| Some((above, above.canonicalize().ok()?)));
    match there {
        Some((above, settled)) => settled.join(absolute.strip_prefix(above).unwrap_or(Path::new(""))),
        None => absolute,
    }
}

/// The way from a folder down to a path in it; `None` where it does not lie there.
fn folder_of(path: &Path, folder: &Path) -> Option<PathBuf> {
    let path = settled(path);
    let above = path.ancestors().skip(1).find(|above| above.exists() && is_same(above, folder))?;
    path.strip_prefix(above).ok().map(Path::to_owned)
}

/// Whether a file in a folder is `file` too, by a hard link.
fn holds(folder: &Path, file: &Path) -> bool {
    let Ok(about) = std::fs::metadata(file) else { return false };
    if !has_hard_links(&about) {
        return false;
    }
    let (mut folders, mut left) = (vec![folder.to_owned()], MAX_ENTRIES);
    while let Some(entries) = folders.pop().map(std::fs::read_dir) {
        for path in entries.into_iter().flatten().flatten().map(|entry| entry.path()) {
            left = left.saturating_sub(1);
            if left == 0 || is_same(&path, file) {
                return left > 0;
            }
            if path.is_dir() && !path.is_symlink() {
                folders.push(path);
            }
        }
    }
    false
}

#[cfg(unix)]
fn has_hard_links(about: &Metadata) -> bool {
    std::os::unix::fs::MetadataExt::nlink(about) > 1
}

#[cfg(not(unix))]
fn has_hard_links(_: &Metadata) -> bool {
    true
}
