//! What is drawn for a seed: scene, sensor, mount, brightness and cells.

use crate::base::Result;
use crate::config::Config;
use crate::sensor::Scan;
use crate::sim::generate::{Family, Level, Random, add_walkers, generate};
use crate::sim::lidar::{Lidar, LidarModel, Returns};
use crate::sim::{Scene, poses};

/// Families in turn, the likelier the more often they stand here: plants and strings, and rooms of walls and furniture.
pub const FAMILIES: [Family; 20] = [
    Family::Thicket,
    Family::Vegetation,
    Family::Curtain,
    Family::Train,
    Family::Thicket,
    Family::Vegetation,
    Family::Glass,
    Family::Drive,
    Family::Thicket,
    Family::Vegetation,
    Family::Curtain,
    Family::Train,
    Family::Thicket,
    Family::Vegetation,
    Family::Mixed,
    Family::Drive,
    Family::Thicket,
    Family::Vegetation,
    Family::Curtain,
    Family::Glass,
];

/// Frames of the way through a scene.
const FRAMES: u32 = 60;

/// What is made of the sensor's intensities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// `None`: the cloud has none.
    pub gain: Option<f32>,
}

impl Light {
    /// Changes a scan's.
    pub fn shine(self, scan: &mut Scan) {
        scan.columns.intensity = self.gain.is_some();
        for point in &mut scan.points {
            point.intensity *= self.gain.unwrap_or(0.0);
        }
    }
}

/// What a seed comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// The seed.
    pub seed: u64,
    /// Which generator.
    pub family: Family,
    /// The scene with its lidar.
    pub scene: Scene,
    /// Of the clouds.
    pub light: Light,
    /// Side of the cells, metres.
    pub resolution_m: f64,
    /// Side of the map, metres.
    pub map_size_m: f64,
}

impl Drawn {
    /// The lidar.
    pub fn lidar(&self) -> Lidar {
        self.scene.lidar.clone().unwrap_or_default()
    }

    /// These parameters, with the size of the map and layers from below the floor to above the robot. Nothing is inflated, so that
    /// every cell shows its own class.
    pub fn config(&self, base: &Config) -> Config {
        let lidar_m = self.lidar().height_m;
        let layer_heights_m = vec![-lidar_m - 0.5, 0.0, (base.height_max_m - lidar_m).max(0.1)];
        let (resolution_m, map_size_m) = (self.resolution_m, self.map_size_m);
        Config {
            scan_resolution_m: resolution_m,
            scan_map_size_m: map_size_m,
            layer_heights_m,
            inflation_length_m: 0.0,
            inflation_padding_cells: 0,
            inflation_side_m: 0.0,
            inscribed_radius_m: 0.0,
            ..base.clone()
        }
    }
}

/// Of every second tree the crown reaches down to where the robot drives, as at the edge of a wood, where that leaves the way
/// free.
fn lower_crowns(scene: &mut Scene, random: &mut Random) {
    let way: Vec<_> = poses(scene).iter().map(|pose| pose.map_from_base.translation_m.truncate()).collect();
    for thicket in &mut scene.thickets {
        let [x, y, z] = thicket.center_m;
        let (bottom_m, top_m) = (z - 0.5 * thicket.size_m[2], z + 0.5 * thicket.size_m[2]);
        let reach_m = 0.5 * thicket.size_m[0].max(thicket.size_m[1]) + 0.5;
        let free = way.iter().all(|at| at.distance(glam::DVec2::new(x, y)) > reach_m);
        if !(thicket.solid && bottom_m > 1.0 && free && random.chance(0.5)) {
            continue;
        }
        let bottom_m = random.within(-0.5, 0.8);
        thicket.center_m[2] = 0.5 * (bottom_m + top_m);
        thicket.size_m[2] = top_m - bottom_m;
    }
}

/// Scene, sensor and cells of a seed.
///
/// # Errors
/// Those of [`generate`].
pub fn draw(seed: u64) -> Result<Drawn> {
    let mut random = Random::new(seed ^ 0x736f_6c69);
    let family = FAMILIES[usize::try_from(seed % FAMILIES.len() as u64).unwrap_or(0)];
    let level = random.pick(&[Level::L0, Level::L1, Level::L2]);
    let mut scene = generate(family, level, seed, FRAMES)?;
    lower_crowns(&mut scene, &mut random);
    let people = random.count(0, 3);
    add_walkers(&mut scene, people);
    let model = random.pick(&LidarModel::ALL);
    let returns = random.pick(&[Returns::Strongest, Returns::StrongestLast, Returns::FirstLast]);
    let tilt = |random: &mut Random| random.within(-0.05, 0.05);
    scene.lidar = Some(Lidar {
        model,
        returns,
        rate_hz: random.pick(&[10.0, 10.0, 20.0]),
        height_m: random.within(0.4, 1.4),
        tilt_rad: [tilt(&mut random), tilt(&mut random), random.within(-3.1, 3.1)],
        ..Lidar::default()
    });
    let exponent = random.within(-3.0, 3.0);
    let gain = random.chance(2.0 / 3.0).then(|| crate::stage::single(10.0_f64.powf(exponent)));
    let resolution_m: f64 = random.pick(&[0.05, 0.1, 0.1, 0.1, 0.15, 0.2, 0.2]);
    let map_size_m = (if resolution_m < 0.1 { 12.0 } else { 24.0 } / resolution_m).round() * resolution_m;
    Ok(Drawn { seed, family, scene, light: Light { gain }, resolution_m, map_size_m })
}
