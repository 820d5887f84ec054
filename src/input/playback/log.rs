//! The messages of a log, of all types that ROS 2 can be told.

use std::collections::BTreeMap;

use crate::base::Result;
use crate::input::log::{LogFiles, Record, Splits, Survey};
use crate::input::playback::convert::Conversion;
use crate::input::playback::{Played, PlayedTopic};
use crate::input::{ReadReport, Skipped, zstd_frame};

/// A channel that is played: which topic, and how its messages become those of ROS 2.
struct Channel {
    topic: usize,
    conversion: Conversion,
}

/// See the module.
pub(super) struct LogMessages {
    records: Splits,
    channels: BTreeMap<u32, Option<Channel>>,
    pub(super) topics: Vec<PlayedTopic>,
    pub(super) unplayed: Vec<Skipped>,
    pub(super) report: ReadReport,
}

impl LogMessages {
    /// # Errors
    /// [`crate::Error::File`] and [`crate::Error::Format`] where no file can be read.
    pub(super) fn open(files: LogFiles) -> Result<Self> {
        let survey = Survey::of(&files)?;
        let mut report = ReadReport::default();
        survey.notes.iter().for_each(|note| report.note(note));
        report.tell_files(files.told());
        let topics: Vec<Record> = survey.topics().collect();
        let mut log = Self {
            records: Splits::open(files, survey)?,
            channels: BTreeMap::new(),
            topics: Vec::new(),
            unplayed: Vec::new(),
            report,
        };
        topics.into_iter().for_each(|topic| log.learn(topic));
        Ok(log)
    }

    /// Takes what a record says about a topic.
    fn learn(&mut self, record: Record) {
        if let Record::Topic { id, topic, type_name, message_encoding } = record {
            self.add(id, &topic, &message_encoding, &type_name);
        }
    }

    fn add(&mut self, id: u32, topic: &str, encoding: &str, schema: &str) {
        if self.channels.contains_key(&id) {
            return;
        }
        let channel = match Conversion::of(encoding, schema) {
            Ok(conversion) => {
                let topic = PlayedTopic::new(conversion.topic(topic), conversion.type_name());
                let known = self.topics.iter().position(|other| *other == topic);
                let at = known.unwrap_or(self.topics.len());
                if known.is_none() {
                    self.topics.push(topic);
                }
                Some(Channel { topic: at, conversion })
            }
            Err(reason) => {
                self.unplayed.push(Skipped { source: topic.into(), reason, first_stamp_ns: 0, count: 0 });
                None
            }
        };
        self.channels.insert(id, channel);
    }

    pub(super) fn next_message(&mut self) -> Result<Option<Played>> {
        loop {
            let channels = &self.channels;
            let played = |id: u32| channels.get(&id).is_none_or(Option::is_some);
            let record = self.records.next(&played)?;
            self.records.take_notes().into_iter().for_each(|note| self.report.tell_damage(note));
            match record {
                None => return Ok(None),
                Some(Record::Message { channel_id, log_time_ns, data }) => {
                    let Some(Some(Channel { topic, conversion })) = self.channels.get(&channel_id) else {
                        continue;
                    };
                    match unpacked(data).and_then(|data| conversion.convert(data)) {
                        Ok(payload) => {
                            return Ok(Some(Played { topic: *topic, at_ns: log_time_ns, payload }));
                        }
                        Err(error) => {
                            let name = self.topics[*topic].name.clone();
                            self.report.skip(&name, error.to_string(), log_time_ns);
                        }
                    }
                }
                Some(about_channels) => self.learn(about_channels),
            }
        }
    }
}

/// Messages that rosbag2 packed one by one are unpacked.
fn unpacked(data: Vec<u8>) -> Result<Vec<u8>> {
    if zstd_frame::is_packed(&data) { zstd_frame::unpack(&data) } else { Ok(data) }
}
