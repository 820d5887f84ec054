//! Whether a lidar's intensities may call things passable: only while its scans bear out full scale and Gamma (spec 2 §3).
//!
//! Walls, posts, furniture and the like stand upright. Where intensities, full scale and Gamma fit each other most of what stands
//! upright is above Gamma: 67 to 100 % of the cells in recordings of six sensors, none of them with a wrong scale. So the host
//! looks for cells with an upright surface and for how many of these intensity calls solid. Until most are, what stands is solid.
//!
//! All scans of one lidar count, in their order, so that neither other sensors nor what is under way change the outcome. It turns
//! at most twice: to intensities once they are borne out, and back for good where later scans contradict them.

use glam::DQuat;

use crate::config::{LayerMeasure, Solidity};
use crate::sensor::{Scan, SensorPose};
use crate::stage::LidarJob;
use crate::stage::lidar::intensity_classes::solid_value;

/// Upright cells from which a share of them says something.
const LEAST_UPRIGHT: u64 = 20;
/// Share of them that is to be solid before intensities are believed, and under which they are not believed any more.
const BORNE_OUT: f64 = 0.5;
const CONTRADICTED: f64 = 0.4;
/// Share of returns above full scale from which it is too low. Retroreflectors are brighter than diffuse surfaces can be.
const MOST_ABOVE: f64 = 0.1;
/// Height that returns of an upright cell span at least, metres; in low layers half of these.
const UPRIGHT_M: f64 = 0.3;
/// Height of scans that are flat, metres.
const FLAT_M: f32 = 0.05;
/// Returns of an upright cell.
const UPRIGHT_RETURNS: u32 = 3;
/// Least side of a cell that is looked at, metres.
const LEAST_CELL_M: f64 = 0.1;
/// Cells along the side of the square around the lidar that is looked at.
const MOST_SIDE: u32 = 256;
/// Scans of which every one is looked at; of those after them each sixteenth is.
const FIRST_SCANS: u64 = 32;
const LATER_EVERY: u64 = 16;

/// What a user is told first where the scale of intensities does not matter.
const LEARNED: &str = "solid or passable by shape and by beams that go on behind (solidity: learned)";

/// Returns of a cell.
#[derive(Debug, Clone, Copy)]
struct Cell {
    low_m: f32,
    high_m: f32,
    returns: u32,
}

const EMPTY: Cell = Cell { low_m: f32::INFINITY, high_m: f32::NEG_INFINITY, returns: 0 };

/// What the scans said so far; see the module.
#[derive(Debug, Clone)]
pub struct IntensityTrust {
    /// Whether clouds have intensities at all.
    measured: bool,
    scans: u64,
    returns: u64,
    above: u64,
    least: f32,
    most: f32,
    /// Lowest and highest return in the lidar's own frame, metres.
    heights_m: [f32; 2],
    upright: u64,
    solid: u64,
    /// Sum of the upright cells' values, as shares of full scale.
    values: f64,
    believed: bool,
    given_up: bool,
    cells: Vec<Cell>,
    /// Sum of intensities as shares of full scale, and returns, by cell and tall layer.
    layers: Vec<[f32; 2]>,
}

impl IntensityTrust {
    /// Before the first scan.
    pub fn new() -> Self {
        Self {
            measured: true,
            scans: 0,
            returns: 0,
            above: 0,
            least: f32::INFINITY,
            most: f32::NEG_INFINITY,
            heights_m: [f32::INFINITY, f32::NEG_INFINITY],
            upright: 0,
            solid: 0,
            values: 0.0,
            believed: false,
            given_up: false,
            cells: Vec::new(),
            layers: Vec::new(),
        }
    }

    /// Takes in the next scan: whether what stands in it is solid, whatever its intensity.
    pub fn stands(&mut self, job: &LidarJob, scan: &Scan, pose: SensorPose) -> bool {
        match job.config.settled_solidity() {
            Solidity::Standing => return true,
            Solidity::Intensity => return false,
            Solidity::Auto | Solidity::Learned => {}
        }
        let number = self.scans;
        self.scans += 1;
        self.measured &= scan.columns.intensity;
        if self.measured && (number < FIRST_SCANS || number.is_multiple_of(LATER_EVERY)) {
            self.count(job, scan);
            self.look(job, scan, pose);
            self.judge();
        }
        !self.believed
    }

