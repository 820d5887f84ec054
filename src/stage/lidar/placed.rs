//! Where a lidar was in the window during a scan.

use glam::{DVec2, DVec3};

use crate::base::Rigid;
use crate::sensor::Sweep;
use crate::stage::Moment;

/// The lidar's motion during a scan, as the shader takes it: the pose at share s of the way from the first point to the
/// last is that of the first, turned by s of the angle and moved by s of the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Axis in the lidar's frame, of length 1.
    pub axis: DVec3,
    /// Radians.
    pub angle_rad: f64,
    /// Metres, in the window's axes.
    pub way_m: DVec3,
    /// Time of the first point, seconds after the stamp.
    pub first_s: f64,
    /// Time from the first to the last, seconds; 0: all at once.
    pub duration_s: f64,
}

impl Turn {
    fn of(sweep: Sweep) -> Self {
        let first_from_last = sweep.map_from_first.inverse().then(sweep.map_from_last);
        let rotation = first_from_last.rotation;
        let shorter = if rotation.w < 0.0 { -rotation } else { rotation };
        let (axis, angle_rad) = shorter.to_axis_angle();
        Self {
            axis,
            angle_rad,
            way_m: sweep.map_from_last.translation_m - sweep.map_from_first.translation_m,
            first_s: sweep.first_s.into(),
            duration_s: f64::from(sweep.last_s) - f64::from(sweep.first_s),
        }
    }
}

/// The lidar in window coordinates: x and y from the corner of cell (0, 0), z from the lidar's height at the stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// At the first point's time where the scan is deskewed, else at the stamp.
    pub window_from_lidar: Rigid,
    /// At the stamp, deskewed or not: what is given in the lidar's frame, as panes are, is placed by it.
    pub window_from_lidar_at_stamp: Rigid,
    /// The lidar's place in the window at the stamp, metres.
    pub lidar_in_window_m: DVec2,
    /// Its height in the map at the stamp, metres.
    pub lidar_z_m: f64,
    /// The motion during the scan, where it is deskewed.
    pub turn: Option<Turn>,
}

impl Placed {
    /// Of a scan that is deskewed or not.
    pub fn of(moment: &Moment<'_>, deskew: bool) -> Self {
        let map_from_lidar = moment.pose.map_from_sensor();
        let lidar_m = map_from_lidar.translation_m;
        let corner_m = DVec3::new(moment.grid.origin_x_m, moment.grid.origin_y_m, lidar_m.z);
        let sweep = moment.pose.sweep.filter(|_| deskew);
        let at_first = sweep.map_or(map_from_lidar, |sweep| sweep.map_from_first);
        Self {
            window_from_lidar: moment.in_window(at_first, lidar_m.z),
            window_from_lidar_at_stamp: moment.in_window(map_from_lidar, lidar_m.z),
            lidar_in_window_m: (lidar_m - corner_m).truncate(),
            lidar_z_m: lidar_m.z,
            turn: sweep.map(Turn::of),
        }
    }
}
