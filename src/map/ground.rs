//! The ground as a sensor sees it.

use glam::{DVec2, DVec3, DVec4};

use crate::sensor::SensorPose;

/// Where heights are counted from (spec 6 §2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GroundFrom {
    /// From `ground_z_m`: no sensor has seen the ground for `ground_keep_s`.
    Stated,
    /// From what this sensor sees of it.
    Seen,
    /// From what another sensor sees of it.
    Other,
}

/// The ground of one message, as its sensor knows it.
///
/// ```
/// use limpid::map::GroundPlane;
///
/// let plane = GroundPlane { normal: glam::DVec3::Z, below_m: 0.41, messages: 30 };
/// assert_eq!((plane.tilt_deg(), plane.height_at(glam::DVec2::ZERO)), (0.0, -0.41));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    /// Where heights are counted from.
    pub from: GroundFrom,
    /// Whether `ground_z_m` is taken as it is, because what is seen differs from it no more than noise may make it.
    pub agrees: bool,
    /// Height of the sensor above the ground that is used, metres.
    pub sensor_height_m: f64,
    /// The plane, filtered over the sensor's messages; `None`: it has not seen it for `ground_keep_s`.
    pub plane: Option<GroundPlane>,
    /// Whether this message showed it.
    pub seen: bool,
    /// Height above `ground_z_m` of a level plane that this message showed where the ground cannot be, metres: a table, or the floor
    /// where a transform is wrong. `None`: it showed none, or there is no map.
    pub refused_m: Option<f64>,
    /// Share of the samples below the sensor that lie on the best plane of this message, in [0, 1], be it the ground or not.
    pub support: f64,
    /// How much of that plane was seen, square metres.
    pub area_m2: f64,
    /// How much of it beams passed on their way to something below that it did not mirror, square metres.
    pub pierced_m2: f64,
    /// Height of the plane above `ground_z_m` under the base, metres; `None`: it is not known, or there is no map.
    pub above_stated_m: Option<f64>,
}

/// A plane below a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundPlane {
    /// Upwards, of length 1, in the map's axes.
    pub normal: DVec3,
    /// How far below the sensor it lies, along the normal, metres.
    pub below_m: f64,
    /// Messages that showed it without a gap of `ground_keep_s`.
    pub messages: u32,
}

impl GroundPlane {
    /// Angle between it and the level, degrees: where there is a map by tf, else by the sensor's axes.
    pub fn tilt_deg(&self) -> f64 {
        self.normal.truncate().length().atan2(self.normal.z).to_degrees()
    }

    /// Height above the sensor at a place from the sensor in the map's axes, metres.
    pub fn height_at(&self, place_m: DVec2) -> f64 {
        -(self.below_m + self.normal.truncate().dot(place_m)) / self.normal.z
    }
}

impl Ground {
    /// Height above the ground that is used, metres, of a place `off_m` from the sensor in the map's axes. Where another sensor's
    /// plane is used, it is taken as level.
    pub fn height_of(&self, off_m: DVec3) -> f64 {
        match self.plane {
            Some(plane) if self.from == GroundFrom::Seen && !self.agrees => {
                plane.normal.dot(off_m) + plane.below_m
            }
            _ => self.sensor_height_m + off_m.z,
        }
    }

    /// From what `ground/settle` tells of a message of a sensor at `pose`.
    pub(crate) fn read(words: &[[f32; 4]; 5], pose: SensorPose, ground_z_m: f64) -> Self {
        let [_, used, plane, shown, now] = words.map(|word| DVec4::from_array(word.map(f64::from)));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
        let messages = shown.z as u32;
        let plane_of = |plane: DVec4, messages: u32| {
            let normal = plane.truncate();
            (normal.length() > 0.5).then_some(GroundPlane { normal, below_m: -plane.w, messages })
        };
        let sensor_m = pose.map_from_sensor().translation_m;
        let base_m = (pose.map_from_base.translation_m - sensor_m).truncate();
        let above = |plane: GroundPlane| plane.height_at(base_m) + sensor_m.z - ground_z_m;
        let (plane, now) = (plane_of(plane, messages), plane_of(now, 1));
        let in_map = pose != SensorPose::SENSOR;
        Self {
            from: match used.x {
                x if x < 0.5 => GroundFrom::Stated,
                x if x < 1.5 => GroundFrom::Seen,
                _ => GroundFrom::Other,
            },
            agrees: shown.w > 0.5,
            sensor_height_m: used.y,
            plane,
            seen: shown.x > 1.5,
            refused_m: now.filter(|_| in_map && shown.x < 1.5).map(above),
            support: shown.y,
            area_m2: used.z,
            pierced_m2: used.w,
            above_stated_m: plane.filter(|_| in_map).map(above),
        }
    }
}

