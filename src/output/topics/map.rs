//! A published map as ROS 2 messages.

use serde_bytes::Bytes;

use super::{Named, TopicSink};
use crate::base::Result;
use crate::map::{CellClass, Grid, MapUpdate, Verdict};
use crate::message::RosMessage;
use crate::message::ros2::{Header, Pose, Quaternion, Vector3};
use crate::message::written::{
    Costmap, CostmapMetaData, FoxgloveGrid, MapMetaData, OccupancyGrid, PackedElementField, Vector2,
};
use crate::output::narrow;

/// Name of the costmap layer.
const LAYER: &str = "limpid";

pub(super) const COSTMAP: &str = "costmap";
pub(super) const RAW: &str = "costmap_raw";
pub(super) const CLASSES: &str = "classes";
pub(super) const VERDICTS: &str = "verdicts";

/// Topics of the map.
pub(super) const TOPICS: [Named; 4] = [
    (COSTMAP, OccupancyGrid::TYPE),
    (RAW, Costmap::TYPE),
    (CLASSES, OccupancyGrid::TYPE),
    (VERDICTS, FoxgloveGrid::TYPE),
];

/// Writes a map whose parts fit each other.
pub(super) fn write(out: &mut impl TopicSink, stamp_ns: u64, map_frame: &str, map: &MapUpdate) -> Result<()> {
    let header = &Header::new(stamp_ns, map_frame);
    let bytes = |values: &mut dyn Iterator<Item = i8>| values.map(i8::cast_unsigned).collect::<Vec<u8>>();
    if out.wants(COSTMAP) {
        let occupancy = bytes(&mut map.costmap.iter().map(|&cost| occupancy_of_cost(cost)));
        out.put(COSTMAP, stamp_ns, &occupancy_grid(header, &map.grid, Bytes::new(&occupancy)))?;
    }
    if out.wants(RAW) {
        out.put(RAW, stamp_ns, &costmap(header, &map.grid, Bytes::new(&map.costmap)))?;
    }
    if !map.classes.is_empty() && out.wants(CLASSES) {
        let classes = bytes(&mut map.classes.iter().map(|&class| occupancy_of_class(class)));
        out.put(CLASSES, stamp_ns, &occupancy_grid(header, &map.grid, Bytes::new(&classes)))?;
    }
    if !map.verdicts.is_empty() && out.wants(VERDICTS) {
        let cells: Vec<u8> = map.verdicts.iter().flat_map(bytes_of_verdict).collect();
        out.put(VERDICTS, stamp_ns, &verdict_grid(header, &map.grid, Bytes::new(&cells)))?;
    }
    Ok(())
}

/// A grid of Nav2 costs.
pub(crate) fn costmap<'a>(header: &Header, grid: &Grid, data: &'a Bytes) -> Costmap<'a> {
    let metadata = CostmapMetaData {
        map_load_time: header.stamp,
        update_time: header.stamp,
        layer: LAYER.into(),
        resolution: narrow(grid.resolution_m),
        size_x: grid.width,
        size_y: grid.height,
        origin: origin(grid),
    };
    Costmap { header: header.clone(), metadata, data }
}

/// A grid of values 0..=100 or -1.
pub(crate) fn occupancy_grid<'a>(header: &Header, grid: &Grid, data: &'a Bytes) -> OccupancyGrid<'a> {
    let info = MapMetaData {
        map_load_time: header.stamp,
        resolution: narrow(grid.resolution_m),
        width: grid.width,
        height: grid.height,
        origin: origin(grid),
    };
    OccupancyGrid { header: header.clone(), info, data }
}

fn origin(grid: &Grid) -> Pose {
    let corner = Vector3 { x: grid.origin_x_m, y: grid.origin_y_m, z: 0.0 };
    Pose { position: corner, orientation: Quaternion::default() }
}

/// `nav_msgs/OccupancyGrid` value of a Nav2 cost, as Nav2's costmap publisher translates it:
/// 0 free, 1..=98 for costs 1..=252, 99 inscribed, 100 lethal, -1 unknown.
pub fn occupancy_of_cost(cost: u8) -> i8 {
    match cost {
        0 => 0,
        253 => 99,
        254 => 100,
        255 => -1,
        // At most 98, so the conversion cannot fail.
        graded => i8::try_from(1 + 97 * (u32::from(graded) - 1) / 251).unwrap_or(98),
    }
}

/// Bytes of a cell of the verdicts' grid; the age lies on a multiple of its size.
const VERDICT_STRIDE: u32 = 8;

/// Name, offset and `PackedElementField` type of a verdict's parts: 1 is `UINT8`, 7 `FLOAT32`.
const VERDICT_FIELDS: [(&str, u32, u8); 4] =
    [("cost", 0, 1), ("reason", 1, 1), ("sensor", 2, 1), ("age_s", 4, 7)];

/// As [`VERDICT_FIELDS`] says.
fn bytes_of_verdict(verdict: &Verdict) -> [u8; VERDICT_STRIDE as usize] {
    let [a, b, c, d] = narrow(verdict.age_s()).to_le_bytes();
    [verdict.cost(), verdict.reason(), verdict.sensor_number(), 0, a, b, c, d]
}

fn verdict_grid<'a>(header: &Header, grid: &Grid, data: &'a Bytes) -> FoxgloveGrid<'a> {
    let field =
        |(name, offset, r#type): (&str, u32, u8)| PackedElementField { name: name.into(), offset, r#type };
    FoxgloveGrid {
        timestamp: header.stamp,
        frame_id: header.frame_id.clone(),
        pose: origin(grid),
        column_count: grid.width,
        cell_size: Vector2 { x: grid.resolution_m, y: grid.resolution_m },
        row_stride: grid.width * VERDICT_STRIDE,
        cell_stride: VERDICT_STRIDE,
        fields: VERDICT_FIELDS.map(field).into(),
        data,
    }
}

/// Occupancy by which a class is shown.
fn occupancy_of_class(class: u8) -> i8 {
    match class {
        c if c == CellClass::Free as u8 => 0,
        c if c == CellClass::Passable as u8 => 25,
        c if c == CellClass::Inflated as u8 => 50,
        c if c == CellClass::Transparent as u8 => 75,
        c if c == CellClass::Solid as u8 => 100,
        _ => -1,
    }
}
