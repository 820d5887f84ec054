//! Point clouds as `sensor_msgs/PointCloud2`, and the cloud of trusted points of a frame.

use crate::map::FrameImages;
use crate::message::ros2::{Header, PointCloud2, PointField};
use crate::sensor::CameraModel;

/// `sensor_msgs/PointField`'s code of 32-bit floats.
pub const FLOAT32: u8 = 7;

/// A cloud in one row, its fields packed one after another in the order given as (name, datatype, bytes); `data` holds
/// whole points, little-endian, all finite.
pub fn cloud(header: Header, fields: &[(&str, u8, u32)], data: Vec<u8>) -> PointCloud2 {
    let mut point_step = 0;
    let mut place = |&(name, datatype, bytes): &(&str, u8, u32)| {
        let offset = point_step;
        point_step += bytes;
        PointField { name: name.into(), offset, datatype, count: 1 }
    };
    let fields = fields.iter().map(&mut place).collect();
    let points = data.len() / (point_step as usize).max(1);
    let width = u32::try_from(points).unwrap_or(u32::MAX);
    let row_step = width.saturating_mul(point_step);
    PointCloud2 { header, height: 1, width, fields, is_bigendian: 0, point_step, row_step, data, is_dense: 1 }
}

/// The points of a depth camera's pixels: rays of one calibration, kept while it stays the same.
#[derive(Debug, Clone, Default)]
pub(crate) struct TrustedPoints {
    of: Option<CameraModel>,
    /// x and y at a depth of 1 m; `None` outside the lens model's field.
    rays: Vec<Option<[f64; 2]>>,
}

impl TrustedPoints {
    /// Points in the camera's optical frame (metres) with their reliability, of every `stride`-th pixel along rows and
    /// columns that has depth and a reliability above `tau` (spec 0, "Outputs").
    pub(crate) fn of(
        &mut self,
        images: &FrameImages,
        camera: &CameraModel,
        header: Header,
        (tau, stride): (f32, u32),
    ) -> PointCloud2 {
        if self.of.as_ref() != Some(camera) {
            let pixels = (0..camera.height).flat_map(|v| (0..camera.width).map(move |u| (u, v)));
            self.rays = pixels.map(|(u, v)| camera.ray(f64::from(u), f64::from(v))).collect();
            self.of = Some(*camera);
        }
        let mut data = Vec::new();
        let stride = stride.max(1) as usize;
        for row in (0..camera.height).step_by(stride) {
            for column in (0..camera.width).step_by(stride) {
                let pixel = row as usize * camera.width as usize + column as usize;
                let (depth_m, reliability) = (images.depth_m[pixel], images.reliability[pixel]);
                let Some([x, y]) = self.rays[pixel].filter(|_| depth_m > 0.0 && reliability > tau) else {
                    continue;
                };
                let [x_m, y_m] = [x, y].map(|ray| crate::base::single(ray * f64::from(depth_m)));
                for value in [x_m, y_m, depth_m, reliability] {
                    data.extend_from_slice(&value.to_le_bytes());
                }
            }
        }
        let fields = ["x", "y", "z", "reliability"].map(|name| (name, FLOAT32, 4));
        cloud(header, &fields, data)
    }
}
