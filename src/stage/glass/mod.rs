//! Panes of glass in a scan, what lies on them and what they mirror (spec 3): the passes, in order, and their parameters.
//!
//! The passes take a scan's points as they were measured, all as if at the scan's stamp; they are not deskewed. Beams and their
//! grid are the sensor's own, so a point must stay on its beam; and a reflection is on the beam of the pane that mirrors it,
//! seen at the same time. So the lidar is assumed to move little while it sweeps over one pane and what the pane mirrors.
//! A pane is given in the lidar's frame at the stamp. It is off by as much as the lidar moved between the time at which its
//! beams were fired and the stamp: at most 0.1 m at 1 m/s and 10 Hz. What `glass/clean` moves stays on its beam and keeps its
//! time, so the map deskews it like any other point.

use std::sync::Arc;

use glam::Vec4;

use crate::base::Rigid;
use crate::base::{Error, Result};
use crate::config::{Config, GroundSource};
use crate::gpu::{Extent, FrameInput, Invocations, Plan};
use crate::map::glass::COUNTERS_WORDS;
use crate::map::{KEPT_PANES, Pane, PaneSet};
use crate::sensor::BeamGrid;
use crate::stage::lidar::intensity_layers::POINT_ROW;
use crate::stage::{LidarJob, Moment, Stage, rows, single};

pub mod pane_cells;
mod shaders;

pub use shaders::{
    ACCEPT, CANDIDATE, CLEAN, CLEAR, FIT, FLOOR_IMAGES, GATHER, IMAGES, LABEL, LABELLING, MIRROR, MIRRORS,
    OPENINGS, ORGANIZE, PEAK, REMEMBER, SCORE, SETTLE, SURVEY, WALLS,
};

/// Panes that are searched for in one scan (`SCAN_PANES`).
pub const SCAN_PANES: u32 = 4;
/// Mirrors that are found in one scan (`SCAN_MIRRORS`).
pub const SCAN_MIRRORS: u32 = 2;
/// Walls on which mirrors are searched for in one scan (`WALLS`).
pub const SCAN_WALLS: u32 = 4;
/// Words of what is counted behind one (`STRIPS` times `STRIP_WORDS`).
const WALL_WORDS: u64 = 256 * 9;
/// Candidates that are looked at (`MOST_CANDIDATES`).
pub const MOST_CANDIDATES: u32 = 4096;
/// Candidates in a row of their texture (`CANDIDATE_ROW`).
pub const CANDIDATE_ROW: u32 = 64;
/// Rows in a row of their texture (`ROW_TEXELS`).
pub const ROW_TEXELS: u32 = 64;
/// Above any number of a row.
const NO_ROW: f32 = 65536.0;
/// Hypotheses for one plane, at most (`MOST_HYPOTHESES`).
pub const MOST_HYPOTHESES: u32 = 512;
/// Points of a scan that the cells can number (`INDEX_BITS`).
pub const MOST_POINTS: u32 = 1 << 18;
/// Invocations that count one hypothesis (`PARTS` of `glass/score`).
const SCORE_PARTS: u32 = 16;
/// Hypotheses that one invocation counts (`TOGETHER`).
const SCORED_TOGETHER: u32 = 8;
/// Beams that one invocation of the survey takes in turn (`EACH` of `glass/survey_plane`).
const BEAMS_EACH: u32 = 8;
/// Beams for which there is one invocation of `glass/images`, which takes as many in turn as there are.
const PASSED_EACH: u32 = 64;
/// Points that one invocation takes in turn, where all are listed: on software drivers an invocation costs more to begin than
/// most of these passes do with a point.
const POINTS_EACH: u32 = 16;
/// Squares of the survey, times its counts.
const SURVEY_WORDS: u64 = 5 * 8192;
/// Counts per pane (`PANE_COUNTS`).
const PANE_COUNTS: u64 = 8;
/// Bytes of what is known of a pane's ends.
const ENDS_BYTES: u64 = 16;
/// Bytes before the panes in `kept` and in `panes`.
pub const HEADER_BYTES: u64 = 16;

