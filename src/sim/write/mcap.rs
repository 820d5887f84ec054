//! A simulated recording as ROS 2 MCAP.

use std::path::{Path, PathBuf};

use serde_bytes::Bytes;

use super::Recorder;
use crate::base::Result;
use crate::base::Rigid;
use crate::map::Grid;
use crate::message::ros2::{
    CameraInfo, Header, Image, Pose, Quaternion, TFMessage, Time, TransformStamped, Vector3,
};
use crate::message::written::{MapMetaData, OccupancyGrid, RosString};
use crate::output::{End, RosFile, StagedFile, abandon};
use crate::sensor::CameraModel;
use crate::sim::frame::SimFrame;
use crate::sim::scene::Scene;
use crate::sim::trajectory::base_from_camera;
use crate::stage::single;

const MAP_FRAME: &str = "map";
const BASE_FRAME: &str = "base_link";
const OPTICAL_FRAME: &str = "camera_color_optical_frame";

/// Topics as a RealSense camera's driver names them, and those of [`crate::sim::truth`]:
///
/// | topic | content |
/// |---|---|
/// | `/tf`, `/tf_static` | map from base, base from camera |
/// | `/camera/camera/color/image_raw`, `camera_info` | `rgb8`, on the depth grid |
/// | `/camera/camera/aligned_depth_to_color/image_raw`, `camera_info` | `16UC1`, millimetres |
/// | `/camera/camera/infra1/image_rect_raw`, `infra2` | `mono8`, where asked for |
/// | `/truth/...` | ground truth |
pub struct McapRecorder {
    file: RosFile<StagedFile>,
    camera: CameraModel,
    mount: Rigid,
    scene_yaml: Option<String>,
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
            mount: base_from_camera(&scene.camera),
            scene_yaml: Some(scene.to_yaml()?),
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

    fn truth(&mut self, frame: &SimFrame, grid: &Grid, cells: &[i8]) -> Result<()> {
        let at = frame.stamp_ns;
        let depth = bytemuck::cast_slice(&frame.true_depth_m).to_vec();
        self.image("/truth/depth/image_raw", at, "32FC1", depth)?;
        self.image("/truth/material/image_raw", at, "mono8", frame.material.clone())?;
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
        self.file.write("/truth/map", at, &map)
    }
}

impl Recorder for McapRecorder {
    fn write(&mut self, frame: &SimFrame, grid: &Grid, cells: &[i8]) -> Result<()> {
        if let Some(data) = self.scene_yaml.take() {
            self.transform("/tf_static", frame.stamp_ns, [BASE_FRAME, OPTICAL_FRAME], self.mount)?;
            self.file.write("/truth/scene", frame.stamp_ns, &RosString { data })?;
        }
        self.sensor(frame)?;
        self.truth(frame, grid, cells)?;
        self.file.end_result()
    }

    fn finish(&mut self) -> Result<()> {
        self.file.finish()?.map_or(Ok(()), StagedFile::commit)
    }

    fn abandon(&mut self, end: End) -> Result<Option<PathBuf>> {
        abandon(&mut self.file, end)
    }
}
