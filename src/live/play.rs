//! A recording published at its own pace.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::base::{Result, duration_ns};
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::playback::{Playback, Played, PlayedTopic, Purpose};
use crate::live::Stop;
use crate::message::RosMessage;
use crate::message::live::Clock;
use crate::message::ros2::{Time, encode_cdr};
use crate::ros2::{Bytes, Environment, Naming, Participant, Publication, Quality};

/// A pause in the recording longer than this is left out, nanoseconds: the clock that stamped it was set, or somebody slept.
const LONGEST_PAUSE_NS: u64 = 60_000_000_000;

/// How long subscribers that are found one after the other may be apart.
const QUIET: Duration = Duration::from_millis(500);

/// How often it is looked whether DDS still runs.
const LOOK: Duration = Duration::from_secs(1);

/// Most messages of a topic that hold for all time, which are sent again where the domain is joined again.
const MOST_FIXED: u16 = 100;

/// How long the end waits for readers that still fetch what was sent.
const LINGER: Duration = Duration::from_secs(1);

/// How a recording is played.
#[derive(Debug, Clone, PartialEq)]
pub struct PlayOptions {
    /// Times its own pace.
    pub rate: f64,
    /// Again from the start, until the end is asked for.
    pub again: bool,
    /// How often `/clock` tells the recording's time, Hz; `None`: it is not told.
    pub clock_hz: Option<f64>,
    /// Seconds of the recording that are left out at its start; what holds for all time is sent all the same.
    pub start_s: f64,
    /// Longest wait for somebody who listens to a sensor before it starts, seconds.
    pub wait_s: f64,
    /// Sensor data reliably too: what is lost is sent again, and who does not keep up holds up the others.
    pub reliable: bool,
    /// Names and remappings.
    pub naming: Naming,
}

/// What was played.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PlayReport {
    /// Messages sent.
    pub sent: u64,
    /// Messages not sent, as a reliable reader did not answer.
    pub held_up: u64,
    /// Times the domain was joined again, as DDS had ended: the process was stopped, or the computer slept.
    pub rejoined: u64,
    /// Times the recording was played to its end.
    pub rounds: u64,
    /// Topics that are not played, and why.
    pub unplayed: Vec<(String, String)>,
    /// Of the last round.
    pub read: ReadReport,
}

/// Plays a recording into the graph that `environment` names; `say` takes lines for the user.
///
/// # Errors
/// What [`Playback::open`] returns; [`crate::Error::Ros2`]; [`crate::Error::Empty`] where nothing of it can be played.
pub fn play(
    path: &Path,
    config: &Config,
    options: &PlayOptions,
    environment: &Environment,
    stop: &Stop,
    say: &mut dyn FnMut(&str),
) -> Result<PlayReport> {
    let mut playback = Playback::open(path, config)?;
    let mut player = Player::open(&playback, options, environment)?;
    environment.notes.iter().for_each(|note| say(&format!("note: {note}")));
    for topic in playback.topics() {
        say(&format!("{} {}", player.options.naming.resolve(&topic.name)?, topic.type_name));
    }
    for skipped in playback.unplayed() {
        say(&format!("not played: {}: {}", skipped.source, skipped.reason));
    }
    player.wait_for_listeners(playback.topics(), stop)?;
    loop {
        player.round(&mut playback, stop)?;
        player.report.read = playback.report();
        if stop.is_set() || !options.again {
            break;
        }
        playback = Playback::open(path, config)?;
    }
    player.finish(stop);
    let unplayed = playback.unplayed().iter();
    player.report.unplayed =
        unplayed.map(|skipped| (skipped.source.clone(), skipped.reason.clone())).collect();
    if player.report.sent == 0 && !stop.is_set() {
        return Err(crate::Error::Empty { reason: "it holds no message that can be played".into() });
    }
    Ok(player.report)
}

struct Player<'a> {
    options: &'a PlayOptions,
    environment: &'a Environment,
    participant: Participant,
    publications: Vec<Publication>,
    clock: Option<Publication>,
    /// What was sent and holds for all time, the newest of each topic, with its topic.
    fixed: Vec<(usize, Bytes)>,
    next_look: Instant,
    report: PlayReport,
}

