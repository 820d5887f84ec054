//! Whether DDS still runs.
//!
//! RustDDS waits for packets in two threads, which end for good when a wait is interrupted (seen in 0.15.1): where the process is
//! stopped and goes on, where the computer slept, where a debugger is attached. Nothing tells of it: messages are taken and never
//! leave.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// The system's list of the threads of this process.
const THREADS: &str = "/proc/self/task";

/// What the names of DDS's threads begin with, and how many a participant has.
const NAME: &str = "RustDDS";
const COUNT: usize = 2;

/// A thread names itself only once it runs.
const PATIENCE: Duration = Duration::from_secs(1);

/// One participant after the other, so that new threads are its own.
static JOINING: Mutex<()> = Mutex::new(());

/// Which threads a participant lives by; none where the system does not list them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Vigil {
    threads: BTreeSet<PathBuf>,
}

impl Vigil {
    /// Does what starts a participant, and watches over its threads from then on.
    pub(super) fn of<T, E>(start: impl FnOnce() -> Result<T, E>) -> Result<(T, Self), E> {
        let _alone = JOINING.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let before = threads();
        let started = start()?;
        let until = Instant::now() + PATIENCE;
        loop {
            let threads: BTreeSet<PathBuf> = threads().difference(&before).cloned().collect();
            if threads.len() >= COUNT || before.is_empty() && threads.is_empty() && !listed() {
                return Ok((started, Self { threads }));
            }
            if Instant::now() >= until {
                // Not what is expected of this DDS: then nothing is said of it.
                return Ok((started, Self::default()));
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Whether none of the threads has ended.
    pub(super) fn all_run(&self) -> bool {
        self.threads.iter().all(|thread| is_named(thread))
    }
}

fn listed() -> bool {
    std::fs::read_dir(THREADS).is_ok()
}

/// DDS's threads in this process.
fn threads() -> BTreeSet<PathBuf> {
    let entries = std::fs::read_dir(THREADS).into_iter().flatten().flatten();
    entries.map(|entry| entry.path()).filter(|thread| is_named(thread)).collect()
}

fn is_named(thread: &Path) -> bool {
    std::fs::read_to_string(thread.join("comm")).is_ok_and(|name| name.starts_with(NAME))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(until: std::sync::mpsc::Receiver<()>) -> std::thread::JoinHandle<()> {
        let builder = std::thread::Builder::new().name(format!("{NAME} of a test"));
        builder.spawn(move || until.recv().unwrap_or_default()).unwrap()
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn an_end_of_a_thread_of_its_own_is_seen_and_no_other() {
        let (first, second) = (std::sync::mpsc::channel(), std::sync::mpsc::channel());
        let other = std::sync::mpsc::channel();
        let stranger = named(other.1);
        // It has its name only once it runs.
        while threads().is_empty() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let start = || Ok::<_, ()>([named(first.1), named(second.1)]);
        let ([one, two], vigil) = Vigil::of(start).unwrap();
        assert_eq!(vigil.threads.len(), COUNT);
        assert!(vigil.all_run());
        drop(other.0);
        stranger.join().unwrap();
        assert!(vigil.all_run());
        drop(second.0);
        two.join().unwrap();
        let until = Instant::now() + PATIENCE;
        while vigil.all_run() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert!(!vigil.all_run());
        drop(first.0);
        one.join().unwrap();
        assert!(Vigil::default().all_run(), "where nothing is known nothing is said");
    }
}
