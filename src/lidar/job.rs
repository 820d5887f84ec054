//! What a scan pipeline is built for, and what its stages take one scan's parameters from.

use glam::{DVec2, DVec3};

use super::{ScanFrame, ScanPose};
use crate::base::Result;
use crate::base::Rigid;
use crate::config::Config;
use crate::gpu::{FrameInput, Plan};
use crate::map::Window;
use crate::stage::glass::Glass;

/// What a scan pipeline is built for.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanJob {
    /// Parameters.
    pub config: Config,
    /// Most points of a scan; the pipeline is built anew for larger ones.
    pub capacity: u32,
    /// R: intensity of full scale, in the sensor's unit.
    pub full_scale: f64,
    /// Rings of the planes z = 0 and z = -epsilon; `None`: slabs.
    pub plane_rings: Option<[u16; 2]>,
    /// Whether points are placed by the pose at their own times.
    pub deskew: bool,
    /// Whether the grids beside the plan map are read back.
    pub layers: bool,
    /// The grid of beams and the panes to begin with, where glass is searched for.
    pub glass: Option<Glass>,
}

impl ScanJob {
    /// Cells along one side of the map.
    pub fn side(&self) -> u32 {
        self.config.scan_cells_per_side().unwrap_or(8)
    }

    /// Cells of the map.
    pub fn cells(&self) -> u32 {
        self.side() * self.side()
    }

    /// Bytes of a buffer with `bytes` for each cell.
    pub fn grid_bytes(&self, bytes: u64) -> u64 {
        u64::from(self.cells()) * bytes
    }

    /// Tall layers: those between two of `layer_heights_m`.
    pub fn tall_layers(&self) -> u32 {
        u32::try_from(self.config.layer_heights_m.len()).unwrap_or(u32::MAX).saturating_sub(1)
    }

    /// m: the tall layers from the lowest, then the planes z = 0 and z = -epsilon.
    pub fn layer_count(&self) -> u32 {
        self.tall_layers() + 2
    }

    /// Names of the layers in that order.
    pub fn layer_names(&self) -> Vec<String> {
        let tall = (0..self.tall_layers()).map(|layer| layer.to_string());
        tall.chain(["plane".into(), "below".into()]).collect()
    }
}

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

/// What the stages take their parameters of one scan from.
#[derive(Debug)]
pub struct ScanMoment<'a> {
    /// What the pipeline was built for.
    pub job: &'a ScanJob,
    /// The input.
    pub frame: &'a ScanFrame,
    /// Where robot and lidar were.
    pub pose: ScanPose,
    /// The window.
    pub window: Window,
    /// Lidar in window coordinates: x and y from the corner of cell (0, 0), z from the lidar's height at the stamp; at the
    /// first point's time where the scan is deskewed, else at the stamp.
    pub window_from_lidar: Rigid,
    /// The same at the stamp, deskewed or not: what is given in the lidar's frame, as panes are, is placed by it.
    pub window_from_lidar_at_stamp: Rigid,
    /// The lidar's place in the window at the stamp, metres.
    pub lidar_in_window_m: DVec2,
    /// The motion during the scan, where it is deskewed.
    pub turn: Option<Turn>,
    /// Place in the map, of whole metres, from which the coordinates of kept panes count; the same for all scans of a run.
    pub origin_m: DVec3,
    /// Direction from the robot to its goal in the window's axes, of length 1; `None` at the goal.
    pub towards_goal: Option<DVec2>,
    /// Seconds since the scan before; `None` for the first.
    pub since_last_s: Option<f64>,
    /// Whether it is the first scan of the run.
    pub first: bool,
}

impl<'a> ScanMoment<'a> {
    /// For a scan with the lidar at `pose`.
    pub fn new(
        job: &'a ScanJob,
        frame: &'a ScanFrame,
        pose: ScanPose,
        window: Window,
        origin_m: DVec3,
        since_last_s: Option<f64>,
    ) -> Self {
        let grid = window.grid(job.config.scan_resolution_m, job.side());
        let lidar_m = pose.map_from_lidar().translation_m;
        let corner_m = DVec3::new(grid.origin_x_m, grid.origin_y_m, lidar_m.z);
        let placed = |map: Rigid| Rigid { translation_m: map.translation_m - corner_m, ..map };
        let sweep = pose.sweep.filter(|_| job.deskew);
        let turn = sweep.map(|sweep| {
            let first_from_last = sweep.map_from_first.inverse().then(sweep.map_from_last);
            let rotation = first_from_last.rotation;
            let shorter = if rotation.w < 0.0 { -rotation } else { rotation };
            let (axis, angle_rad) = shorter.to_axis_angle();
            Turn {
                axis,
                angle_rad,
                way_m: sweep.map_from_last.translation_m - sweep.map_from_first.translation_m,
                first_s: sweep.first_s.into(),
                duration_s: f64::from(sweep.last_s) - f64::from(sweep.first_s),
            }
        });
        Self {
            job,
            frame,
            pose,
            window,
            window_from_lidar: placed(sweep.map_or(pose.map_from_lidar(), |sweep| sweep.map_from_first)),
            window_from_lidar_at_stamp: placed(pose.map_from_lidar()),
            lidar_in_window_m: (lidar_m - corner_m).truncate(),
            turn,
            origin_m,
            towards_goal: towards_goal(job, frame, pose),
            since_last_s,
            first: since_last_s.is_none(),
        }
    }
}

/// The goal's direction; that of the robot's x axis without a goal; `None` within a cell of the goal.
fn towards_goal(job: &ScanJob, frame: &ScanFrame, pose: ScanPose) -> Option<DVec2> {
    let stated = match job.config.goal_m[..] {
        [x, y] => Some(DVec2::new(x, y)),
        _ => None,
    };
    let way = match frame.goal_m.or(stated) {
        Some(goal_m) => {
            let way_m = goal_m - pose.map_from_base.translation_m.truncate();
            (way_m.length() > job.config.scan_resolution_m).then_some(way_m)?
        }
        None => (pose.map_from_base.rotation * DVec3::X).truncate(),
    };
    way.try_normalize()
}

/// A stage of the lidar path.
pub trait ScanStage: std::fmt::Debug {
    /// Declares its buffers and appends its passes.
    ///
    /// # Errors
    /// From the plan: a name taken, a buffer missing, a shader that does not parse.
    fn append(&self, plan: &mut Plan, job: &ScanJob) -> Result<()>;

    /// Writes its parameters and data for one scan.
    ///
    /// # Errors
    /// [`crate::Error::Input`] where data do not fit their buffer.
    fn write(&self, moment: &ScanMoment<'_>, input: &mut FrameInput<'_>) -> Result<()>;
}
