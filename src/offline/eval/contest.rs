//! The methods side by side: every frame goes through a pipeline of each.

use crate::base::{Error, Result};
use crate::config::{Config, Fusion, Method};
use crate::gpu::Context;
use crate::map::{FrameImages, MapUpdate, Update};
use crate::mapper::{Mapper, Options, SensorInfo};
use crate::sensor::{CameraInfo, Observation, RgbdFrame};
use crate::stage::camera::map_reliability::knows_cells_of;

/// Hits a cell and frame that the stricter naive method asks for (spec 1 §8).
const STRICT_HITS: u32 = 3;

/// What points of the frontier are called, by the key of the configuration and its value: with fusion evidence, learned, and another.
const EXPONENTS: [(&str, f64); 5] = [
    ("evidence_exponent: 2", 2.0),
    ("evidence_exponent: 4", 4.0),
    ("evidence_exponent: 8", 8.0),
    ("evidence_exponent: 12", 12.0),
    ("evidence_exponent: 16", 16.0),
];
const BIASES: [(&str, f64); 5] = [
    ("learned_bias: -2", -2.0),
    ("learned_bias: -1", -1.0),
    ("learned_bias: 0.7", 0.7),
    ("learned_bias: 1.4", 1.4),
    ("learned_bias: 2", 2.0),
];
const TAUS: [(&str, f64); 5] =
    [("tau: 0.1", 0.1), ("tau: 0.2", 0.2), ("tau: 0.45", 0.45), ("tau: 0.6", 0.6), ("tau: 0.75", 0.75)];

/// Whether a name in reports is that of a point of the frontier.
pub fn is_frontier(key: &str) -> bool {
    EXPONENTS.iter().chain(&BIASES).chain(&TAUS).any(|(name, _)| *name == key)
}

/// A method with its settings.
#[derive(Debug, Clone, PartialEq)]
pub struct Contestant {
    /// Its name in reports: `drm` is the method as configured, `drm_evidence`, `drm_learned`, `drm_weight` or `drm_gate` the same with another fusion.
    pub key: &'static str,
    /// Its parameters.
    pub config: Config,
}

/// The method with each other fusion takes the first one's reliability, so that the network runs once a frame.
const OTHER_FUSIONS: [(&str, Fusion); 4] = [
    ("drm_learned", Fusion::Learned),
    ("drm_evidence", Fusion::Evidence),
    ("drm_weight", Fusion::Weight),
    ("drm_gate", Fusion::Gate),
];

/// All methods with the map settings of `config` (spec 1 §4, §8). The baselines have the paper's fusion.
pub fn contestants(config: &Config) -> Vec<Contestant> {
    let paper = Config { fusion: Fusion::Weight, ..config.clone() };
    let with = |key, method| Contestant { key, config: Config { method, ..paper.clone() } };
    let mut all = vec![
        with("naive", Method::Naive),
        with("range", Method::Range),
        with("median", Method::Median),
        with("temporal", Method::Temporal),
        with("naive_3_hits", Method::Naive),
    ];
    all[4].config.min_hits = STRICT_HITS.max(config.min_hits);
    let own = fusion_of_drm(config);
    let drm = Config { method: Method::Drm, fusion: own, ..config.clone() };
    all.push(Contestant { key: "drm", config: drm });
    // Reliability is 0 wherever drm takes no depth, so the wider range of naive lets nothing else in.
    for (key, fusion) in OTHER_FUSIONS.into_iter().filter(|(_, fusion)| *fusion != own) {
        if fusion == Fusion::Learned && !knows_cells_of(config.resolution_m) {
            continue;
        }
        all.push(Contestant { key, config: Config { method: Method::Naive, fusion, ..config.clone() } });
    }
    all
}

/// The fusion that method drm has.
fn fusion_of_drm(config: &Config) -> Fusion {
    match config.fusion {
        Fusion::Auto if knows_cells_of(config.resolution_m) => Fusion::Learned,
        Fusion::Auto => Fusion::Evidence,
        stated => stated,
    }
}

