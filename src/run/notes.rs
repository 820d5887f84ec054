//! What a run tells its user in words.

use super::RunReport;
use crate::base::Error;
use crate::config::Method;
use crate::mapper::SensorInfo;
use crate::sensor::{DepthSpread, SensorModel};
use crate::stage::camera::ingest::depth_range_m;

/// Share of a camera's depth beyond the range that is used, from which its unit is in doubt.
const ODD_SHARE: f64 = 0.6;

/// How many times farther than the range reaches, or nearer than it begins, the median must be as well.
const ODD_TIMES: f64 = 1.5;

/// Fewest depths that tell of the unit.
const LEAST_DEPTHS: u64 = 200;

/// What method `auto` comes to.
pub fn method_note(sensor: &SensorInfo) -> Option<String> {
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

/// The error where nothing was used, from what was counted.
pub(super) fn nothing_used(report: &RunReport, sensors: &[SensorInfo]) -> Error {
    let refused = report.sensors.iter().filter_map(|sensor| {
        let first = sensor.first_refused.as_ref()?;
        Some(format!("{}: refused {}, the first: {first}", sensor.name, sensor.refused))
    });
    report.read.nothing_used(sensors, refused.collect())
}
