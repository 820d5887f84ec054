//! The node: what its sensors see, as a map, for as long as it runs (spec 5).

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use crate::base::Result;
use crate::config::Config;
use crate::gpu::Context;
use crate::live::Stop;
use crate::live::building::Building;
use crate::live::finding::HINT_FIRST;
use crate::live::full_names::with_full_names;
use crate::live::health::{Health, SensorHealth};
use crate::live::mapping::{Mapping, Outcome};
use crate::live::publisher::Publisher;
use crate::live::reading::{Event, Reading};
use crate::live::services::Services;
use crate::live::supervisor::Supervisor;
use crate::live::timeline::Timeline;
use crate::message::RosMessage;
use crate::message::live::Clock;
use crate::message::ros2::decode_cdr;
use crate::ros2::{Announcement, Environment, Graph, Inbox, Naming, Participant, Quality};

/// Longest sleep, and the sleep while the GPU works.
const NAP: Duration = Duration::from_millis(20);
const WINK: Duration = Duration::from_millis(1);

/// Number under which `/clock` is received.
const CLOCK: u32 = u32::MAX;

/// What a node runs with.
#[derive(Clone)]
pub struct NodeOptions {
    /// Parameters.
    pub config: Config,
    /// Part of the GPU adapter's name; `None`: `LIMPID_ADAPTER`, else the best.
    pub adapter: Option<String>,
    /// Names and remappings.
    pub naming: Naming,
    /// Where Foxglove is served; `None`: nowhere.
    pub foxglove: Option<SocketAddr>,
    /// A device that is open already, which a lost one is replaced by a new one of.
    pub context: Option<Context>,
}

/// Runs a node in the graph that `environment` names until `stop` is set; `say` takes lines for the user. At its end the maps
/// are left unknown.
///
/// # Errors
/// [`crate::Error::Ros2`] where DDS does not start; [`crate::Error::Config`] for sensors that are configured wrongly;
/// [`crate::Error::NoAdapter`] where there is no GPU at the start.
pub fn run_node(
    options: &NodeOptions,
    environment: &Environment,
    stop: &Stop,
    say: &mut dyn FnMut(&str),
) -> Result<()> {
    options.config.validate()?;
    let options = &NodeOptions { config: with_full_names(options)?, ..options.clone() };
    environment.notes.iter().for_each(|note| say(&format!("note: {note}")));
    let context = match &options.context {
        Some(context) => context.clone(),
        None => Context::open(options.adapter.as_deref(), false)?,
    };
    say(&format!("adapter: {}", context.describe()));
    let mut before = Before { context: Some(context), health: Health::default() };
    loop {
        let participant = Participant::join(environment)?;
        let mut node = Node::open(options, environment, &participant, before)?;
        if let Some(address) = options.foxglove {
            node.serve_foxglove(address, say)?;
        }
        say(&format!("{} in ROS domain {}", options.naming.full_name(), environment.domain));
        let lines = RefCell::new(Vec::new());
        let ended = node.turn_until(stop, &lines, &mut |line| {
            say(line);
            lines.borrow_mut().push(line.to_owned());
        });
        if let Ok(End::Deaf) = ended {
            say("FAULT: DDS has ended, as where the process was stopped or the computer slept: joins again");
            before = node.into_before();
            continue;
        }
        node.supervisor.stopping();
        let left = node.publisher.leave_unknown();
        node.count_messages();
        node.health.summary().iter().for_each(|line| say(line));
        return ended.map(|_| ()).and(left);
    }
}

/// Why a node's turns end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// It is asked for.
    Asked,
    /// DDS has ended.
    Deaf,
}

/// What goes on where a node joins again.
struct Before {
    context: Option<Context>,
    health: Health,
}

/// See the module.
pub(super) struct Node<'a> {
    pub(super) options: &'a NodeOptions,
    /// Some of it may change while it runs.
    pub(super) config: Config,
    /// The graph's name in messages.
    pub(super) place: String,
    pub(super) participant: &'a Participant,
    pub(super) announcement: Announcement,
    pub(super) inbox: Inbox,
    pub(super) services: Services,
    pub(super) graph: Graph,
    /// Topics ever seen, with their types.
    pub(super) known: BTreeMap<String, String>,
    pub(super) newest_topic: Instant,
    /// Who does not hear whom, as far as it is told.
    pub(super) mismatches: BTreeSet<String>,
    pub(super) reading: Option<Reading>,
    pub(super) mapping: Option<Mapping>,
    pub(super) building: Option<Building>,
    pub(super) context: Option<Context>,
    pub(super) publisher: Publisher<'a>,
    pub(super) health: Health,
    pub(super) time: Timeline,
    pub(super) supervisor: Supervisor,
    pub(super) began: Instant,
    pub(super) next_look: Instant,
    pub(super) next_hint: Instant,
    pub(super) next_tick: Instant,
    pub(super) next_second: Instant,
    pub(super) retry: Option<(Instant, Duration)>,
    pub(super) suffered: u64,
    /// Messages of `/clock` that were not understood.
    pub(super) clocks_malformed: u64,
    /// How often topics became known, and how often they had when sensors were chosen.
    pub(super) changes: u64,
    pub(super) chosen: u64,
}

