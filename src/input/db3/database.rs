//! An SQLite file that is opened to read it, and nothing else: no lock is taken, no file is made beside it, and what is
//! damaged is read as far as it goes.

use std::io::Read;
use std::path::{Path, PathBuf};

use rusqlite::{Connection, OpenFlags};

use crate::base::{Error, Result};

/// Bytes of an SQLite file's header.
pub(super) const HEADER: usize = 100;

/// Instructions of SQLite's machine between two looks at how many there were.
const WORK_STEP: u16 = 1000;

/// Most instructions in all, and more of these for each byte of the file: a row takes less than a hundred and more than a
/// byte. A damaged tree of pages may lead in circles.
const WORK_LEAST: u64 = 10_000_000;
const WORK_A_BYTE: u64 = 100;

/// See the module.
pub(super) struct Database {
    pub(super) connection: Connection,
    /// What to tell of what lies beside it.
    pub(super) note: Option<String>,
}

impl Database {
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] where the file has not the tables of rosbag2.
    pub(super) fn open(path: &Path) -> Result<Self> {
        std::fs::File::open(path).map_err(Error::file(path))?;
        let failed = |error: rusqlite::Error| refused(path, &format!("cannot be read as SQLite: {error}"));
        let has_log = is_filled(&beside(path, "-wal"));
        let (mut connection, mut note) = (connect(path, has_log).map_err(failed)?, None);
        if has_log && has_tables(&connection).is_err() {
            connection = connect(path, false).map_err(failed)?;
            let log = beside(path, "-wal");
            note = Some(format!("{} cannot be read: messages in it are missing", log.display()));
        } else if is_filled(&beside(path, "-journal")) {
            let journal = beside(path, "-journal");
            note = Some(format!(
                "{} says that writing broke off: what was written last may be damaged",
                journal.display()
            ));
        }
        if !has_tables(&connection).map_err(failed)? {
            let reason = "is an SQLite file without the tables `topics` and `messages` of rosbag2";
            return Err(refused(path, reason));
        }
        Ok(Self { connection, note })
    }
}

/// The error for a file that cannot be read, after what of it is missing, which may be the cause.
pub(super) fn refused(path: &Path, reason: &str) -> Error {
    let missing = missing_bytes(path).map_or_else(String::new, |[there, whole]| {
        format!("is cut off: {there} of {whole} bytes are there; it ")
    });
    Error::Format { path: path.into(), reason: format!("{missing}{reason}") }
}

/// How many bytes a file has and should have, where these are fewer.
fn missing_bytes(path: &Path) -> Option<[u64; 2]> {
    let mut header = [0; HEADER];
    let mut file = std::fs::File::open(path).ok()?;
    file.read_exact(&mut header).ok()?;
    let (there, whole) = (file.metadata().ok()?.len(), bytes_of(header)?);
    (there < whole).then_some([there, whole])
}

/// Bytes of a file by its header: page size (1 stands for 64 KiB) and pages, which count where the two change counters agree.
pub(super) fn bytes_of(header: [u8; HEADER]) -> Option<u64> {
    let number = |at: usize| u32::from_be_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    let page_bytes = match u16::from_be_bytes([header[16], header[17]]) {
        1 => 1 << 16,
        bytes => u64::from(bytes),
    };
    let pages = u64::from(number(28));
    (pages > 0 && number(24) == number(92)).then(|| pages * page_bytes)
}

/// A file of SQLite beside the database.
fn beside(path: &Path, end: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(end);
    name.into()
}

fn is_filled(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() > 0)
}

/// A connection that only reads. With a write-ahead log the pages in it hold; SQLite then works without the memory that it
/// else shares with writers in a file, and without locks.
fn connect(path: &Path, has_log: bool) -> rusqlite::Result<Connection> {
    let how = if has_log { "vfs=unix-none" } else { "immutable=1" };
    let uri = format!("file:{}?mode=ro&{how}", escaped(path));
    let flags =
        OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let mut connection = Connection::open_with_flags(uri, flags)?;
    let bytes = |path: &Path| std::fs::metadata(path).map_or(0, |file| file.len());
    let all = bytes(path).saturating_add(bytes(&beside(path, "-wal")));
    let most = WORK_LEAST.saturating_add(WORK_A_BYTE.saturating_mul(all));
    let mut work = 0_u64;
    let is_too_much = move || {
        work = work.saturating_add(u64::from(WORK_STEP));
        work > most
    };
    connection.progress_handler(WORK_STEP.into(), Some(is_too_much))?;
    // A schema is data of a stranger. A file that is shorter than its header says is only read with `writable_schema`.
    connection.execute_batch(
        "PRAGMA locking_mode = EXCLUSIVE; PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON; \
         PRAGMA writable_schema = ON; PRAGMA mmap_size = 0; PRAGMA temp_store = MEMORY;",
    )?;
    Ok(connection)
}

/// The bytes of a path as a URI has them.
fn escaped(path: &Path) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/._-".contains(&byte);
    let escape = |&byte: &u8| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    path.as_os_str().as_encoded_bytes().iter().map(escape).collect()
}

/// Whether there are the two tables, and these are tables and not views.
fn has_tables(connection: &Connection) -> rusqlite::Result<bool> {
    let count = "SELECT count(DISTINCT name) FROM sqlite_schema \
                 WHERE type = 'table' AND rootpage > 0 AND name IN ('topics', 'messages')";
    connection.query_row(count, [], |row| row.get::<_, u32>(0)).map(|count| count == 2)
}
