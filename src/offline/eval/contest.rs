//! The methods side by side: every frame goes through a pipeline of each.

use crate::base::{Error, Result};
use crate::config::{Config, Fusion, Method};
use crate::frame::{FrameImages, FrameOutput, Options};
use crate::pipeline::Pipeline;
use crate::sensor::RgbdFrame;

/// Hits a cell and frame that the stricter naive method asks for (spec 1 §8).
const STRICT_HITS: u32 = 3;

/// A method with its settings.
#[derive(Debug, Clone, PartialEq)]
pub struct Contestant {
    /// Its name in reports: `drm` is the method as configured, `drm_weight` or `drm_gate` the same with the other fusion.
    pub key: &'static str,
    /// Its parameters.
    pub config: Config,
}

/// The method of the other fusion takes the first one's reliability, so that the network runs once a frame.
const OTHER_FUSION: [&str; 2] = ["drm_weight", "drm_gate"];

/// All methods with the map settings of `config` (spec 1 §4, §8).
pub fn contestants(config: &Config) -> Vec<Contestant> {
    let with = |key, method| Contestant { key, config: Config { method, ..config.clone() } };
    let mut all = vec![
        with("naive", Method::Naive),
        with("range", Method::Range),
        with("median", Method::Median),
        with("temporal", Method::Temporal),
        with("naive_3_hits", Method::Naive),
    ];
    all[4].config.min_hits = STRICT_HITS.max(config.min_hits);
    let (key, fusion) = match config.fusion {
        Fusion::Weight => (OTHER_FUSION[1], Fusion::Gate),
        Fusion::Gate => (OTHER_FUSION[0], Fusion::Weight),
    };
    all.push(with("drm", Method::Drm));
    // Reliability is 0 wherever drm takes no depth, so the wider range of naive lets nothing else in.
    all.push(Contestant { key, config: Config { method: Method::Naive, fusion, ..config.clone() } });
    all
}

/// A pipeline for each method, all at the same frame.
pub struct Contest {
    entries: Vec<(Contestant, Pipeline)>,
}

/// A method's result for one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The method's name.
    pub key: &'static str,
    /// The method's tau.
    pub tau: f32,
    /// The costmap, with images.
    pub output: FrameOutput,
}

impl Entry {
    /// Depth and weights as the method has them.
    ///
    /// # Errors
    /// [`Error::Input`] where they were not read back.
    pub fn images(&self) -> Result<&FrameImages> {
        let reason = || Error::Input { what: self.key.into(), reason: "has no images".into() };
        self.output.images.as_ref().ok_or_else(reason)
    }
}

impl Contest {
    /// Builds the pipelines for frames like `first`.
    ///
    /// # Errors
    /// Those of [`Pipeline::open`].
    pub fn open(contestants: &[Contestant], first: &RgbdFrame, adapter: Option<&str>) -> Result<Self> {
        let open = |contestant: &Contestant| {
            let options = Options { adapter: adapter.map(str::to_owned), images: true, ..Options::default() };
            let pipeline = if contestant.config.method == Method::Drm {
                let options = options.with_color_of(std::iter::once(first));
                Pipeline::open(&contestant.config, first, &options)?
            } else {
                let mut first = plain(first);
                first.confidence = needs_reliability(contestant.key).then(Vec::new);
                Pipeline::open(&contestant.config, &first, &options)?
            };
            Ok((contestant.clone(), pipeline))
        };
        Ok(Self { entries: contestants.iter().map(open).collect::<Result<_>>()? })
    }

    /// Puts a frame through all of them.
    ///
    /// # Errors
    /// Those of [`Pipeline::submit`] and [`Pipeline::receive`].
    pub fn step(&mut self, frame: &RgbdFrame) -> Result<Vec<Entry>> {
        let bare = plain(frame);
        for (contestant, pipeline) in &mut self.entries {
            if !needs_reliability(contestant.key) {
                pipeline.submit(if contestant.config.method == Method::Drm { frame } else { &bare })?;
            }
        }
        let mut results: Vec<Entry> = Vec::new();
        for (contestant, pipeline) in &mut self.entries {
            if needs_reliability(contestant.key) {
                let last = results.last().map(Entry::images).transpose()?;
                let confidence = last.map(|images| images.reliability.clone());
                pipeline.submit(&RgbdFrame { confidence, ..bare.clone() })?;
            }
            let lost = || Error::Gpu { what: contestant.key.into(), reason: "nothing came back".into() };
            let output = pipeline.receive()?.ok_or_else(lost)?;
            let tau = crate::stage::single(contestant.config.tau);
            results.push(Entry { key: contestant.key, tau, output });
        }
        Ok(results)
    }
}

fn needs_reliability(key: &str) -> bool {
    OTHER_FUSION.contains(&key)
}

/// Without colour, which only the network needs.
fn plain(frame: &RgbdFrame) -> RgbdFrame {
    RgbdFrame {
        index: frame.index,
        depth: frame.depth.clone(),
        color: None,
        color_from_depth: None,
        confidence: frame.confidence.clone(),
        pose: frame.pose,
    }
}
