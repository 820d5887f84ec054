//! The records of a recording's files, one file after the other. A topic has one id, whatever its ids in the files are.

use std::collections::{BTreeMap, BTreeSet};

use crate::base::{Error, Result};
use crate::input::log::files::LogFiles;
use crate::input::log::look::look_of;
use crate::input::log::topics::{Channels, Kind};
use crate::input::log::{Record, Records};
use crate::input::zstd_frame;

/// How far files without a summary are read ahead for their channels, bytes of all of them.
const AHEAD_BYTES: u64 = 256 << 20;

/// How far they are read for the first messages of images and calibrations, bytes.
const LOOK_BYTES: u64 = 64 << 20;

/// Most messages that are looked at; the first of each topic comes early.
const MOST_LOOKED_AT: u32 = 20_000;

/// Topic, message type and message encoding.
type Named = (String, String, String);

/// What one file calls its channels and types.
#[derive(Debug, Clone, Default)]
struct FileIds {
    schemas: BTreeMap<u16, String>,
    /// Ids in the recording by ids in the file.
    channels: BTreeMap<u32, u32>,
}

/// Ids of the recording's channels.
#[derive(Debug, Clone, Default)]
struct Ids {
    by_name: BTreeMap<Named, u32>,
    files: Vec<FileIds>,
}

impl Ids {
    fn channel(&self, file: usize, id: u32) -> Option<u32> {
        self.files.get(file)?.channels.get(&id).copied()
    }

    /// A file's record in ids of the recording; `None` for what says nothing of these. What a file says first of an id holds.
    fn translate(&mut self, file: usize, record: Record) -> Option<Record> {
        if self.files.len() <= file {
            self.files.resize_with(file + 1, FileIds::default);
        }
        let ids = &mut self.files[file];
        let (id, named) = match record {
            Record::Schema { id, name } => {
                ids.schemas.entry(id).or_insert(name);
                return None;
            }
            Record::Channel { id, schema_id, topic, message_encoding } => {
                let type_name = ids.schemas.get(&schema_id).cloned().unwrap_or_default();
                (id, (topic, type_name, message_encoding))
            }
            Record::Topic { id, topic, type_name, message_encoding } => {
                (id, (topic, type_name, message_encoding))
            }
            Record::Message { channel_id, log_time_ns, data } => {
                let channel_id = *ids.channels.get(&channel_id)?;
                return Some(Record::Message { channel_id, log_time_ns, data });
            }
            Record::Statistics { message_counts, span_ns } => {
                let ids = |(id, count): (u32, u64)| Some((*ids.channels.get(&id)?, count));
                let message_counts = message_counts.into_iter().filter_map(ids).collect();
                return Some(Record::Statistics { message_counts, span_ns });
            }
        };
        let next = u32::try_from(self.by_name.len()).ok()?;
        let own = *self.by_name.entry(named.clone()).or_insert(next);
        ids.channels.entry(id).or_insert(own);
        let (topic, type_name, message_encoding) = named;
        Some(Record::Topic { id: own, topic, type_name, message_encoding })
    }
}

/// The span of both.
fn joined(a: Option<[u64; 2]>, b: Option<[u64; 2]>) -> Option<[u64; 2]> {
    match (a, b) {
        (Some([a0, a1]), Some([b0, b1])) => Some([a0.min(b0), a1.max(b1)]),
        (a, b) => a.or(b),
    }
}

/// What the files say of their channels, before their messages are read.
#[derive(Debug, Default)]
pub(crate) struct Survey {
    pub(super) channels: Channels,
    ids: Ids,
    /// Log times of the first and the last message, as far as summaries say so.
    span_ns: Option<[u64; 2]>,
    /// What to tell of it.
    pub(in crate::input) notes: Vec<String>,
    /// Damage met while reading ahead, which is met again in reading.
    pub(super) damage: Vec<String>,
}

