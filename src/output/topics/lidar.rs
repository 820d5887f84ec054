//! What came of a scan as ROS 2 messages: labelled and cleaned clouds, and panes.

use glam::{DMat3, DQuat, DVec3};

use super::{Named, TopicSink};
use crate::base::Result;
use crate::map::Pane;
use crate::map::clean::cleaned;
use crate::map::glass::{LabelledScan, PointClass};
use crate::message::RosMessage;
use crate::message::marker::{Color, Marker, MarkerArray};
use crate::message::ros2::{Header, PointCloud2, Pose};
use crate::output::cloud::{FLOAT32, cloud};
use crate::sensor::{Point, Scan};

/// `sensor_msgs/PointField`'s codes.
const UINT8: u8 = 2;
const UINT16: u8 = 4;
const UINT32: u8 = 6;

/// What a point of both clouds holds, packed in this order: name, code and bytes.
const FIELDS: [(&str, u8, u32); 8] = [
    ("x", FLOAT32, 4),
    ("y", FLOAT32, 4),
    ("z", FLOAT32, 4),
    ("intensity", FLOAT32, 4),
    ("ring", UINT16, 2),
    ("return_type", UINT8, 1),
    ("class", UINT8, 1),
    ("plane_id", UINT32, 4),
];

/// Thickness of a pane as it is shown, metres.
const SHOWN_THICKNESS_M: f64 = 0.02;
const SHOWN_COLOR: Color = Color { r: 0.2, g: 0.8, b: 0.9, a: 0.4 };
/// And of mirrors.
const MIRROR_COLOR: Color = Color { r: 0.8, g: 0.8, b: 0.9, a: 0.8 };

const POINTS: &str = "glass/points";
const CLEANED: &str = "glass/cleaned";
const PANES: &str = "glass/panes";

/// Topics of a lidar whose scans are searched for glass.
pub(super) const TOPICS: [Named; 3] =
    [(POINTS, PointCloud2::TYPE), (CLEANED, PointCloud2::TYPE), (PANES, MarkerArray::TYPE)];

/// Writes what a scan's labels say, in the lidar's frame; the topics' names begin with `prefix`.
pub(super) fn write(
    out: &mut impl TopicSink,
    prefix: &str,
    frame: &str,
    scan: &Scan,
    labelled: &LabelledScan,
) -> Result<()> {
    let stamp_ns = scan.stamp_ns;
    let header = || Header::new(stamp_ns, frame);
    let [points, cleaned, panes] = [POINTS, CLEANED, PANES].map(|name| format!("{prefix}{name}"));
    if out.wants(&points) {
        out.put(&points, stamp_ns, &labelled_cloud(header(), scan, labelled))?;
    }
    if out.wants(&cleaned) {
        out.put(&cleaned, stamp_ns, &cleaned_cloud(header(), scan, labelled))?;
    }
    if out.wants(&panes) {
        out.put(&panes, stamp_ns, &pane_markers(&header(), &labelled.panes))?;
    }
    Ok(())
}

fn push(data: &mut Vec<u8>, place_m: [f32; 3], point: &Point, class: PointClass, pane_id: u32) {
    for value in place_m.into_iter().chain([point.intensity]) {
        data.extend(value.to_le_bytes());
    }
    data.extend(point.ring.to_le_bytes());
    data.extend([point.return_type as u8, class as u8]);
    data.extend(pane_id.to_le_bytes());
}

/// Every point as it was measured, with its class ([`PointClass`] as its number) and pane.
fn labelled_cloud(header: Header, scan: &Scan, labelled: &LabelledScan) -> PointCloud2 {
    let mut data = Vec::new();
    for (point, &(class, pane_id)) in scan.points.iter().zip(&labelled.classes) {
        push(&mut data, point.position_m(), point, class, pane_id);
    }
    cloud(header, &FIELDS, data)
}

/// The cleaned cloud ([`cleaned`]).
fn cleaned_cloud(header: Header, scan: &Scan, labelled: &LabelledScan) -> PointCloud2 {
    let mut data = Vec::new();
    for point in cleaned(scan, labelled) {
        push(&mut data, point.place_m.as_vec3().to_array(), point.measured, point.class, point.pane_id);
    }
    cloud(header, &FIELDS, data)
}

/// The panes as thin boxes, after a marker that takes those of the scan before away.
fn pane_markers(header: &Header, panes: &[Pane]) -> MarkerArray {
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
        let color = if pane.is_mirror() { MIRROR_COLOR } else { SHOWN_COLOR };
        markers.push(Marker::cube(header.clone(), NAMESPACE, id, pose, size.into(), color));
    }
    MarkerArray { markers }
}
