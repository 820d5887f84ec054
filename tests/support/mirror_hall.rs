//! A hall with an opening in one wall, and what a lidar measures there: exact ranges, cast as rays by hand.

use glam::DVec3;
use limpid::sensor::{Columns, Point, ReturnType, Scan};

use super::scan::{point, scan};

pub(crate) const COLUMNS: u16 = 1440;
pub(crate) const RINGS: u16 = 32;
/// The wall with the opening, metres along x of the hall.
pub(crate) const WALL_X_M: f64 = 3.0;
/// The opening: y and z of its edges.
pub(crate) const OPENING: [[f64; 2]; 2] = [[-1.3, 0.6], [-0.5, 1.0]];
/// The others walls: at which x and to which y; floor and ceiling.
const BACK_X_M: f64 = -4.0;
const HALF_Y_M: f64 = 3.5;
const FLOOR_M: f64 = -0.6;
const CEILING_M: f64 = 2.2;
/// A cupboard at the back wall: from its least to its largest corner.
const CUPBOARD: [DVec3; 2] = [DVec3::new(-4.0, -1.5, -0.6), DVec3::new(-3.2, 0.2, 0.9)];
/// Heading of the lidar in the hall, radians.
const YAW: f64 = 0.4;

/// What is in the opening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Opening {
    /// Nothing: wall.
    Wall,
    Mirror,
    /// A way into a room as wide and high as the hall, so deep, metres.
    Door(f64),
}

/// A way through a box from within it: to where it leaves.
fn leaves(from: DVec3, way: DVec3, x_m: [f64; 2]) -> f64 {
    let low = DVec3::new(x_m[0], -HALF_Y_M, FLOOR_M);
    let high = DVec3::new(x_m[1], HALF_Y_M, CEILING_M);
    ((low - from) / way).max((high - from) / way).min_element()
}

fn meets(from: DVec3, way: DVec3, [low, high]: [DVec3; 2]) -> Option<f64> {
    let [a, b] = [(low - from) / way, (high - from) / way];
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    (enter > 0.0 && enter < leave).then_some(enter)
}

fn in_hall(from: DVec3, way: DVec3) -> f64 {
    let walls = leaves(from, way, [BACK_X_M, WALL_X_M]);
    meets(from, way, CUPBOARD).map_or(walls, |cupboard| cupboard.min(walls))
}

/// How far a beam from the hall's origin goes, and whether through the opening.
fn end(opening: Opening, way: DVec3) -> (f64, bool) {
    let near = in_hall(DVec3::ZERO, way);
    let at = way * near;
    let [y, z] = OPENING;
    let within =
        (at.x - WALL_X_M).abs() < 1e-6 && (y[0]..y[1]).contains(&at.y) && (z[0]..z[1]).contains(&at.z);
    match (within, opening) {
        (false, _) | (_, Opening::Wall) => (near, false),
        (_, Opening::Mirror) => (near + in_hall(at, DVec3::new(-way.x, way.y, way.z)), true),
        (_, Opening::Door(depth_m)) => (near + leaves(at, way, [WALL_X_M, WALL_X_M + depth_m]), true),
    }
}

fn direction(ring: u16, column: u16) -> DVec3 {
    let elevation = (-25.0 + 40.0 * f64::from(ring) / f64::from(RINGS - 1)).to_radians();
    let azimuth = std::f64::consts::TAU * f64::from(column) / f64::from(COLUMNS) + YAW;
    DVec3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin())
}

/// Of the hall's axes in the lidar's.
pub(crate) fn in_lidar(v: DVec3) -> DVec3 {
    glam::DQuat::from_rotation_z(-YAW) * v
}

/// The scan, in dual mode where some beams of the uppermost ring have a second return; and which points lie behind the opening.
pub(crate) fn hall(opening: Opening, dual: bool) -> (Scan, Vec<bool>) {
    let (mut points, mut behind) = (Vec::new(), Vec::new());
    for ring in 0..RINGS {
        for column in 0..COLUMNS {
            let way = direction(ring, column);
            let (range_m, through) = end(opening, way);
            let mut put = |range_m: f64, return_type| {
                let mut point = point(in_lidar(way * range_m).to_array(), 20.0);
                (point.ring, point.column, point.return_type) = (ring, column, return_type);
                points.push(Point { ..point });
                behind.push(through);
            };
            put(range_m, if dual { ReturnType::First } else { ReturnType::Single });
            if dual && ring + 1 == RINGS && column % 90 == 0 {
                put(range_m + 0.6, ReturnType::Last);
            }
        }
    }
    let columns = Columns { ring: true, column: true, return_type: dual, ..Columns::default() };
    (Scan { columns, ..scan(0, points) }, behind)
}
