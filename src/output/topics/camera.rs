//! What came of a camera's frame as ROS 2 messages.

use super::{Named, TopicSink};
use crate::base::Result;
use crate::config::Config;
use crate::map::FrameImages;
use crate::message::RosMessage;
use crate::message::ros2::{CameraInfo, Header, Image, PointCloud2};
use crate::output::cloud::TrustedPoints;
use crate::output::narrow;
use crate::sensor::{DepthImage, DepthSamples};

const RELIABILITY: &str = "reliability";
const RELIABILITY_FLOAT: &str = "reliability_float";
const FILTERED: &str = "depth_filtered/image";
const FILTERED_INFO: &str = "depth_filtered/camera_info";
const POINTS: &str = "points_trusted";

/// Topics of a camera; the cloud is the last, as not every camera has one.
pub(super) const TOPICS: [Named; 5] = [
    (RELIABILITY, Image::TYPE),
    (RELIABILITY_FLOAT, Image::TYPE),
    (FILTERED, Image::TYPE),
    (FILTERED_INFO, CameraInfo::TYPE),
    (POINTS, PointCloud2::TYPE),
];

/// How the images of one camera are written.
pub(super) struct CameraTopics {
    /// What the names of its topics begin with.
    prefix: String,
    tau: f32,
    cloud_stride: u32,
    points: TrustedPoints,
}

impl CameraTopics {
    pub(super) fn new(prefix: &str, config: &Config) -> Self {
        Self {
            prefix: prefix.into(),
            tau: narrow(config.tau),
            cloud_stride: config.cloud_stride,
            points: TrustedPoints::default(),
        }
    }

    /// Whether its trusted points are told.
    pub(super) fn has_cloud(&self) -> bool {
        self.cloud_stride > 0
    }

    /// Whether anything of its images is wanted.
    pub(super) fn wanted(&self, out: &impl TopicSink) -> bool {
        TOPICS.iter().any(|(name, _)| out.wants(&format!("{}{name}", self.prefix)))
    }

    pub(super) fn write(
        &mut self,
        out: &mut impl TopicSink,
        frame: &str,
        depth: &DepthImage,
        images: &FrameImages,
    ) -> Result<()> {
        if !self.wanted(out) {
            return Ok(());
        }
        let prefix = self.prefix.clone();
        let topic = |name: &str| format!("{prefix}{name}");
        if let Some(reason) = size_mismatch(depth, images) {
            return Err(out.error(reason));
        }
        let (stamp_ns, header) = (depth.stamp_ns, Header::new(depth.stamp_ns, frame));
        let size = (images.width, images.height);
        if out.wants(&topic(RELIABILITY)) {
            let rounded = images.reliability.iter().map(|&r| byte_of_unit(r)).collect();
            out.put(&topic(RELIABILITY), stamp_ns, &image(&header, size, "mono8", rounded))?;
        }
        if out.wants(&topic(RELIABILITY_FLOAT)) {
            let floats = bytemuck::cast_slice(&images.reliability).to_vec();
            out.put(&topic(RELIABILITY_FLOAT), stamp_ns, &image(&header, size, "32FC1", floats))?;
        }
        if out.wants(&topic(FILTERED)) {
            let (encoding, filtered) = filtered_depth(&depth.samples, &images.reliability, self.tau);
            out.put(&topic(FILTERED), stamp_ns, &image(&header, size, encoding, filtered))?;
        }
        if out.wants(&topic(FILTERED_INFO)) {
            let calibration = CameraInfo::new(header.clone(), &depth.camera);
            out.put(&topic(FILTERED_INFO), stamp_ns, &calibration)?;
        }
        if self.has_cloud() && out.wants(&topic(POINTS)) {
            let which = (self.tau, self.cloud_stride);
            let cloud = self.points.of(images, &depth.camera, header, which);
            out.put(&topic(POINTS), stamp_ns, &cloud)?;
        }
        Ok(())
    }
}

fn image(header: &Header, (width, height): (u32, u32), encoding: &str, data: Vec<u8>) -> Image {
    Image {
        header: header.clone(),
        height,
        width,
        encoding: encoding.into(),
        is_bigendian: u8::from(cfg!(target_endian = "big")),
        step: width * bytes_per_pixel(encoding),
        data,
    }
}

/// How a depth image and what came of it disagree, if they do.
fn size_mismatch(depth: &DepthImage, images: &FrameImages) -> Option<String> {
    let pixels = depth.camera.width as usize * depth.camera.height as usize;
    let same_size = (images.width, images.height) == (depth.camera.width, depth.camera.height);
    let lengths = [images.reliability.len(), images.depth_m.len(), depth.samples.len()];
    if same_size && lengths == [pixels; 3] {
        return None;
    }
    Some(format!(
        "{} samples, {} depths and {} reliabilities ({}x{}) do not fit a {}x{} depth image",
        depth.samples.len(),
        images.depth_m.len(),
        images.reliability.len(),
        images.width,
        images.height,
        depth.camera.width,
        depth.camera.height
    ))
}

fn bytes_per_pixel(encoding: &str) -> u32 {
    match encoding {
        "mono8" => 1,
        "16UC1" => 2,
        _ => 4,
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
