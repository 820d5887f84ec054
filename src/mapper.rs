//! The mapper, which runs the stages that `mapper/stages.rs` lists: observations in, one map out.

mod build;
mod channel;
mod checks;
mod goal;
mod read;
mod stages;
mod weights;
mod why;

use std::collections::VecDeque;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use self::build::{Builder, map_job, with_fusion};
use self::channel::{Channel, Published};
pub(crate) use self::checks::frame as check_frame;
use self::goal::towards_goal;
pub use self::stages::{camera_plan, camera_stages, lidar_plan, lidar_stages, map_plan, map_stages};
pub use self::weights::weight_files;
use crate::base::{Error, Refused, Result, duration_ns};
use crate::config::Config;
pub use crate::config::SensorInfo;
use crate::gpu::{Context, Executor, FRAMES_IN_FLIGHT, Store};
use crate::map::{Clock, PaneSet, Seen, State, Update, Window};
use crate::sensor::{Observation, SensorPose};
use crate::stage::{MapJob, Moment};

/// What a mapper runs on, and what it reads back beside the map.
///
/// ```
/// let options = limpid::Options { adapter: Some("llvmpipe".into()), images: true, ..Default::default() };
/// assert!(!options.profiling && !options.layers);
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Part of the adapter's name; `None`: `LIMPID_ADAPTER`, else the best.
    pub adapter: Option<String>,
    /// Whether passes are timed.
    pub profiling: bool,
    /// Whether depth, reliability and colour images are read back.
    pub images: bool,
    /// Whether the grids beside the map are read back.
    pub layers: bool,
    /// Whether what learned solidity judges cells by is read back.
    pub solidity_inputs: bool,
    /// Whether what map reliability judges cells by is read back.
    pub cell_inputs: bool,
    /// Whether the map of one sensor comes with its verdicts; that of several always does.
    pub verdicts: bool,
    /// Whether the map goes on without data, as on a robot: even that of one sensor is published apart
    /// ([`Mapper::publish`]); images are read back without colour.
    pub live: bool,
}

/// What became of an observation that was given to the mapper.
///
/// ```
/// use limpid::{Refused, Submitted};
///
/// fn refused(submitted: Submitted) -> Option<String> {
///     match submitted {
///         Submitted::Taken => None,
///         Submitted::Refused(reason) => Some(reason.to_string()),
///     }
/// }
/// let told = refused(Submitted::Refused(Refused::NoPose));
/// assert_eq!(told.as_deref(), Some("no transform from map to sensor"));
/// ```
#[derive(Debug, Clone, PartialEq)]
#[must_use]
pub enum Submitted {
    /// It is under way.
    Taken,
    /// It was not taken; the map stays as it was.
    Refused(Refused),
}

/// Observations in, maps out, with up to three of a sensor under way. It is `Send`, and blocks in [`Mapper::wait`] alone.
///
/// All sensors write into one map. That of a single sensor comes with each of its observations; that of several is asked for
/// by [`Mapper::publish`].
///
/// ```
/// use limpid::{Config, Mapper, Options, Submitted};
/// use limpid::config::Method;
///
/// # if let Err(limpid::Error::NoAdapter { .. }) = limpid::gpu::adapters(None) { return Ok(()) }
/// let config = Config { method: Method::Range, ..Config::default() };
/// let mut room = limpid::open_source("testdata/room.mcap".as_ref(), &config)?;
/// let mut mapper = Mapper::open(&config, room.sensors(), &Options::default())?;
/// if let Some(frame) = room.next()? {
///     assert_eq!(mapper.submit(&frame)?, Submitted::Taken);
/// }
/// let map = mapper.wait()?.and_then(|update| update.map);
/// assert!(map.is_some_and(|map| map.costmap.len() == 240 * 240));
/// # Ok::<(), limpid::Error>(())
/// ```
pub struct Mapper {
    context: Context,
    store: Store,
    /// Of the sensors, then that of the map where it is published apart.
    channels: Vec<Channel>,
    map: Arc<MapJob>,
    window: Option<Window>,
    /// Whole metres near the first pose, once there is one.
    local_origin_m: Option<DVec3>,
    clock: Clock,
    /// Channels in the order of what is under way.
    order: VecDeque<usize>,
    /// Where the robot was when the newest observation came, in which frame, and its goal.
    newest: Option<Newest>,
    /// What each sensor's last result said of it.
    said: Vec<State>,
    published: u64,
}

/// A mapper may live on a thread of its own.
const _: () = {
    const fn is_send<T: Send>() {}
    is_send::<Mapper>();
};

/// See [`Mapper::newest`].
#[derive(Debug, Clone)]
struct Newest {
    pose: SensorPose,
    map_frame: String,
    goal_m: Option<DVec2>,
}

