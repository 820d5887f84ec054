//! Ground truth of simulated recordings: the true map as the camera could have seen it so far, and its reader.
//!
//! | topic in MCAP | file in a folder | content |
//! |---|---|---|
//! | `/truth/depth/image_raw` (`32FC1`) | `truth/depth/NNNNNN.exr` | depth of the first surface, glass included, metres; 0: none |
//! | `/truth/material/image_raw` (`mono8`) | `truth/material/NNNNNN.png` | its [`Kind`](super::material::Kind)'s code |
//! | `/truth/map` (`nav_msgs/OccupancyGrid`) | `truth/map/NNNNNN.png`, `truth/map.yaml` | [`TrueMap::cells`]; in pictures code + 1, row 0 = smallest y |
//! | `/truth/scene` (`std_msgs/String`) | `truth/scene.yaml` | the scene |
//! | `/truth/all` (`nav_msgs/OccupancyGrid`) | | where there is a lidar: [`TrueMap::all_cells`] |
//! | `/truth/points` (`PointCloud2`) | | of each point of a scan: its true place in the map, and [`PointTruth`](super::lidar::PointTruth) |

mod read;

use std::collections::BTreeMap;

pub use read::{TruthFrame, TruthReader};

use glam::{DVec2, DVec3};

use super::footprint::{Footprint, Shape, footprints, standing};
use super::frame::SimFrame;
use super::scene::Scene;
use super::trajectory::seconds_at;
use super::walker::Walker;
use super::walls::is_inside;
use crate::base::Rigid;
use crate::config::Config;
use crate::map::Grid;
use crate::sensor::CameraModel;

/// Cell not seen so far, or never to be: behind panes, inside things.
pub const UNKNOWN: i8 = -1;
/// Cell without anything in the height band, seen so far.
pub const FREE: i8 = 0;
/// Cell with something in the height band, a surface of which was seen.
pub const OCCUPIED: i8 = 100;
/// The same, where all that stands there is glass.
pub const GLASS: i8 = 99;
/// The same, where all that stands there can be passed: grass, strings.
pub const PASSABLE: i8 = 50;

/// Margin around the rooms, metres.
const MARGIN_M: f64 = 0.5;

/// True points within this height are on the floor.
const ON_FLOOR_M: f64 = 0.02;

/// Heights at which rays are taken to cross a cell, as shares of the height band.
const LEVELS: [f64; 10] = [0.01, 0.05, 0.1, 0.18, 0.27, 0.37, 0.48, 0.63, 0.8, 0.98];

/// What stands in a cell, the one that counts last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Content {
    /// No room.
    Outside,
    Nothing,
    /// Grass, strings.
    Passable,
    Glass,
    Solid,
}

/// The true map of a scene in the map frame, and which of its cells the camera could have seen.
///
/// A cell is occupied where a surface lies in it within the height band, and counts once a pixel's true point
/// lay in it. It is free where nothing stands in the band, once a ray crossed it in the band, or met the floor in
/// it, before its end. Range, height band and cells are those of the configuration (spec 1 §3 and §6).
#[derive(Debug, Clone)]
pub struct TrueMap {
    grid: Grid,
    band_m: [f64; 2],
    range_m: f64,
    contents: Vec<Content>,
    seen: Vec<bool>,
    walkers: Vec<Walker>,
    /// Cells in which a person is now, and whether the frame shows a surface there.
    people: BTreeMap<usize, bool>,
}

