//! A box room with one pane of glass in a wall, a thing on each side of it, and what a dual-return lidar measures there:
//! exact ranges, one of each beam's returns in the first slot and another in the last.

use glam::DVec3;
use limpid::map::glass::PointClass;
use limpid::sensor::{Columns, Dropped, Point, ReturnType, Scan, Strength};

pub(crate) const ROWS: u16 = 32;
pub(crate) const COLUMNS: u16 = 720;
/// The wall with the pane, metres along x.
pub(crate) const WALL_X_M: f64 = 4.0;

/// What of it there is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GlassRoom {
    /// Whether the pane is glass; else wall.
    pub(crate) glass: bool,
    /// Whether all of a pane mirrors and nothing shows through.
    pub(crate) mirror: bool,
    /// Whether the sensor gives one return a beam.
    pub(crate) single: bool,
    /// Turn of the sensor about the vertical, radians.
    pub(crate) yaw: f64,
    /// The sensor in the room, metres.
    pub(crate) sensor_m: DVec3,
}

impl Default for GlassRoom {
    fn default() -> Self {
        Self { glass: true, mirror: false, single: false, yaw: 0.4, sensor_m: DVec3::new(0.3, 0.2, 0.0) }
    }
}

/// A point's true class, and whether everything around its beam is of the same kind (and a reflection's origin is seen).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Truth {
    pub(crate) class: PointClass,
    pub(crate) away_from_edges: bool,
}

/// A box from its least to its largest corner.
type Solid = [DVec3; 2];