crate::params! {
    /// Parameters of all passes of glass.
    pub struct GlassParams {
        /// Rotation and translation of the lidar in the map's axes from the local origin, row x.
        pub local_from_lidar_x: Vec4,
        /// Row y.
        pub local_from_lidar_y: Vec4,
        /// Row z.
        pub local_from_lidar_z: Vec4,
        /// Points of the scan.
        pub points: u32,
        /// Rows of the organized cloud.
        pub rows: u32,
        /// Columns of the organized cloud.
        pub columns: u32,
        /// Ring numbers that have a row; 0: rows are by elevation alone.
        pub rings: u32,
        /// Row nearest the horizontal.
        pub level_row: u32,
        /// Rows on each side that count as around a beam.
        pub half_rows: u32,
        /// Columns on each side that count as around a beam.
        pub half_columns: u32,
        /// Hypotheses for one plane.
        pub hypotheses: u32,
        /// Of the draws.
        pub seed: u32,
        /// Whether panes are kept from scan to scan: 0 or 1.
        pub remembers: u32,
        /// Panes in `loaded_panes`.
        pub loaded: u32,
        /// Candidates that make a plane.
        pub min_inliers: u32,
        /// Beams that must go behind it.
        pub min_behind: u32,
        /// Returns of a beam differ when they are farther apart than this.
        pub return_gap_m: f32,
        /// Distance of a candidate from the plane that it fits.
        pub fit_tolerance_m: f32,
        /// Distance from a pane's plane at which a return lies on it.
        pub plane_tolerance_m: f32,
        /// Difference of ranges at which two surfaces are one.
        pub match_m: f32,
        /// Its growth with range.
        pub match_per_m: f32,
        /// How much brighter than the lower quartile of its candidates a pane may look.
        pub bright_ratio: f32,
        /// Cosine of the angle from head on within which glass shines.
        pub lobe_cos: f32,
        /// Cosine of the angle from head on within which glass shows.
        pub visible_cos: f32,
        /// Whether what is kept goes, and those in `loaded_panes` come in its place: 0 or 1.
        pub replaces: u32,
        /// Unused.
        pub pad1: u32,
        /// Unused.
        pub pad2: u32,
    }
}

/// Rows by number, as `shaders/lib/glass/row_texels.wgsl` reads them: of the bin of elevation, and of the ring.
pub fn row_texels(grid: &BeamGrid) -> Vec<[f32; 4]> {
    let most = grid.elevation_rows.len().max(grid.ring_rows.len());
    let row = |rows: &[u32], number: usize| rows.get(number).and_then(|&row| u16::try_from(row).ok());
    let texel = |number| {
        let of = |rows| row(rows, number).map_or(NO_ROW, f32::from);
        [of(&grid.elevation_rows), of(&grid.ring_rows), 0.0, 0.0]
    };
    (0..most.next_multiple_of(ROW_TEXELS as usize)).map(texel).collect()
}

/// What the passes need of one scan.
#[derive(Debug, Clone, Copy)]
pub struct GlassMoment<'a> {
    /// Points of the scan.
    pub points: u32,
    /// Pose of the lidar in the frame in which panes are kept: the map's axes, from an origin near the first pose, as f32
    /// is too coarse for coordinates far from it.
    pub local_from_lidar: Rigid,
    /// Panes to begin with, in place of all those kept, if there are none too; `None`: what is kept stays.
    pub load: Option<&'a [Pane]>,
}

/// The stage: the organized cloud it is built for.
#[derive(Debug, Clone, PartialEq)]
pub struct Glass {
    /// Rows and columns of the sensor's beams.
    pub grid: BeamGrid,
    /// Panes to begin with, in the map.
    pub load: PaneSet,
}

/// The stage of a map's lidar.
#[derive(Debug)]
pub struct LabelGlass {
    /// What it is built for.
    pub job: Arc<LidarJob>,
    /// The passes.
    pub glass: Glass,
}

impl Stage for LabelGlass {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let capacity = self.job.capacity;
        self.glass.append(plan, &self.job.config, capacity)?;
        plan.scratch("clean_points", u64::from(capacity) * 32)?;
        plan.step(CLEAN, Invocations::line(capacity), &[])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let first = moment.since_last_s.is_none();
        let load = first.then(|| self.glass.load.from_origin(moment.local_origin_m));
        let points = u32::try_from(moment.scan()?.points.len()).unwrap_or(self.job.capacity);
        let glass = GlassMoment {
            points,
            local_from_lidar: moment.pose.map_from_sensor().from_origin(moment.local_origin_m),
            load: load.as_deref(),
        };
        self.glass.write(&self.job.config, &glass, input)?;
        input.limit(CLEAN.name, Invocations::line(points))
    }
}

