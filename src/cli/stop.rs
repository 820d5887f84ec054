//! Ctrl-C: a run ends in order with what has come so far.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use limpid::input::{Source, SourceReport};
use limpid::{Observation, Result, SensorInfo};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag::{register, register_conditional_shutdown};

/// Exit code of a program that Ctrl-C has ended, as shells give it.
pub(super) const STOPPED: u8 = 130;

static IS_STOPPED: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Has Ctrl-C, and a request to terminate, end a command in order; the second one ends it at once.
pub(super) fn listen() {
    IS_STOPPED.get_or_init(|| {
        let is_stopped = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // Where no handler can be set, the signal ends the program, and what was written stays in partial files.
            let at_once = register_conditional_shutdown(signal, STOPPED.into(), Arc::clone(&is_stopped));
            let _ = at_once.and_then(|_| register(signal, Arc::clone(&is_stopped)));
        }
        is_stopped
    });
}

/// Whether the user has asked for an end.
pub(super) fn is_stopped() -> bool {
    IS_STOPPED.get().is_some_and(|is_stopped| is_stopped.load(Ordering::Relaxed))
}

/// A source that ends where the user stops it.
pub(super) struct Stoppable<'a> {
    source: &'a mut dyn Source,
    was_stopped: bool,
}

impl<'a> Stoppable<'a> {
    /// From here on Ctrl-C stops `source`.
    pub(super) fn new(source: &'a mut dyn Source) -> Self {
        listen();
        Self { source, was_stopped: false }
    }
}

impl Source for Stoppable<'_> {
    fn sensors(&self) -> &[SensorInfo] {
        self.source.sensors()
    }

    fn next(&mut self) -> Result<Option<Observation>> {
        self.was_stopped |= is_stopped();
        if self.was_stopped { Ok(None) } else { self.source.next() }
    }

    fn report(&self) -> SourceReport {
        self.source.report()
    }

    fn count_hint(&self) -> Option<u64> {
        self.source.count_hint()
    }

    fn was_stopped(&self) -> bool {
        self.was_stopped
    }
}
