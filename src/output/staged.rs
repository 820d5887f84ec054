//! Files that take their names when they are complete, so that an older file survives a run that fails.

use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::base::{Error, Result};

/// Most names tried for a partial file, and most symbolic links followed.
const MAX_TRIES: u32 = 100;

/// A file in the making. `costmap.mcap` is written as `costmap.partial.mcap` beside it and renamed by
/// [`StagedFile::commit`]; a symbolic link stays, and the file that it names is replaced.
///
/// What is no regular file (a pipe, a device, `/dev/stdout`) is written directly. So is a file whose folder takes no new
/// files.
pub(crate) struct StagedFile {
    /// As it was named, for errors.
    path: PathBuf,
    staged: Option<Staged>,
    file: BufWriter<File>,
    /// How many bytes were written to what cannot seek.
    passed_bytes: Option<u64>,
}

/// Where a file is written, and what it is to be called.
struct Staged {
    partial: PathBuf,
    target: PathBuf,
}

impl StagedFile {
    /// Starts a file that a user named; an older one stays as it is until [`Self::commit`].
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be created, and where an older one may not be written.
    pub(crate) fn create(path: &Path) -> Result<Self> {
        follow_links(path).and_then(|target| Self::open(path, target)).map_err(Error::file(path))
    }

    /// As [`Self::create`], of a file in a folder that a user named: there a symbolic link is replaced, not the file that
    /// it leads to, which nobody named.
    pub(crate) fn create_in_folder(path: &Path) -> Result<Self> {
        Self::open(path, path.into()).map_err(Error::file(path))
    }

    fn open(path: &Path, target: PathBuf) -> io::Result<Self> {
        let with = |mut file: File, staged| {
            let passed_bytes = file.stream_position().is_err().then_some(0);
            Self { path: path.into(), staged, file: BufWriter::new(file), passed_bytes }
        };
        if is_direct(path) {
            return Ok(with(File::create(path)?, None));
        }
        let older = std::fs::symlink_metadata(&target).ok().filter(|about| about.is_file());
        if older.is_some() {
            // One that is read-only is refused, as a rename would not.
            OpenOptions::new().write(true).open(&target)?;
        }
        match create_beside(&target) {
            Ok((partial, file)) => {
                if let Some(older) = older {
                    // A file system without permissions keeps none.
                    let _ = std::fs::set_permissions(&partial, older.permissions());
                }
                Ok(with(file, Some(Staged { partial, target })))
            }
            Err(error) if older.is_some() && is_closed(&error) => Ok(with(File::create(&target)?, None)),
            Err(error) => Err(error),
        }
    }

