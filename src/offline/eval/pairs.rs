//! Still pairs with a reference: whether reliability finds bad depth in real images (spec 1 §6).

use std::path::Path;

use serde::Deserialize;
use serde_json::{Map, Value, json};

use crate::base::Rigid;
use crate::base::{Error, Result, plain};
use crate::config::{Config, Method};
use crate::input::image_decode::{Decoded, color_from_file, depth_from_file, read_file};
use crate::mapper::{Mapper, Options, SensorInfo};
use crate::offline::eval::picture::{Panel, sheet};
use crate::offline::eval::predictors::Predictor;
use crate::offline::eval::ranking::suspicion;
use crate::offline::eval::report::table::Table;
use crate::offline::eval::{Decision, Ranking, share};
use crate::sensor::{CameraInfo, Observation};
use crate::sensor::{CameraModel, Distortion};
use crate::sensor::{ColorImage, DepthImage, DepthSamples, FramePose, RgbdFrame};

/// A list of pairs in YAML; file names are relative to the folder of the pairs.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairList {
    /// Intrinsics, row-major 3x3, pixels.
    pub camera_matrix: [f64; 9],
    /// Metres per count of integer depth images.
    #[serde(default = "millimetre")]
    pub depth_unit_m: f64,
    /// Depth is bad where it is missing, or further than this from the reference, metres.
    #[serde(default = "centimetre")]
    pub tolerance_m: f64,
    /// The pairs.
    pub pairs: Vec<Pair>,
}

fn millimetre() -> f64 {
    1e-3
}

fn centimetre() -> f64 {
    1e-2
}

/// One pair.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// Its name in reports.
    pub name: String,
    /// Colour (JPEG, PNG).
    pub color: String,
    /// Measured depth (16-bit PNG, or EXR in metres), aligned to colour.
    pub depth: String,
    /// Reference depth on the same grid.
    pub reference: String,
    /// Pixels of interest (not black); none: all.
    #[serde(default)]
    pub mask: Option<String>,
}

impl PairList {
    /// Reads a list.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] where it is no such list or holds no pair.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
        let bad = |reason: String| Error::Format { path: path.into(), reason };
        let list: Self = serde_saphyr::from_str(&text).map_err(|error| bad(plain(&error)))?;
        if list.pairs.is_empty() {
            return Err(bad("`pairs` is empty".into()));
        }
        if !(list.tolerance_m.is_finite() && list.tolerance_m > 0.0) {
            return Err(bad(format!("`tolerance_m`: {} is not a positive number", list.tolerance_m)));
        }
        Ok(list)
    }
}

/// A pair in memory.
struct Loaded {
    frame: RgbdFrame,
    measured_m: Vec<f32>,
    reference_m: Vec<f32>,
    mask: Vec<bool>,
}

impl Pair {
    fn load(&self, folder: &Path, list: &PairList) -> Result<Loaded> {
        let path = |name: &str| folder.join(name);
        let depth = metres(&path(&self.depth), list.depth_unit_m)?;
        let size = (depth.width, depth.height);
        let reference = metres(&path(&self.reference), list.depth_unit_m)?;
        same_size(&path(&self.reference), (reference.width, reference.height), size)?;
        let color = picture(&path(&self.color), size)?;
        let mask = match &self.mask {
            Some(name) => picture(&path(name), size)?.chunks_exact(3).map(|p| p[0] > 127).collect(),
            None => vec![true; depth.samples.len()],
        };
        let [fx, _, cx, _, fy, cy, ..] = list.camera_matrix;
        let camera =
            CameraModel { width: size.0, height: size.1, fx, fy, cx, cy, distortion: Distortion::None };
        let samples = DepthSamples::Metres(depth.samples.clone());
        let frame = RgbdFrame {
            index: 0,
            depth: DepthImage { stamp_ns: 0, frame_id: "camera".into(), camera, samples },
            color: Some(ColorImage { stamp_ns: 0, camera, rgb: color }),
            color_from_depth: Some(Rigid::IDENTITY),
            color_missing: None,
            confidence: None,
            // Reliability needs no pose, and the map of a single pair is not looked at.
            pose: Some(FramePose { map_from_base: Rigid::IDENTITY, base_from_camera: Rigid::IDENTITY }),
        };
        let measured_m = crate::offline::eval::depth::measured_m(&frame);
        Ok(Loaded { frame, measured_m, reference_m: reference.samples, mask })
    }
}

fn metres(path: &Path, unit_m: f64) -> Result<Decoded<Vec<f32>>> {
    let in_file = |error: Error| Error::Format { path: path.into(), reason: error.to_string() };
    let Decoded { width, height, samples } = depth_from_file(&read_file(path)?, unit_m).map_err(in_file)?;
    let samples = match samples {
        DepthSamples::Metres(samples) => samples,
        DepthSamples::Integer { raw, unit_m } => {
            raw.iter().map(|&count| crate::stage::single(f64::from(count) * unit_m)).collect()
        }
    };
    Ok(Decoded { width, height, samples })
}