    /// The range of intensities, and how many are above full scale.
    fn count(&mut self, job: &LidarJob, scan: &Scan) {
        for point in scan.points.iter().filter(|point| point.intensity.is_finite()) {
            let intensity = point.intensity;
            self.heights_m = [self.heights_m[0].min(point.z_m), self.heights_m[1].max(point.z_m)];
            self.returns += 1;
            self.above += u64::from(f64::from(intensity) > job.full_scale);
            self.least = self.least.min(intensity);
            self.most = self.most.max(intensity);
        }
    }

    /// Counts upright cells around the lidar, and those of them that intensity calls solid.
    fn look(&mut self, job: &LidarJob, scan: &Scan, pose: SensorPose) {
        let (cell_m, tall) = (cell_m(job), job.tall_layers() as usize);
        let side = cells_within(f64::from(job.map.side) * job.config.scan_resolution_m, cell_m);
        self.cells.clear();
        self.cells.resize(side * side, EMPTY);
        self.layers.clear();
        self.layers.resize(side * side * tall, [0.0; 2]);
        self.fill(job, scan, pose.map_from_sensor().rotation, side, cell_m);
        let heights = &job.config.layer_heights_m;
        let span_m = heights.last().zip(heights.first()).map_or(0.0, |(high, low)| high - low);
        let upright_m = UPRIGHT_M.min(0.5 * span_m);
        let (solid, gamma) = (solid_value(job), job.config.gamma_or_default());
        for (at, cell) in self.cells.iter().enumerate() {
            if cell.returns < UPRIGHT_RETURNS || f64::from(cell.high_m - cell.low_m) < upright_m {
                continue;
            }
            let range_m = range_m(at, side, cell_m);
            let layers = self.layers[at * tall..][..tall].iter().enumerate();
            let value =
                layers.map(|(layer, sums)| layer_value(job, *sums, layer, range_m)).fold(0.0, f64::max);
            self.upright += 1;
            self.solid += u64::from(value > gamma);
            self.values += (value / solid).min(1.0);
        }
    }

    fn fill(&mut self, job: &LidarJob, scan: &Scan, rotation: DQuat, side: usize, cell_m: f64) {
        let heights = &job.config.layer_heights_m;
        let (per_m, tall) = (1.0 / cell_m, job.tall_layers() as usize);
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let (middle, most) = (0.5 * side as f64, side as f64);
        for point in &scan.points {
            let at = rotation * glam::DVec3::from(point.position_m().map(f64::from));
            let (column, row) = (at.x * per_m + middle, at.y * per_m + middle);
            // Written so that NaN is left out.
            if !(column >= 0.0 && row >= 0.0 && column < most && row < most) {
                continue;
            }
            let below = heights.partition_point(|&bound| bound <= at.z);
            let layer = if heights.last() == Some(&at.z) { below - 1 } else { below };
            if layer == 0 || layer > tall {
                continue;
            }
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the square")]
            let index = row as usize * side + column as usize;
            let cell = &mut self.cells[index];
            #[expect(clippy::cast_possible_truncation, reason = "a height in 32 bits")]
            let z_m = at.z as f32;
            (cell.low_m, cell.high_m) = (cell.low_m.min(z_m), cell.high_m.max(z_m));
            cell.returns += 1;
            let sums = &mut self.layers[index * tall + layer - 1];
            #[expect(clippy::cast_possible_truncation, reason = "a share in 32 bits")]
            let share = (f64::from(point.intensity) / job.full_scale).clamp(0.0, 1.0) as f32;
            sums[0] += share;
            sums[1] += 1.0;
        }
    }

    fn judge(&mut self) {
        let borne_out = |share: f64| {
            self.upright >= LEAST_UPRIGHT
                && self.solid_share() >= share
                && !self.is_constant()
                && !self.is_above()
        };
        let keeps = borne_out(if self.believed { CONTRADICTED } else { BORNE_OUT });
        self.given_up |= self.believed && !keeps;
        self.believed = keeps && !self.given_up;
    }

    fn solid_share(&self) -> f64 {
        share(self.solid, self.upright)
    }

    fn is_constant(&self) -> bool {
        self.least >= self.most
    }

    fn is_above(&self) -> bool {
        share(self.above, self.returns) > MOST_ABOVE
    }

