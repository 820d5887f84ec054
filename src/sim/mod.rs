//! Simulated recordings with ground truth: scenes, a ray-traced stereo camera and its matcher, lidars, the robot's way.
//!
//! Holes and spikes are never painted on: they come out of matching two infrared images of a scene with mirrors,
//! glass, lamps and sunlight (spec 1 §8).

mod check;
mod cluster;
pub(crate) mod footprint;
pub mod frame;
pub mod generate;
pub mod lidar;
pub mod material;
mod pack;
pub mod passes;
pub mod rates;
pub mod scene;
pub mod settings;
pub mod simulator;
pub mod sun;
pub(crate) mod trajectory;
pub mod truth;
pub mod vessel;
pub mod walker;
pub(crate) mod walls;
pub mod write;
mod written;

pub use pack::SimScene;
pub use scene::Scene;
pub use simulator::Simulator;
pub use trajectory::{Way, poses, stamp_ns};
