//! How a node's passes are built, and built again after the GPU was lost.

use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::base::{Error, Result};
use crate::gpu::Context;
use crate::live::mapping::Mapping;
use crate::live::node::Node;
use crate::live::reading::Reading;

/// Shortest and longest pause before the GPU is opened again.
const RETRY_FIRST: Duration = Duration::from_millis(500);
const RETRY_LAST: Duration = Duration::from_secs(30);

/// Passes that are being built.
pub(super) struct Building {
    thread: JoinHandle<Result<Mapping>>,
    began: Instant,
    /// Whether the sensors have changed since.
    pub(super) in_vain: bool,
}

impl Node<'_> {
    /// Builds the passes once the sensors are known, and again where one came late; meanwhile the node goes on.
    pub(super) fn build(&mut self, now: Instant, say: &mut dyn FnMut(&str)) -> Result<()> {
        self.take_built(now, say)?;
        let both = self.mapping.as_ref().zip(self.reading.as_ref());
        let late = both.and_then(|(mapping, reading)| mapping.lacks(reading.source.sensors()));
        if let Some(name) = late {
            self.begin_anew(&format!("`{name}` came late"), say);
        }
        let idle = self.mapping.is_none() && self.building.is_none();
        let paused = self.retry.is_some_and(|(at, _)| now < at);
        let ready = self.reading.as_mut().filter(|reading| idle && !paused && reading.is_ready(now));
        let Some(reading) = ready else { return Ok(()) };
        let found = reading.source.sensors().len();
        reading.leave_out_missing();
        if reading.source.sensors().len() < found {
            reading
                .source
                .report()
                .read
                .notes
                .last()
                .into_iter()
                .for_each(|note| say(&format!("note: {note}")));
        }
        say(&format!("builds the passes of {}", names(reading)));
        let (context, adapter) = (self.context.clone(), self.options.adapter.clone());
        let (config, infos) = (self.config.clone(), reading.source.sensors().to_vec());
        let build = move || {
            let context = match context {
                Some(context) => context,
                None => Context::open(adapter.as_deref(), false)?,
            };
            Mapping::open(&context, &config, &infos)
        };
        let thread = std::thread::Builder::new().name("limpid-build".into()).spawn(build);
        let failed =
            |error: std::io::Error| Error::Ros2 { what: "building".into(), reason: error.to_string() };
        self.building = Some(Building { thread: thread.map_err(failed)?, began: now, in_vain: false });
        Ok(())
    }

    /// Takes the passes once they are built.
    fn take_built(&mut self, now: Instant, say: &mut dyn FnMut(&str)) -> Result<()> {
        let Some(Building { thread, began, in_vain }) =
            self.building.take_if(|building| building.thread.is_finished())
        else {
            return Ok(());
        };
        let panicked = |_| Error::Gpu { what: "building".into(), reason: "it panicked".into() };
        let mapping = thread.join().map_err(panicked)??;
        self.context = Some(mapping.mapper.context().clone());
        let Some(reading) = self.reading.as_ref().filter(|_| !in_vain) else { return Ok(()) };
        let took_s = now.saturating_duration_since(began).as_secs_f64();
        say(&format!("maps {}, passes built in {took_s:.1} s", names(reading)));
        mapping.mapper.notes().iter().for_each(|note| say(&format!("note: {note}")));
        self.publisher.watch(reading.source.sensors())?;
        self.health.watch(reading.source.sensors());
        self.mapping = Some(mapping);
        self.health.fault = None;
        self.retry = None;
        Ok(())
    }

    /// The GPU is lost or does not answer: no free cell is left standing, and the device is opened again after a pause that
    /// grows.
    pub(super) fn fail(&mut self, error: Error, now: Instant, say: &mut dyn FnMut(&str)) -> Result<()> {
        if !matches!(error, Error::DeviceLost(_) | Error::Gpu { .. } | Error::NoAdapter { .. }) {
            return Err(error);
        }
        let pause = self.retry.map_or(RETRY_FIRST, |(_, pause)| (2 * pause).min(RETRY_LAST));
        say(&format!("FAULT: {error}; the device is opened again in {:.1} s", pause.as_secs_f64()));
        self.retry = Some((now + pause, pause));
        self.health.fault = Some(error.to_string());
        (self.mapping, self.context) = (None, None);
        self.time.forget();
        self.publisher.forget_free(&self.health)
    }
}

fn names(reading: &Reading) -> String {
    let names: Vec<_> = reading.source.sensors().iter().map(|sensor| sensor.name.as_str()).collect();
    names.join(", ")
}
