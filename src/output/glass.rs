//! Labelled and cleaned clouds and panes of a scan as ROS 2 messages.

use glam::{DMat3, DQuat, DVec3};

use crate::map::Pane;
use crate::map::clean::cleaned;
use crate::map::glass::{LabelledScan, PointClass};
use crate::message::marker::{Color, Marker, MarkerArray};
use crate::message::ros2::{Header, PointCloud2, PointField, Pose};
use crate::sensor::{Point, Scan};

/// `sensor_msgs/PointField`'s codes, with bytes.
const UINT8: (u8, u32) = (2, 1);
const UINT16: (u8, u32) = (4, 2);
const UINT32: (u8, u32) = (6, 4);
const FLOAT32: (u8, u32) = (7, 4);

/// What a point of both clouds holds, packed in this order.
const FIELDS: [(&str, (u8, u32)); 8] = [
    ("x", FLOAT32),
    ("y", FLOAT32),
    ("z", FLOAT32),
    ("intensity", FLOAT32),
    ("ring", UINT16),
    ("return_type", UINT8),
    ("class", UINT8),
    ("plane_id", UINT32),
];

/// Thickness of a pane as it is shown, metres.
const SHOWN_THICKNESS_M: f64 = 0.02;
const SHOWN_COLOR: Color = Color { r: 0.2, g: 0.8, b: 0.9, a: 0.4 };

fn push(data: &mut Vec<u8>, place_m: [f32; 3], point: &Point, class: PointClass, pane_id: u32) {
    for value in place_m.into_iter().chain([point.intensity]) {
        data.extend(value.to_le_bytes());
    }
    data.extend(point.ring.to_le_bytes());
    data.extend([point.return_type as u8, class as u8]);
    data.extend(pane_id.to_le_bytes());
}

fn cloud(header: Header, data: Vec<u8>) -> PointCloud2 {
    let mut point_step = 0;
    let mut fields = Vec::new();
    for (name, (datatype, bytes)) in FIELDS {
        fields.push(PointField { name: name.into(), offset: point_step, datatype, count: 1 });
        point_step += bytes;
    }
    let width = u32::try_from(data.len()).unwrap_or(u32::MAX) / point_step;
    let row_step = width * point_step;
    PointCloud2 { header, height: 1, width, fields, is_bigendian: 0, point_step, row_step, data, is_dense: 1 }
}

/// Every point as it was measured, with its class ([`PointClass`] as its number) and pane.
pub(super) fn labelled_cloud(header: Header, scan: &Scan, labelled: &LabelledScan) -> PointCloud2 {
    let mut data = Vec::new();
    for (point, &(class, pane_id)) in scan.points.iter().zip(&labelled.classes) {
        push(&mut data, point.position_m(), point, class, pane_id);
    }
    cloud(header, data)
}

/// The cleaned cloud ([`cleaned`]).
pub(super) fn cleaned_cloud(header: Header, scan: &Scan, labelled: &LabelledScan) -> PointCloud2 {
    let mut data = Vec::new();
    for point in cleaned(scan, labelled) {
        push(&mut data, point.place_m.as_vec3().to_array(), point.measured, point.class, point.pane_id);
    }
    cloud(header, data)
}

/// The panes as thin boxes, after a marker that takes those of the scan before away.
pub(super) fn pane_markers(header: &Header, panes: &[Pane]) -> MarkerArray {
    const NAMESPACE: &str = "panes";
    let mut markers = vec![Marker::delete_all(header.clone(), NAMESPACE)];
    for pane in panes {
        let n = pane.unit_normal().as_dvec3();
        let u = pane.level.truncate().as_dvec3();
        let rotation = DQuat::from_mat3(&DMat3::from_cols(n, u, n.cross(u))).normalize();
        let pose = Pose { position: pane.centre_m().into(), orientation: rotation.into() };
        let [u0, u1, v0, v1] = pane.extent_m.to_array().map(f64::from);
        let size = DVec3::new(SHOWN_THICKNESS_M, u1 - u0, v1 - v0);
        let id = i32::try_from(pane.id).unwrap_or(i32::MAX);
        markers.push(Marker::cube(header.clone(), NAMESPACE, id, pose, size.into(), SHOWN_COLOR));
    }
    MarkerArray { markers }
}
