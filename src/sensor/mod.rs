//! What sensors measure, as values: they know nothing of files and messages.

mod beam_grid;
mod camera;
mod depth_spread;
mod dropped;
mod frame;
mod model;
mod observation;
mod returns;
mod rings;
mod scan;
mod velodyne;

#[doc(inline)]
pub use crate::base::Rigid;
pub use beam_grid::BeamGrid;
pub use camera::{CameraModel, Distortion};
pub use depth_spread::DepthSpread;
pub use dropped::{DropReason, Dropped};
pub use frame::{ColorImage, DepthImage, DepthSamples, FramePose, RgbdFrame};
pub use model::{CameraInfo, LidarInfo, SensorKind, SensorModel};
pub use observation::{Observation, SensorData, SensorPose, Sweep};
pub use returns::{ReturnCodes, ReturnType, Strength};
pub use rings::{has_steady_rings, ring_elevations};
pub use scan::{Columns, Point, PointClock, Scan};
pub use velodyne::VelodyneModel;
