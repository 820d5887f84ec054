//! A simulated recording as ROS 2 MCAP.

use std::path::{Path, PathBuf};

use serde_bytes::Bytes;

use super::Recorder;
use super::packets::Packets;
use crate::base::{Result, Rigid};
use crate::config::Config;
use crate::map::Grid;
use crate::message::ros2::{
    CameraInfo, Header, Image, PointCloud2, Pose, Quaternion, TFMessage, Time, TransformStamped, Vector3,
};
use crate::message::written::{MapMetaData, OccupancyGrid, RosString};
use crate::output::cloud::{FLOAT32, cloud};
use crate::output::{End, RosFile, StagedFile, abandon};
use crate::sensor::CameraModel;
use crate::sim::frame::SimFrame;
use crate::sim::lidar::{LIDAR_FRAME, LidarModel, PointTruth, SimScan};
use crate::sim::scene::Scene;
use crate::sim::trajectory::base_from_camera;
use crate::sim::truth::TrueMap;
use crate::stage::single;

const MAP_FRAME: &str = "map";
const BASE_FRAME: &str = "base_link";
const OPTICAL_FRAME: &str = "camera_color_optical_frame";

/// `sensor_msgs/PointField`'s codes.
const UINT8: u8 = 2;
const UINT16: u8 = 4;

/// Where the driver of a lidar publishes.
/// Where Velodyne's driver publishes packets.
const PACKETS: &str = "/velodyne_packets";

fn topic_of(model: LidarModel) -> &'static str {
    match model {
        LidarModel::Vlp16 | LidarModel::Hdl32e | LidarModel::Vlp32c => "/velodyne_points",
        LidarModel::Os1x64 => "/ouster/points",
        LidarModel::Qt64 => "/hesai/points",
    }
}

fn measured_cloud(header: Header, scan: &SimScan) -> PointCloud2 {
    let mut data = Vec::new();
    for point in &scan.scan.points {
        let floats = [point.x_m, point.y_m, point.z_m, point.intensity];
        data.extend(floats.into_iter().flat_map(f32::to_le_bytes));
        data.extend(point.ring.to_le_bytes());
        data.extend(point.time_s.to_le_bytes());
        data.push(point.return_type as u8);
    }
    let floats = ["x", "y", "z", "intensity"].map(|name| (name, FLOAT32, 4));
    let rest = [("ring", UINT16, 2), ("time", FLOAT32, 4), ("return_type", UINT8, 1)];
    cloud(header, &[floats.as_slice(), &rest].concat(), data)
}

/// Of each point in the order of the sensor's message: the true place, the material's number and the flags of [`PointTruth`].
fn true_cloud(header: Header, scan: &SimScan, order: &[usize]) -> PointCloud2 {
    let mut data = Vec::new();
    for &at in order {
        let PointTruth { place_m, material, flags } = &scan.truth[at];
        data.extend(place_m.as_vec3().to_array().into_iter().flat_map(f32::to_le_bytes));
        data.extend([*material, *flags]);
    }
    let place = ["x", "y", "z"].map(|name| (name, FLOAT32, 4));
    cloud(header, &[place.as_slice(), &[("material", UINT8, 1), ("flags", UINT8, 1)]].concat(), data)
}

/// Topics as a RealSense camera's driver names them, and those of [`crate::sim::truth`]:
///
/// | topic | content |
/// |---|---|
/// | `/tf`, `/tf_static` | map from base, base from camera |
/// | `/camera/camera/color/image_raw`, `camera_info` | `rgb8`, on the depth grid |
/// | `/camera/camera/aligned_depth_to_color/image_raw`, `camera_info` | `16UC1`, millimetres |
/// | `/camera/camera/infra1/image_rect_raw`, `infra2` | `mono8`, where asked for |
/// | `/velodyne_points`, `/ouster/points`, `/hesai/points` | scans as the driver of that lidar packs them, with `return_type` |
/// | `/velodyne_packets` | in place of them where the lidar sends packets: a revolution each |
/// | `/truth/...` | ground truth |
pub struct McapRecorder {
    file: RosFile<StagedFile>,
    camera: CameraModel,
    /// Until something was written.
    scene: Option<Scene>,
    scans: &'static str,
    packets: Option<Packets>,
    infrared: bool,
}

impl McapRecorder {
    /// Starts the file, which takes its name, or an older one's place, when it is finished.
    ///
    /// # Errors
    /// [`crate::Error::File`] where it cannot be created.
    pub fn create(path: &Path, scene: &Scene, infrared: bool) -> Result<Self> {
        Ok(Self {
            file: RosFile::new(StagedFile::create(path)?, path)?,
            camera: scene.camera.model(),
            scene: Some(scene.clone()),
            scans: scene.lidar.as_ref().map_or("", |lidar| topic_of(lidar.model)),
            packets: scene.lidar.as_ref().and_then(Packets::of),
            infrared,
        })
    }

    fn transform(&mut self, topic: &str, stamp_ns: u64, ends: [&str; 2], pose: Rigid) -> Result<()> {
        let transform = TransformStamped {
            header: Header::new(stamp_ns, ends[0]),
            child_frame_id: ends[1].into(),
            transform: pose.into(),
        };
        self.file.write(topic, stamp_ns, &TFMessage { transforms: vec![transform] })
    }

