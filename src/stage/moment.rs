//! What stages take their parameters of one observation, or of one published map, from.

use glam::{DVec2, DVec3};

use crate::base::{Error, Result, Rigid};
use crate::config::Config;
use crate::map::{Grid, Window};
use crate::sensor::{Observation, RgbdFrame, Scan, SensorPose};

/// See the module.
#[derive(Debug)]
pub struct Moment<'a> {
    /// What came in; `None`: the map is published.
    pub observation: Option<&'a Observation>,
    /// Where base and sensor were.
    pub pose: SensorPose,
    /// The window.
    pub window: Window,
    /// The same, moved since the observation before of the same sensor.
    pub own_window: Window,
    /// Its geometry in the map.
    pub grid: Grid,
    /// Seconds since the observation before of the same sensor; `None` for the first.
    pub since_last_s: Option<f64>,
    /// Whether the observation before of the same sensor was taken, so that this one follows it.
    pub follows: bool,
    /// Place in the map, of whole metres, from which the coordinates of kept panes count; the same for a whole run.
    pub local_origin_m: DVec3,
    /// Tick of the observation, in hundredths of a second since the map began.
    pub tick: u32,
    /// The newest tick.
    pub now: u32,
    /// Of each sensor the tick before which its evidence is stale; `u32::MAX` for a stale sensor.
    pub fresh_since: &'a [u32],
    /// Of a scan: whether what stands is solid, as intensities say nothing ([`crate::stage::lidar::trust`]).
    pub standing: bool,
    /// Direction from the robot to its goal in the map's axes, of length 1; `None` at the goal.
    pub towards_goal: Option<DVec2>,
}

impl<'a> Moment<'a> {
    /// A first observation, for tools without a map of their own.
    pub fn of(observation: &'a Observation, pose: SensorPose, window: Window, config: &Config) -> Self {
        Self {
            observation: Some(observation),
            pose,
            window,
            own_window: window,
            grid: window.grid(config.resolution_m, 1),
            since_last_s: None,
            follows: false,
            local_origin_m: DVec3::ZERO,
            tick: 1,
            now: 1,
            fresh_since: &[],
            standing: false,
            towards_goal: None,
        }
    }

    /// The frame.
    ///
    /// # Errors
    /// [`Error::Plan`] where a stage of a camera is asked to take something else.
    pub fn frame(&self) -> Result<&'a RgbdFrame> {
        self.observation.and_then(Observation::frame).ok_or_else(|| not_a("frame"))
    }

    /// The scan.
    ///
    /// # Errors
    /// [`Error::Plan`] where a stage of a lidar is asked to take something else.
    pub fn scan(&self) -> Result<&'a Scan> {
        self.observation.and_then(Observation::scan).ok_or_else(|| not_a("scan"))
    }

    /// The sensor in the map's axes, from the local origin.
    pub fn local_from_sensor(&self) -> Rigid {
        let map_from_sensor = self.pose.map_from_sensor();
        Rigid { translation_m: map_from_sensor.translation_m - self.local_origin_m, ..map_from_sensor }
    }

    /// A pose in window coordinates: metres from the corner of cell (0, 0), and from a height in the map.
    pub fn in_window(&self, map_from_frame: Rigid, zero_z_m: f64) -> Rigid {
        let corner_m = DVec3::new(self.grid.origin_x_m, self.grid.origin_y_m, zero_z_m);
        Rigid { translation_m: map_from_frame.translation_m - corner_m, ..map_from_frame }
    }
}

fn not_a(kind: &str) -> Error {
    Error::Plan { pass: kind.into(), reason: "is missing in what the stage was given".into() }
}
