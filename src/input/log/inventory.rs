//! What a log holds: from its summary where it has one, else counted.

use std::collections::BTreeMap;

use crate::base::{Result, seconds_between};
use crate::config::Config;
use crate::input::inventory::{FrameInfo, Inventory, TopicInfo};
use crate::input::log::LogFiles;
use crate::input::log::motion::Motion;
use crate::input::log::reading::Log;

/// How much of a log whose summary counts its messages is looked through for frames, bytes.
const SKIMMED_BYTES: u64 = 64 << 20;

/// Messages of a channel that were counted, and the log times of the first and the last, nanoseconds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counted {
    messages: u64,
    span_ns: [u64; 2],
}

impl Counted {
    /// Takes in one message more.
    pub(super) fn add(counted: Option<Self>, log_time_ns: u64) -> Self {
        let Self { messages, span_ns: [first_ns, last_ns] } =
            counted.unwrap_or(Self { messages: 0, span_ns: [log_time_ns; 2] });
        Self { messages: messages + 1, span_ns: [first_ns.min(log_time_ns), last_ns.max(log_time_ns)] }
    }
}

/// What a recording of messages holds.
///
/// # Errors
/// [`crate::Error::File`]; [`crate::Error::Format`] for other files.
pub(crate) fn inventory(files: LogFiles) -> Result<Inventory> {
    let (path, format) = (files.path().to_owned(), files.format_name());
    let mut log = Log::open(files, |channels, _| {
        Ok((Motion::choose(channels, &Config::default(), &path)?, Vec::new()))
    })?;
    let is_indexed = log.channels.is_counted();
    let counted = log.skim(!is_indexed, if is_indexed { SKIMMED_BYTES } else { u64::MAX })?;
    if is_indexed && !log.at_end {
        log.report.note("frames are those of the first 64 MiB");
    }
    let mut inventory = of(&log, &counted, is_indexed);
    inventory.format = format;
    Ok(inventory)
}

fn of(log: &Log, counted: &BTreeMap<u32, Counted>, is_indexed: bool) -> Inventory {
    let spans = counted.values().map(|counted| counted.span_ns);
    let skimmed_ns = spans.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let span_ns = if is_indexed { log.channels.span_ns().or(skimmed_ns) } else { skimmed_ns };
    let mut topics: BTreeMap<&str, TopicInfo> = BTreeMap::new();
    for (id, channel) in log.channels.all() {
        let (messages, own_ns) = match counted.get(&id) {
            _ if is_indexed => (channel.messages, span_ns),
            Some(counted) => (Some(counted.messages), Some(counted.span_ns)),
            None => (Some(0), None),
        };
        let rate_hz = messages.zip(own_ns).and_then(|(messages, span_ns)| rate_hz(messages, span_ns));
        let topic = topics.entry(&channel.topic).or_insert_with(|| TopicInfo {
            topic: channel.topic.clone(),
            type_name: channel.type_name.clone(),
            messages: Some(0),
            rate_hz: Some(0.0),
            is_read: channel.kind.is_some(),
        });
        // A topic may have several channels, as several publishers.
        topic.messages = topic.messages.zip(messages).map(|(a, b)| a + b);
        topic.rate_hz = Some(topic.rate_hz.unwrap_or(0.0) + rate_hz.unwrap_or(0.0)).filter(|&hz| hz > 0.0);
    }
    let tree = log.frames();
    let frame = |(frame, link): (&str, &crate::input::frames::Link)| FrameInfo {
        frame: frame.into(),
        parent: link.parent.clone(),
        fixed: link.fixed,
    };
    Inventory {
        span_ns,
        topics: topics.into_values().collect(),
        frames: tree.links().map(frame).collect(),
        frame_tree: tree.text(),
        notes: log.report.notes.clone(),
        ..Inventory::default()
    }
}

/// Messages a second, of two or more.
fn rate_hz(messages: u64, [first_ns, last_ns]: [u64; 2]) -> Option<f64> {
    let span_s = seconds_between(first_ns, last_ns);
    #[expect(clippy::cast_precision_loss, reason = "told to a tenth")]
    let gaps = messages.saturating_sub(1) as f64;
    (gaps > 0.0 && span_s > 0.0).then(|| gaps / span_s)
}