    /// Writes all of a file, to be named; where that fails, what was written is removed.
    ///
    /// # Errors
    /// [`Error::File`].
    pub(crate) fn filled(mut self, write: impl FnOnce(&mut Self) -> io::Result<()>) -> Result<Self> {
        match write(&mut self).and_then(|()| self.file.flush()) {
            Ok(()) => Ok(self),
            Err(source) => {
                let path = self.path.clone();
                self.discard();
                Err(Error::File { path, source })
            }
        }
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// [`Error::File`] where the rest cannot be written or the file cannot be renamed.
    pub(crate) fn commit(mut self) -> Result<()> {
        self.file.flush().map_err(Error::file(&self.path))?;
        let Some(Staged { partial, target }) = self.staged else { return Ok(()) };
        std::fs::rename(&partial, target).map_err(|error| {
            let reason = format!("{error}; what was written is in {}", partial.display());
            Error::File { path: self.path, source: io::Error::new(error.kind(), reason) }
        })
    }

    /// Ends a file that is not complete and keeps what there is, where the answer says: at its path where `may_be_named` and
    /// nothing stands there, else beside it.
    pub(crate) fn keep(mut self, may_be_named: bool) -> PathBuf {
        // What cannot be written is lost; the error that ended the run is told.
        let _ = self.file.flush();
        let Some(Staged { partial, target }) = self.staged else { return self.path };
        let is_free = may_be_named && std::fs::symlink_metadata(&target).is_err();
        if is_free && std::fs::rename(&partial, &target).is_ok() { self.path } else { partial }
    }

    /// Removes what was written.
    pub(crate) fn discard(self) {
        if let Some(Staged { partial, .. }) = self.staged {
            // One that stays is named as partial.
            let _ = std::fs::remove_file(partial);
        }
    }
}

/// Writes a file that a user named at once.
///
/// # Errors
/// [`Error::File`]; then an older file is as it was.
pub fn save_file(path: &Path, bytes: &[u8]) -> Result<()> {
    StagedFile::create(path)?.filled(|file| file.write_all(bytes))?.commit()
}

/// As [`save_file`], of a file in a folder that a user named.
pub(crate) fn save_in_folder(path: &Path, bytes: &[u8]) -> Result<()> {
    StagedFile::create_in_folder(path)?.filled(|file| file.write_all(bytes))?.commit()
}

/// Writes two files that belong together: neither takes its name before both are written.
///
/// # Errors
/// [`Error::File`]; then older files are as they were, unless the second cannot be renamed.
pub(crate) fn save_pair(first: (&Path, &[u8]), second: (&Path, &[u8])) -> Result<()> {
    let written =
        |(path, bytes): (&Path, &[u8])| StagedFile::create(path)?.filled(|file| file.write_all(bytes));
    let first = written(first)?;
    match written(second) {
        Ok(second) => first.commit().and_then(|()| second.commit()),
        Err(error) => {
            first.discard();
            Err(error)
        }
    }
}

impl Write for StagedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        if let Some(passed) = &mut self.passed_bytes {
            *passed += written as u64;
        }
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// What cannot seek says where it is, and no more.
impl Seek for StagedFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match (self.passed_bytes, to) {
            (None, to) => self.file.seek(to),
            (Some(passed), SeekFrom::Current(0)) => Ok(passed),
            (Some(_), _) => Err(ErrorKind::NotSeekable.into()),
        }
    }
}

/// Whether nothing can be renamed over a path: a pipe or a device, an open file that the system gives a name, a folder.
fn is_direct(path: &Path) -> bool {
    let special = std::fs::metadata(path).is_ok_and(|about| !about.is_file());
    special || path.starts_with("/dev") || path.starts_with("/proc")
}

/// The path that a chain of symbolic links leads to, whether or not there is a file.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut at = path.to_owned();
    for _ in 0..MAX_TRIES {
        match std::fs::read_link(&at) {
            // A link is relative to its folder; an absolute one takes the folder's place.
            Ok(to) => at = at.parent().unwrap_or(Path::new("")).join(to),
            Err(_) => return Ok(at),
        }
    }
    Err(io::Error::new(ErrorKind::InvalidInput, "too many symbolic links"))
}

/// A new file beside `target`; it takes the place of none.
fn create_beside(target: &Path) -> io::Result<(PathBuf, File)> {
    let mut number = 1;
    loop {
        let partial = partial_name(target, number);
        match OpenOptions::new().write(true).create_new(true).open(&partial) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists && number < MAX_TRIES => number += 1,
            result => return result.map(|file| (partial, file)),
        }
    }
}

/// `costmap.partial.mcap` of `costmap.mcap`: programs that go by the ending open it too.
fn partial_name(target: &Path, number: u32) -> PathBuf {
    let mut name = target.file_stem().map_or_else(OsString::new, OsString::from);
    name.push(".partial");
    if number > 1 {
        name.push(format!("-{number}"));
    }
    if let Some(extension) = target.extension() {
        name.push(".");
        name.push(extension);
    }
    target.with_file_name(name)
}

/// A path that a run which was stopped may write: `path`, or the first partial name of it by which `is_free` finds nothing.
pub fn free_path(path: &Path, is_free: impl Fn(&Path) -> bool) -> PathBuf {
    let partial = (1..MAX_TRIES).map(|number| partial_name(path, number));
    let mut all = [path.to_owned()].into_iter().chain(partial);
    all.find(|path| is_free(path)).unwrap_or_else(|| partial_name(path, MAX_TRIES))
}

/// Whether an error says that a folder takes no new files.
fn is_closed(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem)
}
