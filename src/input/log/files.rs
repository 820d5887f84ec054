//! The files of a recording: one file, or the splits in a folder of rosbag2.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::base::{Error, Result};
use crate::input::bag::{self, BagRecords};
use crate::input::db3::{self, Db3Records, Unpacked};
use crate::input::log::metadata::{METADATA, Metadata};
use crate::input::log::names;
use crate::input::log::{Record, Records};
use crate::input::mcap::McapRecords;
use crate::input::start::start_of;
use crate::input::zstd_frame;

/// What a file of messages is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    Mcap,
    /// ROS 1.
    Bag,
    /// SQLite, as rosbag2 wrote it.
    Db3,
}

impl Format {
    /// By the first bytes of a file, or of what is packed in it; `None` for other files.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] for what is not a file, and for packed files of another kind.
    fn of(path: &Path) -> Result<Option<Self>> {
        let start = start_of(path)?;
        if !start.starts_with(&zstd_frame::MAGIC) {
            return Ok(Self::of_start(&start));
        }
        let packed = Self::of_start(&zstd_frame::start_of_unpacked(path)?);
        packed.map(Some).ok_or_else(|| Error::Format {
            path: path.into(),
            reason: "is packed with zstd and holds neither MCAP nor a bag: unpack it with `unzstd`".into(),
        })
    }

    fn of_start(start: &[u8]) -> Option<Self> {
        let magics = [(::mcap::MAGIC, Self::Mcap), (bag::MAGIC, Self::Bag), (db3::MAGIC, Self::Db3)];
        magics.into_iter().find(|(magic, _)| start.starts_with(magic)).map(|(_, format)| format)
    }
}

/// A file of a recording.
#[derive(Debug, Clone)]
pub(super) struct LogPart {
    path: PathBuf,
    format: Format,
    /// A packed SQLite file is read from an unpacked copy.
    unpacked: Option<Arc<Unpacked>>,
}

impl LogPart {
    fn new(path: &Path, format: Format) -> Result<Self> {
        let is_packed = || Ok(start_of(path)?.starts_with(&zstd_frame::MAGIC));
        let unpacked = match format {
            Format::Db3 if is_packed()? => Some(Arc::new(Unpacked::of(path)?)),
            _ => None,
        };
        Ok(Self { path: path.into(), format, unpacked })
    }

    /// Its name without the folder.
    pub(super) fn name(&self) -> String {
        names::name_of(&self.path)
    }

    /// # Errors
    /// As [`Records::open`].
    pub(super) fn open(&self) -> Result<Box<dyn Records + Send>> {
        Ok(match self.format {
            Format::Mcap => Box::new(McapRecords::open(&self.path)?),
            Format::Bag => Box::new(BagRecords::open(&self.path)?),
            Format::Db3 => Box::new(Db3Records::open(self.file())?),
        })
    }

    /// # Errors
    /// As [`Records::summary`].
    pub(super) fn summary(&self) -> Result<Vec<Record>> {
        match self.format {
            Format::Mcap => McapRecords::summary(&self.path),
            Format::Bag => BagRecords::summary(&self.path),
            Format::Db3 => Db3Records::summary(self.file()),
        }
    }

    fn file(&self) -> &Path {
        self.unpacked.as_ref().map_or(&self.path, |unpacked| unpacked.path())
    }
}

/// What is to be told of the files.
#[derive(Debug, Clone, Default)]
pub(in crate::input) struct Told {
    /// How they were found.
    pub(in crate::input) notes: Vec<String>,
    /// What of the recording is not in them.
    pub(in crate::input) lost: Vec<String>,
}

/// See the module.
#[derive(Debug, Clone)]
pub(crate) struct LogFiles {
    path: PathBuf,
    parts: Vec<LogPart>,
    told: Told,
}

impl LogFiles {
    /// What kind of recording it is, in words.
    pub(super) fn format_name(&self) -> String {
        let name = |format| match format {
            Format::Mcap => "MCAP",
            Format::Bag => "ROS 1 bag",
            Format::Db3 => "SQLite bag of rosbag2",
        };
        let format = self.parts.first().map_or("no file", |part| name(part.format));
        match self.parts.len() {
            0 | 1 => format.into(),
            parts => format!("{format}, {parts} files"),
        }
    }

    /// One file that is said to be of a format.
    pub(crate) fn one(path: &Path, format: Format) -> Result<Self> {
        Ok(Self { path: path.into(), parts: vec![LogPart::new(path, format)?], told: Told::default() })
    }

    /// The files that a path stands for: itself, or those of a folder as its `metadata.yaml` names them; without that, the
    /// bag files whose names differ in their numbers alone. `None` where the path is no recording of messages; a folder with PLY
    /// or PCD files is none without metadata.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] for what is neither file nor folder, for a folder none of whose files is there and
    /// for one with several recordings.
    pub(crate) fn find(path: &Path) -> Result<Option<Self>> {
        if path.is_dir() {
            return Self::in_folder(path);
        }
        match path.parent() {
            Some(folder) if path.ends_with(METADATA) && path.is_file() => {
                let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
                Self::in_folder(folder)
            }
            _ => {
                let Some(format) = Format::of(path)? else { return Ok(None) };
                let files = Self::one(path, format)?;
                let lost = note_of_split(path).into_iter().collect();
                Ok(Some(Self { told: Told { lost, ..Told::default() }, ..files }))
            }
        }
    }

