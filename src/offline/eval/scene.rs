//! One scene through all methods.

use crate::base::{Error, Result};
use crate::config::Config;
use crate::offline::eval::contest::{Contest, Contestant, Entry};
use crate::offline::eval::depth::{measured_m, tolerance_m};
use crate::offline::eval::predictors::Predictor;
use crate::offline::eval::ranking::suspicion;
use crate::offline::eval::{MethodTally, SceneResult, Source, TrueFrame, TrueWindow};

/// Frames at the start that are not scored: a map needs some to form (spec 1 §6).
pub const UNSCORED: u64 = 10;

/// A frame that was scored, with what all methods made of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Scored {
    /// What the sensor gave, and the truth.
    pub frame: TrueFrame,
    /// The true map on the costmap's window.
    pub window: TrueWindow,
    /// Results by method.
    pub entries: Vec<Entry>,
}

/// Puts all frames of `source` through all methods and scores every one after the tenth; gives the last one too.
///
/// # Errors
/// Those of the source and the pipelines; [`Error::Empty`] where too few frames came to score any.
pub fn evaluate(
    source: &mut dyn Source,
    contestants: &[Contestant],
    config: &Config,
    adapter: Option<&str>,
) -> Result<(SceneResult, Scored)> {
    let mut result = SceneResult::default();
    let mut contest = None;
    let mut seen = 0;
    let mut last = None;
    while let Some(frame) = source.next_frame()? {
        let contest = match &mut contest {
            Some(contest) => contest,
            None => contest.insert(Contest::open(contestants, &frame.frame, adapter)?),
        };
        let entries = contest.step(&frame.frame)?;
        seen += 1;
        let Some(first) = entries.first().filter(|_| seen > UNSCORED) else { continue };
        let window = TrueWindow::new(&frame.truth, &first.map()?.grid, config)?;
        score(&mut result, &frame, &window, &entries)?;
        last = Some(Scored { frame, window, entries });
    }
    let reason = || format!("{seen} posed frames came, and scoring starts after {UNSCORED}");
    Ok((result, last.ok_or_else(|| Error::Empty { reason: reason() })?))
}

fn score(result: &mut SceneResult, frame: &TrueFrame, window: &TrueWindow, entries: &[Entry]) -> Result<()> {
    let measured = measured_m(&frame.frame);
    let truth = &frame.truth.depth_m;
    if truth.len() != measured.len() {
        let reason = format!("{} true depths for {} pixels", truth.len(), measured.len());
        return Err(Error::Input { what: "true depth".into(), reason });
    }
    let camera = frame.frame.depth.camera;
    let labels = labels(&measured, truth, camera.fx);
    for predictor in Predictor::ALL {
        let ranking = result.predictors.entry(predictor.key().into()).or_default();
        let scores = predictor.scores(&measured, camera.width as usize);
        for (&score, bad) in scores.iter().zip(&labels).filter_map(|(score, bad)| Some((score, (*bad)?))) {
            ranking.put(score, bad);
        }
    }
    for entry in entries {
        let images = entry.images()?;
        let tally: &mut MethodTally = result.methods.entry(entry.key.into()).or_default();
        tally.depth.observe(&measured, &images.depth_m, &images.reliability, entry.tau, truth);
        tally.map.observe(&entry.map()?.costmap, window)?;
        for (&weight, bad) in images.reliability.iter().zip(&labels) {
            let Some(bad) = *bad else { continue };
            tally.ranking.put(suspicion(weight), bad);
            tally.decision.put(weight <= entry.tau, bad);
        }
    }
    result.frames += 1;
    Ok(())
}

/// Whether each measured pixel is unreliable: further from the truth than delta; `None` where either is missing.
fn labels(measured_m: &[f32], true_m: &[f32], focal_px: f64) -> Vec<Option<bool>> {
    let label = |(&measured, &truth): (&f32, &f32)| {
        let error_m = (f64::from(measured) - f64::from(truth)).abs();
        (measured > 0.0 && truth > 0.0).then(|| error_m > tolerance_m(truth.into(), focal_px))
    };
    measured_m.iter().zip(true_m).map(label).collect()
}