    /// What is made of the intensities and why, for the user; names the key to set.
    pub fn note(&self, job: &LidarJob) -> String {
        let scale = if job.config.intensity_full_scale > 0.0 {
            format!("full scale of intensities: {} as configured", job.full_scale)
        } else {
            let percentile = job.config.intensity_percentile;
            format!(
                "full scale of intensities: {} (percentile {percentile} of the first scan)",
                job.full_scale
            )
        };
        match job.config.settled_solidity() {
            Solidity::Intensity => scale,
            Solidity::Learned if self.believed => format!("{LEARNED}; {scale}"),
            Solidity::Learned => format!("{LEARNED}; no glass by brightness: {}", self.reason(job)),
            Solidity::Standing => "everything that stands is solid (solidity: standing)".into(),
            Solidity::Auto if self.believed => scale,
            Solidity::Auto => {
                format!("everything that stands is solid, nothing is passable: {}", self.reason(job))
            }
        }
    }

    fn reason(&self, job: &LidarJob) -> String {
        let (full_scale, gamma) = (job.full_scale, job.config.gamma_or_default());
        if !self.measured {
            return "clouds have no intensity that is known by its name; set `intensity_field` if there is one".into();
        }
        if self.returns == 0 {
            return "no return has been seen yet".into();
        }
        let range = format!("intensities go from {} to {}", self.least, self.most);
        if self.is_constant() {
            let most = self.most;
            return format!(
                "the intensity is {most} in every return, which says nothing (`solidity: intensity` takes it as it is)"
            );
        }
        if self.is_above() {
            let above = 100.0 * share(self.above, self.returns);
            return format!(
                "{above:.0} % of the returns are above the full scale of {full_scale}; {range}: set `intensity_full_scale`, and `gamma` as a share of it"
            );
        }
        let upright = self.upright;
        if upright == 0 && self.heights_m[1] - self.heights_m[0] < FLAT_M {
            return format!(
                "scans are flat, so that nothing shows whether intensities fit `intensity_full_scale` {full_scale} and `gamma` {gamma}; {range} (`solidity: intensity` takes them as they are)"
            );
        }
        if upright < LEAST_UPRIGHT {
            return format!(
                "too little stands upright ({upright} cells) to see whether intensities fit `intensity_full_scale` {full_scale} and `gamma` {gamma}; {range} (`solidity: intensity` takes them as they are)"
            );
        }
        let (solid, mean) = (100.0 * self.solid_share(), self.values / as_f64(upright));
        format!(
            "of {upright} cells with something upright {solid:.0} % are above `gamma` {gamma}; their mean is {mean:.3} of `intensity_full_scale` {full_scale}, and {range}: set these two (`solidity: intensity` takes them as they are)"
        )
    }
}

impl Default for IntensityTrust {
    fn default() -> Self {
        Self::new()
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts of a run fit in 53 bits")]
fn as_f64(count: u64) -> f64 {
    count as f64
}

fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { as_f64(part) / as_f64(whole) }
}

/// Side of the cells that are looked at, metres: those of the map. A mean is the same in larger ones, so that the cells of a fine
/// map, in which few returns lie, are not too small.
fn cell_m(job: &LidarJob) -> f64 {
    let resolution_m = job.config.scan_resolution_m;
    if job.config.layer_measure == LayerMeasure::Mean { resolution_m.max(LEAST_CELL_M) } else { resolution_m }
}

/// Cells along the side of the square.
fn cells_within(size_m: f64, cell_m: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "cut off at 256, from 0 up")]
    let cells = (size_m / cell_m + 0.5) as u32;
    cells.min(MOST_SIDE) as usize
}

/// From the lidar to the centre of a cell, metres.
fn range_m(at: usize, side: usize, resolution_m: f64) -> f64 {
    let from_middle = |index: usize| as_f64(index as u64) + 0.5 - 0.5 * as_f64(side as u64);
    from_middle(at % side).hypot(from_middle(at / side)) * resolution_m
}

/// A layer's value as `intensity_classes` computes it.
fn layer_value(job: &LidarJob, [sum, returns]: [f32; 2], layer: usize, range_m: f64) -> f64 {
    let (sum, config) = (f64::from(sum), &job.config);
    match config.layer_measure {
        LayerMeasure::Sum => sum / config.scan_resolution_m.powi(2),
        LayerMeasure::Mean => sum / f64::from(returns.max(1.0)),
        LayerMeasure::Expected => {
            let away_m = range_m.max(0.5 * config.scan_resolution_m);
            let across = config.scan_resolution_m / away_m / config.azimuth_step_deg.to_radians();
            let [low, high] = config.elevation_range_deg.map(f64::to_radians);
            let to = |bound: usize| config.layer_heights_m[bound].atan2(away_m);
            let rings = (to(layer + 1).min(high) - to(layer).max(low)).max(0.0)
                / config.elevation_step_deg.to_radians();
            sum / (across * rings).max(1.0)
        }
    }
}
