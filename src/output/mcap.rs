//! Results as an MCAP that Foxglove, RViz and Nav2's tools open without configuration.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use serde_bytes::Bytes;

use crate::base::Result;
use crate::base::Rigid;
use crate::config::Config;
use crate::frame::{FrameImages, FrameOutput};
use crate::map::Grid;
use crate::message::RosMessage;
use crate::message::ros2::{
    CameraInfo, Header, Image, Pose, Quaternion, TFMessage, Time, TransformStamped, Vector3,
};
use crate::message::written::{Costmap, CostmapMetaData, MapMetaData, OccupancyGrid};
use crate::output::cloud::TrustedPoints;
use crate::output::ros_file::RosFile;
use crate::output::{Sink, create_file, diagnostics, encode_error, grid_mismatch, narrow};
use crate::sensor::{DepthImage, DepthSamples, RgbdFrame};

/// A crash loses at most this many frames, or scans.
const FRAMES_PER_FLUSH: u64 = 15;

/// A file that sinks may share.
pub(super) type OutFile = RosFile<BufWriter<File>>;

/// Where a costmap is written.
pub(super) struct GridTopics {
    /// `nav_msgs/OccupancyGrid`.
    pub(super) occupancy: &'static str,
    /// `nav2_msgs/Costmap`.
    pub(super) raw: &'static str,
    /// Name of the costmap layer.
    pub(super) layer: &'static str,
}

const TOPICS: GridTopics =
    GridTopics { occupancy: "/limpid/costmap", raw: "/limpid/costmap_raw", layer: "limpid" };

/// Frame of images whose recording names none.
const NAMELESS_CAMERA_FRAME: &str = "camera_optical_frame";

/// Writes, for every frame:
///
/// | topic | type | stamp |
/// |---|---|---|
/// | `/limpid/costmap` | `nav_msgs/OccupancyGrid`, see [`occupancy_of_cost`] | oldest data used |
/// | `/limpid/costmap_raw` | `nav2_msgs/Costmap` | oldest data used |
/// | `/limpid/diagnostics` | `diagnostic_msgs/DiagnosticArray` | oldest data used |
/// | `/tf` | map from base, base from camera | depth image |
/// | `/limpid/reliability` | `mono8`, R * 255 | depth image |
/// | `/limpid/reliability_float` | `32FC1`, R | depth image |
/// | `/limpid/depth_filtered/image` | encoding of the recording, 0 where R is at most tau | depth image |
/// | `/limpid/depth_filtered/camera_info` | its calibration | depth image |
/// | `/limpid/points_trusted` | `sensor_msgs/PointCloud2` of x, y, z, reliability where R is above tau | depth image |
///
/// The last five need the images to be read back; the cloud holds every `cloud_stride`-th pixel both ways, and is left
/// out where that is 0. Images, cloud and the last frame of `/tf` bear the depth image's
/// `frame_id`; where it has none, `camera_frame`; where that is empty too, `camera_optical_frame`.
#[derive(Clone)]
pub struct McapSink {
    path: PathBuf,
    file: Arc<Mutex<OutFile>>,
    map_frame: String,
    base_frame: String,
    camera_frame: String,
    tau: f32,
    cloud_stride: u32,
    points: TrustedPoints,
    frames: u64,
}

impl McapSink {
    /// Creates (or replaces) the file `path`.
    ///
    /// # Errors
    /// [`Error::File`](crate::Error::File) where it cannot be created.
    pub fn create(path: &Path, config: &Config) -> Result<Self> {
        Ok(Self {
            path: path.into(),
            file: Arc::new(Mutex::new(RosFile::new(create_file(path)?, path)?)),
            map_frame: config.map_frame.clone(),
            base_frame: config.base_frame.clone(),
            camera_frame: config.camera_frame.clone(),
            tau: narrow(config.tau),
            cloud_stride: config.cloud_stride,
            points: TrustedPoints::default(),
            frames: 0,
        })
    }

    fn write_grids(&mut self, output: &FrameOutput) -> Result<()> {
        if let Some(reason) = grid_mismatch(output) {
            return Err(encode_error(&self.path, reason));
        }
        let (stamp_ns, map_frame) = (output.stamp_ns, self.map_frame.clone());
        self.with_file(|file, path| {
            write_costmap(file, path, &TOPICS, stamp_ns, &map_frame, &output.grid, &output.costmap)
        })
    }