impl<'a> Node<'a> {
    fn open(
        options: &'a NodeOptions,
        environment: &Environment,
        participant: &'a Participant,
        Before { context, health }: Before,
    ) -> Result<Self> {
        let (config, now) = (options.config.clone(), Instant::now());
        let inbox = Inbox::open()?;
        if config.use_sim_time {
            let clock = participant.subscribe("/clock", Clock::TYPE, Quality::Sensor)?;
            inbox.add(CLOCK, clock, 8, true);
        }
        Ok(Self {
            place: format!("ROS domain {}", environment.domain),
            announcement: Announcement::open(participant, environment)?,
            publisher: Publisher::open(participant, &options.naming, &config)?,
            services: Services::open(participant, &options.naming, &inbox)?,
            graph: Graph::default(),
            known: BTreeMap::new(),
            newest_topic: now,
            mismatches: BTreeSet::new(),
            reading: None,
            mapping: None,
            building: None,
            context,
            health,
            time: Timeline::new(config.use_sim_time),
            supervisor: Supervisor::of_environment(),
            began: now,
            next_look: now,
            next_hint: now + HINT_FIRST,
            next_tick: now,
            next_second: now,
            retry: None,
            suffered: 0,
            clocks_malformed: 0,
            changes: 0,
            chosen: 0,
            options,
            config,
            participant,
            inbox,
        })
    }

    fn turn_until(
        &mut self,
        stop: &Stop,
        lines: &RefCell<Vec<String>>,
        say: &mut dyn FnMut(&str),
    ) -> Result<End> {
        self.supervisor.ready();
        while !stop.is_set() {
            let now = Instant::now();
            if now >= self.next_second && !self.participant.is_alive() {
                return Ok(End::Deaf);
            }
            self.look(now, say)?;
            self.receive(now, say)?;
            if let Err(error) = self.map(now, say) {
                self.fail(error, now, say)?;
            }
            self.tick(now, say)?;
            self.log(lines)?;
            self.sleep();
        }
        Ok(End::Asked)
    }

    /// What the next one begins with. The map begins anew: nobody knows how long ago its last data are.
    fn into_before(mut self) -> Before {
        self.count_messages();
        self.health.restarts += 1;
        self.health.last_restart = Some("DDS had ended".into());
        Before { context: self.context.take(), health: std::mem::take(&mut self.health) }
    }

    /// Until there is something to do: the GPU is asked again soon, everything else wakes the inbox.
    fn sleep(&self) {
        let now = Instant::now();
        let stuck = self.reading.as_ref().is_some_and(|reading| !reading.has_room());
        if stuck {
            std::thread::sleep(WINK);
            return;
        }
        let busy = self.mapping.as_ref().is_some_and(Mapping::is_busy);
        self.inbox.wait(now + if busy { WINK } else { NAP });
    }