/// The publication of `/clock`, where it is told.
fn clock(participant: &Participant, options: &PlayOptions) -> Result<Option<Publication>> {
    let publish = |_| participant.publish("/clock", Clock::TYPE, Quality::Stream { depth: 1 });
    options.clock_hz.map(publish).transpose()
}

/// Where a round is in time.
struct Pace {
    rate: f64,
    /// When the message of `at_ns` is due.
    due: Instant,
    at_ns: u64,
}

impl Pace {
    /// When a message that was received at `at_ns` is due.
    fn due(&mut self, at_ns: u64) -> Instant {
        let passed_ns = at_ns.saturating_sub(self.at_ns);
        if passed_ns <= LONGEST_PAUSE_NS {
            self.due += Duration::from_nanos(passed_ns).div_f64(self.rate);
        }
        self.at_ns = self.at_ns.max(at_ns);
        self.due
    }

    /// The recording's time now.
    fn now_ns(&self, now: Instant) -> u64 {
        let since = now.saturating_duration_since(self.due).mul_f64(self.rate);
        let before = self.due.saturating_duration_since(now).mul_f64(self.rate);
        let ns = |duration: Duration| u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
        self.at_ns.saturating_add(ns(since)).saturating_sub(ns(before))
    }
}

impl<'a> Player<'a> {
    fn open(playback: &Playback, options: &'a PlayOptions, environment: &'a Environment) -> Result<Self> {
        let participant = Participant::join(environment)?;
        let mut player = Self {
            options,
            environment,
            publications: Vec::new(),
            clock: clock(&participant, options)?,
            fixed: Vec::new(),
            next_look: Instant::now() + LOOK,
            participant,
            report: PlayReport::default(),
        };
        player.publish_more(playback.topics())?;
        Ok(player)
    }

    /// Joins the domain again where DDS has ended, and sends again what holds for all time.
    fn look(&mut self, topics: &[PlayedTopic]) -> Result<()> {
        let now = Instant::now();
        if now < self.next_look {
            return Ok(());
        }
        self.next_look = now + LOOK;
        if self.participant.is_alive() {
            return Ok(());
        }
        self.report.rejoined += 1;
        (self.publications, self.clock) = (Vec::new(), None);
        self.participant = Participant::join(self.environment)?;
        self.clock = clock(&self.participant, self.options)?;
        self.publish_more(topics)?;
        for (topic, payload) in &self.fixed {
            if let Some(publication) = self.publications.get(*topic) {
                publication.send(payload.clone())?;
            }
        }
        Ok(())
    }

    /// Keeps a message that holds for all time.
    fn keep(&mut self, topic: usize, payload: &Bytes) {
        let of_topic = |kept: &&(usize, Bytes)| kept.0 == topic;
        if self.fixed.iter().filter(of_topic).count() >= usize::from(MOST_FIXED)
            && let Some(oldest) = self.fixed.iter().position(|kept| kept.0 == topic)
        {
            self.fixed.remove(oldest);
        }
        self.fixed.push((topic, payload.clone()));
    }

    /// Publishes the topics that are new: a file without a summary may tell some late.
    fn publish_more(&mut self, topics: &[PlayedTopic]) -> Result<()> {
        for topic in &topics[self.publications.len().min(topics.len())..] {
            let quality = match topic.purpose {
                Purpose::Sensor if self.options.reliable => Quality::SensorReliable,
                Purpose::Sensor => Quality::Sensor,
                Purpose::Fixed => Quality::Latched { depth: MOST_FIXED },
                Purpose::Stream => Quality::Stream { depth: 100 },
            };
            let name = self.options.naming.resolve(&topic.name)?;
            self.publications.push(self.participant.publish(&name, &topic.type_name, quality)?);
        }
        Ok(())
    }