fn picture(path: &Path, size: (u32, u32)) -> Result<Vec<u8>> {
    let in_file = |error: Error| Error::Format { path: path.into(), reason: error.to_string() };
    let image = color_from_file(&read_file(path)?).map_err(in_file)?;
    same_size(path, (image.width, image.height), size)?;
    Ok(image.samples)
}

fn same_size(path: &Path, got: (u32, u32), want: (u32, u32)) -> Result<()> {
    if got == want {
        return Ok(());
    }
    let reason = format!("is {}x{}, but the depth image {}x{}", got.0, got.1, want.0, want.1);
    Err(Error::Format { path: path.into(), reason })
}

/// Counts of one pair or of all, over pixels whose reference is valid.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PairTally {
    /// Pixels with a reference.
    pub pixels: u64,
    /// Of these, bad ones, missing ones included.
    pub bad: u64,
    /// By score, among pixels that have depth.
    pub rankings: Vec<(String, Ranking)>,
    /// Reliability at tau, among pixels that have depth.
    pub decision: Decision,
}

impl PairTally {
    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.bad += other.bad;
        self.decision.add(&other.decision);
        for (name, ranking) in &other.rankings {
            match self.rankings.iter_mut().find(|(known, _)| known == name) {
                Some((_, mine)) => mine.add(ranking),
                None => self.rankings.push((name.clone(), ranking.clone())),
            }
        }
    }

    /// Share of bad pixels, missing ones included.
    pub fn bad_share(&self) -> Option<f64> {
        share(self.bad, self.pixels)
    }
}

/// All pairs of a list, each over the whole image and within its mask.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PairReport {
    /// Name and counts.
    pub rows: Vec<(String, PairTally)>,
    /// Name and picture file, where pictures were asked for.
    pub pictures: Vec<(String, String)>,
}

/// Bad, good, or nothing to compare with; missing depth is bad.
fn verdicts(measured_m: &[f32], reference_m: &[f32], tolerance_m: f64) -> Vec<Option<bool>> {
    let verdict = |(&measured, &reference): (&f32, &f32)| {
        let valid = reference.is_finite() && reference > 0.0;
        let far = (f64::from(measured) - f64::from(reference)).abs() > tolerance_m;
        valid.then_some(measured <= 0.0 || far)
    };
    measured_m.iter().zip(reference_m).map(verdict).collect()
}

/// Scores all pairs in `folder`; reliability is that of the configuration's weights. Pictures go to
/// `pictures`.
///
/// # Errors
/// [`Error::File`] and [`Error::Format`] for images, with their paths; those of the pipeline.
pub fn evaluate_pairs(
    folder: &Path,
    list: &PairList,
    config: &Config,
    adapter: Option<&str>,
    pictures: Option<&Path>,
) -> Result<PairReport> {
    let mut report = PairReport::default();
    let [mut all, mut masked] = [PairTally::default(), PairTally::default()];
    for pair in &list.pairs {
        let loaded = pair.load(folder, list)?;
        let reliability = reliability(&loaded.frame, config, adapter)?;
        let bad = verdicts(&loaded.measured_m, &loaded.reference_m, list.tolerance_m);
        let everywhere = vec![true; bad.len()];
        for (name, mask, sum) in [("", &everywhere, &mut all), (" in mask", &loaded.mask, &mut masked)] {
            let tally = tally(&loaded, &bad, mask, reliability.as_deref(), config.tau);
            sum.add(&tally);
            report.rows.push((format!("{}{name}", pair.name), tally));
        }
        if let Some(folder) = pictures {
            let file = draw(pair, &loaded, &bad, reliability.as_deref(), folder)?;
            report.pictures.push((pair.name.clone(), file));
        }
    }
    report.rows.extend([("all".to_owned(), all), ("all in mask".to_owned(), masked)]);
    Ok(report)
}

fn reliability(frame: &RgbdFrame, config: &Config, adapter: Option<&str>) -> Result<Option<Vec<f32>>> {
    let options = Options { adapter: adapter.map(str::to_owned), images: true, ..Options::default() };
    let config = Config { method: Method::Drm, ..config.clone() };
    let Some(info) = CameraInfo::of_frames([frame]) else { return Ok(None) };
    let mut mapper = Mapper::open(&config, &[SensorInfo::camera(&config, info)], &options)?;
    let update = mapper.step(&Observation::of_frame(0, &config.map_frame, frame.clone()))?;
    let images = update.camera().and_then(|camera| camera.images.as_ref());
    Ok(images.map(|images| images.reliability.clone()))
}

