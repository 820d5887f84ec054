//! The messages of a bag in the order in which they were written.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;

use rusqlite::{Connection, OptionalExtension, Row};

use crate::base::Result;
use crate::input::db3::database::{Database, refused};
use crate::input::log::{MAX_MESSAGE_BYTES, Record, Records, too_large};

/// Rows looked up at a time, without their data.
const ROWS: u32 = 256;

/// Places that are damaged, after which the rest is given up.
const MAX_DAMAGES: u32 = 1000;

/// A message without its data.
struct Entry {
    row: i64,
    topic: Option<u32>,
    time_ns: u64,
    bytes: u64,
}

impl Entry {
    fn of(row: &Row<'_>) -> rusqlite::Result<Self> {
        let number = |at: usize| row.get::<_, Option<i64>>(at);
        Ok(Self {
            row: row.get(0)?,
            topic: number(1)?.and_then(|topic| u32::try_from(topic).ok()),
            time_ns: number(2)?.and_then(|time_ns| u64::try_from(time_ns).ok()).unwrap_or(0),
            bytes: number(3)?.and_then(|bytes| u64::try_from(bytes).ok()).unwrap_or(0),
        })
    }
}

/// See the module.
pub(in crate::input) struct Db3Records {
    connection: Connection,
    entries: VecDeque<Entry>,
    /// The last row that was looked up.
    last: i64,
    ended: bool,
    offset: u64,
    /// How often rows could not be looked up.
    damages: u32,
    /// Messages whose data cannot be read, and the first reason.
    unread: Option<(u64, String)>,
    notes: Vec<String>,
}

impl Records for Db3Records {
    fn open(path: &Path) -> Result<Self> {
        let Database { connection, note } = Database::open(path)?;
        Ok(Self {
            connection,
            entries: VecDeque::new(),
            last: i64::MIN,
            ended: false,
            offset: 0,
            damages: 0,
            unread: None,
            notes: note.into_iter().collect(),
        })
    }

    fn summary(path: &Path) -> Result<Vec<Record>> {
        let Database { connection, .. } = Database::open(path)?;
        let failed = |error: rusqlite::Error| {
            refused(path, &format!("has a table `topics` that cannot be read: {error}"))
        };
        let mut found = topics(&connection).map_err(failed)?;
        let span_ns = span_ns(&connection);
        found
            .extend(counts(&connection).map(|message_counts| Record::Statistics { message_counts, span_ns }));
        Ok(found)
    }

    fn next_in_chunk(&mut self, _: &dyn Fn(u32) -> bool) -> Option<Record> {
        None
    }

    fn next_in_file(&mut self, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>> {
        let Some(Entry { row, topic, time_ns, bytes }) = self.entries.pop_front() else {
            self.look_up();
            return Ok(None);
        };
        self.offset = self.offset.saturating_add(bytes);
        let Some(channel_id) = topic.filter(|&topic| wanted(topic)) else { return Ok(None) };
        if bytes > MAX_MESSAGE_BYTES {
            self.notes.push(too_large(bytes, &format!("in row {row}")));
            return Ok(None);
        }
        match self.data(row) {
            Ok(data) => Ok(Some(Record::Message { channel_id, log_time_ns: time_ns, data })),
            Err(error) => {
                let (count, _) = self.unread.get_or_insert_with(|| (0, error.to_string()));
                *count += 1;
                Ok(None)
            }
        }
    }

    fn ended(&self) -> bool {
        self.ended
    }

    /// Bytes of messages.
    fn offset(&self) -> u64 {
        self.offset
    }

    fn take_notes(&mut self) -> Vec<String> {
        if self.ended
            && let Some((count, reason)) = self.unread.take()
        {
            self.notes.push(format!("messages that cannot be read and are lost: {count} ({reason})"));
        }
        std::mem::take(&mut self.notes)
    }
}

impl Db3Records {
    fn data(&self, row: i64) -> rusqlite::Result<Vec<u8>> {
        let mut find = self.connection.prepare("SELECT data FROM messages WHERE rowid = ?1")?;
        find.query_row([row], |found| Ok(found.get_ref(0)?.as_bytes()?.to_vec()))
    }

    /// Looks up the next rows; past those that are damaged.
    fn look_up(&mut self) {
        let found = self.entries_after_last();
        if !self.entries.is_empty() {
            return;
        }
        match found {
            Ok(()) => self.ended = true,
            Err(error) => self.pass_over(&error.to_string()),
        }
    }

