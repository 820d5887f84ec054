//! `visualization_msgs/MarkerArray`, as far as panes need it: boxes.

use serde::Serialize;

use crate::message::RosMessage;
use crate::message::ros2::{CompressedImage, Header, Pose, Vector3};

/// `std_msgs/ColorRGBA`, 0 to 1.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Color {
    pub(crate) r: f32,
    pub(crate) g: f32,
    pub(crate) b: f32,
    pub(crate) a: f32,
}

/// `builtin_interfaces/Duration`.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct Span {
    sec: i32,
    nanosec: u32,
}

#[derive(Debug, Clone, Default, Serialize)]
struct MeshFile {
    filename: String,
    data: Vec<u8>,
}

/// `visualization_msgs/Marker`; fields in the order of the definition.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Marker {
    header: Header,
    ns: String,
    id: i32,
    kind: i32,
    action: i32,
    pose: Pose,
    scale: Vector3,
    color: Color,
    lifetime: Span,
    frame_locked: bool,
    points: Vec<Vector3>,
    colors: Vec<Color>,
    texture_resource: String,
    texture: CompressedImage,
    uv_coordinates: Vec<[f32; 2]>,
    text: String,
    mesh_resource: String,
    mesh_file: MeshFile,
    mesh_use_embedded_materials: bool,
}

/// `visualization_msgs/MarkerArray`.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct MarkerArray {
    pub(crate) markers: Vec<Marker>,
}

impl RosMessage for MarkerArray {
    const TYPE: &'static str = "visualization_msgs/msg/MarkerArray";
}

/// Marker types and actions.
const CUBE: i32 = 1;
const ADD: i32 = 0;
const DELETE_ALL: i32 = 3;

impl Marker {
    fn empty(header: Header, ns: &str, action: i32) -> Self {
        Self {
            header,
            ns: ns.into(),
            id: 0,
            kind: CUBE,
            action,
            pose: Pose::default(),
            scale: Vector3::default(),
            color: Color { r: 0.0, g: 0.0, b: 0.0, a: 0.0 },
            lifetime: Span::default(),
            frame_locked: false,
            points: Vec::new(),
            colors: Vec::new(),
            texture_resource: String::new(),
            texture: CompressedImage::default(),
            uv_coordinates: Vec::new(),
            text: String::new(),
            mesh_resource: String::new(),
            mesh_file: MeshFile::default(),
            mesh_use_embedded_materials: false,
        }
    }

    /// What takes all earlier markers away.
    pub(crate) fn delete_all(header: Header, ns: &str) -> Self {
        Self::empty(header, ns, DELETE_ALL)
    }

    /// A box of these sides (metres) about `pose`.
    pub(crate) fn cube(header: Header, ns: &str, id: i32, pose: Pose, scale: Vector3, color: Color) -> Self {
        Self { id, pose, scale, color, ..Self::empty(header, ns, ADD) }
    }
}
