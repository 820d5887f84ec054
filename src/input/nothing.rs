//! Why nothing of a recording was used: what was seen, and the causes that were counted.

use std::cmp::Reverse;

use crate::base::Error;
use crate::config::SensorInfo;
use crate::input::{ReadReport, SourceReport};
use crate::sensor::SensorKind;

/// Most causes that an error lists, apart from missing poses.
const MAX_CAUSES: usize = 3;

/// What of sensors there is none of, in words of those that there are.
fn none_of(sensors: &[SensorInfo]) -> &'static str {
    let alone = |kind| sensors.iter().all(|sensor| sensor.model.kind() == kind);
    match (alone(SensorKind::Lidar), alone(SensorKind::Camera)) {
        (true, false) => "no scan with points",
        (false, true) => "no depth image",
        _ => "no depth image and no scan with points",
    }
}

impl ReadReport {
    /// What was damaged; what was passed over, most frequent first; why there are no poses.
    pub(crate) fn causes(&self) -> impl Iterator<Item = String> {
        let damage = self.damage.iter().take(MAX_CAUSES).cloned();
        let mut skipped: Vec<_> = self.skipped.iter().collect();
        skipped.sort_by_key(|skipped| Reverse(skipped.count));
        let counted = skipped.into_iter().map(|s| format!("{}: {} ({} times)", s.source, s.reason, s.count));
        damage.chain(counted.take(MAX_CAUSES)).chain(self.frames.iter().cloned())
    }
}

impl SourceReport {
    /// The error where nothing was used; `refused`: what the mapper refused, in words.
    pub(crate) fn nothing_used(&self, sensors: &[SensorInfo], refused: Vec<String>) -> Error {
        let (damage, causes): (Vec<_>, Vec<_>) =
            self.read.causes().partition(|cause| self.read.damage.contains(cause));
        let causes: Vec<_> = damage.into_iter().chain(refused).chain(causes).collect();
        let seen: u64 = self.sensors.iter().map(|sensor| sensor.seen).sum();
        let reason = match (seen, causes.is_empty()) {
            (0, true) => format!("it holds {}", none_of(sensors)),
            (_, true) => format!("none of its {} lies in the wanted range", self.seen(sensors)),
            (_, false) => format!("{} seen; {}", self.seen(sensors), causes.join("; ")),
        };
        Error::Empty { reason }
    }

    /// How much of what was seen: `12 depth images and 4 scans`.
    fn seen(&self, sensors: &[SensorInfo]) -> String {
        let of_kind = |kind: SensorKind| {
            let of_kind =
                sensors.iter().zip(&self.sensors).filter(move |(info, _)| info.model.kind() == kind);
            of_kind.map(|(_, sensor)| sensor.seen)
        };
        let kinds = [(SensorKind::Camera, "depth images"), (SensorKind::Lidar, "scans")];
        let there = kinds.into_iter().filter(|&(kind, _)| of_kind(kind).next().is_some());
        let counts = there.map(|(kind, name)| format!("{} {name}", of_kind(kind).sum::<u64>()));
        counts.collect::<Vec<_>>().join(" and ")
    }
}
