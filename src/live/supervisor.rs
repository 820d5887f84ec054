//! What systemd is told (sd_notify): that the node is up, that it still turns, that it ends.

use std::env;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::time::{Duration, Instant};

/// Tells a supervisor, where there is one.
pub(super) struct Supervisor {
    to: Option<(UnixDatagram, SocketAddr)>,
    /// How often it wants to hear.
    period: Option<Duration>,
    told: Instant,
}

impl Supervisor {
    /// As `NOTIFY_SOCKET` and `WATCHDOG_USEC` say.
    pub(super) fn of_environment() -> Self {
        let watchdog = env::var("WATCHDOG_USEC").ok().and_then(|micros| micros.parse().ok());
        Self::new(env::var("NOTIFY_SOCKET").ok().as_deref(), watchdog.map(Duration::from_micros))
    }

    fn new(socket: Option<&str>, watchdog: Option<Duration>) -> Self {
        let address = socket.and_then(|socket| match socket.strip_prefix('@') {
            Some(name) => SocketAddr::from_abstract_name(name).ok(),
            None => SocketAddr::from_pathname(socket).ok(),
        });
        let to = address.and_then(|address| Some((UnixDatagram::unbound().ok()?, address)));
        // Three times within the time after which it takes the node for dead.
        Self { to, period: watchdog.map(|watchdog| watchdog / 3), told: Instant::now() }
    }

    pub(super) fn ready(&self) {
        self.tell("READY=1");
    }

    pub(super) fn stopping(&self) {
        self.tell("STOPPING=1");
    }

    /// The node turns.
    pub(super) fn alive(&mut self, now: Instant) {
        if self.period.is_some_and(|period| now.saturating_duration_since(self.told) >= period) {
            self.told = now;
            self.tell("WATCHDOG=1");
        }
    }

    fn tell(&self, what: &str) {
        if let Some((socket, address)) = &self.to {
            // A supervisor that does not listen is no reason to stop.
            let _ = socket.send_to_addr(what.as_bytes(), address);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_supervisor_hears_that_the_node_is_up_turns_and_ends() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notify");
        let socket = UnixDatagram::bind(&path).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let mut supervisor = Supervisor::new(path.to_str(), Some(Duration::from_secs(30)));
        let begun = Instant::now();
        supervisor.ready();
        supervisor.alive(begun + Duration::from_secs(1));
        supervisor.alive(begun + Duration::from_secs(11));
        supervisor.alive(begun + Duration::from_secs(12));
        supervisor.stopping();
        let heard = || {
            let mut bytes = [0; 32];
            let length = socket.recv(&mut bytes).unwrap();
            String::from_utf8_lossy(&bytes[..length]).into_owned()
        };
        assert_eq!([heard(), heard(), heard()], ["READY=1", "WATCHDOG=1", "STOPPING=1"]);
    }
}
