//! Lidar scans in logs of messages: clouds and raw packets in MCAP files and ROS 1 bags.

use std::path::Path;

use crate::base::Result;
use crate::input::bag::BagRecords;
use crate::input::log::scan as scan_channels;
use crate::input::log::topics::{Channel, Channels, Kind, Wire, missing};
use crate::input::log::{Record, Records};
use crate::input::mcap::McapRecords;
use crate::input::points::velodyne::{Cut, Decoder, ScanMessage};
use crate::input::points::{Options, ScanReport, Scans, cloud};
use crate::message::{decode_error, foxglove};
use crate::sensor::Scan;

/// Reads the scans of one topic; see [`Scans`].
///
/// A `VelodyneScan` whose packets make a revolution is one scan, as its driver cut it; smaller ones are joined and cut
/// where the azimuth wraps.
pub struct LogScans {
    records: Box<dyn Records + Send>,
    channels: Channels,
    topic: String,
    options: Options,
    /// Of a topic with packets, from its first message on.
    decoder: Option<Decoder>,
    cloud: Option<Scan>,
    report: ScanReport,
    scan_count_hint: Option<u64>,
    log_time_ns: Option<u64>,
    at_end: bool,
}

impl LogScans {
    /// Opens an MCAP file and chooses the topic, from the summary or, without one, from the first 256 MiB of the file.
    ///
    /// # Errors
    /// [`crate::Error::File`]; [`crate::Error::Format`] for a file that is not MCAP or has no topic with scans;
    /// [`crate::Error::Config`] for a stated topic that is absent or of another type.
    pub fn mcap(path: &Path, options: &Options) -> Result<Self> {
        Self::open::<McapRecords>(path, options)
    }

    /// As [`Self::mcap`], for a ROS 1 bag and its index.
    ///
    /// # Errors
    /// As [`Self::mcap`].
    pub fn bag(path: &Path, options: &Options) -> Result<Self> {
        Self::open::<BagRecords>(path, options)
    }

    fn open<R: Records + Send + 'static>(path: &Path, options: &Options) -> Result<Self> {
        let (mut report, mut channels) = (ScanReport::default(), Channels::default());
        R::summary(path)?.into_iter().for_each(|record| channels.learn(record));
        if channels.is_empty() {
            scan_channels(&mut R::open(path)?, &mut channels)?;
            report.read.note("the file has no summary: its topics were found by reading ahead");
        }
        let stated = options.topic.as_deref().unwrap_or_default();
        let topic = channels
            .configured(path, "topic", stated, Kind::is_scan)?
            .or_else(|| find(&channels))
            .ok_or_else(|| missing(path, "point cloud or Velodyne packets", "topic", &channels))?;
        report.read.note(note(&channels, &topic));
        Ok(Self {
            records: Box::new(R::open(path)?),
            scan_count_hint: channels.messages(&topic),
            channels,
            topic,
            options: options.clone(),
            decoder: None,
            cloud: None,
            report,
            log_time_ns: None,
            at_end: false,
        })
    }

    /// Takes in one record, or the end of the file.
    fn step(&mut self) -> Result<()> {
        let (channels, topic) = (&self.channels, &self.topic);
        let wanted = |id: u32| channels.get(id).is_some_and(|channel| channel.topic == *topic);
        let record = self.records.next(&wanted)?;
        self.records.take_notes().into_iter().for_each(|note| self.report.read.note(note));
        match record {
            None => {
                self.at_end = true;
                if let Some(decoder) = &mut self.decoder {
                    decoder.finish(&mut self.report.read);
                }
            }
            Some(Record::Message { channel_id, log_time_ns, data }) => {
                self.log_time_ns = self.log_time_ns.max(Some(log_time_ns));
                let Some(Channel { kind: Some(kind), .. }) = self.channels.get(channel_id) else {
                    return Ok(());
                };
                if let Err(error) = self.take_message(*kind, &data) {
                    self.report.read.skip(&self.topic, error.to_string(), log_time_ns);
                }
            }
            Some(Record::Statistics { .. }) => {}
            Some(about_channels) => self.channels.learn(about_channels),
        }
        Ok(())
    }

    fn take_message(&mut self, kind: Kind, payload: &[u8]) -> Result<()> {
        let scan = match kind {
            Kind::RosPointCloud(wire) => {
                cloud::from_ros(wire.decode("sensor_msgs/PointCloud2", payload)?, &self.options)?
            }
            Kind::FoxglovePointCloud => {
                let message = foxglove::decode_protobuf("foxglove.PointCloud", payload)?;
                cloud::from_foxglove(&message, &self.options)?
            }
            Kind::VelodyneScan(Wire::Cdr) => {
                self.take_packets(&ScanMessage::from_cdr(payload)?);
                return Ok(());
            }
            Kind::VelodyneScan(Wire::Ros1) => {
                self.take_packets(&ScanMessage::from_ros1(payload)?);
                return Ok(());
            }
            _ => return Err(decode_error("scan", "the topic holds another type")),
        };
        self.cloud = Some(scan);
        Ok(())
    }

    fn take_packets(&mut self, message: &ScanMessage) {
        let report = &mut self.report.read;
        if message.packets.is_empty() {
            report.skip(&self.topic, "the message has no packets", message.stamp_ns);
        }
        let decoder =
            self.decoder.get_or_insert_with(|| Decoder::new(&self.topic, &message.frame_id, &self.options));
        let whole = message.is_revolution();
        if whole {
            decoder.finish(report);
        }
        for (at, packet) in message.packets.iter().enumerate() {
            let cut = match (whole, at + 1 == message.packets.len()) {
                (false, _) => Cut::AtWrap,
                (true, false) => Cut::Not,
                (true, true) => Cut::After,
            };
            decoder.push(packet.payload, packet.stamp_ns, cut, report);
        }
    }

    fn pop(&mut self) -> Option<Scan> {
        self.cloud.take().or_else(|| self.decoder.as_mut()?.pop())
    }
}

/// Packets before clouds, as clouds are made of packets and may have lost returns, then by name.
fn find(channels: &Channels) -> Option<String> {
    let rank = |channel: &&Channel| {
        let packets = matches!(channel.kind, Some(Kind::VelodyneScan(_)));
        (!packets, channel.topic.clone())
    };
    channels.of_kind(Kind::is_scan).min_by_key(rank).map(|channel| channel.topic.clone())
}

fn note(channels: &Channels, topic: &str) -> String {
    let others = channels.of_kind(Kind::is_scan).map(|channel| channel.topic.as_str());
    let others: Vec<&str> = others.filter(|other| *other != topic).take(40).collect();
    if others.is_empty() {
        format!("topic: {topic}")
    } else {
        format!("topic: {topic} (others with scans: {})", others.join(", "))
    }
}

impl Scans for LogScans {
    fn next_scan(&mut self) -> Result<Option<Scan>> {
        loop {
            if let Some(mut scan) = self.pop() {
                if scan.points.is_empty() {
                    self.report.count_empty(&self.topic, &scan);
                    continue;
                }
                self.report.count(&mut scan);
                return Ok(Some(scan));
            }
            if self.at_end {
                return Ok(None);
            }
            self.step()?;
        }
    }

    fn report(&self) -> &ScanReport {
        &self.report
    }

    fn log_time_ns(&self) -> Option<u64> {
        self.log_time_ns
    }

    fn scan_count_hint(&self) -> Option<u64> {
        self.scan_count_hint
    }
}