impl Glass {
    /// Declares its buffers and appends its passes; `points` holds at most `capacity` points. Where the ground is estimated, its passes
    /// stand before these.
    ///
    /// # Errors
    /// [`Error::Plan`], also for more points than cells can number; [`Error::Shader`].
    pub fn append(&self, plan: &mut Plan, config: &Config, capacity: u32) -> Result<()> {
        if capacity > MOST_POINTS {
            let reason = format!("{capacity} points; glass is searched for among at most {MOST_POINTS}");
            return Err(Error::Plan { pass: "glass".into(), reason });
        }
        self.declare(plan, capacity)?;
        let size = self.grid.cells();
        plan.step(CLEAR, Invocations::line(size.max(64)), &[])?;
        plan.step(ORGANIZE, Invocations::line(capacity.div_ceil(POINTS_EACH)), &[])?;
        plan.step(PEAK, Invocations::line(self.grid.columns), &[])?;
        plan.step(CANDIDATE, Invocations::line(size.div_ceil(32)), &[])?;
        plan.step(GATHER, Invocations::line(1), &[("candidates", "candidates_even")])?;
        for turn in 0..SCAN_PANES {
            let lists = ["candidates_even", "candidates_odd"];
            let (list, left) = if turn % 2 == 0 { (lists[0], lists[1]) } else { (lists[1], lists[0]) };
            let from = [("candidates", list)];
            plan.step(
                SCORE,
                Invocations::area(config.glass_hypotheses.div_ceil(SCORED_TOGETHER), SCORE_PARTS),
                &from,
            )?;
            plan.step(FIT, Invocations::line(1), &from)?;
            plan.step(SURVEY, Invocations::line(size.div_ceil(BEAMS_EACH)), &[])?;
            plan.step(ACCEPT, Invocations::line(1), &[("candidates", list), ("left", left)])?;
        }
        if config.glass_mirrors {
            plan.scratch("scan_walls", 48 * u64::from(SCAN_WALLS))?;
            plan.scratch("wall_strips", 4 * WALL_WORDS * u64::from(SCAN_WALLS))?;
            plan.scratch("passed_beams", 4 + 8 * u64::from(size))?;
            plan.step(WALLS, Invocations::line(1), &[])?;
            plan.step(OPENINGS, Invocations::line(size.div_ceil(BEAMS_EACH)), &[])?;
            plan.step(IMAGES, Invocations::line(size.div_ceil(PASSED_EACH)), &[])?;
            plan.step(MIRRORS, Invocations::line(1), &[])?;
        }
        plan.step(REMEMBER, Invocations::line(1), &[])?;
        plan.step(MIRROR, Invocations::line(capacity.div_ceil(POINTS_EACH)), &[])?;
        plan.step(LABEL, Invocations::line(capacity.div_ceil(POINTS_EACH)), &[])?;
        plan.step(SETTLE, Invocations::line(capacity.div_ceil(POINTS_EACH)), &[])?;
        if config.ground == GroundSource::Stated {
            return Ok(());
        }
        plan.step(FLOOR_IMAGES, Invocations::line(capacity.div_ceil(POINTS_EACH)), &[])
    }