    /// Calls `write` with the file.
    pub(super) fn with_file<T>(&mut self, write: impl FnOnce(&mut OutFile, &Path) -> Result<T>) -> Result<T> {
        write(&mut self.file.lock().unwrap_or_else(PoisonError::into_inner), &self.path)
    }

    /// Counts a frame as written; every 15th makes what was written so far readable.
    pub(super) fn end_frame(&mut self) -> Result<()> {
        self.frames += 1;
        if self.frames.is_multiple_of(FRAMES_PER_FLUSH) {
            self.with_file(|file, _| file.flush())
        } else {
            Ok(())
        }
    }

    /// Completes the file unless another sink still writes into it.
    pub(super) fn close(&mut self) -> Result<()> {
        let last = Arc::strong_count(&self.file) == 1;
        self.with_file(|file, _| if last { file.finish().map(|_| ()) } else { file.flush() })
    }

    fn put<M: RosMessage>(&mut self, topic: &str, stamp_ns: u64, message: &M) -> Result<()> {
        self.with_file(|file, _| file.write(topic, stamp_ns, message))
    }

    fn write_transforms(&mut self, stamp_ns: u64, camera_frame: &str, output: &FrameOutput) -> Result<()> {
        let edge = |parent: &str, child: &str, pose: Rigid| TransformStamped {
            header: Header::new(stamp_ns, parent),
            child_frame_id: child.to_owned(),
            transform: pose.into(),
        };
        let mut transforms = vec![edge(&self.map_frame, &self.base_frame, output.map_from_base)];
        // A robot whose base is the camera itself has one edge only.
        if camera_frame != self.base_frame {
            transforms.push(edge(&self.base_frame, camera_frame, output.base_from_camera));
        }
        self.put("/tf", stamp_ns, &TFMessage { transforms })
    }

    fn write_images(&mut self, depth: &DepthImage, header: &Header, images: &FrameImages) -> Result<()> {
        let rounded: Vec<u8> = images.reliability.iter().map(|&r| byte_of_unit(r)).collect();
        let size = (images.width, images.height);
        self.write_image("/limpid/reliability", depth.stamp_ns, header, size, "mono8", rounded)?;
        let floats = bytemuck::cast_slice(&images.reliability).to_vec();
        self.write_image("/limpid/reliability_float", depth.stamp_ns, header, size, "32FC1", floats)?;

        let (encoding, filtered) = filtered_depth(&depth.samples, &images.reliability, self.tau);
        let size = (depth.camera.width, depth.camera.height);
        self.write_image("/limpid/depth_filtered/image", depth.stamp_ns, header, size, encoding, filtered)?;
        let calibration = CameraInfo::new(header.clone(), &depth.camera);
        self.put("/limpid/depth_filtered/camera_info", depth.stamp_ns, &calibration)?;
        if self.cloud_stride == 0 {
            return Ok(());
        }
        let which = (self.tau, self.cloud_stride);
        let cloud = self.points.of(images, &depth.camera, header.clone(), which);
        self.put("/limpid/points_trusted", depth.stamp_ns, &cloud)
    }

    fn write_image(
        &mut self,
        topic: &str,
        stamp_ns: u64,
        header: &Header,
        (width, height): (u32, u32),
        encoding: &str,
        data: Vec<u8>,
    ) -> Result<()> {
        let message = Image {
            header: header.clone(),
            height,
            width,
            encoding: encoding.into(),
            is_bigendian: u8::from(cfg!(target_endian = "big")),
            step: width * bytes_per_pixel(encoding),
            data,
        };
        self.put(topic, stamp_ns, &message)
    }

    fn check_sizes(&self, depth: &DepthImage, images: &FrameImages) -> Result<()> {
        let pixels = depth.camera.width as usize * depth.camera.height as usize;
        let same_size = (images.width, images.height) == (depth.camera.width, depth.camera.height);
        let lengths = [images.reliability.len(), images.depth_m.len(), depth.samples.len()];
        if same_size && lengths == [pixels; 3] {
            return Ok(());
        }
        let reason = format!(
            "{} samples, {} depths and {} reliabilities ({}x{}) do not fit a {}x{} depth image",
            depth.samples.len(),
            images.depth_m.len(),
            images.reliability.len(),
            images.width,
            images.height,
            depth.camera.width,
            depth.camera.height
        );
        Err(encode_error(&self.path, reason))
    }
}

