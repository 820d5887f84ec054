//! How a node finds its sensors in the graph, and those who listen to it; and what it tells all of them.

use std::cell::RefCell;
use std::time::{Duration, Instant};

use crate::base::{Error, Result};
use crate::input::LiveSource;
use crate::live::node::Node;
use crate::live::reading::{Reading, hint};
use crate::ros2::Counts;

/// How often the graph is looked at, before sensors are found and after.
const LOOK_FIRST: Duration = Duration::from_millis(100);
const LOOK_LATER: Duration = Duration::from_millis(500);

/// Discovery is over where no new topic was found for so long.
const SETTLED: Duration = Duration::from_millis(700);

/// Where ROS reads transforms.
const TRANSFORMS: [&str; 2] = ["/tf", "/tf_static"];

/// After so long without sensors the user is told what there is, and then again and again.
pub(super) const HINT_FIRST: Duration = Duration::from_secs(5);
const HINT_LATER: Duration = Duration::from_secs(30);

/// Most mismatches that are told.
const MAX_MISMATCHES: usize = 64;

/// Levels of `rcl_interfaces/Log`.
const LOG_INFO: u8 = 20;
const LOG_WARN: u8 = 30;
const LOG_ERROR: u8 = 40;

impl Node<'_> {
    /// What was said goes to `/rosout` too.
    pub(super) fn log(&mut self, lines: &RefCell<Vec<String>>) -> Result<()> {
        for line in lines.take() {
            let level = match line.as_str() {
                fault if fault.starts_with("FAULT") => LOG_ERROR,
                other
                    if other.contains("begins anew")
                        || other.contains("still waits")
                        || other.starts_with("warning")
                        || other.starts_with("state") && other != "state OK" =>
                {
                    LOG_WARN
                }
                _ => LOG_INFO,
            };
            self.publisher.log(level, &line, self.time.stamp_ns())?;
        }
        Ok(())
    }

    /// Looks at the graph: finds sensors, and newcomers among those who listen.
    pub(super) fn look(&mut self, now: Instant, say: &mut dyn FnMut(&str)) -> Result<()> {
        if now < self.next_look {
            return Ok(());
        }
        self.next_look = now + if self.reading.is_some() { LOOK_LATER } else { LOOK_FIRST };
        self.graph = self.participant.graph();
        for topic in &self.graph.topics {
            let kind = topic.types.first().cloned().unwrap_or_default();
            if self.known.get(&topic.name) != Some(&kind) {
                self.known.insert(topic.name.clone(), kind);
                (self.newest_topic, self.changes) = (now, self.changes + 1);
            }
        }
        self.publisher.see(&self.graph)?;
        self.find(now, say)?;
        self.tell_mismatches(say);
        let mut readers = self.reading.as_ref().map(|reading| reading.readers.clone()).unwrap_or_default();
        readers.sort_unstable();
        readers.extend(&self.services.readers);
        let mut writers = self.publisher.writers();
        writers.extend(self.services.writers());
        self.announcement.tell(&self.options.naming, readers, writers)
    }

    /// Tells, once, who does not hear whom.
    fn tell_mismatches(&mut self, say: &mut dyn FnMut(&str)) {
        let reading = self.reading.as_ref().map(|reading| reading.unheard(&self.graph));
        for what in reading.into_iter().flatten().chain(self.publisher.unheard()) {
            if self.mismatches.len() < MAX_MISMATCHES && self.mismatches.insert(what.clone()) {
                say(&format!("warning: {what}"));
            }
        }
    }

    /// Chooses what is read, and chooses again where that is not complete and new topics came.
    fn find(&mut self, now: Instant, say: &mut dyn FnMut(&str)) -> Result<()> {
        let complete =
            |reading: &mut Reading| reading.source.absent().is_empty() && reading.source.has_motion();
        let enough =
            self.reading.as_mut().is_some_and(|reading| complete(reading) || self.chosen == self.changes);
        if enough || now.saturating_duration_since(self.newest_topic) < SETTLED {
            return Ok(());
        }
        let topics = self.presented();
        let source = match LiveSource::choose(&self.place, &topics, &self.config) {
            Ok(source) => source,
            Err(error @ (Error::Config { .. } | Error::Format { .. })) => {
                self.wait_for(error.to_string(), now, say);
                return Ok(());
            }
            Err(other) => return Err(other),
        };
        let absent = source.absent();
        let waited = now.saturating_duration_since(self.began) >= HINT_FIRST;
        if !absent.is_empty() {
            self.wait_for(format!("nobody publishes the topics of {}", absent.join(", ")), now, say);
            // Sensors that are named may still be starting.
            if self.reading.is_none() && !waited {
                return Ok(());
            }
        } else {
            self.health.waits_for = None;
        }
        self.chosen = self.changes;
        self.read(source, say)
    }

    /// The topics that may be read, by their names without remappings: of transforms those alone that ROS reads, as others may
    /// be of other robots.
    fn presented(&self) -> Vec<(String, String)> {
        let naming = &self.options.naming;
        let topics = self.known.iter().filter_map(|(name, kind)| {
            let presented = naming.present(name)?;
            let transforms = kind == "tf2_msgs/msg/TFMessage";
            (!transforms || TRANSFORMS.contains(&presented)).then(|| (presented.to_owned(), kind.clone()))
        });
        topics.collect()
    }

    fn wait_for(&mut self, what: String, now: Instant, say: &mut dyn FnMut(&str)) {
        if now >= self.next_hint {
            self.next_hint = now + HINT_LATER;
            say(&hint(&self.options.naming, &self.known, &what));
        }
        self.health.waits_for = Some(what);
    }

    /// Subscribes to what a source reads, unless that is read already.
    fn read(&mut self, mut source: LiveSource, say: &mut dyn FnMut(&str)) -> Result<()> {
        let names = |source: &LiveSource| -> Vec<String> {
            source.topics().iter().map(|topic| format!("{} {}", topic.name, topic.type_name)).collect()
        };
        let sensors = |source: &LiveSource| -> Vec<String> {
            source.sensors().iter().map(|sensor| sensor.name.clone()).collect()
        };
        if let Some(reading) = self.reading.take_if(|reading| names(&reading.source) != names(&source)) {
            reading.close(&self.inbox);
            if sensors(&reading.source) != sensors(&source) {
                self.begin_anew("other sensors are read", say);
            }
        }
        if self.reading.is_some() {
            return Ok(());
        }
        say(&format!("reads {}", names(&source).join(", ")));
        source.report().read.notes.iter().for_each(|note| say(&format!("note: {note}")));
        if !source.has_motion() && self.config.static_transforms.is_empty() {
            say("note: nobody publishes transforms (/tf) so far");
        }
        self.health.watch(source.sensors());
        self.reading =
            Some(Reading::open(source, self.options, (self.participant, &self.inbox, &self.graph))?);
        Ok(())
    }

    /// What was known of the sensors holds no more.
    pub(super) fn read_again(&mut self) {
        if let Some(reading) = self.reading.take() {
            reading.close(&self.inbox);
        }
        self.next_look = Instant::now();
    }

    /// Counts what happened to the messages of the topics that are read.
    pub(super) fn count_messages(&mut self) {
        let (mut suffered, mut input) = (0, Vec::new());
        for (name, count) in [("/clock", self.clocks_malformed), ("services", self.services.malformed)] {
            if count > 0 {
                suffered += count;
                input.push((format!("{name}: not understood"), count.to_string()));
            }
        }
        let read = self.reading.as_ref().map(|reading| &reading.source);
        for topic in read.iter().flat_map(|source| source.topics()) {
            let Counts { received, lost, malformed, dropped } = self.inbox.counts(topic.number);
            suffered += malformed + dropped;
            let counts = format!(
                "received {received}, lost {lost}, malformed {malformed}, dropped for newer {dropped}"
            );
            input.push((topic.name.clone(), counts));
        }
        let skipped = read.map(|source| source.report().read.skipped).unwrap_or_default();
        for skipped in skipped.iter().take(32) {
            suffered += skipped.count;
            input.push((format!("{}: {}", skipped.source, skipped.reason), skipped.count.to_string()));
        }
        self.health.input_suffers = suffered > self.suffered;
        (self.suffered, self.health.input) = (suffered, input);
    }
}
