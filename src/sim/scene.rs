//! Scenes as YAML: rooms, solids, panes, lights, materials; the camera and the robot's way through.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::check;
use super::lidar::Lidar;
use super::material::Material;
use super::settings::{Camera, Imager, Matcher};
use super::sun::Sun;
use super::vessel::Vessel;
use super::walker::Walker;
use crate::base::{Error, Result, plain};

/// A rectangle of floor with walls around it, where no other room adjoins: rooms that overlap or touch
/// are open to each other, so that corridors are long rooms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// Corner of least x and y, metres.
    pub min_m: [f64; 2],
    /// Corner of greatest x and y, metres.
    pub max_m: [f64; 2],
    /// Material of its walls.
    pub walls: String,
}

/// An upright box, turned about the vertical.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Its centre, metres.
    pub center_m: [f64; 3],
    /// Its lengths along its own axes, metres.
    pub size_m: [f64; 3],
    /// Its turn, counter-clockwise.
    #[serde(default)]
    pub yaw_rad: f64,
    /// Name of its material.
    pub material: String,
}

/// An upright cylinder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Centre of its foot, metres.
    pub base_m: [f64; 3],
    /// Metres.
    pub radius_m: f64,
    /// Metres.
    pub height_m: f64,
    /// Name of its material.
    pub material: String,
}

/// An upright rectangle without thickness: a glass pane, a mirror, a picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pane {
    /// Its centre, metres.
    pub center_m: [f64; 3],
    /// Metres.
    pub width_m: f64,
    /// Metres.
    pub height_m: f64,
    /// Direction that it faces, counter-clockwise from x.
    pub yaw_rad: f64,
    /// Name of its material.
    pub material: String,
}

/// The outline of a thicket.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outline {
    /// A box: grass, a hedge.
    #[default]
    Box,
    /// The ellipsoid in that box: a bush, a crown.
    Ellipsoid,
}

/// A volume of thin elements at random (blades, leaves, twigs), which rays meet by the distance that they travel in it
/// (spec 6 section 1).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thicket {
    /// Its centre, metres.
    pub center_m: [f64; 3],
    /// Its lengths along its own axes, metres.
    pub size_m: [f64; 3],
    /// Its turn, counter-clockwise.
    #[serde(default)]
    pub yaw_rad: f64,
    /// Box or ellipsoid.
    #[serde(default)]
    pub outline: Outline,
    /// Elements in a cubic metre; 0: nothing is there.
    pub density_per_m3: f64,
    /// Width of an element, metres.
    pub element_width_m: f64,
    /// Length of an element, metres.
    pub element_length_m: f64,
    /// Name of their material.
    pub material: String,
    /// Whether a robot cannot pass: the true map's solid things.
    #[serde(default)]
    pub solid: bool,
}

impl Thicket {
    /// Elements that a ray meets in a metre: a plate that faces anywhere shows half its area in the mean.
    pub fn extinction_per_m(&self) -> f64 {
        0.5 * self.density_per_m3 * self.element_width_m * self.element_length_m
    }
}

/// An upright plane of vertical strings: a string or bead curtain, which a robot can pass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curtain {
    /// Its centre, metres.
    pub center_m: [f64; 3],
    /// Metres.
    pub width_m: f64,
    /// Metres.
    pub height_m: f64,
    /// Direction that it faces, counter-clockwise from x.
    pub yaw_rad: f64,
    /// From one string to the next, metres.
    pub spacing_m: f64,
    /// Diameter of a string, metres.
    pub string_width_m: f64,
    /// Name of their material.
    pub material: String,
}

/// A lamp: a horizontal panel that shines down.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lamp {
    /// Its centre, metres.
    pub center_m: [f64; 3],
    /// Its lengths along x and y, metres.
    pub size_m: [f64; 2],
    /// Radiance in red, green and blue.
    pub color: [f64; 3],
    /// Radiance in the infrared.
    pub infrared: f64,
}

/// A window: an upright rectangle that shines to the side it faces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// Its centre, metres.
    pub center_m: [f64; 3],
    /// Metres.
    pub width_m: f64,
    /// Metres.
    pub height_m: f64,
    /// Direction that it faces, counter-clockwise from x.
    pub yaw_rad: f64,
    /// Radiance in red, green and blue.
    pub color: [f64; 3],
    /// Radiance in the infrared.
    pub infrared: f64,
}

/// Light that comes from everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ambient {
    /// In red, green and blue.
    pub color: [f64; 3],
    /// In the infrared.
    pub infrared: f64,
}

impl Default for Ambient {
    fn default() -> Self {
        Self { color: [0.25; 3], infrared: 0.01 }
    }
}