/// Method drm's fusion at other points of its frontier between false obstacles and missed ones, by the key that the fusion has for that:
/// they take the reliability of drm before them.
pub fn frontier(config: &Config) -> Vec<Contestant> {
    let fusion = fusion_of_drm(config);
    let base = Config { method: Method::Naive, fusion, ..config.clone() };
    if fusion == Fusion::Evidence {
        let of = |(key, evidence_exponent)| Contestant {
            key,
            config: Config { evidence_exponent, ..base.clone() },
        };
        return EXPONENTS.into_iter().map(of).collect();
    }
    if fusion == Fusion::Learned {
        let of = |(key, learned_bias)| Contestant { key, config: Config { learned_bias, ..base.clone() } };
        return BIASES.into_iter().map(of).collect();
    }
    TAUS.into_iter().map(|(key, tau)| Contestant { key, config: Config { tau, ..base.clone() } }).collect()
}

/// A mapper for each method, all at the same frame.
pub struct Contest {
    entries: Vec<(Contestant, Mapper)>,
}

/// A method's result for one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The method's name.
    pub key: &'static str,
    /// The method's tau.
    pub tau: f32,
    /// What came of the frame, with images.
    pub update: Update,
}

impl Entry {
    /// Depth and weights as the method has them.
    ///
    /// # Errors
    /// [`Error::Input`] where they were not read back.
    pub fn images(&self) -> Result<&FrameImages> {
        let reason = || Error::Input { what: self.key.into(), reason: "has no images".into() };
        self.update.camera().and_then(|camera| camera.images.as_ref()).ok_or_else(reason)
    }

    /// The map after the frame.
    ///
    /// # Errors
    /// [`Error::Input`] where there is none.
    pub fn map(&self) -> Result<&MapUpdate> {
        let reason = || Error::Input { what: self.key.into(), reason: "has no map".into() };
        self.update.map.as_ref().ok_or_else(reason)
    }
}

impl Contest {
    /// Builds the passes for frames like `first`.
    ///
    /// # Errors
    /// Those of [`Mapper::open`].
    pub fn open(contestants: &[Contestant], first: &RgbdFrame, adapter: Option<&str>) -> Result<Self> {
        let context = Context::open(adapter, false)?;
        let options = Options { images: true, ..Options::default() };
        let open = |contestant: &Contestant| {
            let mut first =
                if contestant.config.method == Method::Drm { first.clone() } else { plain(first) };
            if needs_reliability(contestant.key) {
                first.confidence = Some(Vec::new());
            }
            let nothing = || Error::Empty { reason: "no first frame".into() };
            let info = CameraInfo::of_frames([&first]).ok_or_else(nothing)?;
            let sensors = [SensorInfo::camera(&contestant.config, info)];
            Ok((contestant.clone(), Mapper::on(&context, &contestant.config, &sensors, &options)?))
        };
        Ok(Self { entries: contestants.iter().map(open).collect::<Result<_>>()? })
    }

    /// Puts a frame through all of them.
    ///
    /// # Errors
    /// Those of [`Mapper::step`].
    pub fn step(&mut self, frame: &RgbdFrame) -> Result<Vec<Entry>> {
        let bare = plain(frame);
        let mut results: Vec<Entry> = Vec::new();
        for (contestant, mapper) in &mut self.entries {
            let frame = if needs_reliability(contestant.key) {
                let last = results.last().map(Entry::images).transpose()?;
                let confidence = last.map(|images| images.reliability.clone());
                RgbdFrame { confidence, ..bare.clone() }
            } else if contestant.config.method == Method::Drm {
                frame.clone()
            } else {
                bare.clone()
            };
            let update = mapper.step(&Observation::of_frame(0, &contestant.config.map_frame, frame))?;
            let tau = crate::stage::single(contestant.config.tau);
            results.push(Entry { key: contestant.key, tau, update });
        }
        Ok(results)
    }
}

fn needs_reliability(key: &str) -> bool {
    OTHER_FUSIONS.iter().any(|(other, _)| *other == key) || is_frontier(key)
}

/// Without colour, which only the network needs.
fn plain(frame: &RgbdFrame) -> RgbdFrame {
    RgbdFrame {
        index: frame.index,
        depth: frame.depth.clone(),
        color: None,
        color_from_depth: None,
        color_missing: None,
        confidence: frame.confidence.clone(),
        pose: frame.pose,
    }
}
