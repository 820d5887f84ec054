//! Simulated lidars: beams as cones of sub-rays, echoes out of the power that comes back (spec 6 section 1).
//!
//! Nothing is painted on: weak partial returns from blades and strings, two returns at edges and behind panes, the bright
//! patch of glass met head on, mirrored rooms and missing glass elsewhere come out of the rays.

mod model;
mod scan;
mod settings;
mod simulator;

pub use model::{LidarModel, Optics, Ring};
pub use scan::{PointTruth, SimScan};
pub use settings::{Lidar, Returns};
pub use simulator::{LIDAR_FRAME, LidarSimulator, plan};
