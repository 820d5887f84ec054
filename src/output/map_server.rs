//! The final map as nav2's map_server reads it: a PGM picture and a YAML file.

use std::path::{Path, PathBuf};

use crate::base::Result;
use crate::map::{CellClass, Grid, MapUpdate, Verdict};
use crate::output::{encode_error, grid_mismatch, save_pair};

const OCCUPIED: u8 = 0;
const FREE: u8 = 254;
const UNKNOWN: u8 = 205;

/// Writes `<stem>.pgm` and `<stem>.yaml` (trinary) and returns the two paths. `stem` is a path
/// without extension; a folder gets `map.pgm` and `map.yaml`.
///
/// Lethal cells (254) are occupied. A cell is free only where it is known to be: 255 is unknown, and so are inscribed cells
/// (253), since inflation overwrites unknown from there up, unless they are known to be free under it: by their verdict
/// (free or passable) where the map has verdicts, else by their class (free or passable) where it has classes.
/// Costs up to 252 are free, however near an obstacle: a map holds obstacles, and the planner's own inflation layer
/// adds its margin; inflation saved as obstacles would be inflated twice.
///
/// The thresholds are those with which the three grey values come back as they were written: grey 205
/// reads as (255 - 205) / 255 = 0.19608, above 0.196 and so unknown. (With the 0.25 that older nav2
/// releases wrote, unknown space would come back as free.)
///
/// # Errors
/// [`crate::Error::File`] where a file cannot be written (older ones then stay), [`crate::Error::Encode`] where costs, verdicts or classes
/// are not `width * height` cells.
pub fn save_map(stem: &Path, map: &MapUpdate) -> Result<[PathBuf; 2]> {
    if let Some(reason) = grid_mismatch(map) {
        return Err(encode_error(stem, reason));
    }
    let costs = &map.costmap;
    let known_free = |cell: usize| match (map.verdicts.get(cell), map.classes.get(cell)) {
        (Some(verdict), _) => verdict_is_free(*verdict),
        (None, Some(&class)) => class == CellClass::Free as u8 || class == CellClass::Passable as u8,
        (None, None) => false,
    };
    let greys = costs.iter().enumerate().map(|(cell, &cost)| grey_of_cost(cost, known_free(cell)));
    save(stem, &map.grid, greys.collect())
}

/// Whether the rule says free or passable.
fn verdict_is_free(verdict: Verdict) -> bool {
    verdict.row() != 0 && verdict.cost() < 253
}

fn save(stem: &Path, grid: &Grid, greys: Vec<u8>) -> Result<[PathBuf; 2]> {
    let [picture, description] = map_files(stem);
    let name = picture.file_name().unwrap_or_default().to_string_lossy();
    save_pair((&picture, &pgm(grid, &greys)), (&description, yaml(grid, &name).as_bytes()))?;
    Ok([picture, description])
}

/// The two files that [`save_map`] writes for `stem`.
pub fn map_files(stem: &Path) -> [PathBuf; 2] {
    let stem = if stem.is_dir() { stem.join("map") } else { stem.to_owned() };
    ["pgm", "yaml"].map(|extension| with_suffix(&stem, extension))
}

/// Appends, where `Path::with_extension` would cut `map.v2` short.
fn with_suffix(stem: &Path, extension: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    name.into()
}

/// Binary PGM with the largest y in the top row; the greys fill the grid.
fn pgm(grid: &Grid, greys: &[u8]) -> Vec<u8> {
    let (width, height) = (grid.width, grid.height);
    let mut bytes = format!("P5\n{width} {height}\n255\n").into_bytes();
    for row in greys.chunks_exact(width as usize).rev() {
        bytes.extend(row);
    }
    bytes
}

/// Grey of a cell; `free` where it is known to be free under its cost.
fn grey_of_cost(cost: u8, free: bool) -> u8 {
    match cost {
        254 => OCCUPIED,
        255 => UNKNOWN,
        253 if !free => UNKNOWN,
        _ => FREE,
    }
}

fn yaml(grid: &Grid, picture_name: &str) -> String {
    // A JSON string is a YAML string, whatever the name holds.
    let image = serde_json::Value::from(picture_name);
    let Grid { origin_x_m, origin_y_m, resolution_m, .. } = grid;
    format!(
        "image: {image}\nmode: trinary\nresolution: {resolution_m}\norigin: [{origin_x_m:?}, {origin_y_m:?}, 0.0]\n\
         negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
}