impl Survey {
    /// From the summaries of the files; of those without one, from their beginnings.
    ///
    /// # Errors
    /// [`Error::File`] and [`Error::Format`] where no file can be read.
    pub(crate) fn of(files: &LogFiles) -> Result<Self> {
        let mut survey = Self::default();
        let (mut counts, mut ahead_bytes) = (Some(BTreeMap::new()), AHEAD_BYTES);
        let (mut without_summary, mut first_error) = (Vec::new(), None);
        for (file, part) in files.parts().iter().enumerate() {
            let summary = match part.summary() {
                Ok(summary) => summary,
                Err(error) => {
                    survey.damage.push(error.to_string());
                    first_error.get_or_insert(error);
                    continue;
                }
            };
            let has_channels = !summary.iter().all(|record| matches!(record, Record::Statistics { .. }));
            let mut counted = false;
            for record in summary {
                counted |= survey.learn(file, record, &mut counts);
            }
            if !counted {
                counts = None;
            }
            if !has_channels {
                without_summary.push(part.name());
                survey.read_ahead(file, part.open()?, &mut ahead_bytes)?;
            }
        }
        if let (true, Some(error)) = (survey.channels.is_empty(), first_error) {
            return Err(error);
        }
        survey.finish(counts, &without_summary, files.parts().len());
        survey.look_at_messages(files)?;
        Ok(survey)
    }

    /// What it says of the topics, as [`Record::Topic`].
    #[cfg(feature = "ros2")]
    pub(crate) fn topics(&self) -> impl Iterator<Item = Record> {
        self.channels.all().map(|(id, channel)| Record::Topic {
            id,
            topic: channel.topic.clone(),
            type_name: channel.schema.clone(),
            message_encoding: channel.message_encoding.clone(),
        })
    }

    /// Takes in what the first messages of images and calibrations show, then those of the clouds that are to be looked at.
    fn look_at_messages(&mut self, files: &LogFiles) -> Result<()> {
        let is_shown = |kind: Kind| kind.is_image() || kind.is_calibration();
        let kinds: BTreeMap<u32, Kind> = self.channels.of_kind_by_id(is_shown).collect();
        self.first_messages(files, kinds.keys().copied().collect(), LOOK_BYTES, |channels, id, data| {
            let look = kinds.get(&id).and_then(|&kind| look_of(kind, data));
            look.map(|look| channels.show(id, look)).is_some()
        })?;
        let clouds = self.channels.to_look_at();
        self.first_messages(files, clouds, AHEAD_BYTES, |channels, id, data| {
            channels.look_at(id, data);
            true
        })
    }

    /// Gives the messages of the `wanted` channels to `take` until it has taken one of each, as far as they are among the first
    /// bytes and the first messages.
    fn first_messages(
        &mut self,
        files: &LogFiles,
        mut wanted: BTreeSet<u32>,
        mut left: u64,
        mut take: impl FnMut(&mut Channels, u32, &[u8]) -> bool,
    ) -> Result<()> {
        let mut messages = 0;
        for (file, part) in files.parts().iter().enumerate() {
            if wanted.is_empty() || left == 0 {
                break;
            }
            // What cannot be opened is told when it is read.
            let Ok(mut records) = part.open() else { continue };
            while !wanted.is_empty() && records.offset() <= left && messages < MOST_LOOKED_AT {
                let is_wanted = |id| self.ids.channel(file, id).is_some_and(|id| wanted.contains(&id));
                let Some(record) = records.next(&is_wanted)? else { break };
                if let Some(Record::Message { channel_id, data, .. }) = self.ids.translate(file, record) {
                    messages += 1;
                    let data = if zstd_frame::is_packed(&data) {
                        zstd_frame::unpack(&data).ok()
                    } else {
                        Some(data)
                    };
                    if take(&mut self.channels, channel_id, &data.unwrap_or_default()) {
                        wanted.remove(&channel_id);
                    }
                }
            }
            left = left.saturating_sub(records.offset());
        }
        Ok(())
    }

    /// Takes in a record of a summary; whether it has counts.
    fn learn(&mut self, file: usize, record: Record, counts: &mut Option<BTreeMap<u32, u64>>) -> bool {
        match self.ids.translate(file, record) {
            Some(Record::Statistics { message_counts, span_ns }) => {
                self.span_ns = joined(self.span_ns, span_ns);
                for (id, count) in message_counts {
                    let Some(counts) = counts else { break };
                    let sum: &mut u64 = counts.entry(id).or_default();
                    *sum = sum.saturating_add(count);
                }
                true
            }
            Some(record) => {
                self.channels.learn(record);
                false
            }
            None => false,
        }
    }

