//! What a scan pipeline is asked for, and what it gives for one scan.

use bytemuck::pod_read_unaligned;
use glam::DVec2;

use super::{ScanFrame, ScanJob, ScanMoment, ScanPose};
use crate::base::Result;
use crate::base::Rigid;
use crate::gpu::{Executor, Readback};
use crate::map::Grid;
use crate::map::glass::LabelledScan;

/// What a scan pipeline runs on and what it reads back beside the plan map.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScanOptions {
    /// Part of the adapter's name; `None`: `LIMPID_ADAPTER`, else the best.
    pub adapter: Option<String>,
    /// Whether passes are timed.
    pub profiling: bool,
    /// Whether the layers and the maps between them and the plan map are read back.
    pub layers: bool,
}

/// What a cell of the plan map holds (spec 2 §4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellClass {
    /// No beam crossed it, or too few returns came from it.
    Unknown = 0,
    /// A beam crossed it and nothing returned from it.
    Free = 1,
    /// True positive: in the way.
    Solid = 2,
    /// False positive: returns, but weak in all layers.
    Passable = 3,
    /// False negative: glass, from this scan or remembered.
    Transparent = 4,
    /// Near a solid or transparent cell; an unknown cell only within the robot's inscribed radius.
    Inflated = 5,
}

impl CellClass {
    /// All, in order of their numbers.
    pub const ALL: [Self; 6] =
        [Self::Unknown, Self::Free, Self::Solid, Self::Passable, Self::Transparent, Self::Inflated];

    /// Its name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Free => "free",
            Self::Solid => "solid",
            Self::Passable => "passable",
            Self::Transparent => "transparent",
            Self::Inflated => "inflated",
        }
    }
}

/// Grids beside the plan map, row 0 = smallest y: name and one value a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanLayers {
    /// `intensity_<layer>`, `true_positive`, `false_positive`, `false_negative`, `inflated`, `plan`: values in the unit of
    /// `layer_measure`; 0 where there is nothing.
    pub grids: Vec<(String, Vec<f32>)>,
}

/// One scan's result.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanOutput {
    /// Number of the scan in its recording.
    pub index: u64,
    /// The scan's stamp, nanoseconds.
    pub stamp_ns: u64,
    /// Frame of the map.
    pub map_frame: String,
    /// Robot base in the map.
    pub map_from_base: Rigid,
    /// Lidar in the base.
    pub base_from_lidar: Rigid,
    /// Direction from the robot to its goal in the map, of length 1; `None` at the goal.
    pub towards_goal: Option<DVec2>,
    /// Geometry of the grids.
    pub grid: Grid,
    /// Nav2 costs of the plan map (0 free, 1..=252, 253 inscribed, 254 lethal, 255 unknown), row 0 = smallest y.
    pub costmap: Vec<u8>,
    /// [`CellClass`] of each cell, as its number.
    pub classes: Vec<u8>,
    /// Whether the lidar's pose jumped since the scan before (`pose_jump_m_s`, `pose_jump_deg_s`); what is kept from scans
    /// before stays where it was in the map.
    pub pose_jumped: bool,
    /// Points of the scan.
    pub points: usize,
    /// Labels and panes, where glass is searched for.
    pub glass: Option<LabelledScan>,
    /// Grids beside the plan map, when they were asked for.
    pub layers: Option<ScanLayers>,
    /// GPU time per pass in milliseconds, in order, when profiling.
    pub pass_ms: Vec<(String, f64)>,
}

impl ScanOutput {
    /// Cells of a class.
    pub fn count(&self, class: CellClass) -> usize {
        self.classes.iter().filter(|&&c| c == class as u8).count()
    }
}

/// What is remembered of a scan while it is under way.
#[derive(Debug, Clone)]
pub(crate) struct Pending {
    index: u64,
    stamp_ns: u64,
    map_frame: String,
    pose: ScanPose,
    pose_jumped: bool,
    towards_goal: Option<DVec2>,
    grid: Grid,
    points: usize,
}

impl Pending {
    pub(crate) fn new(frame: &ScanFrame, moment: &ScanMoment<'_>, grid: Grid, pose_jumped: bool) -> Self {
        let ScanMoment { pose, towards_goal, .. } = *moment;
        Self {
            pose_jumped,
            index: frame.scan.index,
            stamp_ns: frame.scan.stamp_ns,
            map_frame: frame.map_frame.clone(),
            pose,
            towards_goal,
            grid,
            points: frame.scan.points.len(),
        }
    }
}

/// The result of a scan.
pub(crate) fn output(
    pending: Pending,
    readback: &Readback,
    executor: &Executor,
    job: &ScanJob,
) -> Result<ScanOutput> {
    let bytes = |name: &str| readback.bytes(executor.find(name)?);
    let side = job.side() as usize;
    let quads = |name: &str| -> Result<Vec<u8>> {
        let rows = bytes(name)?.chunks_exact(side.next_multiple_of(4));
        Ok(rows.flat_map(|row| &row[..side]).copied().collect())
    };
    let floats = |bytes: &[u8]| bytes.chunks_exact(4).map(pod_read_unaligned).collect::<Vec<f32>>();
    let layers = || -> Result<ScanLayers> {
        let values = bytes("layer_values")?.chunks_exact(4 * side * side);
        let named = job.layer_names().into_iter().map(|name| format!("intensity_{name}"));
        let mut grids: Vec<_> = named.zip(values.map(floats)).collect();
        let cells: Vec<[f32; 4]> = bytes("cell_values")?.chunks_exact(16).map(pod_read_unaligned).collect();
        for (at, name) in
            ["true_positive", "false_positive", "false_negative", "inflated"].into_iter().enumerate()
        {
            grids.push((name.into(), cells.iter().map(|values| values[at]).collect()));
        }
        // Eq. 11: I_plan = I_inflate u I_FP.
        grids.push((
            "plan".into(),
            cells.iter().map(|[_, passable, _, inflated]| passable.max(*inflated)).collect(),
        ));
        Ok(ScanLayers { grids })
    };
    let glass = job
        .glass
        .is_some()
        .then(|| LabelledScan::read(readback, executor, pending.points, pending.pose_jumped));
    Ok(ScanOutput {
        index: pending.index,
        stamp_ns: pending.stamp_ns,
        map_frame: pending.map_frame,
        map_from_base: pending.pose.map_from_base,
        base_from_lidar: pending.pose.base_from_lidar,
        towards_goal: pending.towards_goal,
        grid: pending.grid,
        costmap: quads("plan_costs")?,
        classes: quads("plan_classes")?,
        pose_jumped: pending.pose_jumped,
        points: pending.points,
        glass: glass.transpose()?,
        layers: job.layers.then(layers).transpose()?,
        pass_ms: readback
            .spans
            .iter()
            .map(|(name, span)| (name.to_string(), span.length_ns * 1e-6))
            .collect(),
    })
}
