//! A source through the mapper into sinks, with up to three observations of a sensor under way.

mod mount;
mod notes;

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::base::{Error, Refused, Result, duration_ns};
use crate::config::Config;
use crate::input::{Source, SourceReport};
use crate::map::{GroundRun, Update};
use crate::mapper::{Mapper, Options, SensorInfo, Submitted};
use crate::output::{End, Sink};
pub use crate::run::mount::{Mistake, MountHint};
pub use crate::run::notes::method_note;
use crate::sensor::{DepthSpread, Observation};

/// What a run did with one sensor.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SensorRun {
    /// Its name.
    pub name: String,
    /// Observations that went into the map.
    pub taken: u64,
    /// Those without a pose, counted and passed over.
    pub without_pose: u64,
    /// Those that were refused.
    pub refused: u64,
    /// The first reason.
    pub first_refused: Option<String>,
    /// Frames that were DEGRADED.
    pub degraded: u64,
    /// Frames that method auto, which is drm, fused by depth alone, by the reason.
    pub depth_alone: BTreeMap<String, u64>,
    /// How far a camera's depth reached.
    pub depth: DepthSpread,
    /// Scans to whose pose the lidar jumped from the scan before.
    pub pose_jumps: u64,
    /// What it saw of the ground.
    pub ground: GroundRun,
    /// A mistake of its mount that explains why it sees no floor.
    pub mount: Option<MountHint>,
    /// Observations that were asked for one.
    mount_asked: u32,
    /// The last result.
    pub last: Option<Update>,
}

/// Observations of a sensor that are asked why they show no floor.
const MOUNT_ASKED: u32 = 5;

impl SensorRun {
    /// Asks an observation without a floor for a mistake of the mount.
    fn ask_mount(&mut self, update: &Update, observation: &Observation) {
        let wanted = update.ground.as_ref().is_some_and(|ground| !ground.seen) && self.ground.seen == 0;
        if wanted && self.mount.is_none() && self.mount_asked < MOUNT_ASKED {
            self.mount_asked += 1;
            self.mount = mount::mistake(observation);
        }
    }

    /// What the floor says against the configuration and the transforms.
    fn warning(&self, sensor: &SensorInfo) -> Option<String> {
        let mount = self.mount.filter(|_| self.ground.seen == 0).map(|mount| mount.text(&sensor.frame_id));
        let z_m = sensor.config.ground_z_m;
        let text = mount.or_else(|| self.ground.warning(z_m, z_m != Config::default().ground_z_m))?;
        Some(format!("{}: {text}", self.name))
    }
}

/// What a run did.
///
/// ```
/// let report = limpid::RunReport::default();
/// assert!(report.taken() == 0 && report.last().is_none());
/// ```
#[derive(Debug, Default)]
pub struct RunReport {
    /// With each sensor, as the source counts them.
    pub sensors: Vec<SensorRun>,
    /// Adapter and why it was chosen.
    pub adapter: String,
    /// What was decided when the passes were built and in the run, in words.
    pub notes: Vec<String>,
    /// What a user should look at: a mount or a height that what was seen contradicts.
    pub warnings: Vec<String>,
    /// Building the passes, compilation included.
    pub build: Duration,
    /// From the first observation in to the last result written.
    pub elapsed: Duration,
    /// The last published map, where several sensors share one.
    pub published: Option<Update>,
    /// The sensor whose result was the last one with a map.
    latest: Option<usize>,
    /// What the source met.
    pub read: SourceReport,
    /// Whether the user stopped the source before its end.
    pub stopped: bool,
    /// Of a run that was stopped: the files that hold what was written.
    pub kept: Vec<PathBuf>,
}

impl RunReport {
    /// Counts a result in.
    fn count(&mut self, update: Update) {
        let Some(number) = update.sensor else {
            self.published = Some(update);
            return;
        };
        let Some(sensor) = self.sensors.get_mut(number) else { return };
        sensor.taken += 1;
        sensor.degraded += u64::from(update.camera().is_some_and(|camera| camera.degraded));
        if let Some(reason) = update.camera().and_then(|camera| camera.depth_alone.clone()) {
            *sensor.depth_alone.entry(reason).or_default() += 1;
        }
        sensor.pose_jumps += u64::from(update.lidar().is_some_and(|lidar| lidar.pose_jumped));
        sensor.ground.count(update.ground.as_ref());
        self.latest = if update.map.is_some() { Some(number) } else { self.latest };
        sensor.last = Some(update);
    }

    /// The last result with a map.
    pub fn last(&self) -> Option<&Update> {
        self.published.as_ref().or_else(|| self.sensors.get(self.latest?)?.last.as_ref())
    }

    /// Observations of all sensors that went into the map.
    pub fn taken(&self) -> u64 {
        self.sensors.iter().map(|sensor| sensor.taken).sum()
    }
}

