//! Schema texts in MCAP's `ros2msg` encoding: a definition followed by those it needs.

use std::fmt::Write as _;

/// ROS package and name of an interface, and its definition.
struct Definition {
    name: &'static str,
    text: &'static str,
}

macro_rules! definitions {
    ($($package:literal $name:literal),* $(,)?) => {
        &[$(Definition {
            name: concat!($package, "/", $name),
            text: include_str!(concat!("schema/", $package, "_", $name, ".msg")),
        }),*]
    };
}

/// Every interface that limpid writes, from the public ROS 2 interface definitions and Foxglove's.
const DEFINITIONS: &[Definition] = definitions![
    "builtin_interfaces" "Duration",
    "builtin_interfaces" "Time",
    "diagnostic_msgs" "DiagnosticArray",
    "diagnostic_msgs" "DiagnosticStatus",
    "diagnostic_msgs" "KeyValue",
    "foxglove_msgs" "Grid",
    "foxglove_msgs" "PackedElementField",
    "foxglove_msgs" "Vector2",
    "geometry_msgs" "Point",
    "geometry_msgs" "Pose",
    "geometry_msgs" "Quaternion",
    "geometry_msgs" "Transform",
    "geometry_msgs" "TransformStamped",
    "geometry_msgs" "Vector3",
    "nav2_msgs" "Costmap",
    "nav2_msgs" "CostmapMetaData",
    "nav_msgs" "MapMetaData",
    "nav_msgs" "OccupancyGrid",
    "sensor_msgs" "CameraInfo",
    "sensor_msgs" "CompressedImage",
    "sensor_msgs" "Image",
    "sensor_msgs" "PointCloud2",
    "sensor_msgs" "PointField",
    "sensor_msgs" "RegionOfInterest",
    "std_msgs" "ColorRGBA",
    "std_msgs" "Header",
    "std_msgs" "String",
    "tf2_msgs" "TFMessage",
    "velodyne_msgs" "VelodynePacket",
    "velodyne_msgs" "VelodyneScan",
    "visualization_msgs" "Marker",
    "visualization_msgs" "MarkerArray",
    "visualization_msgs" "MeshFile",
    "visualization_msgs" "UVCoordinate",
];

/// Line between the definitions of one schema.
const SEPARATOR: &str = "================================================================================";

/// Schema of `type_name` (as in `nav_msgs/msg/OccupancyGrid`) with all definitions it needs, each once.
///
/// # Errors
/// The name of the interface that has no definition here.
pub(crate) fn full_text(type_name: &str) -> Result<String, String> {
    let root = definition(&type_name.replace("/msg/", "/"))?;
    let mut text = root.text.to_owned();
    let mut needed = dependencies(root);
    let mut next = 0;
    while let Some(&name) = needed.get(next) {
        let part = definition(name)?;
        // Writing into a String cannot fail.
        let _ = write!(text, "{SEPARATOR}\nMSG: {}\n{}", part.name, part.text);
        let new: Vec<_> = dependencies(part).into_iter().filter(|name| !needed.contains(name)).collect();
        needed.extend(new);
        next += 1;
    }
    Ok(text)
}

fn definition(name: &str) -> Result<&'static Definition, String> {
    DEFINITIONS.iter().find(|d| d.name == name).ok_or_else(|| format!("no definition of {name}"))
}

/// Types of other packages or messages among the fields, each once, in order.
fn dependencies(definition: &Definition) -> Vec<&'static str> {
    let mut names = Vec::new();
    for line in definition.text.lines().filter(|line| !line.starts_with('#')) {
        let field_type = line.split([' ', '[']).next().unwrap_or_default();
        if field_type.contains('/') && !names.contains(&field_type) {
            names.push(field_type);
        }
    }
    names
}
