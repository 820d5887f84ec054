//! What a run tells its user in words.

use super::RunReport;
use crate::config::Method;
use crate::mapper::SensorInfo;
use crate::sensor::{DepthSpread, SensorKind, SensorModel};
use crate::stage::camera::ingest::depth_range_m;

/// Share of a camera's depth beyond the range that is used, from which its unit is in doubt.
const ODD_SHARE: f64 = 0.6;

/// How many times farther than the range reaches, or nearer than it begins, the median must be as well.
const ODD_TIMES: f64 = 1.5;

/// Fewest depths that tell of the unit.
const LEAST_DEPTHS: u64 = 200;

/// What method `auto` comes to.
pub(super) fn method(sensor: &SensorInfo) -> Option<String> {
    let SensorModel::Camera(info) = &sensor.model else { return None };
    let note = match &sensor.color_missing {
        None if info.color.is_some() => {
            "method drm: depth is weighed by DRM-Net with colour; a frame whose colour cannot be used counts by its depth alone, as under method range".into()
        }
        why => {
            let why = why.as_deref().unwrap_or("they have none");
            format!("method range: no colour among the first frames that method drm could use: {why}")
        }
    };
    (sensor.config.method == Method::Auto).then_some(note)
}

/// That nearly all depth of a camera lies beyond what is used of it, which is so where its unit is another.
pub(super) fn depth(sensor: &SensorInfo, spread: &DepthSpread) -> Option<String> {
    let SensorModel::Camera(info) = &sensor.model else { return None };
    let config = sensor.config.resolved(info.color.is_some() && sensor.color_missing.is_none());
    let (nearest_m, farthest_m) = depth_range_m(&config);
    let (nearest_m, farthest_m) = (nearest_m.max(config.depth_min_m), farthest_m.min(config.depth_max_m));
    let median_m = spread.median_m()?;
    if spread.count() < LEAST_DEPTHS {
        return None;
    }
    let (unit_key, unit_m) = match info.float_depth {
        true => ("float_depth_unit_m", config.float_depth_unit_m),
        false => ("depth_unit_m", config.depth_unit_m),
    };
    let near_share = 1.0 - spread.share_beyond(nearest_m);
    let (share, place, key, limit_m) = if median_m > ODD_TIMES * farthest_m {
        let key = if farthest_m < config.depth_max_m { "range_gate_m" } else { "depth_max_m" };
        (spread.share_beyond(farthest_m), "beyond", key, farthest_m)
    } else if median_m < nearest_m / ODD_TIMES {
        (near_share, "nearer than", "depth_min_m", nearest_m)
    } else {
        return None;
    };
    if share < ODD_SHARE {
        return None;
    }
    // The power of ten that puts the median between half a metre and five.
    let tens = -(median_m / 0.5).log10().floor();
    let likely_m = format!("{:.9}", unit_m * 10_f64.powf(tens));
    Some(format!(
        "{}: {:.0} % of its depth lies {place} `{key}` = {limit_m} m, where it is not used (the median is {} m). \
         Is its unit another than `{unit_key}` = {unit_m}? {unit_key}: {} would make the median {} m",
        sensor.name,
        share * 100.0,
        rounded(median_m),
        likely_m.trim_end_matches('0'),
        rounded(median_m * 10_f64.powf(tens)),
    ))
}

/// Metres to two digits or so.
fn rounded(m: f64) -> String {
    match m {
        10.0.. => format!("{m:.0}"),
        1.0.. => format!("{m:.1}"),
        _ => format!("{m:.3}"),
    }
}

/// Why nothing was used, from what was counted, in words of the sensors that there are.
pub(super) fn nothing_used(report: &RunReport, kinds: &[SensorKind]) -> String {
    if let Some(reason) = report.sensors.iter().find_map(|sensor| sensor.first_refused.as_ref()) {
        return reason.clone();
    }
    let skipped = report.read.read.skipped.iter();
    let reasons: Vec<_> =
        skipped.map(|s| format!("{}: {} ({} times)", s.source, s.reason, s.count)).take(3).collect();
    let seen: u64 = report.read.sensors.iter().map(|sensor| sensor.seen).sum();
    let alone = |kind| kinds.iter().all(|&other| other == kind);
    let [what, no] = if alone(SensorKind::Lidar) {
        ["scans", "no scan with points"]
    } else if alone(SensorKind::Camera) {
        ["depth images", "no depth image"]
    } else {
        ["depth images and scans", "no depth image and no scan with points"]
    };
    match (seen, reasons.is_empty()) {
        (0, true) => format!("it holds {no}"),
        (seen, true) => format!("none of its {seen} {what} lies in the wanted range"),
        (seen, false) => format!("{seen} {what} seen; {}", reasons.join("; ")),
    }
}