fn tally(
    loaded: &Loaded,
    bad: &[Option<bool>],
    mask: &[bool],
    reliability: Option<&[f32]>,
    tau: f64,
) -> PairTally {
    let width = loaded.frame.depth.camera.width as usize;
    let mut scores: Vec<(String, Vec<f32>)> = Predictor::ALL
        .map(|predictor| (predictor.key().into(), predictor.scores(&loaded.measured_m, width)))
        .into();
    if let Some(reliability) = reliability {
        scores.insert(0, ("drm".into(), reliability.iter().copied().map(suspicion).collect()));
    }
    let mut tally = PairTally::default();
    let judged = || (0..bad.len()).filter(|&i| mask[i]).filter_map(|i| Some((i, bad[i]?)));
    for (pixel, bad) in judged() {
        tally.pixels += 1;
        tally.bad += u64::from(bad);
        if let Some(reliability) = reliability.filter(|_| loaded.measured_m[pixel] > 0.0) {
            tally.decision.put(f64::from(reliability[pixel]) <= tau, bad);
        }
    }
    for (name, scores) in scores {
        let mut ranking = Ranking::default();
        for (pixel, bad) in judged().filter(|(pixel, _)| loaded.measured_m[*pixel] > 0.0) {
            ranking.put(scores[pixel], bad);
        }
        tally.rankings.push((name, ranking));
    }
    tally
}

fn draw(
    pair: &Pair,
    loaded: &Loaded,
    bad: &[Option<bool>],
    reliability: Option<&[f32]>,
    folder: &Path,
) -> Result<String> {
    let width = loaded.frame.depth.camera.width;
    let color = loaded.frame.color.as_ref().map_or(&[][..], |color| &color.rgb);
    let first = [
        Panel::color("color", width, color),
        Panel::depth("depth", width, &loaded.measured_m),
        Panel::depth("reference", width, &loaded.reference_m),
    ];
    let mut second = vec![Panel::verdict("bad depth", width, bad)];
    if let Some(reliability) = reliability {
        second.push(Panel::reliability("reliability", width, reliability, &loaded.measured_m));
    }
    let file = format!("{}.png", file_name(&pair.name));
    let size = [424, 424 * loaded.frame.depth.camera.height / width.max(1)];
    sheet(&[(&first, size), (&second, size)], &folder.join(&file))?;
    Ok(file)
}

/// A name without anything that a path could mean.
pub fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '-' }).collect()
}

impl PairReport {
    /// As a table: AUPRC for "bad" among pixels with depth.
    pub fn table(&self) -> Table {
        let number = |value: Option<f64>| value.map_or_else(|| "-".into(), |value| format!("{value:.3}"));
        let names: Vec<&str> = match self.rows.first() {
            Some((_, tally)) => tally.rankings.iter().map(|(name, _)| name.as_str()).collect(),
            None => Vec::new(),
        };
        let head = ["pair", "bad or missing", "bad"].into_iter().chain(names).chain(["F1 at tau"]);
        let row = |(name, tally): &(String, PairTally)| {
            let base = tally.rankings.first().and_then(|(_, ranking)| ranking.base_rate());
            let mut cells = vec![name.clone(), number(tally.bad_share()), number(base)];
            cells.extend(tally.rankings.iter().map(|(_, ranking)| number(ranking.auprc())));
            cells.push(number(tally.decision.f1()));
            cells
        };
        Table {
            title: "Still pairs".into(),
            note: "bad: share among pixels with depth; then AUPRC of each score for bad pixels among these"
                .into(),
            head: head.map(str::to_owned).collect(),
            rows: self.rows.iter().map(row).collect(),
        }
    }

    /// `pairs.NAME.SCORE.auprc`.
    pub fn json(&self) -> Value {
        let scores = |tally: &PairTally| -> Map<String, Value> {
            let score = |(name, ranking): &(String, Ranking)| {
                (name.clone(), json!({ "auprc": ranking.auprc(), "f1_best": ranking.best_f1() }))
            };
            tally.rankings.iter().map(score).collect()
        };
        let row = |(name, tally): &(String, PairTally)| {
            let mut object = scores(tally);
            object.insert("pixels".into(), json!(tally.pixels));
            object.insert("bad_share".into(), json!(tally.bad_share()));
            object.insert("f1".into(), json!(tally.decision.f1()));
            (name.clone(), object.into())
        };
        let pairs: Map<String, Value> = self.rows.iter().map(row).collect();
        json!({ "pairs": pairs })
    }

    /// One page with the table and the pictures.
    pub fn html(&self) -> String {
        crate::offline::eval::report::page("Still pairs", &[], &[self.table()], &self.pictures)
    }
}