    fn declare(&self, plan: &mut Plan, capacity: u32) -> Result<()> {
        let size = u64::from(self.grid.cells());
        let pane = size_of::<Pane>() as u64;
        plan.uniform::<GlassParams>("glass_params")?;
        let rows = row_texels(&self.grid);
        let extent = Extent {
            width: ROW_TEXELS,
            height: u32::try_from(rows.len()).unwrap_or(u32::MAX) / ROW_TEXELS,
            layers: 1,
        };
        plan.fixed_texture("row_texels", extent, bytemuck::cast_slice(&rows).to_vec())?;
        plan.upload("loaded_panes", pane * KEPT_PANES as u64)?;
        plan.state("kept", HEADER_BYTES + pane * KEPT_PANES as u64)?;
        plan.state("pane_counts", 4 * PANE_COUNTS * KEPT_PANES as u64)?;
        plan.state("kept_ends", ENDS_BYTES * KEPT_PANES as u64)?;
        for (name, bytes) in [
            ("beam_cells", 8 * size),
            ("mirrored", 4 * size),
            ("peaks", 4 * size),
            ("candidate_bits", 4 * size.div_ceil(32)),
            ("met_points", 8 + 8 * u64::from(capacity)),
            ("scores", 4 * u64::from(MOST_HYPOTHESES)),
            ("found", 48),
            ("survey", 4 * SURVEY_WORDS),
            ("scan_panes", pane * u64::from(SCAN_PANES + SCAN_MIRRORS)),
            ("scan_ends", ENDS_BYTES * u64::from(SCAN_PANES + SCAN_MIRRORS)),
        ] {
            plan.scratch(name, bytes)?;
        }
        for name in ["candidates_even", "candidates_odd"] {
            let height = MOST_CANDIDATES / CANDIDATE_ROW;
            plan.texture(name, Extent { width: CANDIDATE_ROW, height, layers: 1 })?;
        }
        let height = capacity.div_ceil(POINT_ROW);
        plan.texture("placed", Extent { width: POINT_ROW, height, layers: 1 })?;
        let height = u32::try_from(KEPT_PANES).unwrap_or(u32::MAX);
        plan.texture("pane_texels", Extent { width: 4, height, layers: 1 })?;
        plan.product("panes", HEADER_BYTES + pane * KEPT_PANES as u64)?;
        plan.product("classes", 4 * u64::from(capacity))?;
        plan.product("glass_counters", 4 * COUNTERS_WORDS as u64)?;
        Ok(())
    }

    /// The parameters of one scan.
    pub fn params(&self, config: &Config, moment: &GlassMoment<'_>) -> GlassParams {
        let [local_from_lidar_x, local_from_lidar_y, local_from_lidar_z] = rows(moment.local_from_lidar);
        let count = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
        let [half_rows, half_columns] = self.grid.cells_within(config.glass_slack_deg);
        GlassParams {
            local_from_lidar_x,
            local_from_lidar_y,
            local_from_lidar_z,
            points: moment.points,
            rows: self.grid.rows,
            columns: self.grid.columns,
            rings: if self.grid.by_ring { count(self.grid.ring_rows.len()) } else { 0 },
            level_row: self.grid.level_row,
            half_rows,
            half_columns,
            hypotheses: config.glass_hypotheses,
            seed: config.glass_seed,
            remembers: u32::from(config.glass_memory),
            loaded: moment.load.map_or(0, |panes| count(panes.len().min(KEPT_PANES))),
            min_inliers: config.glass_min_inliers,
            min_behind: config.glass_min_behind,
            return_gap_m: single(config.glass_return_gap_m),
            fit_tolerance_m: single(config.glass_fit_tolerance_m),
            plane_tolerance_m: single(config.glass_plane_tolerance_m),
            match_m: single(config.glass_match_m),
            match_per_m: single(config.glass_match_per_m),
            bright_ratio: single(config.glass_bright_ratio),
            lobe_cos: single(config.glass_lobe_deg.to_radians().cos()),
            visible_cos: single(config.glass_visible_deg.to_radians().cos()),
            replaces: u32::from(moment.load.is_some()),
            pad1: 0,
            pad2: 0,
        }
    }

    /// Writes its parameters and data for one scan.
    ///
    /// # Errors
    /// [`Error::Input`] where data do not fit their buffer.
    pub fn write(&self, config: &Config, moment: &GlassMoment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        input.set("glass_params", &self.params(config, moment))?;
        let floor_images = (config.ground != GroundSource::Stated).then_some(&FLOOR_IMAGES);
        for pass in [&ORGANIZE, &MIRROR, &LABEL, &SETTLE].into_iter().chain(floor_images) {
            input.limit(pass.name, Invocations::line(moment.points.div_ceil(POINTS_EACH)))?;
        }
        input.read_back_first("classes", 4 * u64::from(moment.points))?;
        match moment.load {
            Some(panes) => {
                let panes = &panes[..panes.len().min(KEPT_PANES)];
                input.write("loaded_panes", bytemuck::cast_slice(panes))
            }
            None => Ok(()),
        }
    }
}