const fn corner(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// The pane: y and z of its edges.
const PANE: [[f64; 2]; 2] = [[-2.0, 2.0], [-0.9, 1.4]];
const ROOM: Solid = [corner(-4.0, -3.5, -1.2), corner(WALL_X_M, 3.5, 1.8)];
/// A cupboard in a corner behind the sensor.
const INDOORS: Solid = [corner(-4.0, 1.5, -1.2), corner(-3.0, 3.5, 0.9)];
/// A thing behind the pane, nearer than the mirrored back of the room.
const OUTDOORS: Solid = [corner(6.4, -1.6, -1.2), corner(6.9, -0.3, -0.2)];
/// The house opposite.
const FAR_X_M: f64 = 16.0;
/// Within this angle of head on, glass returns the beam (spec 3 §1).
const VISIBLE_DEG: f64 = 20.0;

/// Ways along a ray to where it enters and leaves a box.
fn enter_leave(from: DVec3, way: DVec3, [low, high]: Solid) -> (f64, f64) {
    let [a, b] = [(low - from) / way, (high - from) / way];
    (a.min(b).max_element(), a.max(b).min_element())
}

fn hit(from: DVec3, way: DVec3, solid: Solid) -> Option<f64> {
    let (enter, leave) = enter_leave(from, way, solid);
    (enter > 0.0 && enter < leave).then_some(enter)
}

/// The way to the first surface of the room from within it.
fn indoors(from: DVec3, way: DVec3) -> f64 {
    let wall = enter_leave(from, way, ROOM).1;
    hit(from, way, INDOORS).map_or(wall, |near| near.min(wall))
}

/// What one beam returns, nearest first: way in metres, class, intensity.
fn returns(room: &GlassRoom, way: DVec3) -> Vec<(f64, PointClass, f32)> {
    let first = indoors(room.sensor_m, way);
    let at = room.sensor_m + way * first;
    let [y, z] = PANE;
    let on_wall = (at.x - WALL_X_M).abs() < 1e-6;
    let on_pane = on_wall && (y[0]..y[1]).contains(&at.y) && (z[0]..z[1]).contains(&at.z);
    if !(room.glass && on_pane) {
        return vec![(first, PointClass::Inside, 120.0)];
    }
    let mut list = Vec::new();
    let angle = way.x.acos().to_degrees();
    if angle < VISIBLE_DEG && !room.mirror {
        let lobe = 200.0 * (-(angle / 6.0).powi(2)).exp();
        list.push((first, PointClass::Glass, 20.0 + lobe as f32));
    }
    let mirrored = first + indoors(at, DVec3::new(-way.x, way.y, way.z));
    let far = (FAR_X_M - room.sensor_m.x) / way.x;
    let through = hit(room.sensor_m, way, OUTDOORS).map_or(far, |near| near.min(far));
    // The upper half mirrors, the lower half shows what is outside.
    if room.mirror || at.z > 0.2 {
        list.push((mirrored, PointClass::Reflection, 15.0));
    } else {
        list.push((through, PointClass::Outside, 30.0));
    }
    list
}

impl GlassRoom {
    fn way(&self, row: i32, column: i32) -> DVec3 {
        let elevation = (f64::from(row) - 15.5) * 2.0_f64.to_radians();
        let azimuth = f64::from(column) * std::f64::consts::TAU / f64::from(COLUMNS) + self.yaw;
        let level = elevation.cos();
        DVec3::new(level * azimuth.cos(), level * azimuth.sin(), elevation.sin())
    }

    /// The direction of the pane's normal in the sensor's frame, and the pane's distance.
    pub(crate) fn plane(&self) -> (DVec3, f64) {
        (DVec3::new(self.yaw.cos(), -self.yaw.sin(), 0.0), WALL_X_M - self.sensor_m.x)
    }

    /// Whether the sensor also sees directly what it sees at the end of this way in the pane: only then can a scan prove a
    /// reflection.
    fn seen_directly(&self, end_m: DVec3) -> bool {
        let place = DVec3::new(2.0 * (WALL_X_M - self.sensor_m.x) - end_m.x, end_m.y, end_m.z);
        let way = place.normalize();
        let highest = (0.5 * f64::from(ROWS) - 0.5) * 2.0;
        way.z.asin().to_degrees().abs() < highest && indoors(self.sensor_m, way) > place.length() - 0.05
    }

    /// Classes of all beams around one are as its own, and ranges differ little.
    fn even(&self, row: i32, column: i32) -> bool {
        let here = returns(self, self.way(row, column));
        (-1..=1).all(|r| {
            (-3..=3).all(|c| {
                let other = returns(self, self.way(row + r, column + c));
                let alike = |(a, b): (&(f64, PointClass, f32), &(f64, PointClass, f32))| {
                    a.1 == b.1 && (a.0 - b.0).abs() < 0.2 * a.0
                };
                here.len() == other.len() && here.iter().zip(&other).all(alike)
            })
        })
    }

    /// The scan, and the truth of each of its points.
    pub(crate) fn scan(&self) -> (Scan, Vec<Truth>) {
        let (mut points, mut truth) = (Vec::new(), Vec::new());
        for row in 0..ROWS {
            for column in 0..COLUMNS {
                let (r, c) = (i32::from(row), i32::from(column));
                let mut list = returns(self, self.way(r, c));
                list.truncate(if self.single { 1 } else { 2 });
                let away_from_edges = list[0].1 != PointClass::Inside && self.even(r, c);
                for (number, &(range_m, class, intensity)) in list.iter().enumerate() {
                    let turned = self.way(r, c) * range_m;
                    let (sin, cos) = (-self.yaw).sin_cos();
                    let return_type = if number == 0 { ReturnType::First } else { ReturnType::Last };
                    points.push(Point {
                        x_m: (turned.x * cos - turned.y * sin) as f32,
                        y_m: (turned.x * sin + turned.y * cos) as f32,
                        z_m: turned.z as f32,
                        intensity,
                        time_s: 0.0,
                        ring: row,
                        column,
                        return_type,
                        strength: Strength::Unknown,
                        reserved: 0,
                        label: Point::UNLABELLED,
                    });
                    let decidable = match class {
                        PointClass::Inside => true,
                        PointClass::Reflection => away_from_edges && self.seen_directly(turned),
                        _ => away_from_edges,
                    };
                    truth.push(Truth { class, away_from_edges: decidable });
                }
            }
        }
        let columns = Columns { ring: true, column: true, return_type: true, ..Columns::default() };
        let frame_id = "lidar".into();
        (Scan { index: 0, stamp_ns: 0, frame_id, points, columns, dropped: Dropped::default() }, truth)
    }
}