    fn image(&mut self, topic: &str, stamp_ns: u64, encoding: &str, data: Vec<u8>) -> Result<()> {
        let CameraModel { width, height, .. } = self.camera;
        let pixels = width as usize * height as usize;
        let message = Image {
            header: Header::new(stamp_ns, OPTICAL_FRAME),
            height,
            width,
            encoding: encoding.into(),
            is_bigendian: u8::from(cfg!(target_endian = "big")),
            step: width * u32::try_from(data.len() / pixels.max(1)).unwrap_or(0),
            data,
        };
        self.file.write(topic, stamp_ns, &message)
    }

    fn calibration(&mut self, topic: &str, stamp_ns: u64) -> Result<()> {
        let info = CameraInfo::new(Header::new(stamp_ns, OPTICAL_FRAME), &self.camera);
        self.file.write(topic, stamp_ns, &info)
    }

    fn sensor(&mut self, frame: &SimFrame) -> Result<()> {
        let at = frame.stamp_ns;
        self.transform("/tf", at, [MAP_FRAME, BASE_FRAME], frame.pose.map_from_base)?;
        self.calibration("/camera/camera/color/camera_info", at)?;
        self.image("/camera/camera/color/image_raw", at, "rgb8", frame.rgb.clone())?;
        self.calibration("/camera/camera/aligned_depth_to_color/camera_info", at)?;
        let depth = bytemuck::cast_slice(&frame.depth_mm).to_vec();
        self.image("/camera/camera/aligned_depth_to_color/image_raw", at, "16UC1", depth)?;
        if self.infrared {
            self.image("/camera/camera/infra1/image_rect_raw", at, "mono8", frame.infrared_left.clone())?;
            self.image("/camera/camera/infra2/image_rect_raw", at, "mono8", frame.infrared_right.clone())?;
        }
        Ok(())
    }

    /// What comes first: mounts, the scene, and the whole true map where there is a lidar.
    fn begin(&mut self, stamp_ns: u64) -> Result<()> {
        let Some(scene) = self.scene.take() else { return Ok(()) };
        let mut mounts = vec![(OPTICAL_FRAME, base_from_camera(&scene.camera))];
        mounts.extend(scene.lidar.as_ref().map(|lidar| (LIDAR_FRAME, lidar.base_from_lidar())));
        let transform = |(child, pose): (&str, Rigid)| TransformStamped {
            header: Header::new(stamp_ns, BASE_FRAME),
            child_frame_id: child.into(),
            transform: pose.into(),
        };
        let transforms = mounts.into_iter().map(transform).collect();
        self.file.write("/tf_static", stamp_ns, &TFMessage { transforms })?;
        self.file.write("/truth/scene", stamp_ns, &RosString { data: scene.to_yaml()? })?;
        if scene.lidar.is_some() {
            let map = TrueMap::new(&scene, &Config::default());
            self.map("/truth/all", stamp_ns, &map.grid(), &map.all_cells())?;
        }
        Ok(())
    }

    fn truth(&mut self, frame: &SimFrame, grid: &Grid, cells: &[i8]) -> Result<()> {
        let at = frame.stamp_ns;
        let depth = bytemuck::cast_slice(&frame.true_depth_m).to_vec();
        self.image("/truth/depth/image_raw", at, "32FC1", depth)?;
        self.image("/truth/material/image_raw", at, "mono8", frame.material.clone())?;
        self.map("/truth/map", at, grid, cells)
    }

    fn map(&mut self, topic: &str, at: u64, grid: &Grid, cells: &[i8]) -> Result<()> {
        let position = Vector3 { x: grid.origin_x_m, y: grid.origin_y_m, z: 0.0 };
        let info = MapMetaData {
            map_load_time: Time::from_stamp_ns(at),
            resolution: single(grid.resolution_m),
            width: grid.width,
            height: grid.height,
            origin: Pose { position, orientation: Quaternion::default() },
        };
        let data = Bytes::new(bytemuck::cast_slice(cells));
        let map = OccupancyGrid { header: Header::new(at, MAP_FRAME), info, data };
        self.file.write(topic, at, &map)
    }
}

impl Recorder for McapRecorder {
    fn write(&mut self, frame: &SimFrame, grid: &Grid, cells: &[i8]) -> Result<()> {
        self.begin(frame.stamp_ns)?;
        self.sensor(frame)?;
        self.truth(frame, grid, cells)?;
        self.file.end_result()
    }

    fn write_pose(&mut self, stamp_ns: u64, map_from_base: Rigid) -> Result<()> {
        self.begin(stamp_ns)?;
        self.transform("/tf", stamp_ns, [MAP_FRAME, BASE_FRAME], map_from_base)
    }

    fn write_scan(&mut self, scan: &SimScan, end_ns: u64) -> Result<()> {
        self.begin(scan.scan.stamp_ns)?;
        let stamp_ns = scan.scan.stamp_ns;
        let order = match &self.packets {
            Some(packets) => {
                self.file.write(PACKETS, end_ns, &packets.message(scan))?;
                packets.order(scan)
            }
            None => {
                let cloud = measured_cloud(Header::new(stamp_ns, LIDAR_FRAME), scan);
                self.file.write(self.scans, end_ns, &cloud)?;
                (0..scan.truth.len()).collect()
            }
        };
        let cloud = true_cloud(Header::new(stamp_ns, MAP_FRAME), scan, &order);
        self.file.write("/truth/points", end_ns, &cloud)?;
        self.file.end_result()
    }

    fn finish(&mut self) -> Result<()> {
        self.file.finish()?.map_or(Ok(()), StagedFile::commit)
    }

    fn abandon(&mut self, end: End) -> Result<Option<PathBuf>> {
        abandon(&mut self.file, end)
    }
}
