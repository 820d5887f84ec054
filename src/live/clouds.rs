//! What a sensor's points say to Nav2's ObstacleLayer and collision_monitor: which are obstacles, and how far the sensor sees.

use glam::DVec3;

use crate::config::Config;
use crate::map::clean::cleaned;
use crate::map::{CellClass, FrameImages, Ground, LidarUpdate, MapUpdate};
use crate::message::ros2::{Header, PointCloud2};
use crate::output::cloud::{FLOAT32, TrustedPoints, cloud};
use crate::sensor::{DepthImage, Scan, SensorPose};

/// Fields of both clouds; a cloud without points has them too, as some versions of collision_monitor fall over one without.
const FIELDS: [(&str, u8, u32); 4] =
    [("x", FLOAT32, 4), ("y", FLOAT32, 4), ("z", FLOAT32, 4), ("reliability", FLOAT32, 4)];

/// Bytes of a point.
const STEP: usize = 16;

/// The points that are obstacles, and all that the sensor is sure of, both in the sensor's frame.
pub(super) struct Clouds {
    pub(super) marking: PointCloud2,
    pub(super) clearing: PointCloud2,
}

/// Obstacles among points in the sensor's frame: within the height band above the ground, unless the map says that the cell may
/// be driven through.
struct Obstacles<'a> {
    config: &'a Config,
    pose: SensorPose,
    ground: Option<Ground>,
    map: Option<&'a MapUpdate>,
}

impl Obstacles<'_> {
    fn has(&self, point_m: [f32; 3]) -> bool {
        let map_from_sensor = self.pose.map_from_sensor();
        let in_map = map_from_sensor.transform_point(DVec3::from(point_m.map(f64::from)));
        let stated_m = in_map.z - self.config.ground_z_m;
        let off_m = in_map - map_from_sensor.translation_m;
        let height_m = self.ground.map_or(stated_m, |ground| ground.height_of(off_m));
        let in_band = (self.config.height_min_m..=self.config.height_max_m).contains(&height_m);
        in_band && !self.is_passable(in_map)
    }

    fn is_passable(&self, place_m: DVec3) -> bool {
        let class = self.map.and_then(|map| {
            let [column, row] = map.grid.cell_at(place_m.x, place_m.y)?;
            map.classes.get(row as usize * map.grid.width as usize + column as usize)
        });
        class == Some(&(CellClass::Passable as u8))
    }

    fn split(&self, header: &Header, all: Vec<u8>) -> Clouds {
        let number = |bytes: &[u8]| bytes.first_chunk().map_or(0.0, |&four| f32::from_le_bytes(four));
        let is_obstacle = |point: &&[u8]| self.has([0, 4, 8].map(|at| number(&point[at..])));
        let marking: Vec<u8> = all.chunks_exact(STEP).filter(is_obstacle).flatten().copied().collect();
        Clouds {
            marking: cloud(header.clone(), &FIELDS, marking),
            clearing: cloud(header.clone(), &FIELDS, all),
        }
    }
}

/// Clouds of a camera's frame: its pixels of a reliability above tau.
pub(super) fn of_camera(
    points: &mut TrustedPoints,
    config: &Config,
    depth: &DepthImage,
    images: &FrameImages,
    header: &Header,
    (pose, ground, map): (SensorPose, Option<Ground>, Option<&MapUpdate>),
) -> Clouds {
    let which = (crate::base::single(config.tau), config.cloud_stride.max(1));
    let all = points.of(images, &depth.camera, header.clone(), which);
    Obstacles { config, pose, ground, map }.split(header, all.data)
}

/// Clouds of a lidar's scan: its points, those mirrored in glass put right.
pub(super) fn of_lidar(
    config: &Config,
    scan: &Scan,
    lidar: &LidarUpdate,
    header: &Header,
    (pose, ground, map): (SensorPose, Option<Ground>, Option<&MapUpdate>),
) -> Clouds {
    let places: Vec<[f32; 3]> = match &lidar.glass {
        Some(labelled) => cleaned(scan, labelled).map(|point| point.place_m.as_vec3().to_array()).collect(),
        None => scan.points.iter().map(|point| point.position_m()).collect(),
    };
    let of = |[x, y, z]: [f32; 3]| [x, y, z, 1.0].into_iter().flat_map(f32::to_le_bytes);
    Obstacles { config, pose, ground, map }.split(header, places.into_iter().flat_map(of).collect())
}