/// Runs the observations numbered in `range` (each sensor's own numbers) of `source` through a mapper and gives every
/// result to all `sinks`, in order; `progress` is called after each.
///
/// Whatever ends the run, results that were under way are written first. The sinks are finished where the source came to its
/// end and something was used, else abandoned.
///
/// # Errors
/// [`Error::Empty`] where no observation could be used; errors of the source, the GPU and the sinks; all of them in
/// [`Error::Partial`] where a sink has kept results.
///
/// # Examples
/// ```
/// use limpid::config::Method;
/// use limpid::{Config, Options, open_source, run};
///
/// # if let Err(limpid::Error::NoAdapter { .. }) = limpid::gpu::adapters(None) { return Ok(()) }
/// let config = Config { method: Method::Range, ..Config::default() };
/// let mut room = open_source("testdata/room.mcap".as_ref(), &config)?;
/// let report = run(room.as_mut(), 0..3, &config, &Options::default(), &mut [], &mut |_| ())?;
/// assert_eq!(report.taken(), 3);
/// # Ok::<(), limpid::Error>(())
/// ```
pub fn run(
    source: &mut dyn Source,
    range: Range<u64>,
    config: &Config,
    options: &Options,
    sinks: &mut [Box<dyn Sink>],
    progress: &mut dyn FnMut(&Update),
) -> Result<RunReport> {
    let sensors = source.sensors().iter();
    let sensors = sensors.map(|sensor| SensorRun { name: sensor.name.clone(), ..SensorRun::default() });
    let report = RunReport { sensors: sensors.collect(), ..RunReport::default() };
    let mut run =
        Run { source, range, sinks, progress, under_way: VecDeque::new(), unpublished: false, report };
    let outcome = run.all(config, options);
    run.report.read = run.source.report();
    let sensors = run.report.sensors.iter().zip(run.source.sensors());
    run.report.warnings = sensors.filter_map(|(of, sensor)| of.warning(sensor)).collect();
    let spreads = run.source.sensors().iter().zip(&run.report.sensors);
    let odd: Vec<_> = spreads.filter_map(|(sensor, run)| notes::depth(sensor, &run.depth)).collect();
    run.report.notes.extend(odd);
    run.report.stopped = run.source.was_stopped();
    let outcome = match outcome {
        Ok(()) if run.report.taken() == 0 => Err(notes::nothing_used(&run.report, run.source.sensors())),
        outcome => outcome,
    };
    let mut report = run.report;
    match outcome {
        Ok(()) if report.stopped => report.kept = abandon(sinks, End::Stopped)?,
        Ok(()) => finish(sinks)?,
        Err(cause) => {
            // What cannot be closed after a failure is not told: the failure is.
            let kept = abandon(sinks, End::Failed).unwrap_or_default();
            return Err(if kept.is_empty() {
                cause
            } else {
                Error::Partial { cause: Box::new(cause), kept }
            });
        }
    }
    Ok(report)
}

/// Finishes all sinks; the first error.
fn finish(sinks: &mut [Box<dyn Sink>]) -> Result<()> {
    sinks.iter_mut().map(|sink| sink.finish()).fold(Ok(()), Result::and)
}

/// Abandons all sinks: the files that they keep, or the first error.
fn abandon(sinks: &mut [Box<dyn Sink>], end: End) -> Result<Vec<PathBuf>> {
    let kept: Vec<_> = sinks.iter_mut().map(|sink| sink.abandon(end)).collect();
    kept.into_iter().filter_map(Result::transpose).collect()
}

/// When the map of several sensors is published: with the first observation, and then with the first after each period.
pub(crate) struct Rhythm {
    period_ns: u64,
    due_ns: Option<u64>,
}

impl Rhythm {
    pub(crate) fn of(config: &Config) -> Self {
        Self { period_ns: duration_ns(1.0 / config.publish_rate_hz), due_ns: None }
    }

    /// Whether the map is to be published now that an observation was taken.
    pub(crate) fn is_due(&mut self, mapper: &Mapper) -> bool {
        let (now_ns, due_ns) = (mapper.now_ns(), self.due_ns);
        if !mapper.publishes() || due_ns.is_some_and(|due_ns| now_ns < due_ns) {
            return false;
        }
        // On time where no observation is missing; from now on where there was a gap.
        let from_ns = due_ns.map_or(now_ns, |due_ns| due_ns.max(now_ns.saturating_sub(self.period_ns / 2)));
        self.due_ns = Some(from_ns + self.period_ns);
        true
    }
}

/// Runs `source` one observation at a time until the map numbered `map` (of one sensor: that of the observation of this number;
/// of several: the published one), or to the end: the mapper as it is then, and its last result with a map.
///
/// # Errors
/// As [`run`]; [`Error::Empty`] where there is no map.
pub fn run_to(
    source: &mut dyn Source,
    map: Option<u64>,
    config: &Config,
    options: &Options,
) -> Result<(Mapper, Update)> {
    let mut mapper = Mapper::open(config, source.sensors(), options)?;
    let (mut rhythm, mut last, mut unpublished) = (Rhythm::of(config), None, false);
    let mut refused = Vec::new();
    while let Some(observation) = source.next()? {
        let is_after = |last: &Update| map.is_some_and(|map| last.index >= map);
        if last.as_ref().is_some_and(is_after) {
            break;
        }
        if let Submitted::Refused(reason) = mapper.submit(&observation)? {
            if reason != Refused::NoPose && refused.is_empty() {
                refused.push(format!("{} {}: {reason}", kind(&observation), observation.index()));
            }
            continue;
        }
        unpublished = !rhythm.is_due(&mapper);
        if !unpublished {
            mapper.publish(None)?;
        }
        last = newest(&mut mapper)?.or(last);
    }
    if unpublished && map.is_none() && mapper.publish(None)? {
        last = newest(&mut mapper)?.or(last);
    }
    let nothing = || source.report().nothing_used(source.sensors(), refused);
    last.map(|last| (mapper, last)).ok_or_else(nothing)
}