    /// Reads what has come, as far as there is room for what it gives.
    fn receive(&mut self, now: Instant, say: &mut dyn FnMut(&str)) -> Result<()> {
        if let Some(reading) = &mut self.reading {
            if self.retry.is_some() {
                // What comes while there is no GPU would be old by then.
                reading.waiting.clear();
            } else if self.mapping.is_some() {
                reading.built(now);
            }
        }
        let (mut events, mut requests) = (Vec::new(), Vec::new());
        let mut clock_jumped = false;
        loop {
            if self.reading.as_ref().is_some_and(|reading| !reading.has_room()) {
                break;
            }
            let longest = self.reading.as_ref().and_then(Reading::longest_wait);
            let Some(parcel) = self.inbox.take(longest) else {
                self.reading.iter_mut().for_each(Reading::emptied);
                break;
            };
            if parcel.topic == CLOCK {
                let clock = decode_cdr::<Clock>(Clock::TYPE, &parcel.payload)
                    .and_then(|clock| clock.clock.stamp_ns());
                self.clocks_malformed += u64::from(clock.is_err());
                clock_jumped |= clock.is_ok_and(|stamp_ns| self.time.take_clock(stamp_ns));
                continue;
            }
            if Services::has(parcel.topic) {
                requests.push(parcel);
                continue;
            }
            let came_ns = self.time.steady_ns(parcel.arrived);
            if let Some(reading) = &mut self.reading {
                reading.take(&parcel, came_ns, now, &mut |event| events.push(event));
            }
        }
        if let Some(reading) = &mut self.reading {
            // What waits unread may be what an observation waits for.
            let heard = self.inbox.oldest().map_or(now, |oldest| oldest.min(now));
            reading.tell_time(self.time.steady_ns(heard), now, &mut |event| events.push(event));
        }
        for event in events {
            match event {
                Event::Jumped => self.begin_anew("stamps jumped back by more than a second", say),
                Event::WithoutPose(sensor) => self.count(sensor, |health| health.without_pose += 1),
                Event::BeforeJump(sensor) => self.count(sensor, |health| health.before_jump += 1),
            }
        }
        if clock_jumped {
            self.begin_anew("/clock jumped back by more than a second", say);
        }
        requests.iter().try_for_each(|request| self.serve(request, say))
    }

    fn count(&mut self, sensor: usize, count: impl Fn(&mut SensorHealth)) {
        self.health.sensors.get_mut(sensor).into_iter().for_each(count);
    }

    /// The map begins anew, with passes for the sensors as they are now.
    pub(super) fn begin_anew(&mut self, why: &str, say: &mut dyn FnMut(&str)) {
        let built = self.mapping.take().is_some();
        if let Some(building) = &mut self.building {
            building.in_vain = true;
        }
        if built || self.building.is_some() {
            say(&format!("the map begins anew: {why}"));
            self.health.restarts += 1;
            self.health.last_restart = Some(why.into());
        }
        self.time.forget();
        if let Some(reading) = &mut self.reading {
            reading.begin_anew();
        }
    }

    /// Moves data through the map.
    fn map(&mut self, now: Instant, say: &mut dyn FnMut(&str)) -> Result<()> {
        self.build(now, say)?;
        let (Some(mapping), Some(reading)) = (&mut self.mapping, &mut self.reading) else { return Ok(()) };
        let mut changed = None;
        while let Some(first) = reading.waiting.front() {
            if !mapping.has_room(first.observation.sensor) {
                break;
            }
            let Some(waiting) = reading.waiting.pop_front() else { break };
            let (sensor, since) = (waiting.observation.sensor, waiting.since);
            mapping.mapper.want_images(sensor, self.publisher.wants_images(sensor));
            let refused = match mapping.submit(waiting, now)? {
                Outcome::Taken(map_ns) => {
                    self.time.took(map_ns, since);
                    self.health.took(sensor, now);
                    continue;
                }
                Outcome::Refused(reason) => reason,
                Outcome::Changed(reason) => {
                    changed = Some(reason.to_string());
                    reason
                }
            };
            if let Some(health) = self.health.sensors.get_mut(sensor) {
                health.refused += 1;
                health.last_refused = Some(refused.to_string());
            }
            if changed.is_some() {
                break;
            }
        }
        while let Some((update, under_way)) = mapping.poll(now)? {
            self.health.judge(&update);
            self.publisher.publish(&update, under_way, &mut self.health)?;
        }
        if let Some(reason) = changed {
            self.begin_anew(&format!("a sensor has changed: {reason}"), say);
            self.read_again();
        }
        Ok(())
    }

    /// What is due by time alone.
    fn tick(&mut self, now: Instant, say: &mut dyn FnMut(&str)) -> Result<()> {
        self.supervisor.alive(now);
        if now >= self.next_tick {
            self.next_tick = now + Duration::from_secs_f64(1.0 / self.config.publish_rate_hz).max(WINK);
            if let (Some(mapping), Some(map_ns)) = (&mut self.mapping, self.time.map_ns(now))
                && mapping.mapper.goes_stale(map_ns)
            {
                // An error shows at the next look for results too.
                let _ = mapping.publish(Some(map_ns), now);
            }
        }
        if now >= self.next_second {
            self.next_second = now + Duration::from_secs(1);
            self.count_messages();
            self.publisher.second(&mut self.health, self.time.stamp_ns(), now)?;
            self.health.news().into_iter().for_each(|news| say(&format!("state {news}")));
        }
        Ok(())
    }
}
