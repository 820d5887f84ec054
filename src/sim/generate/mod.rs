//! Random scenes from a seed and a glare level, in families: rooms for cameras, glass and greenery for lidars.

mod drive;
mod glazed;
mod green;
mod held_out;
mod layout;
mod people;
mod physics;
mod random;
mod shiny;
mod tabletop;
mod train;
mod vary;
mod vessels;
mod vitrine;
mod way;

pub use people::add_walkers;
pub use physics::Physics;
pub use random::Random;
pub use vary::vary_sensor;

use super::scene::Scene;
use crate::base::{Error, Result};

/// How much glare (spec 1 §8).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[cfg_attr(feature = "cli", value(rename_all = "UPPER"))]
pub enum Level {
    /// Matt floor, little infrared in the lamps.
    L0,
    /// Some gloss, warm lamps, a window.
    L1,
    /// A polished dark floor, strong lamps, sunlit windows, a glass pane.
    L2,
}

impl Level {
    /// The level of a scene that [`generate`] made and named; `None` for any other.
    pub fn of_scene(scene: &Scene) -> Option<Self> {
        let [_, level, "seed", _] = scene.name.split(' ').collect::<Vec<_>>()[..] else { return None };
        [Self::L0, Self::L1, Self::L2].into_iter().find(|known| format!("{known:?}") == level)
    }
}

/// Which generator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Family {
    /// Rectangular rooms, some with a corridor, square lamps, upright furniture.
    #[default]
    Train,
    /// Angled plans, pillars and round tables, other patterns, strip lamps, narrow windows: for evaluation only.
    HeldOut,
    /// Clear vessels, foil, steel and labels on a table from 0.4 to 1 m: for training beside the rooms.
    Tabletop,
    /// Rooms with shop windows, aquaria, bottles, steel fronts, black gloss and sun patches: for training.
    Vitrine,
    /// Rooms with glass fronts, railings, doors, mirrors, for lidars.
    Glass,
    /// Narrow passages closed by curtains of strings.
    Curtain,
    /// Grass, bushes and trees apart.
    Vegetation,
    /// Grass, bushes and trees intertwined.
    Thicket,
    /// Corridors, halls and glass fronts, long enough to drive through: for navigation trials.
    Drive,
    /// A hall with a polished floor, a glass front, a string curtain and furniture: for trials with camera and lidar.
    Mixed,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Train,
        Self::HeldOut,
        Self::Tabletop,
        Self::Glass,
        Self::Curtain,
        Self::Vegetation,
        Self::Thicket,
        Self::Drive,
        Self::Mixed,
        Self::Vitrine,
    ];

    /// Its name at the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::HeldOut => "held-out",
            Self::Tabletop => "tabletop",
            Self::Vitrine => "vitrine",
            Self::Glass => "glass",
            Self::Curtain => "curtain",
            Self::Vegetation => "vegetation",
            Self::Thicket => "thicket",
            Self::Drive => "drive",
            Self::Mixed => "mixed",
        }
    }
}

/// Attempts at one scene before giving up.
const ATTEMPTS: u64 = 200;

/// The scene of a seed, with a way of `frames` frames.
///
/// # Errors
/// [`Error::Config`] for the key `seed` where no way was found through any arrangement.
pub fn generate(family: Family, level: Level, seed: u64, frames: u32) -> Result<Scene> {
    for attempt in 0..ATTEMPTS {
        let mut random = Random::new(seed.wrapping_mul(0x1_0001).wrapping_add(attempt << 48));
        let mut scene = match family {
            Family::Train => train::scene(level, &mut random),
            Family::HeldOut => held_out::scene(level, &mut random),
            Family::Tabletop => tabletop::scene(level, frames, &mut random),
            Family::Vitrine => vitrine::scene(level, frames, &mut random),
            Family::Glass => glazed::scene(level, &mut random),
            Family::Curtain => green::passage(level, &mut random),
            Family::Vegetation => green::meadow(level, false, &mut random),
            Family::Thicket => green::meadow(level, true, &mut random),
            Family::Drive => drive::scene(level, seed, &mut random),
            Family::Mixed => drive::mixed(level, &mut random),
        };
        scene.name = format!("{family:?} {level:?} seed {seed}");
        scene.seed = seed;
        scene.trajectory.frames = frames;
        // The way up to a table or a vitrine is part of that scene.
        let on_its_way = !scene.trajectory.waypoints_m.is_empty() || way::lay(&mut scene, &mut random);
        if on_its_way && scene.validate().is_ok() {
            return Ok(scene);
        }
    }
    let reason =
        format!("no way of {frames} frames was found in {ATTEMPTS} arrangements; ask for fewer frames");
    Err(Error::Config { key: "seed".into(), reason })
}