impl TrueMap {
    /// Nothing seen yet.
    pub fn new(scene: &Scene, config: &Config) -> Self {
        let bound = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| {
            scene.rooms.iter().map(|r| pick(r.min_m[axis], r.max_m[axis])).fold(start, pick)
        };
        let low = [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY) - MARGIN_M);
        let high = [0, 1].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY) + MARGIN_M);
        let resolution_m = config.resolution_m;
        let first = low.map(|at| (at / resolution_m).floor());
        let count = |axis: usize| whole((high[axis] / resolution_m).ceil() - first[axis]);
        let grid = Grid {
            origin_x_m: first[0] * resolution_m,
            origin_y_m: first[1] * resolution_m,
            resolution_m,
            width: count(0),
            height: count(1),
        };
        let cells = grid.width as usize * grid.height as usize;
        let band_m = [config.height_min_m, config.height_max_m];
        let range_m = config.mark_range_m;
        let (contents, seen) = (vec![Content::Outside; cells], vec![false; cells]);
        let (walkers, people) = (scene.walkers.clone(), BTreeMap::new());
        let mut map = Self { grid, band_m, range_m, contents, seen, walkers, people };
        for (cell, content) in map.contents.iter_mut().enumerate() {
            let [x, y] = [cell % grid.width as usize, cell / grid.width as usize].map(coordinate);
            let at =
                DVec2::new(x + 0.5, y + 0.5) * resolution_m + DVec2::new(grid.origin_x_m, grid.origin_y_m);
            if is_inside(scene, at.x, at.y) {
                *content = Content::Nothing;
            }
        }
        for thing in footprints(scene) {
            map.put(&thing);
        }
        map
    }

    /// Where the cells lie.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    fn cell(&self, at: DVec2) -> Option<usize> {
        let x = ((at.x - self.grid.origin_x_m) / self.grid.resolution_m).floor();
        let y = ((at.y - self.grid.origin_y_m) / self.grid.resolution_m).floor();
        let inside = x >= 0.0 && y >= 0.0 && x < self.grid.width.into() && y < self.grid.height.into();
        inside.then(|| whole(y) as usize * self.grid.width as usize + whole(x) as usize)
    }

    fn center(&self, x: u32, y: u32) -> DVec2 {
        let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) * self.grid.resolution_m;
        at + DVec2::new(self.grid.origin_x_m, self.grid.origin_y_m)
    }

    /// Marks the cells that a thing touches within the height band.
    fn put(&mut self, thing: &Footprint) {
        let content = match (thing.glass, thing.passable) {
            (true, _) => Content::Glass,
            (_, true) => Content::Passable,
            _ => Content::Solid,
        };
        for cell in self.touched(thing) {
            self.contents[cell] = self.contents[cell].max(content);
        }
    }

    /// Cells that a thing touches, where it reaches into the height band; some more than once.
    fn touched(&self, thing: &Footprint) -> Vec<usize> {
        if thing.span_m[1] < self.band_m[0] || thing.span_m[0] > self.band_m[1] {
            return Vec::new();
        }
        let mut touched = Vec::new();
        for y in 0..self.grid.height {
            for x in 0..self.grid.width {
                if thing.shape.distance_m(self.center(x, y)) == 0.0 {
                    touched.push((y * self.grid.width + x) as usize);
                }
            }
        }
        // A border that lies between two cells belongs to both.
        const ASIDE_M: f64 = 1e-4;
        for at in border(thing.shape, self.grid.resolution_m / 20.0) {
            let aside = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
            touched.extend(aside.iter().filter_map(|&(dx, dy)| self.cell(at + DVec2::new(dx, dy) * ASIDE_M)));
        }
        touched
    }

    /// Puts the people where they are at a stamp. A cell with a person in it counts by what the frame shows; when the person has
    /// left, by what was seen there without.
    fn move_people(&mut self, stamp_ns: u64) {
        let at = |walker: &Walker| standing(&walker.at(seconds_at(stamp_ns)), String::new());
        let touched: Vec<usize> = self.walkers.iter().flat_map(|walker| self.touched(&at(walker))).collect();
        let free = |cell: &usize| self.contents[*cell] == Content::Nothing;
        self.people = touched.into_iter().filter(free).map(|cell| (cell, false)).collect();
    }

    /// Takes in what a frame shows, by its true depth and pose.
    pub fn observe(&mut self, frame: &SimFrame, camera: &CameraModel) {
        self.move_people(frame.stamp_ns);
        let map_from_camera = frame.pose.map_from_base.then(frame.pose.base_from_camera);
        self.see_surfaces(frame, camera, map_from_camera);
        self.see_through(frame, camera, map_from_camera);
    }

    fn see_surfaces(&mut self, frame: &SimFrame, camera: &CameraModel, map_from_camera: Rigid) {
        let rotation = map_from_camera.rotation_matrix();
        let origin = map_from_camera.translation_m;
        for (pixel, &depth_m) in (0_u32..).zip(&frame.true_depth_m) {
            let (u, v) = (f64::from(pixel % camera.width), f64::from(pixel / camera.width));
            let ray = DVec3::new((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
            let offset = rotation * (ray * f64::from(depth_m));
            let at = origin + offset;
            let in_band = (self.band_m[0]..=self.band_m[1]).contains(&at.z);
            let on_floor = at.z.abs() < ON_FLOOR_M;
            let usable = depth_m > 0.0 && offset.truncate().length() <= self.range_m;
            if let Some(cell) = usable.then(|| self.cell(at.truncate())).flatten() {
                if let Some(shown) = self.people.get_mut(&cell) {
                    *shown |= in_band;
                    continue;
                }
                self.seen[cell] |= match self.contents[cell] {
                    Content::Outside => false,
                    Content::Nothing => on_floor,
                    Content::Passable | Content::Glass | Content::Solid => in_band,
                };
            }
        }
    }

    /// Empty cells that a ray crosses in the band before its end.
    fn see_through(&mut self, frame: &SimFrame, camera: &CameraModel, map_from_camera: Rigid) {
        let camera_from_map = map_from_camera.inverse();
        let origin = map_from_camera.translation_m;
        let depth_at = |point: DVec3| {
            let at = camera_from_map.transform_point(point);
            let u = (camera.fx * at.x / at.z + camera.cx).round();
            let v = (camera.fy * at.y / at.z + camera.cy).round();
            let inside =
                at.z > 0.05 && u >= 0.0 && v >= 0.0 && u < camera.width.into() && v < camera.height.into();
            let pixel = || whole(v) as usize * camera.width as usize + whole(u) as usize;
            inside.then(|| (at.z, f64::from(frame.true_depth_m[pixel()])))
        };
        for y in 0..self.grid.height {
            for x in 0..self.grid.width {
                let cell = (y * self.grid.width + x) as usize;
                let at = self.center(x, y);
                let near = at.distance(origin.truncate()) <= self.range_m;
                let settled = self.seen[cell] || self.contents[cell] != Content::Nothing;
                if settled || !near || self.people.contains_key(&cell) {
                    continue;
                }
                let span = self.band_m[1] - self.band_m[0];
                self.seen[cell] = LEVELS.iter().any(|level| {
                    let point = at.extend(self.band_m[0] + level * span);
                    depth_at(point).is_some_and(|(z, depth_m)| depth_m > z)
                });
            }
        }
    }

    /// All cells as of now, row 0 = smallest y: [`UNKNOWN`], [`FREE`], [`OCCUPIED`] or [`GLASS`].
    pub fn cells(&self) -> Vec<i8> {
        let cell = |(&content, &seen): (&Content, &bool)| match (seen, content) {
            (false, _) => UNKNOWN,
            (true, Content::Outside) => UNKNOWN,
            (true, Content::Nothing) => FREE,
            (true, Content::Solid) => OCCUPIED,
            (true, Content::Glass) => GLASS,
            (true, Content::Passable) => PASSABLE,
        };
        let mut cells: Vec<i8> = self.contents.iter().zip(&self.seen).map(cell).collect();
        for (&at, &shown) in &self.people {
            cells[at] = if shown { OCCUPIED } else { UNKNOWN };
        }
        cells
    }

    /// All cells as if every one had been seen.
    pub fn all_cells(&self) -> Vec<i8> {
        let people = self.people.keys().map(|&cell| (cell, true)).collect();
        Self { seen: vec![true; self.contents.len()], people, ..self.clone() }.cells()
    }
}

/// Points around a shape, at most `step_m` apart.
fn border(shape: Shape, step_m: f64) -> Vec<DVec2> {
    let line = |a: DVec2, b: DVec2| {
        let steps = whole((a.distance(b) / step_m).ceil()).max(1);
        (0..=steps).map(move |k| a.lerp(b, f64::from(k) / f64::from(steps))).collect::<Vec<_>>()
    };
    match shape {
        Shape::Segment(a, b) => line(a, b),
        Shape::Oval(center, half, turn) => {
            let steps = whole((std::f64::consts::TAU * half.max_element() / step_m).ceil()).max(8);
            let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(steps);
            (0..steps).map(|k| center + turn.rotate(DVec2::from_angle(angle(k)) * half)).collect()
        }
        Shape::Rectangle(center, half, turn) => {
            let corner = |x: f64, y: f64| center + turn.rotate(half * DVec2::new(x, y));
            let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            (0..4).flat_map(|i| line(corners[i], corners[(i + 1) % 4])).collect()
        }
        Shape::Disc(center, radius) => {
            let steps = whole((std::f64::consts::TAU * radius / step_m).ceil()).max(8);
            let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(steps);
            (0..steps).map(|k| center + DVec2::from_angle(angle(k)) * radius).collect()
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates; used on counts from 0 up"
)]
fn whole(value: f64) -> u32 {
    value as u32
}

fn coordinate(index: usize) -> f64 {
    u32::try_from(index).map_or(f64::INFINITY, f64::from)
}