/// The last map of what is under way.
fn newest(mapper: &mut Mapper) -> Result<Option<Update>> {
    let mut last = None;
    while mapper.in_flight() > 0 {
        last = mapper.wait()?.filter(|update| update.map.is_some()).or(last);
    }
    Ok(last)
}

struct Run<'a> {
    source: &'a mut dyn Source,
    range: Range<u64>,
    sinks: &'a mut [Box<dyn Sink>],
    progress: &'a mut dyn FnMut(&Update),
    /// What the results under way came of; `None`: a published map.
    under_way: VecDeque<Option<Observation>>,
    /// Whether an observation came after the last publication.
    unpublished: bool,
    report: RunReport,
}

impl Run<'_> {
    /// The next observation of the range that has a pose.
    fn next(&mut self) -> Result<Option<Observation>> {
        while let Some(observation) = self.source.next()? {
            let index = observation.index();
            // With one sensor nothing wanted can follow.
            if index >= self.range.end && self.report.sensors.len() == 1 {
                return Ok(None);
            }
            if !self.range.contains(&index) {
                continue;
            }
            if observation.pose.is_some() {
                return Ok(Some(observation));
            }
            if let Some(sensor) = self.report.sensors.get_mut(observation.sensor) {
                sensor.without_pose += 1;
            }
        }
        Ok(None)
    }

    fn all(&mut self, config: &Config, options: &Options) -> Result<()> {
        let Some(first) = self.next()? else { return Ok(()) };
        let start = Instant::now();
        let mut mapper = Mapper::open(config, self.source.sensors(), options)?;
        self.report.build = start.elapsed();
        self.report.adapter = mapper.context().describe();
        let start = Instant::now();
        let outcome = self.feed(&mut mapper, first, Rhythm::of(config));
        let mut drained = Ok(());
        while drained.is_ok() && !self.under_way.is_empty() {
            drained = self.take(&mut mapper);
        }
        self.report.elapsed = start.elapsed();
        self.report.notes = self.source.sensors().iter().filter_map(method_note).collect();
        self.report.notes.extend(mapper.notes());
        outcome.and(drained)
    }

    fn feed(&mut self, mapper: &mut Mapper, first: Observation, mut rhythm: Rhythm) -> Result<()> {
        let mut next = Some(first);
        while let Some(observation) = next {
            while mapper.is_full(observation.sensor) {
                self.take(mapper)?;
            }
            if let (Some(frame), Some(run)) =
                (observation.frame(), self.report.sensors.get_mut(observation.sensor))
            {
                run.depth.add(&frame.depth.samples);
            }
            match mapper.submit(&observation)? {
                Submitted::Taken => {
                    self.under_way.push_back(Some(observation));
                    self.unpublished = mapper.publishes();
                    if rhythm.is_due(mapper) {
                        self.publish(mapper)?;
                    }
                }
                Submitted::Refused(reason) => {
                    if let Some(sensor) = self.report.sensors.get_mut(observation.sensor) {
                        sensor.refused += 1;
                        let text = format!("{} {}: {reason}", kind(&observation), observation.index());
                        sensor.first_refused.get_or_insert(text);
                    }
                }
            }
            next = self.next()?;
        }
        // What came after the last publication.
        if self.unpublished {
            self.publish(mapper)?;
        }
        Ok(())
    }

    fn publish(&mut self, mapper: &mut Mapper) -> Result<()> {
        while mapper.is_publishing_full() {
            self.take(mapper)?;
        }
        if mapper.publish(None)? {
            self.under_way.push_back(None);
        }
        self.unpublished = false;
        Ok(())
    }

    /// Waits for the oldest result and writes it.
    fn take(&mut self, mapper: &mut Mapper) -> Result<()> {
        let observation = self.under_way.pop_front().flatten();
        let Some(update) = mapper.wait()? else { return Ok(()) };
        let sensor = update.sensor.and_then(|number| self.report.sensors.get_mut(number));
        if let (Some(sensor), Some(observation)) = (sensor, &observation) {
            sensor.ask_mount(&update, observation);
        }
        for sink in self.sinks.iter_mut() {
            sink.write(&update, observation.as_ref())?;
        }
        (self.progress)(&update);
        self.report.count(update);
        Ok(())
    }
}

fn kind(observation: &Observation) -> &'static str {
    if observation.frame().is_some() { "frame" } else { "scan" }
}
