//! Where a sensor was in the map.

use crate::base::Rigid;
use crate::map::Update;
use crate::message::ros2::{Header, TFMessage, TransformStamped};

/// Map from base and base from sensor; `None` where the map is the sensor's own frame.
pub(crate) fn transforms(
    stamp_ns: u64,
    base_frame: &str,
    sensor_frame: &str,
    update: &Update,
) -> Option<TFMessage> {
    let map_frame = update.map_frame.as_str();
    if map_frame == sensor_frame {
        return None;
    }
    let edge = |parent: &str, child: &str, pose: Rigid| TransformStamped {
        header: Header::new(stamp_ns, parent),
        child_frame_id: child.to_owned(),
        transform: pose.into(),
    };
    let mut transforms = vec![edge(map_frame, base_frame, update.map_from_base)];
    // A robot whose base is the sensor itself has one edge only.
    if sensor_frame != base_frame {
        transforms.push(edge(base_frame, sensor_frame, update.base_from_sensor));
    }
    Some(TFMessage { transforms })
}