    fn in_folder(folder: &Path) -> Result<Option<Self>> {
        let there = names::bag_files(folder)?;
        let file = folder.join(METADATA);
        let stated = file.exists().then(|| Metadata::read(&file));
        let mut told = Told::default();
        let paths = match stated {
            Some(Ok(metadata)) => listed(folder, &metadata, there, &mut told)?,
            _ if there.is_empty() => return Ok(None),
            None if names::has_scans(folder)? => return Ok(None),
            Some(Err(reason)) => {
                told.notes.push(format!(
                    "{METADATA} cannot be read ({reason}): the folder's files are read by name"
                ));
                names::one_recording(folder, there)?
            }
            None => {
                told.notes.push(format!("the folder has no {METADATA}: its files are read by name"));
                names::one_recording(folder, there)?
            }
        };
        let mut files = Self { path: folder.into(), parts: Vec::new(), told };
        files.take(&paths)?;
        Ok(Some(files))
    }

    /// Takes in the files that are recordings and notes the others.
    ///
    /// # Errors
    /// The first file's, where none is a recording.
    fn take(&mut self, paths: &[PathBuf]) -> Result<()> {
        let mut first_error = None;
        for path in paths {
            let format = Format::of(path).and_then(|format| {
                let other =
                    || Error::Format { path: path.into(), reason: "is neither MCAP nor a bag".into() };
                format.ok_or_else(other)
            });
            match format.and_then(|format| LogPart::new(path, format)) {
                Ok(part) => self.parts.push(part),
                Err(error) => {
                    self.told.lost.push(format!("{error}: what was recorded in it is missing"));
                    first_error.get_or_insert(error);
                }
            }
        }
        if let (true, Some(error)) = (self.parts.is_empty(), first_error) {
            return Err(error);
        }
        if self.parts.len() > 1 {
            let read: Vec<String> = self.parts.iter().map(LogPart::name).collect();
            self.told.notes.push(format!(
                "{} files are one recording: {}",
                read.len(),
                names::listing(&read)
            ));
        }
        Ok(())
    }

    /// The path that was given, for messages.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn parts(&self) -> &[LogPart] {
        &self.parts
    }

    /// What is to be told of the files.
    pub(in crate::input) fn told(&self) -> &Told {
        &self.told
    }
}

/// What to tell of a file that is one of several of a recording.
fn note_of_split(path: &Path) -> Option<String> {
    let metadata = Metadata::read(&path.with_file_name(METADATA)).ok()?;
    let [name, count] = [names::name_of(path), metadata.names().len().to_string()];
    let is_one = metadata.names().iter().any(|other| names::name_of(Path::new(other)) == name);
    (is_one && metadata.names().len() > 1).then(|| {
        format!("{name} is one of {count} files of its recording, and what comes once may be in another: give the folder to read all")
    })
}

/// The files that metadata.yaml names, in its order, and those of a recorder that did not come to name them.
fn listed(folder: &Path, metadata: &Metadata, there: Vec<PathBuf>, told: &mut Told) -> Result<Vec<PathBuf>> {
    if let Some(format) = metadata.unread_compression() {
        told.lost.push(format!("{METADATA}: compression_format `{format}` is not read, zstd is"));
    }
    let mut found: Vec<PathBuf> = Vec::new();
    let mut missing = Vec::new();
    for name in metadata.names() {
        match metadata.places(folder, name).into_iter().find(|place| place.is_file()) {
            Some(place) if found.contains(&place) => {}
            Some(place) => found.push(place),
            None => missing.push(name.clone()),
        }
    }
    let is_found = |path: &PathBuf| found.iter().any(|found| names::are_the_same(path, found));
    let left: Vec<PathBuf> = there.into_iter().filter(|path| !is_found(path)).collect();
    if found.is_empty() {
        let stated = format!("{METADATA} names {}, of which nothing is there", names::listing(&missing));
        if left.is_empty() {
            return Err(Error::Format { path: folder.into(), reason: stated });
        }
        told.notes.push(format!("{stated}: the folder's files are read by name"));
        return names::one_recording(folder, left);
    }
    if !missing.is_empty() {
        let missing = names::listing(&missing);
        told.lost
            .push(format!("missing: {missing}, which {METADATA} names; what was recorded in it is lost"));
    }
    let (alike, others): (Vec<_>, Vec<_>) =
        left.into_iter().partition(|path| found.iter().any(|found| names::is_split_of(path, found)));
    for path in alike {
        let name = names::name_of(&path);
        told.notes.push(format!("{METADATA} does not name {name}; it is read after the others"));
        found.push(path);
    }
    if !others.is_empty() {
        let others: Vec<String> = others.iter().map(|path| names::name_of(path)).collect();
        told.notes.push(format!("{METADATA} does not name {}; left out", names::listing(&others)));
    }
    Ok(found)
}
