//! Panes as YAML.

use std::fmt::Write as _;
use std::path::Path;

use glam::{DVec3, Vec3, Vec4};
use serde::Deserialize;

use crate::base::{Error, Result, plain};
use crate::map::KEPT_PANES;
use crate::map::Pane;
use crate::map::PaneSet;

/// How far a normal or an axis may be from length 1, and from upright on each other.
const UNIT_TOLERANCE: f32 = 1e-3;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PaneFile {
    /// Files from before coordinates had an origin of their own count from that of the map.
    #[serde(default)]
    origin_m: [f64; 3],
    panes: Vec<PaneRecord>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PaneRecord {
    id: u32,
    normal: [f32; 3],
    distance_m: f32,
    level_axis: [f32; 3],
    extent_m: [f32; 4],
    bright_above: f32,
    hits: u32,
    misses: u32,
    age: u32,
}

/// The panes as YAML, with coordinates x from `origin_m` in the map: the plane `normal . x = distance_m`, and the least and
/// largest values of u = `level_axis . x` and of v = (`normal` x `level_axis`) . x. Of a mirror `bright_above` is below 0.
pub fn panes_to_yaml(set: &PaneSet) -> String {
    let list =
        |values: &[f32]| values.iter().map(|value| format!("{value:?}")).collect::<Vec<_>>().join(", ");
    let PaneSet { origin_m, panes } = set;
    let mut text = String::from("# Panes of glass in the map frame, metres from origin_m.\n");
    // Writing into a String cannot fail.
    let _ = writeln!(text, "origin_m: {:?}\npanes:", origin_m.to_array());
    text.truncate(text.len() - 1);
    text += if panes.is_empty() { " []\n" } else { "\n" };
    for pane in panes {
        let _ = write!(
            text,
            "  - id: {}\n    normal: [{}]\n    distance_m: {:?}\n    level_axis: [{}]\n    extent_m: [{}]\n    \
             bright_above: {:?}\n    hits: {}\n    misses: {}\n    age: {}\n",
            pane.id,
            list(&pane.unit_normal().to_array()),
            pane.normal.w,
            list(&pane.level.truncate().to_array()),
            list(&pane.extent_m.to_array()),
            pane.level.w,
            pane.hits,
            pane.misses,
            pane.age
        );
    }
    text
}

/// The panes of a file as [`panes_to_yaml`] writes it.
///
/// # Errors
/// [`Error::File`]; [`Error::Format`] for other content, an origin that is not finite, planes that are none, and more than 16
/// panes.
pub fn read_panes(path: &Path) -> Result<PaneSet> {
    let bad = |reason: String| Error::Format { path: path.into(), reason };
    let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
    let file: PaneFile = serde_saphyr::from_str(&text).map_err(|error| bad(plain(&error)))?;
    if file.panes.len() > KEPT_PANES {
        return Err(bad(format!("{} panes; at most {KEPT_PANES} are kept", file.panes.len())));
    }
    let origin_m = DVec3::from(file.origin_m);
    if !origin_m.is_finite() {
        return Err(bad("origin_m is not finite".into()));
    }
    let panes = file.panes.iter().map(|record| pane(record).map_err(&bad)).collect::<Result<_>>()?;
    Ok(PaneSet { origin_m, panes })
}

fn pane(record: &PaneRecord) -> Result<Pane, String> {
    let (normal, level) = (Vec3::from(record.normal), Vec3::from(record.level_axis));
    let unit = |v: Vec3| (v.length() - 1.0).abs() < UNIT_TOLERANCE;
    let [u0, u1, v0, v1] = record.extent_m;
    let finite =
        record.extent_m.iter().chain([&record.distance_m, &record.bright_above]).all(|v| v.is_finite());
    let sound = unit(normal) && unit(level) && normal.dot(level).abs() < UNIT_TOLERANCE;
    if record.id == 0 || !finite || !sound || u0 >= u1 || v0 >= v1 {
        return Err(format!(
            "pane {} is none: an id from 1, unit axes at right angles, extents that grow",
            record.id
        ));
    }
    Ok(Pane {
        normal: normal.extend(record.distance_m),
        level: level.extend(record.bright_above),
        extent_m: Vec4::from(record.extent_m),
        id: record.id,
        hits: record.hits,
        misses: record.misses,
        age: record.age,
    })
}