/// What a sensor saw of the ground in a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GroundRun {
    /// Messages for which the ground was estimated.
    pub messages: u64,
    /// Those that showed it.
    pub seen: u64,
    /// The last one that did.
    pub last: Option<Ground>,
    /// Messages that showed a level plane where the ground cannot be, and the last of them.
    pub refused: u64,
    /// Its height above `ground_z_m`, metres.
    pub refused_m: f64,
    /// Messages whose heights count from `ground_z_m`, as no sensor had seen the ground.
    pub stated: u64,
}

/// Share of messages whose heights count from a `ground_z_m` that is wrong, from which that is worth a warning.
const STATED_SHARE: u64 = 10;

/// Difference between `ground_z_m` and what is seen that is worth a warning, metres.
const WRONG_M: f64 = 0.1;

impl GroundRun {
    /// Counts a message in; `None`: the ground is stated.
    pub fn count(&mut self, ground: Option<&Ground>) {
        let Some(ground) = ground else { return };
        self.messages += 1;
        self.stated += u64::from(ground.from == GroundFrom::Stated);
        if ground.seen {
            self.seen += 1;
            self.last = Some(*ground);
        }
        if let Some(height_m) = ground.refused_m {
            self.refused += 1;
            self.refused_m = height_m;
        }
    }

    /// One line: `floor 0.41 m below the camera, tilted 1.2 degrees`; `None` where it was not estimated.
    pub fn text(&self, kind: &str) -> Option<String> {
        let messages = self.messages;
        match self.last.and_then(|ground| ground.plane) {
            _ if messages == 0 => None,
            None => Some(format!("no floor seen in {messages} messages; heights count from ground_z_m")),
            Some(plane) => {
                let (below_m, tilt_deg) = (-plane.height_at(DVec2::ZERO), plane.tilt_deg());
                let seen = self.seen;
                Some(format!(
                    "floor {below_m:.2} m below the {kind}, tilted {tilt_deg:.1} degrees (seen in {seen} of {messages})"
                ))
            }
        }
    }

    /// What the floor says against `ground_z_m`, or the sensor's transform. Of a `ground_z_m` that nobody set, no more than a start,
    /// this is said only where heights count from it in part of the messages.
    pub fn warning(&self, ground_z_m: f64, set: bool) -> Option<String> {
        let counts = set || STATED_SHARE * self.stated > self.messages;
        let above_m = self.last.and_then(|ground| ground.above_stated_m);
        let side = |above_m: f64| if above_m > 0.0 { "above" } else { "below" };
        match above_m {
            Some(above_m) if above_m.abs() > WRONG_M && counts => Some(format!(
                "the floor lies {:.2} m {} ground_z_m ({ground_z_m}): state ground_z_m: {:.2}, or see the sensor's transform; heights count from the floor that is seen, and from ground_z_m until it was ({} of {} messages)",
                above_m.abs(),
                side(above_m),
                ground_z_m + above_m,
                self.stated,
                self.messages,
            )),
            None if 2 * self.refused > self.messages => Some(format!(
                "no floor at ground_z_m ({ground_z_m}), but something level {:.2} m {} it, where the robot's base says that it is none: see ground_z_m and the transforms of the base and the sensor",
                self.refused_m.abs(),
                side(self.refused_m),
            )),
            _ => None,
        }
    }
}