impl Mapper {
    /// Builds the passes for `sensors`, which share the map of `config`: all that is compiled and allocated is so here.
    ///
    /// # Errors
    /// [`Error::Config`], [`Error::Decode`] for impossible intrinsics, [`Error::NoAdapter`], [`Error::Limit`], [`Error::Gpu`].
    pub fn open(config: &Config, sensors: &[SensorInfo], options: &Options) -> Result<Self> {
        Self::on(&Context::open(options.adapter.as_deref(), options.profiling)?, config, sensors, options)
    }

    /// As [`Mapper::open`], on a device that is open already.
    ///
    /// # Errors
    /// As there.
    pub fn on(context: &Context, config: &Config, sensors: &[SensorInfo], options: &Options) -> Result<Self> {
        let sensors = &with_fusion(config, sensors)[..];
        let map = Arc::new(map_job(config, sensors, options)?);
        let store = Store::new(context);
        let builder = Builder { context, options, map: &map, sensors };
        let mut channels = Vec::new();
        for (number, sensor) in sensors.iter().enumerate() {
            channels.push(match builder.sensor(number)? {
                Some(program) => Channel::build(sensor, program, &store)?,
                None => Channel::missing(sensor),
            });
        }
        if map.apart {
            channels.push(Channel::of_map(config, builder.map()?, &store)?);
        }
        let timeouts_ns: Vec<u64> = sensors.iter().map(|sensor| duration_ns(sensor.timeout_s)).collect();
        Ok(Self {
            context: context.clone(),
            store,
            clock: Clock::new(&timeouts_ns),
            channels,
            map,
            window: None,
            local_origin_m: None,
            order: VecDeque::new(),
            newest: None,
            said: vec![State::Ok; sensors.len()],
            published: 0,
        })
    }

