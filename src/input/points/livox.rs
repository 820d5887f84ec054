//! The Livox driver's own message, `CustomMsg`.

use crate::base::Result;
use crate::input::points::check_points;
use crate::input::points::fields::narrow;
use crate::message::lidar::{CustomMsg, CustomPoint};
use crate::message::ros2::Header;
use crate::message::{bare_frame, decode_error};
use crate::sensor::{Columns, DropReason, Dropped, Point, PointClock, ReturnType, Scan, Strength};

const WHAT: &str = "livox CustomMsg";

/// `timebase` and the stamp are of one clock where they are no farther apart than this, nanoseconds.
const SAME_CLOCK_NS: u64 = 2_000_000_000;

/// The start of a `CustomMsg`.
#[derive(Debug, serde::Deserialize)]
#[serde(rename = "CustomMsg")]
pub(crate) struct CustomHead {
    #[expect(dead_code, reason = "it stands before the number of points")]
    header: Header,
    #[expect(dead_code, reason = "as the header")]
    timebase: u64,
    point_num: u32,
}

/// Refuses a message that says that it has too many points, before memory is taken for them.
///
/// # Errors
/// [`crate::Error::Decode`] with the number of points.
pub(crate) fn check_size(head: &CustomHead) -> Result<()> {
    check_points(WHAT, head.point_num.into())
}

/// The scan in a message: times count from its `timebase`, which is the stamp in most recordings; rings there are none, as a
/// `line` is a laser that draws a rosette.
///
/// # Errors
/// [`crate::Error::Decode`] where `point_num` contradicts the points, and for stamps before 1970.
pub fn from_custom_msg(message: CustomMsg) -> Result<Scan> {
    check_points(WHAT, message.points.len() as u64)?;
    if message.point_num as usize != message.points.len() {
        let reason = format!("point_num is {} for {} points", message.point_num, message.points.len());
        return Err(decode_error(WHAT, reason));
    }
    let stated_ns = message.header.stamp.stamp_ns()?;
    let stamp_ns = if stated_ns == 0 { message.timebase } else { stated_ns };
    let same_clock = stamp_ns.abs_diff(message.timebase) <= SAME_CLOCK_NS;
    let base_ns = if same_clock { message.timebase } else { stamp_ns };
    let (mut points, mut dropped) = (Vec::with_capacity(message.points.len()), Dropped::default());
    for point in &message.points {
        match reason(point) {
            Some(reason) => dropped.add(reason, 1),
            None => points.push(placed(point, base_ns, stamp_ns)),
        }
    }
    let clock = if same_clock { PointClock::Stamp } else { PointClock::Own };
    let columns = Columns { time: true, clock, ..Columns::default() };
    Ok(Scan { index: 0, stamp_ns, frame_id: bare_frame(message.header.frame_id), points, columns, dropped })
}

fn reason(point: &CustomPoint) -> Option<DropReason> {
    let place = [point.x, point.y, point.z];
    if !place.iter().all(|value| value.is_finite()) {
        Some(DropReason::NotFinite)
    } else if place == [0.0; 3] {
        Some(DropReason::NoReturn)
    } else {
        None
    }
}

fn placed(point: &CustomPoint, base_ns: u64, stamp_ns: u64) -> Point {
    let at_ns = i128::from(base_ns) + i128::from(point.offset_time) - i128::from(stamp_ns);
    #[expect(clippy::cast_precision_loss, reason = "at most a few seconds")]
    let time_s = narrow(at_ns as f64 * 1e-9);
    Point {
        x_m: point.x,
        y_m: point.y,
        z_m: point.z,
        intensity: point.reflectivity.into(),
        time_s,
        ring: Point::UNKNOWN,
        column: Point::UNKNOWN,
        return_type: ReturnType::Single,
        strength: Strength::Unknown,
        reserved: 0,
        label: Point::UNLABELLED,
    }
}
