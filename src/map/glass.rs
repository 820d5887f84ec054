//! Labels of scans with glass (spec 3): classes of points, what was met, whole scans.

use bytemuck::pod_read_unaligned;

use crate::base::Result;
use crate::gpu::{Executor, Readback};
use crate::map::Pane;

/// Bytes before the panes in a buffer of panes.
const HEADER_BYTES: usize = 16;

/// Words of a scan's counters.
pub const COUNTERS_WORDS: usize = 16;

/// What a point is (spec 3 §5).
#[repr(u8)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PointClass {
    /// No step decided, or the point is none.
    #[default]
    Unlabelled = 0,
    /// Real, and not behind a pane.
    Inside = 1,
    /// On a pane.
    Glass = 2,
    /// Seen in a pane; nothing real stands there.
    Reflection = 3,
    /// Real, behind a pane.
    Outside = 4,
}

impl PointClass {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 5] = [Self::Unlabelled, Self::Inside, Self::Glass, Self::Reflection, Self::Outside];

    /// Of a number as shaders give it; [`Self::Unlabelled`] where it is none.
    pub fn of_number(number: u8) -> Self {
        Self::ALL.get(usize::from(number)).copied().unwrap_or_default()
    }

    /// The class in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unlabelled => "unlabelled",
            Self::Inside => "inside",
            Self::Glass => "glass",
            Self::Reflection => "reflection",
            Self::Outside => "outside",
        }
    }
}

/// What was met in one scan.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct GlassCounters {
    /// Points that are no numbers, or no place a beam could reach.
    pub unusable_points: u32,
    /// Points whose ring or elevation has no row.
    pub points_without_row: u32,
    /// Beams with two returns that differ.
    pub dual_returns: u32,
    /// Points of intensity peaks.
    pub peak_points: u32,
    /// Candidates, of both kinds.
    pub candidates: u32,
    /// Of them those not looked at, as there were too many.
    pub thinned_candidates: u32,
    /// Planes that were fitted and are no panes.
    pub refused_planes: u32,
    /// Panes found.
    pub found_panes: u32,
    /// Mirrors found.
    pub found_mirrors: u32,
    /// Points of each [`PointClass`].
    pub classes: [u32; 5],
    /// Whether the lidar's pose jumped since the scan before: panes that are kept stay where they were. 0 or 1.
    pub pose_jumps: u32,
}

impl GlassCounters {
    pub(crate) fn of_words(words: &[u32]) -> Self {
        let mut all = [0; COUNTERS_WORDS];
        all.iter_mut().zip(words).for_each(|(to, from)| *to = *from);
        let [unusable_points, points_without_row, dual_returns, peak_points, candidates, thinned, ..] = all;
        let [_, _, _, _, _, _, refused_planes, found_panes, a, b, c, d, e, found_mirrors, ..] = all;
        Self {
            unusable_points,
            points_without_row,
            dual_returns,
            peak_points,
            candidates,
            thinned_candidates: thinned,
            refused_planes,
            found_panes,
            found_mirrors,
            classes: [a, b, c, d, e],
            pose_jumps: 0,
        }
    }
}

/// A scan with its labels.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelledScan {
    /// Class and pane id (0: none) of each point, in the scan's order.
    pub classes: Vec<(PointClass, u32)>,
    /// The panes that it was labelled by, in the lidar's frame; their ids are those of the points.
    pub panes: Vec<Pane>,
    /// What was met.
    pub counters: GlassCounters,
    /// GPU time per pass in milliseconds, in order, when profiling.
    pub pass_ms: Vec<(String, f64)>,
}

impl LabelledScan {
    /// Of a scan of `points` points that came back from the passes of `scope`, its pose having `jumped` or not.
    ///
    /// # Errors
    /// [`Error::Gpu`] where labels were not read back.
    pub(crate) fn read(
        readback: &Readback,
        executor: &Executor,
        scope: &str,
        points: usize,
        jumped: bool,
    ) -> Result<Self> {
        let bytes = |name: &str| readback.bytes(executor.find_in(scope, name)?);
        let words = |name: &str| -> Result<Vec<u32>> {
            Ok(bytes(name)?.chunks_exact(4).map(pod_read_unaligned).collect())
        };
        let panes = bytes("panes")?.get(HEADER_BYTES..).unwrap_or_default();
        let panes = panes.chunks_exact(size_of::<Pane>()).map(pod_read_unaligned::<Pane>);
        let class = |word: &u32| (PointClass::of_number(word.to_le_bytes()[0]), word >> 8);
        let spans = readback.spans.iter();
        Ok(Self {
            classes: words("classes")?.iter().take(points).map(class).collect(),
            panes: panes.filter(|pane| pane.id != 0).collect(),
            counters: GlassCounters {
                pose_jumps: u32::from(jumped),
                ..GlassCounters::of_words(&words("glass_counters")?)
            },
            pass_ms: spans.map(|(name, span)| (name.to_string(), span.length_ns * 1e-6)).collect(),
        })
    }
}