impl Sink for McapSink {
    fn write(&mut self, input: &RgbdFrame, output: &FrameOutput) -> Result<()> {
        let depth = &input.depth;
        let camera_frame = [&depth.frame_id, &self.camera_frame].into_iter().find(|name| !name.is_empty());
        let camera_frame = camera_frame.map_or(NAMELESS_CAMERA_FRAME, String::as_str).to_owned();
        self.write_grids(output)?;
        self.put("/limpid/diagnostics", output.stamp_ns, &diagnostics::of_frame(output, &camera_frame))?;
        self.write_transforms(depth.stamp_ns, &camera_frame, output)?;
        if let Some(images) = &output.images {
            self.check_sizes(depth, images)?;
            self.write_images(depth, &Header::new(depth.stamp_ns, &camera_frame), images)?;
        }
        self.end_frame()
    }

    fn finish(&mut self) -> Result<()> {
        self.close()
    }
}

/// A grid of values 0..=100 or -1.
pub(super) fn occupancy_grid<'a>(
    stamp_ns: u64,
    map_frame: &str,
    grid: &Grid,
    data: &'a Bytes,
) -> OccupancyGrid<'a> {
    let info = MapMetaData {
        map_load_time: Time::from_stamp_ns(stamp_ns),
        resolution: narrow(grid.resolution_m),
        width: grid.width,
        height: grid.height,
        origin: origin(grid),
    };
    OccupancyGrid { header: Header::new(stamp_ns, map_frame), info, data }
}

fn origin(grid: &Grid) -> Pose {
    let corner = Vector3 { x: grid.origin_x_m, y: grid.origin_y_m, z: 0.0 };
    Pose { position: corner, orientation: Quaternion::default() }
}

/// Writes Nav2 costs as an `OccupancyGrid` and as a `Costmap`.
pub(super) fn write_costmap(
    file: &mut OutFile,
    path: &Path,
    topics: &GridTopics,
    stamp_ns: u64,
    map_frame: &str,
    grid: &Grid,
    costmap: &[u8],
) -> Result<()> {
    if costmap.len() != grid.width as usize * grid.height as usize {
        return Err(encode_error(path, "the costs do not fill the grid"));
    }
    let occupancy: Vec<u8> = costmap.iter().map(|&c| occupancy_of_cost(c).cast_unsigned()).collect();
    let message = occupancy_grid(stamp_ns, map_frame, grid, Bytes::new(&occupancy));
    file.write(topics.occupancy, stamp_ns, &message)?;
    let time = Time::from_stamp_ns(stamp_ns);
    let metadata = CostmapMetaData {
        map_load_time: time,
        update_time: time,
        layer: topics.layer.into(),
        resolution: narrow(grid.resolution_m),
        size_x: grid.width,
        size_y: grid.height,
        origin: origin(grid),
    };
    let message = Costmap { header: Header::new(stamp_ns, map_frame), metadata, data: Bytes::new(costmap) };
    file.write(topics.raw, stamp_ns, &message)
}

fn bytes_per_pixel(encoding: &str) -> u32 {
    match encoding {
        "mono8" => 1,
        "16UC1" => 2,
        _ => 4,
    }
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

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..=255; NaN becomes 0"
)]
fn byte_of_unit(share: f32) -> u8 {
    (share.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// The samples as the sensor wrote them, 0 where reliability is not above `tau`; encoding and bytes.
fn filtered_depth(samples: &DepthSamples, reliability: &[f32], tau: f32) -> (&'static str, Vec<u8>) {
    // Written so that a NaN reliability removes its pixel.
    let trusted = |r: f32| r > tau;
    match samples {
        DepthSamples::Integer { raw, .. } => {
            let kept: Vec<u16> =
                raw.iter().zip(reliability).map(|(&d, &r)| if trusted(r) { d } else { 0 }).collect();
            ("16UC1", bytemuck::cast_slice(&kept).to_vec())
        }
        DepthSamples::Metres(metres) => {
            let kept: Vec<f32> =
                metres.iter().zip(reliability).map(|(&d, &r)| if trusted(r) { d } else { 0.0 }).collect();
            ("32FC1", bytemuck::cast_slice(&kept).to_vec())
        }
    }
}
