//! Ctrl-C and SIGTERM: a wish to end, which whoever waits looks for.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::base::{Error, Result};

/// Longest sleep between two looks.
pub(super) const LOOK: Duration = Duration::from_millis(20);

/// Whether to end. Clones tell of the same wish.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// One that Ctrl-C and SIGTERM set.
    ///
    /// # Errors
    /// [`Error::Ros2`] where the system takes no handler.
    pub fn on_signals() -> Result<Self> {
        let stop = Self::default();
        let failed =
            |error: std::io::Error| Error::Ros2 { what: "signals".into(), reason: error.to_string() };
        for signal in [SIGINT, SIGTERM] {
            flag::register(signal, Arc::clone(&stop.0)).map_err(failed)?;
        }
        Ok(stop)
    }

    /// Asks for the end.
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether somebody asked for the end.
    pub fn is_set(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Sleeps until `until`, or until the end is asked for; whether it is.
    pub fn sleep(&self, until: Instant) -> bool {
        loop {
            let left = until.saturating_duration_since(Instant::now());
            if self.is_set() || left.is_zero() {
                return self.is_set();
            }
            thread::sleep(left.min(LOOK));
        }
    }
}
