//! How good depth, reliability and costmaps are against ground truth (spec 1 §6), for all methods side by side.
//!
//! Counts are kept, not rates: those of frames and scenes add up, and every figure is one division at the end.

pub mod contest;
pub mod depth;
pub mod glass_metrics;
pub mod glass_scenes;
pub mod map;
pub mod pairs;
pub mod picture;
pub mod predictors;
pub mod ranking;
pub mod report;
pub mod result;
pub mod scene;
pub mod shown;
pub mod source;

pub use contest::{Contest, contestants, frontier};
pub use depth::DepthTally;
pub use map::{MapTally, TrueWindow};
pub use ranking::{Decision, Ranking};
pub use result::{MethodTally, SceneResult};
pub use scene::evaluate;
pub use source::{Generated, Recorded, Source, TrueFrame};

/// `part / whole`; `None` of nothing.
#[expect(clippy::cast_precision_loss, reason = "pixels and cells of any evaluation fit in 53 bits")]
pub(crate) fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}
