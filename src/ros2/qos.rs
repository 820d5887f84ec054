//! Qualities of service by what a topic is for.

use rustdds::policy::{Durability, History, Reliability, ResourceLimits};
use rustdds::{Duration, QosPolicies, QosPolicyBuilder};

/// How long a reliable writer blocks while a reader does not keep up. Few milliseconds: a subscriber that never reads must not
/// hold up the map.
const MAX_BLOCKING: Duration = Duration::from_millis(10);

/// What a topic is for, which says how its messages are sent and received.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quality {
    /// Sensor data: best effort, volatile, the last few.
    Sensor,
    /// Sensor data from one that offers to send again what was lost: reliable, volatile, the last few.
    SensorReliable,
    /// Events and streams that should be complete (`/tf`, updates): reliable, volatile.
    Stream {
        /// Messages kept.
        depth: u16,
    },
    /// What holds until it is replaced (`/tf_static`, a map): reliable, transient local.
    Latched {
        /// Messages kept.
        depth: u16,
    },
}

impl Quality {
    /// Messages of sensors kept by DDS.
    const SENSOR_DEPTH: u16 = 10;

    /// Messages that a reliable writer keeps for readers that do not answer, until their lease ends: the crate's own default
    /// of 8192 would be hundreds of megabytes of maps.
    const UNANSWERED: i32 = 256;

    /// Whether lost messages are sent again.
    pub fn is_reliable(self) -> bool {
        !matches!(self, Self::Sensor)
    }

    /// Whether those who come late are given what came before.
    pub fn is_latched(self) -> bool {
        matches!(self, Self::Latched { .. })
    }

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sensor => "best effort and volatile",
            Self::SensorReliable | Self::Stream { .. } => "reliable and volatile",
            Self::Latched { .. } => "reliable and transient local",
        }
    }

    /// Of a reader.
    pub(super) fn of_reader(self) -> QosPolicies {
        self.builder().build()
    }

    /// Of a writer, with bounded memory.
    pub(super) fn of_writer(self) -> QosPolicies {
        let max_samples = Self::UNANSWERED;
        let limits = ResourceLimits { max_samples, max_instances: 1, max_samples_per_instance: max_samples };
        self.builder().resource_limits(limits).build()
    }

    fn builder(self) -> QosPolicyBuilder {
        let reliable = Reliability::Reliable { max_blocking_time: MAX_BLOCKING };
        let (reliability, durability, depth) = match self {
            Self::Sensor => (Reliability::BestEffort, Durability::Volatile, Self::SENSOR_DEPTH),
            Self::SensorReliable => (reliable, Durability::Volatile, Self::SENSOR_DEPTH),
            Self::Stream { depth } => (reliable, Durability::Volatile, depth),
            Self::Latched { depth } => (reliable, Durability::TransientLocal, depth),
        };
        QosPolicyBuilder::new()
            .reliability(reliability)
            .durability(durability)
            .history(History::KeepLast { depth: i32::from(depth) })
    }
}
