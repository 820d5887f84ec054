//! Cells of simulated scans with what learned solidity judges them by, what the map calls them, and what is true of them
//! (spec 6 §3): data for `weights/train_solidity.py`.

mod draw;
mod file;
mod truth;

use glam::DVec3;

pub use draw::{Drawn, FAMILIES, Light, draw};
pub use file::CellFile;
pub use truth::Label;

use crate::base::{Error, Result};
use crate::config::Config;
use crate::gpu::Context;
use crate::map::{Grid, MapUpdate};
use crate::mapper::{Mapper, Options, SensorInfo};
use crate::sensor::{Observation, Point, SensorData, SensorPose};
use crate::sim::lidar::{LidarSimulator, SimScan};
use crate::sim::truth::TrueMap;
use crate::sim::{poses, stamp_ns};
use crate::stage::lidar::solidity::INPUTS;
use truth::Votes;

/// Scans of a scene, at places spread over the way through it.
pub const SCANS: usize = 3;

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// Parameters that all scenes have; sizes, layers and mount are drawn.
    pub config: Config,
    /// Cells of a scan that are kept, at most, spread over all.
    pub most_cells: usize,
}

/// A cell in which something stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Numbers that [`INPUTS`] names.
    pub inputs: Vec<f32>,
    /// What stands there.
    pub label: Label,
    /// What the map calls it ([`crate::map::CellClass`]).
    pub class: u8,
    /// Points that stand there by the true ground.
    pub points: u32,
    /// From the lidar, metres.
    pub range_m: f32,
    /// The material that most of its points are of.
    pub material: String,
}

/// The cells of one scan of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Cells {
    /// What was drawn.
    pub drawn: Drawn,
    /// Number of the scan.
    pub scan: usize,
    /// Of it.
    pub cells: Vec<Cell>,
}

/// Simulates the scans of a seed's scene, maps them, and gives their cells.
///
/// # Errors
/// Those of generator, simulator and mapper.
pub fn make(seed: u64, request: &Request, context: &Context) -> Result<Vec<Cells>> {
    let drawn = draw(seed)?;
    let config = drawn.config(&request.config);
    let lidar = drawn
        .scene
        .lidar
        .as_ref()
        .ok_or_else(|| Error::Config { key: "lidar".into(), reason: "the scene has none".into() })?;
    let mount = lidar.base_from_lidar();
    let mut simulator = LidarSimulator::with_context(&drawn.scene, context)?;
    let truth =
        TrueMap::new(&drawn.scene, &Config { resolution_m: config.scan_resolution_m, ..config.clone() });
    let mut mapper: Option<Mapper> = None;
    let (way, mut all) = (poses(&drawn.scene), Vec::new());
    for number in 0..SCANS {
        let at = (2 * number + 1) * way.len() / (2 * SCANS);
        let map_from_base = way[at.min(way.len() - 1)].map_from_base;
        let stamp = stamp_ns(&drawn.scene, at as u64);
        let mut simulated = simulator.scan(at as u64, stamp, |_| map_from_base)?;
        drawn.light.shine(&mut simulated.scan);
        let pose = SensorPose { map_from_base, base_from_sensor: mount, sweep: None };
        let observation = Observation {
            sensor: 0,
            pose: Some(pose),
            map_frame: "map".into(),
            goal_m: None,
            data: SensorData::Scan(simulated.scan.clone()),
        };
        if mapper.is_none() {
            let sensors = [SensorInfo::lidar(&config, simulated.scan.clone())];
            let options = Options { solidity_inputs: true, ..Options::default() };
            mapper = Some(Mapper::on(context, &config, &sensors, &options)?);
        }
        let Some(mapper) = &mut mapper else { continue };
        let update = mapper.step(&observation)?;
        let (Some(map), Some(seen)) = (&update.map, update.lidar()) else { continue };
        let scene = Seen { config: &config, drawn: &drawn, simulated: &simulated, pose, truth: &truth };
        let cells = scene.cells(map, &seen.solidity_inputs, request.most_cells);
        all.push(Cells { drawn: drawn.clone(), scan: number, cells });
    }
    Ok(all)
}

/// A scan with what is true of it.
struct Seen<'a> {
    config: &'a Config,
    drawn: &'a Drawn,
    simulated: &'a SimScan,
    pose: SensorPose,
    truth: &'a TrueMap,
}

impl Seen<'_> {
    fn cells(&self, map: &MapUpdate, inputs: &[f32], most: usize) -> Vec<Cell> {
        let votes = self.votes(&map.grid);
        let map_from_sensor = self.pose.map_from_sensor();
        let all = self.truth.all_cells();
        let mut found = Vec::new();
        for (cell, votes) in votes.iter().enumerate() {
            let own = inputs.get(cell * INPUTS.len()..(cell + 1) * INPUTS.len());
            let centre = middle(&map.grid, cell);
            let label = votes.label(truth::true_cell(&self.truth.grid(), &all, centre));
            let (Some(label), Some(class)) = (label, map.classes.get(cell)) else { continue };
            // A learned map has inputs wherever something stands; the others have none at all.
            if own.is_some_and(|own| own[0] == 0.0) {
                continue;
            }
            let away_m = (centre - map_from_sensor.translation_m.truncate()).length();
            found.push(Cell {
                inputs: own.map_or_else(|| vec![0.0; INPUTS.len()], <[f32]>::to_vec),
                label,
                class: *class,
                points: votes.points(),
                range_m: crate::stage::single(away_m),
                material: votes.material(&self.drawn.scene),
            });
        }
        let stride = found.len().div_ceil(most).max(1);
        found.into_iter().step_by(stride).collect()
    }

    /// What the points of each cell of a window are of, those that stand on the true ground.
    fn votes(&self, grid: &Grid) -> Vec<Votes> {
        let mut votes = vec![Votes::default(); grid.width as usize * grid.height as usize];
        let map_from_sensor = self.pose.map_from_sensor();
        for (point, truth) in self.simulated.scan.points.iter().zip(&self.simulated.truth) {
            let at = map_from_sensor.transform_point(place(point));
            let stands = (self.config.height_min_m..=self.config.height_max_m).contains(&at.z);
            if let Some(cell) = stands.then(|| cell_at(grid, at)).flatten() {
                votes[cell].add(truth);
            }
        }
        votes
    }
}

fn place(point: &Point) -> DVec3 {
    DVec3::from(point.position_m().map(f64::from))
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the grid")]
fn cell_at(grid: &Grid, at: DVec3) -> Option<usize> {
    let column = (at.x - grid.origin_x_m) / grid.resolution_m;
    let row = (at.y - grid.origin_y_m) / grid.resolution_m;
    let inside = column >= 0.0 && row >= 0.0 && column < grid.width.into() && row < grid.height.into();
    inside.then(|| row as usize * grid.width as usize + column as usize)
}

fn middle(grid: &Grid, cell: usize) -> glam::DVec2 {
    let of = |index: usize| u32::try_from(index).map_or(0.0, f64::from);
    let (width, origin) = (grid.width as usize, glam::DVec2::new(grid.origin_x_m, grid.origin_y_m));
    origin + (glam::DVec2::new(of(cell % width), of(cell / width)) + 0.5) * grid.resolution_m
}