    /// Waits until somebody listens to a sensor and no more come, or for as long as is stated.
    fn wait_for_listeners(&self, topics: &[PlayedTopic], stop: &Stop) -> Result<()> {
        let until = Instant::now() + Duration::from_secs_f64(self.options.wait_s);
        let sensors = topics.iter().filter(|topic| topic.purpose == Purpose::Sensor);
        let names =
            sensors.map(|topic| self.options.naming.resolve(&topic.name)).collect::<Result<Vec<_>>>()?;
        let (mut known, mut quiet_since) = (0, Instant::now());
        while Instant::now() < until && !stop.is_set() {
            let graph = self.participant.graph();
            let found: usize = names.iter().map(|name| graph.listeners(name)).sum();
            if found != known {
                (known, quiet_since) = (found, Instant::now());
            }
            if known > 0 && quiet_since.elapsed() >= QUIET {
                break;
            }
            stop.sleep(Instant::now() + Duration::from_millis(50));
        }
        Ok(())
    }

    /// Plays to the end of the recording.
    fn round(&mut self, playback: &mut Playback, stop: &Stop) -> Result<()> {
        let mut pace: Option<Pace> = None;
        let skipped_ns = duration_ns(self.options.start_s);
        let mut first_ns = None;
        while let Some(played) = playback.next_message()? {
            self.look(playback.topics())?;
            self.publish_more(playback.topics())?;
            let start_ns = first_ns.get_or_insert(played.at_ns).saturating_add(skipped_ns);
            let fixed =
                playback.topics().get(played.topic).is_some_and(|topic| topic.purpose == Purpose::Fixed);
            if played.at_ns < start_ns && pace.is_none() {
                if fixed {
                    self.send(played, fixed)?;
                }
                continue;
            }
            let now = Instant::now();
            let rate = self.options.rate;
            let pace = pace.get_or_insert(Pace { rate, due: now, at_ns: played.at_ns });
            let due = pace.due(played.at_ns);
            if self.wait(pace, due, stop)? {
                return Ok(());
            }
            self.send(played, fixed)?;
        }
        self.report.rounds += 1;
        Ok(())
    }

    /// Waits until a message is due and tells the time meanwhile; whether the end is asked for.
    fn wait(&self, pace: &Pace, due: Instant, stop: &Stop) -> Result<bool> {
        let Some(hz) = self.options.clock_hz else { return Ok(stop.sleep(due)) };
        let period = Duration::from_secs_f64(1.0 / hz);
        loop {
            let now = Instant::now();
            if let Some(clock) = &self.clock {
                let clock_now = Clock { clock: Time::from_stamp_ns(pace.now_ns(now)) };
                clock.send(encode_cdr(Clock::TYPE, &clock_now)?)?;
            }
            if stop.sleep(due.min(now + period)) {
                return Ok(true);
            }
            if Instant::now() >= due {
                return Ok(false);
            }
        }
    }

    fn send(&mut self, played: Played, fixed: bool) -> Result<()> {
        let payload = Bytes::from(played.payload);
        if fixed {
            self.keep(played.topic, &payload);
        }
        if self.publications[played.topic].send(payload)? {
            self.report.sent += 1;
        } else {
            self.report.held_up += 1;
        }
        Ok(())
    }

    /// Gives readers time to fetch what was sent.
    fn finish(&self, stop: &Stop) {
        let until = Instant::now() + LINGER;
        for publication in &self.publications {
            if !stop.is_set() {
                publication.flush(until.saturating_duration_since(Instant::now()));
            }
        }
        // Best effort has no acknowledgement; datagrams leave within this.
        stop.sleep((Instant::now() + Duration::from_millis(100)).min(until));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_due_at_their_own_pace_and_long_pauses_are_left_out() {
        let start = Instant::now();
        let mut pace = Pace { rate: 2.0, due: start, at_ns: 1_000 };
        let after = |due: Instant| due.duration_since(start);
        assert_eq!(after(pace.due(1_000_001_000)), Duration::from_millis(500));
        // Out of order: at once.
        assert_eq!(after(pace.due(500_000_000)), Duration::from_millis(500));
        assert_eq!(after(pace.due(1_000_001_000 + LONGEST_PAUSE_NS + 1)), Duration::from_millis(500));
        let later = pace.now_ns(start + Duration::from_millis(750));
        assert_eq!(later, 1_000_001_000 + LONGEST_PAUSE_NS + 1 + 500_000_000);
    }
}