    /// Starts an observation; returns at once. Take results first where [`Mapper::is_full`].
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`]; an observation that cannot be taken is none, but [`Submitted::Refused`].
    pub fn submit(&mut self, observation: &Observation) -> Result<Submitted> {
        match self.checked(observation) {
            Ok(pose) => self.start(observation, pose).map(|()| Submitted::Taken),
            Err(reason) => {
                if let Some(channel) = self.channels.get_mut(observation.sensor) {
                    channel.refused = true;
                }
                Ok(Submitted::Refused(reason))
            }
        }
    }

    fn start(&mut self, observation: &Observation, pose: SensorPose) -> Result<()> {
        let (stamp_ns, before) = (observation.stamp_ns(), self.clock.now());
        let arrival = self.clock.observe(observation.sensor, stamp_ns);
        let window = self.moved_window(pose, arrival.tick < before);
        let local_origin_m =
            *self.local_origin_m.get_or_insert_with(|| PaneSet::origin_near(pose.map_from_sensor()));
        let (fresh_since, states) = (self.clock.fresh_since(), self.states());
        let (resolution_m, side) = (self.map.config.resolution_m, self.map.side);
        let channel = &mut self.channels[observation.sensor];
        let moment = Moment {
            observation: Some(observation),
            pose,
            window,
            own_window: channel.own_window(window, side),
            grid: window.grid(resolution_m, side),
            since_last_s: channel.since_last_s(stamp_ns),
            follows: !channel.refused,
            local_origin_m,
            tick: arrival.tick,
            now: self.clock.now(),
            fresh_since: &fresh_since,
            standing: channel.stands(observation, pose),
            towards_goal: towards_goal(&channel.config, observation.goal_m, pose, resolution_m),
        };
        channel.start(&moment, observation, states)?;
        self.window = Some(window);
        self.order.push_back(observation.sensor);
        let (map_frame, goal_m) = (observation.map_frame.clone(), observation.goal_m);
        if arrival.tick >= before {
            self.newest = Some(Newest { pose, map_frame, goal_m });
        }
        Ok(())
    }

    /// The window around the robot; a message that is `late` leaves it where newer ones have it.
    fn moved_window(&self, pose: SensorPose, late: bool) -> Window {
        let (resolution_m, side) = (self.map.config.resolution_m, self.map.side);
        match self.window.filter(|_| late) {
            Some(now) => Window { shift: [0, 0], forget: false, ..now },
            None => {
                let base = pose.map_from_base.translation_m;
                Window::around(base.x, base.y, resolution_m, side, self.window)
            }
        }
    }

    /// Whether a camera's images come back with its frames from now on, where the mapper was opened for images: at first they do.
    /// Left on the GPU they cost nothing.
    pub fn want_images(&mut self, sensor: usize, wanted: bool) {
        if let Some(channel) = self.channels.get_mut(sensor) {
            channel.images = wanted;
        }
    }

    /// Whether the map is published apart from observations ([`Mapper::publish`]): there are several sensors.
    pub fn publishes(&self) -> bool {
        self.map.apart
    }

    /// Starts the publication of the map of several sensors as it stands; `now_ns`: a clock's time, where that goes on
    /// without data. Whether there is something to publish: before the first observation there is not.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn publish(&mut self, now_ns: Option<u64>) -> Result<bool> {
        let number = self.said.len();
        now_ns.into_iter().for_each(|now_ns| self.clock.advance(now_ns));
        let (Some(window), Some(newest), true) = (self.window, self.newest.clone(), self.map.apart) else {
            return Ok(false);
        };
        let (fresh_since, states) = (self.clock.fresh_since(), self.states());
        let config = &self.map.config;
        let still = Window { shift: [0, 0], forget: false, ..window };
        let moment = Moment {
            observation: None,
            pose: newest.pose,
            window: still,
            own_window: still,
            grid: window.grid(config.resolution_m, self.map.side),
            since_last_s: None,
            follows: true,
            local_origin_m: self.local_origin_m.unwrap_or_default(),
            tick: self.clock.now(),
            now: self.clock.now(),
            fresh_since: &fresh_since,
            standing: false,
            towards_goal: towards_goal(config, newest.goal_m, newest.pose, config.resolution_m),
        };
        let of =
            Published { index: self.published, stamp_ns: self.clock.now_ns(), map_frame: newest.map_frame };
        self.channels[number].publish(&moment, of, states)?;
        self.published += 1;
        self.order.push_back(number);
        Ok(true)
    }

    /// Whether a sensor that is not stale yet would be so at that time; `now_ns` as for [`Mapper::publish`].
    pub fn goes_stale(&self, now_ns: u64) -> bool {
        self.clock.states_at(now_ns) != self.clock.states()
    }

    /// Time of the newest observation, nanoseconds in the map's time; 0 before the first.
    pub fn now_ns(&self) -> u64 {
        self.clock.now_ns()
    }

    /// States by the clock alone.
    fn states(&self) -> Vec<State> {
        self.clock.states()
    }

    /// The next result, if it is there; never waits.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn poll(&mut self) -> Result<Option<Update>> {
        let Some(&next) = self.order.front() else { return Ok(None) };
        let taken = self.channels[next].poll();
        self.count(taken)
    }

    /// The next result; waits for it, at most a minute. `None` where nothing is under way.
    ///
    /// # Errors
    /// [`Error::Gpu`], also where it does not end in time: that result is given up, and those after it can still be had;
    /// [`Error::DeviceLost`].
    pub fn wait(&mut self) -> Result<Option<Update>> {
        let Some(&next) = self.order.front() else { return Ok(None) };
        let taken = self.channels[next].wait();
        self.count(taken)
    }

    /// Submits an observation and waits for its result, for tools that go step by step.
    ///
    /// # Errors
    /// Those of [`Mapper::submit`] and [`Mapper::wait`]; [`Error::Input`] where it was refused.
    pub fn step(&mut self, observation: &Observation) -> Result<Update> {
        if let Submitted::Refused(reason) = self.submit(observation)? {
            return Err(Error::Input { what: "observation".into(), reason: reason.to_string() });
        }
        let lost = || Error::Gpu { what: "observation".into(), reason: "nothing came back".into() };
        self.wait()?.ok_or_else(lost)
    }

    fn count(&mut self, taken: Result<Option<Update>>) -> Result<Option<Update>> {
        if matches!(taken, Ok(None)) {
            return taken;
        }
        self.order.pop_front();
        let mut update = taken?;
        if let Some(update) = &mut update {
            self.judge(update);
        }
        Ok(update)
    }

    /// Joins what the sensors' own results said of them with what the clock said when the map was asked for.
    fn judge(&mut self, update: &mut Update) {
        if let (Some(sensor), Some(said)) = (update.sensor, update.seen.as_ref().and_then(Seen::state))
            && let Some(last) = self.said.get_mut(sensor)
        {
            *last = said;
        }
        let Some(map) = &mut update.map else { return };
        for (state, &said) in map.sensors.iter_mut().zip(&self.said) {
            *state = said.max(*state);
        }
        map.state = map.sensors.iter().copied().max().unwrap_or_default();
    }

    /// Whether as many observations of a sensor are under way as may be.
    pub fn is_full(&self, sensor: usize) -> bool {
        self.channels.get(sensor).is_some_and(|channel| channel.in_flight() >= FRAMES_IN_FLIGHT)
    }

    /// Whether as many publications of the map are under way as may be.
    pub fn is_publishing_full(&self) -> bool {
        self.is_full(self.said.len())
    }

    /// How many observations and publications are under way.
    pub fn in_flight(&self) -> usize {
        self.order.len()
    }

    /// The device.
    pub fn context(&self) -> &Context {
        &self.context
    }

    /// The passes of a sensor, and what they run on; those of the published map after the last sensor.
    pub fn executor(&self, sensor: usize) -> Option<&Executor> {
        self.channels.get(sensor)?.executor()
    }

    /// What was decided when the passes were built and since, in words, for each sensor.
    pub fn notes(&self) -> Vec<String> {
        let scope =
            |channel: &Channel| if self.map.apart { format!("{}: ", channel.name) } else { String::new() };
        let of = |channel: &Channel| {
            let scope = scope(channel);
            channel.notes().into_iter().map(move |note| format!("{scope}{note}"))
        };
        self.channels.iter().flat_map(of).collect()
    }
}
