//! `sensor_msgs/LaserScan`, `MultiEchoLaserScan` and `foxglove.LaserScan`: one ring at the height of its frame.

use crate::base::Result;
use crate::input::points::check_points;
use crate::input::points::cloud::place;
use crate::input::points::fields::narrow;
use crate::message::foxglove;
use crate::message::lidar::{FlatScan, LaserScan, MultiEchoLaserScan};
use crate::message::{bare_frame, decode_error};
use crate::sensor::{Columns, DropReason, Dropped, Point, PointClock, ReturnType, Scan, Strength};

const FLAT: &str = "sensor_msgs/LaserScan";
const MULTI: &str = "sensor_msgs/MultiEchoLaserScan";
const FOXGLOVE: &str = "foxglove.LaserScan";

/// The rays of a scan, whatever message they came in.
struct Rays {
    what: &'static str,
    angle_min: f64,
    angle_step: f64,
    time_step_s: f64,
    range_min: f32,
    range_max: f32,
}

impl Rays {
    fn of<R>(what: &'static str, message: &FlatScan<R>) -> Self {
        Self {
            what,
            angle_min: message.angle_min.into(),
            angle_step: message.angle_increment.into(),
            time_step_s: message.time_increment.into(),
            range_min: message.range_min,
            range_max: message.range_max,
        }
    }

    fn check(&self, rays: usize) -> Result<()> {
        #[expect(clippy::cast_precision_loss, reason = "far fewer rays than 2^53")]
        let last = rays.saturating_sub(1) as f64;
        // Where both ends are finite so is all between.
        let ends = [self.angle_min, self.angle_min + last * self.angle_step, self.angle_step];
        let times = [self.time_step_s, narrow(last * self.time_step_s).into()];
        if ends.iter().chain(&times).any(|number| !number.is_finite())
            || self.range_min.is_nan()
            || self.range_max.is_nan()
        {
            return Err(decode_error(self.what, "its angles, times or limits of range are not finite"));
        }
        if self.angle_step == 0.0 && rays > 1 {
            return Err(decode_error(self.what, format!("angle_increment is 0 for {rays} ranges")));
        }
        Ok(())
    }

    /// As the message's definition says: a range outside of the limits is to be discarded. Like ROS's laser_geometry it takes
    /// range_max itself, which many drivers give where nothing came back, for no return. REP 117: NaN is an erroneous
    /// measurement, infinity no return, minus infinity an object too close.
    fn reason(&self, range_m: f32) -> Option<DropReason> {
        if range_m.is_nan() {
            Some(DropReason::NotFinite)
        } else if !(range_m >= self.range_min && range_m < self.range_max) || range_m <= 0.0 {
            Some(DropReason::NoReturn)
        } else {
            None
        }
    }

    fn point(&self, ray: usize, range_m: f32, intensity: f32, return_type: ReturnType) -> Point {
        #[expect(clippy::cast_precision_loss, reason = "far fewer rays than 2^53")]
        let at = ray as f64;
        let (sin, cos) = (self.angle_min + at * self.angle_step).sin_cos();
        Point {
            x_m: narrow(f64::from(range_m) * cos),
            y_m: narrow(f64::from(range_m) * sin),
            z_m: 0.0,
            // One bad intensity makes no hole in a wall.
            intensity: if intensity.is_finite() { intensity } else { 0.0 },
            time_s: narrow(at * self.time_step_s),
            ring: 0,
            column: u16::try_from(ray).unwrap_or(Point::UNKNOWN),
            return_type,
            strength: Strength::Unknown,
            reserved: 0,
            label: Point::UNLABELLED,
        }
    }

    fn columns(&self, intensity: bool, return_type: bool) -> Columns {
        Columns {
            intensity,
            ring: true,
            column: true,
            time: self.time_step_s != 0.0,
            clock: PointClock::Stamp,
            return_type,
            label: false,
        }
    }