    fn read_ahead(
        &mut self,
        file: usize,
        mut records: Box<dyn Records + Send>,
        left: &mut u64,
    ) -> Result<()> {
        while records.offset() <= *left {
            let Some(record) = records.next(&|_| false)? else { break };
            if let Some(record @ Record::Topic { .. }) = self.ids.translate(file, record) {
                self.channels.learn(record);
            }
        }
        *left = left.saturating_sub(records.offset());
        self.damage.extend(records.take_notes());
        Ok(())
    }

    fn finish(&mut self, counts: Option<BTreeMap<u32, u64>>, without_summary: &[String], parts: usize) {
        if let Some(counts) = counts {
            let message_counts = counts.into_iter().collect();
            self.channels.learn(Record::Statistics { message_counts, span_ns: self.span_ns });
        }
        match without_summary {
            [] => {}
            _ if parts == 1 => {
                self.notes.push("the file has no summary: its topics were found by reading ahead".into());
            }
            names => {
                let names = names.join(", ");
                self.notes.push(format!("no summary in {names}: topics were found by reading ahead"));
            }
        }
    }
}

/// See the module.
pub(crate) struct Splits {
    files: LogFiles,
    ids: Ids,
    /// The file that is read, or the next one.
    at: usize,
    open: Option<Box<dyn Records + Send>>,
    /// Bytes of the files before it.
    passed_bytes: u64,
    notes: Vec<String>,
}

impl Splits {
    /// Opens the first file.
    ///
    /// # Errors
    /// [`Error::File`] and [`Error::Format`] where no file can be opened.
    pub(crate) fn open(files: LogFiles, survey: Survey) -> Result<Self> {
        let ids = survey.ids;
        let mut splits = Self { files, ids, at: 0, open: None, passed_bytes: 0, notes: Vec::new() };
        match splits.open_next() {
            Some(error) if splits.open.is_none() => Err(error),
            _ => Ok(splits),
        }
    }

    /// Opens the next file that can be opened, and notes those that cannot; gives the first error.
    fn open_next(&mut self) -> Option<Error> {
        let mut first_error = None;
        while let (None, Some(part)) = (&self.open, self.files.parts().get(self.at)) {
            match part.open() {
                Ok(records) => self.open = Some(records),
                Err(error) => {
                    self.notes.push(format!("{error}: what was recorded in it is missing"));
                    first_error.get_or_insert(error);
                    self.at += 1;
                }
            }
        }
        first_error
    }

    /// The next record of use, as [`Records::next`]; what is said of channels comes as [`Record::Topic`].
    ///
    /// # Errors
    /// [`Error::File`] where the operating system fails to read.
    pub(crate) fn next(&mut self, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>> {
        loop {
            let Some(records) = &mut self.open else {
                self.open_next();
                if self.open.is_none() {
                    return Ok(None);
                }
                continue;
            };
            let (ids, file) = (&self.ids, self.at);
            let record = records.next(&|id| ids.channel(file, id).is_some_and(wanted))?;
            let several = self.files.parts().len() > 1;
            let named = |note: String| {
                if several { format!("{}: {note}", self.files.parts()[file].name()) } else { note }
            };
            self.notes.extend(records.take_notes().into_iter().map(named));
            match record {
                Some(Record::Statistics { .. }) => {}
                Some(record) => {
                    let record = self.ids.translate(file, record);
                    if record.is_some() {
                        return Ok(record);
                    }
                }
                None => {
                    self.passed_bytes += records.offset();
                    self.open = None;
                    self.at += 1;
                }
            }
        }
    }

    /// Bytes that were gone through.
    pub(super) fn offset(&self) -> u64 {
        self.passed_bytes + self.open.as_ref().map_or(0, |records| records.offset())
    }

    /// What was damaged or passed over, each once.
    pub(crate) fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }
}