/// The robot's way: straight from point to point, turning on the spot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trajectory {
    /// Points of the way, metres; one is a robot that stands still.
    pub waypoints_m: Vec<[f64; 2]>,
    /// Direction that it faces where the way has one point, radians.
    #[serde(default)]
    pub yaw_rad: f64,
    /// Travel a frame, metres, at most 0.04.
    #[serde(default = "default_step_m")]
    pub step_m: f64,
    /// Turn a frame, radians.
    #[serde(default = "default_turn_rad")]
    pub turn_rad: f64,
    /// Frames a second.
    #[serde(default = "default_rate_hz")]
    pub rate_hz: f64,
    /// Frames; fewer where the way ends before.
    #[serde(default = "default_frames")]
    pub frames: u32,
    /// Radius that must be free around the robot, metres.
    #[serde(default = "default_clearance_m")]
    pub clearance_m: f64,
}

fn default_step_m() -> f64 {
    0.04
}

fn default_turn_rad() -> f64 {
    0.05
}

fn default_rate_hz() -> f64 {
    30.0
}

fn default_frames() -> u32 {
    60
}

fn default_clearance_m() -> f64 {
    0.3
}

/// Everything that a simulated recording is made of. Metres in the map frame: x and y on the floor, z = 0 the floor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// What it is called.
    pub name: String,
    /// Of noise and speckle.
    #[serde(default)]
    pub seed: u64,
    /// By name.
    pub materials: BTreeMap<String, Material>,
    /// Name of the floor's material.
    pub floor: String,
    /// Name of the ceiling's material.
    pub ceiling: String,
    /// Height of the ceiling in all rooms, metres.
    pub ceiling_m: f64,
    /// Rooms and corridors.
    pub rooms: Vec<Room>,
    /// Whether the scene lies in the open: no ceiling, and no walls around the rooms.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub open_air: bool,
    /// Boxes.
    #[serde(default)]
    pub boxes: Vec<Block>,
    /// Cylinders.
    #[serde(default)]
    pub cylinders: Vec<Cylinder>,
    /// People.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub walkers: Vec<Walker>,
    /// Bottles, bowls, glasses.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vessels: Vec<Vessel>,
    /// Panes, mirrors, pictures.
    #[serde(default)]
    pub panes: Vec<Pane>,
    /// Grass, bushes, crowns.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub thickets: Vec<Thicket>,
    /// Curtains of strings.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub curtains: Vec<Curtain>,
    /// Lamps.
    #[serde(default)]
    pub lamps: Vec<Lamp>,
    /// Windows.
    #[serde(default)]
    pub windows: Vec<Window>,
    /// The sun, where it shines in.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sun: Option<Sun>,
    /// Light from everywhere.
    #[serde(default)]
    pub ambient: Ambient,
    /// The robot's way.
    pub trajectory: Trajectory,
    /// The camera and its mount.
    #[serde(default)]
    pub camera: Camera,
    /// Imagers and projector.
    #[serde(default)]
    pub imager: Imager,
    /// Stereo matcher.
    #[serde(default)]
    pub matcher: Matcher,
    /// The lidar and its mount, where the robot has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lidar: Option<Lidar>,
}

impl Scene {
    /// Reads and checks a scene.
    ///
    /// # Errors
    /// [`Error::Yaml`] with line and column for what is no scene, unknown keys among them;
    /// [`Error::Config`] with the key for what cannot be.
    pub fn from_yaml(text: &str) -> Result<Self> {
        let scene: Self = serde_saphyr::from_str(text).map_err(|error| Error::Yaml(plain(&error)))?;
        scene.validate()?;
        Ok(scene)
    }

    /// As [`Self::from_yaml`], from a file.
    ///
    /// # Errors
    /// As there, and [`Error::File`].
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
        Self::from_yaml(&text).map_err(|error| match error {
            Error::Yaml(reason) => Error::Yaml(format!("{}: {reason}", path.display())),
            other => other,
        })
    }

    /// The scene as YAML that [`Self::from_yaml`] reads back.
    ///
    /// # Errors
    /// [`Error::Yaml`] where a value has no form in YAML.
    pub fn to_yaml(&self) -> Result<String> {
        serde_saphyr::to_string(self).map_err(|error| Error::Yaml(error.to_string()))
    }

    /// The scene so many seconds after the first frame, in which people are cylinders.
    pub fn at(&self, seconds: f64) -> Cow<'_, Self> {
        if self.walkers.is_empty() {
            return Cow::Borrowed(self);
        }
        let mut still = self.clone();
        still.cylinders.extend(still.walkers.drain(..).map(|walker| walker.at(seconds)));
        Cow::Owned(still)
    }

    /// Checks numbers, names and places.
    ///
    /// # Errors
    /// [`Error::Config`] with the key, as in `boxes[2].size_m`.
    pub fn validate(&self) -> Result<()> {
        check::scene(self)
    }
}