    fn entries_after_last(&mut self) -> rusqlite::Result<()> {
        let mut find = self.connection.prepare(
            "SELECT rowid, topic_id, timestamp, length(data) FROM messages WHERE rowid > ?1 ORDER BY rowid LIMIT ?2",
        )?;
        for entry in find.query_map((self.last, ROWS), Entry::of)? {
            let entry = entry?;
            if entry.row <= self.last {
                return Err(out_of_order());
            }
            self.last = entry.row;
            self.entries.push_back(entry);
        }
        Ok(())
    }

    /// Goes on after rows that cannot be looked up: by steps that double to a row that can, then by halves to the first.
    fn pass_over(&mut self, reason: &str) {
        let last = self.last.max(0);
        self.damages += 1;
        let mut damaged = last;
        let steps = (0..i64::BITS - 1).filter_map(|doublings| last.checked_add(1 << doublings));
        let mut found = None;
        for after in steps.take_while(|_| self.damages <= MAX_DAMAGES) {
            match self.row_after(after) {
                Ok(row) => {
                    found = row.map(|row| (after, row));
                    break;
                }
                Err(_) => damaged = after,
            }
        }
        let Some((mut readable, mut row)) = found else {
            self.ended = true;
            self.notes.push(format!(
                "the file is cut off or damaged ({reason}): messages after row {last} are lost"
            ));
            return;
        };
        while readable - damaged > 1 {
            let middle = damaged + (readable - damaged) / 2;
            match self.row_after(middle) {
                Ok(Some(found)) => (readable, row) = (middle, found),
                _ => damaged = middle,
            }
        }
        self.last = readable;
        let (first, end) = (last.saturating_add(1), row - 1);
        self.notes
            .push(format!("the file is damaged ({reason}): messages of rows {first} to {end} are lost"));
    }

    fn row_after(&self, row: i64) -> rusqlite::Result<Option<i64>> {
        let next = "SELECT rowid FROM messages WHERE rowid > ?1 ORDER BY rowid LIMIT 1";
        let found: Option<i64> = self.connection.query_row(next, [row], |row| row.get(0)).optional()?;
        if found.is_some_and(|found| found <= row) { Err(out_of_order()) } else { Ok(found) }
    }
}

/// Rows of a table that is not damaged come in order.
fn out_of_order() -> rusqlite::Error {
    let corrupt = rusqlite::ffi::Error::new(rusqlite::ffi::SQLITE_CORRUPT);
    rusqlite::Error::SqliteFailure(corrupt, Some("rows are out of order".into()))
}

fn text(row: &Row<'_>, at: usize) -> rusqlite::Result<String> {
    Ok(row.get::<_, Option<String>>(at)?.unwrap_or_default())
}

fn topics(connection: &Connection) -> rusqlite::Result<Vec<Record>> {
    let mut find = connection.prepare("SELECT id, name, type, serialization_format FROM topics")?;
    let topic = |row: &Row<'_>| {
        Ok(Record::Topic {
            id: row.get(0)?,
            topic: text(row, 1)?,
            type_name: text(row, 2)?,
            message_encoding: text(row, 3)?,
        })
    };
    find.query_map([], topic)?.collect()
}

/// Times of the first and the last message, nanoseconds.
fn span_ns(connection: &Connection) -> Option<[u64; 2]> {
    let ends = |row: &rusqlite::Row<'_>| Ok([row.get::<_, Option<i64>>(0)?, row.get(1)?]);
    let ends = connection.query_row("SELECT min(timestamp), max(timestamp) FROM messages", [], ends).ok()?;
    let [Some(first), Some(last)] = ends else { return None };
    Some([u64::try_from(first).ok()?, u64::try_from(last).ok()?])
}

/// How many messages the topics have; `None` where the table is damaged.
fn counts(connection: &Connection) -> Option<Vec<(u32, u64)>> {
    let mut find = connection.prepare("SELECT rowid, topic_id FROM messages ORDER BY rowid").ok()?;
    let mut counts: BTreeMap<u32, u64> = BTreeMap::new();
    let mut last = i64::MIN;
    for row in find.query_map([], |row| Ok((row.get::<_, i64>(0)?, row.get::<_, Option<i64>>(1)?))).ok()? {
        let (row, topic) = row.ok()?;
        if row <= last {
            return None;
        }
        last = row;
        if let Some(topic) = topic.and_then(|topic| u32::try_from(topic).ok()) {
            *counts.entry(topic).or_default() += 1;
        }
    }
    Some(counts.into_iter().collect())
}
