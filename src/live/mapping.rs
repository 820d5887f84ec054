//! The mapper of a node, and what is under way in it.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use crate::base::{Error, Refused, Result};
use crate::config::{Config, SensorInfo};
use crate::gpu::Context;
use crate::live::reading::Waiting;
use crate::map::Update;
use crate::mapper::{Mapper, Options, Submitted};
use crate::run::Rhythm;
use crate::sensor::{Observation, SensorModel};

/// A GPU that has not answered for so long is at fault; a software driver on a busy machine takes seconds.
const GPU_PATIENCE: Duration = Duration::from_secs(20);

/// Observations of one sensor that do not fit in a row, after which it is another sensor than was known.
const MISFITS: u32 = 3;

/// What a result under way came of.
pub(super) struct UnderWay {
    /// `None`: a published map.
    pub(super) observation: Option<Observation>,
    /// When what it came of was complete.
    pub(super) since: Instant,
    submitted: Instant,
    /// Newest stamp of the data in it, nanoseconds.
    pub(super) stamp_ns: u64,
}

/// What became of an observation.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Outcome {
    /// It went into the map; the map's time before and after it, nanoseconds.
    Taken([u64; 2]),
    /// It was refused.
    Refused(Refused),
    /// It was refused like the ones before it: the sensor has changed.
    Changed(Refused),
}

/// See the module.
pub(super) struct Mapping {
    pub(super) mapper: Mapper,
    infos: Vec<SensorInfo>,
    rhythm: Rhythm,
    under_way: VecDeque<UnderWay>,
    misfits: Vec<u32>,
    /// Newest stamp taken, nanoseconds.
    stamp_ns: u64,
    newest: Option<Instant>,
}

impl Mapping {
    /// # Errors
    /// Those of [`Mapper::open`].
    pub(super) fn open(context: &Context, config: &Config, infos: &[SensorInfo]) -> Result<Self> {
        let options = Options { images: true, live: true, ..Options::default() };
        Ok(Self {
            mapper: Mapper::on(context, config, infos, &options)?,
            infos: infos.to_vec(),
            rhythm: Rhythm::of(config),
            under_way: VecDeque::new(),
            misfits: vec![0; infos.len()],
            stamp_ns: 0,
            newest: None,
        })
    }

    /// Publishes as often as a configuration says.
    pub(super) fn set_rhythm(&mut self, config: &Config) {
        self.rhythm = Rhythm::of(config);
    }

    /// Whether a sensor that was missing when the passes were built is known now.
    pub(super) fn lacks(&self, infos: &[SensorInfo]) -> Option<String> {
        let is_missing = |info: &SensorInfo| matches!(info.model, SensorModel::Missing(_));
        let mut pairs = self.infos.iter().zip(infos);
        pairs.find(|(built, now)| is_missing(built) && !is_missing(now)).map(|(_, now)| now.name.clone())
    }

    /// Whether an observation of a sensor can go in now.
    pub(super) fn has_room(&self, sensor: usize) -> bool {
        !self.mapper.is_full(sensor) && !self.mapper.is_publishing_full()
    }

    /// Whether results are awaited.
    pub(super) fn is_busy(&self) -> bool {
        !self.under_way.is_empty()
    }

    /// Starts an observation and, where the map is due, its publication.
    ///
    /// # Errors
    /// Those of [`Mapper::submit`].
    pub(super) fn submit(&mut self, waiting: Waiting, now: Instant) -> Result<Outcome> {
        let Waiting { observation, since } = waiting;
        let (sensor, stamp_ns) = (observation.sensor, observation.stamp_ns());
        let before_ns = self.mapper.now_ns();
        if let Submitted::Refused(reason) = self.mapper.submit(&observation)? {
            return Ok(self.misfit(sensor, reason));
        }
        if let Some(misfits) = self.misfits.get_mut(sensor) {
            *misfits = 0;
        }
        self.stamp_ns = self.stamp_ns.max(stamp_ns);
        self.newest = Some(since);
        self.begin(Some(observation), since, now);
        // Every observation of a sensor alone gives a map.
        if self.infos.len() == 1 || self.rhythm.is_due(&self.mapper) {
            self.publish(None, now)?;
        }
        Ok(Outcome::Taken([before_ns, self.mapper.now_ns()]))
    }

    fn begin(&mut self, observation: Option<Observation>, since: Instant, now: Instant) {
        self.under_way.push_back(UnderWay { observation, since, submitted: now, stamp_ns: self.stamp_ns });
    }

    fn misfit(&mut self, sensor: usize, reason: Refused) -> Outcome {
        let Some(misfits) = self.misfits.get_mut(sensor) else { return Outcome::Refused(reason) };
        let changed = matches!(
            reason,
            Refused::Image { .. } | Refused::Calibration { .. } | Refused::TooManyPoints { .. }
        );
        *misfits = if changed { *misfits + 1 } else { 0 };
        if *misfits >= MISFITS { Outcome::Changed(reason) } else { Outcome::Refused(reason) }
    }

    /// Starts the publication of the map, as of `now_ns` of its time where that goes on without data.
    ///
    /// # Errors
    /// Those of [`Mapper::publish`].
    pub(super) fn publish(&mut self, now_ns: Option<u64>, now: Instant) -> Result<()> {
        if !self.mapper.is_publishing_full() && self.mapper.publish(now_ns)? {
            let since = if now_ns.is_some() { now } else { self.newest.unwrap_or(now) };
            self.begin(None, since, now);
        }
        Ok(())
    }

    /// The next result, if it is there.
    ///
    /// # Errors
    /// Those of [`Mapper::poll`]; [`Error::Gpu`] where the GPU does not answer.
    pub(super) fn poll(&mut self, now: Instant) -> Result<Option<(Update, UnderWay)>> {
        match self.mapper.poll()? {
            Some(update) => Ok(self.under_way.pop_front().map(|under_way| (update, under_way))),
            None => match self.under_way.front() {
                Some(first) if now.saturating_duration_since(first.submitted) > GPU_PATIENCE => {
                    let reason = format!("no answer for {} s", GPU_PATIENCE.as_secs());
                    Err(Error::Gpu { what: "map".into(), reason })
                }
                _ => Ok(None),
            },
        }
    }
}
