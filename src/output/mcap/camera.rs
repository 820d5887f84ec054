//! What came of a camera's frame as ROS 2 messages.

use super::Out;
use crate::base::Result;
use crate::config::Config;
use crate::map::FrameImages;
use crate::message::ros2::{CameraInfo, Header, Image};
use crate::output::cloud::TrustedPoints;
use crate::output::narrow;
use crate::sensor::{DepthImage, DepthSamples};

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

    pub(super) fn write(
        &mut self,
        out: &mut Out,
        frame: &str,
        depth: &DepthImage,
        images: &FrameImages,
    ) -> Result<()> {
        check_sizes(out, depth, images)?;
        let header = Header::new(depth.stamp_ns, frame);
        let topic = |name: &str| format!("{}/{name}", self.prefix);
        let mut put = |name: &str, size: (u32, u32), encoding: &str, data: Vec<u8>| {
            out.put(&topic(name), depth.stamp_ns, &image(&header, size, encoding, data))
        };
        let rounded: Vec<u8> = images.reliability.iter().map(|&r| byte_of_unit(r)).collect();
        let size = (images.width, images.height);
        put("reliability", size, "mono8", rounded)?;
        let floats = bytemuck::cast_slice(&images.reliability).to_vec();
        put("reliability_float", size, "32FC1", floats)?;

        let (encoding, filtered) = filtered_depth(&depth.samples, &images.reliability, self.tau);
        let size = (depth.camera.width, depth.camera.height);
        put("depth_filtered/image", size, encoding, filtered)?;
        let calibration = CameraInfo::new(header.clone(), &depth.camera);
        out.put(&topic("depth_filtered/camera_info"), depth.stamp_ns, &calibration)?;
        if self.cloud_stride == 0 {
            return Ok(());
        }
        let which = (self.tau, self.cloud_stride);
        let cloud = self.points.of(images, &depth.camera, header, which);
        out.put(&topic("points_trusted"), depth.stamp_ns, &cloud)
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

fn check_sizes(out: &Out, depth: &DepthImage, images: &FrameImages) -> Result<()> {
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
    Err(out.error(reason))
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