    /// The scan of rays with one echo each, without stamp and frame.
    ///
    /// # Errors
    /// [`crate::Error::Decode`] as [`Self::check`], and for more points than are read.
    fn single(&self, ranges: &[f32], intensities: &[f32]) -> Result<Scan> {
        self.check(ranges.len())?;
        check_points(self.what, ranges.len() as u64)?;
        let has_intensity = has_numbers(intensities, ranges.len());
        let (mut points, mut dropped) = (Vec::with_capacity(ranges.len()), Dropped::default());
        for (ray, &range_m) in ranges.iter().enumerate() {
            if let Some(reason) = self.reason(range_m) {
                dropped.add(reason, 1);
                continue;
            }
            let intensity = if has_intensity { intensities[ray] } else { 0.0 };
            points.push(self.point(ray, range_m, intensity, ReturnType::Single));
        }
        let columns = self.columns(has_intensity, false);
        Ok(Scan { index: 0, stamp_ns: 0, frame_id: String::new(), points, columns, dropped })
    }
}

/// The scan in a message. Ranges that are not valid, and rays from which nothing came back, are counted: they neither mark nor
/// clear.
///
/// # Errors
/// [`crate::Error::Decode`] for angles that are not finite or do not change, for too many ranges, and for stamps before 1970.
pub fn from_laser_scan(message: LaserScan) -> Result<Scan> {
    let scan = Rays::of(FLAT, &message).single(&message.ranges, &message.intensities)?;
    let stamp_ns = message.header.stamp.stamp_ns()?;
    Ok(Scan { stamp_ns, frame_id: bare_frame(message.header.frame_id), ..scan })
}

/// As [`from_laser_scan`]; a pose that the message gives is applied to the points.
///
/// # Errors
/// As there, and for a pose that is none.
pub fn from_foxglove(message: foxglove::LaserScan) -> Result<Scan> {
    let narrowed = |values: &[f64]| values.iter().map(|&value| narrow(value)).collect::<Vec<f32>>();
    #[expect(clippy::cast_precision_loss, reason = "far fewer rays than 2^53")]
    let steps = message.ranges.len().saturating_sub(1).max(1) as f64;
    let rays = Rays {
        what: FOXGLOVE,
        angle_min: message.start_angle,
        angle_step: (message.end_angle - message.start_angle) / steps,
        time_step_s: 0.0,
        range_min: 0.0,
        range_max: f32::INFINITY,
    };
    check_points(FOXGLOVE, message.ranges.len() as u64)?;
    let mut scan = rays.single(&narrowed(&message.ranges), &narrowed(&message.intensities))?;
    place(&mut scan, FOXGLOVE, message.pose.as_ref())?;
    let stamp_ns = foxglove::stamp_ns(message.timestamp)?;
    Ok(Scan { stamp_ns, frame_id: bare_frame(message.frame_id), ..scan })
}

/// As [`from_laser_scan`], each valid echo a point: of several the nearest as the first return and the others as last ones.
///
/// # Errors
/// As there.
pub fn from_multi_echo(message: MultiEchoLaserScan) -> Result<Scan> {
    let rays = Rays::of(MULTI, &message);
    rays.check(message.ranges.len())?;
    let echoes = message.ranges.iter().map(|ray| ray.echoes.len()).sum();
    check_points(MULTI, echoes as u64)?;
    let intensities: Vec<f32> = message.intensities.iter().flat_map(|ray| &ray.echoes).copied().collect();
    let has_intensity = has_numbers(&intensities, echoes);
    let (mut points, mut dropped) = (Vec::with_capacity(echoes), Dropped::default());
    for (ray, ranges) in message.ranges.iter().enumerate() {
        let valid = ranges.echoes.iter().filter(|range_m| rays.reason(**range_m).is_none()).count();
        let mut given = 0;
        for (echo, &range_m) in ranges.echoes.iter().enumerate() {
            if let Some(reason) = rays.reason(range_m) {
                dropped.add(reason, 1);
                continue;
            }
            given += 1;
            let return_type = match (valid, given) {
                (1, _) => ReturnType::Both,
                (_, 1) => ReturnType::First,
                _ => ReturnType::Last,
            };
            let measured = message.intensities.get(ray).and_then(|ray| ray.echoes.get(echo));
            points.push(rays.point(ray, range_m, measured.copied().unwrap_or(0.0), return_type));
        }
    }
    let (stamp_ns, columns) = (message.header.stamp.stamp_ns()?, rays.columns(has_intensity, true));
    Ok(Scan { index: 0, stamp_ns, frame_id: bare_frame(message.header.frame_id), points, columns, dropped })
}

/// Whether there is a number for each echo, and one of them is finite.
fn has_numbers(intensities: &[f32], echoes: usize) -> bool {
    intensities.len() == echoes && intensities.iter().any(|value| value.is_finite())
}
