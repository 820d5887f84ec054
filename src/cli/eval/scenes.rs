//! Generated scenes and recordings with ground truth.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::Instant;

use limpid::mapper::weight_files;
use limpid::offline::eval::contest::Contestant;
use limpid::offline::eval::pairs::file_name;
use limpid::offline::eval::report::Report;
use limpid::offline::eval::{
    Generated, Recorded, SceneResult, Source, contestants, evaluate, frontier, picture,
};
use limpid::sim::Scene;
use limpid::sim::generate::{Level, add_walkers, generate, vary_sensor};
use limpid::{Config, Error, Result};
use serde::{Deserialize, Serialize};

use super::{EvalArguments, make_folder, shown};
use crate::cli::run::progress_bar;

pub(super) fn generated(arguments: &EvalArguments) -> Result<()> {
    let wanted = &arguments.scenes;
    let judge = Judge::new(arguments)?;
    let count = wanted.count();
    let bar = progress_bar(Some(u64::from(count) * wanted.levels.len() as u64));
    let mut results = Vec::new();
    // Levels take turns, so that a run that is cut short has something of each.
    for seed in (wanted.first_seed..).take(count as usize) {
        for &level in &wanted.levels {
            let start = Instant::now();
            let scene = scene(arguments, level, seed)?;
            let result = judge.scene(&scene, level)?;
            bar.suspend(|| eprintln!("{} ({:.0} s)", line(&result), start.elapsed().as_secs_f64()));
            bar.inc(1);
            results.push(result);
        }
    }
    bar.finish_and_clear();
    let family = wanted.family.name();
    let title = format!(
        "{count} scenes a level of family {family} from seed {}, {} frames each",
        wanted.first_seed,
        wanted.frames()
    );
    judge.finish(&title, results)
}

pub(super) fn recorded(arguments: &EvalArguments, recordings: &[PathBuf]) -> Result<()> {
    let judge = Judge::new(arguments)?;
    let mut results = Vec::new();
    let bar = progress_bar(Some(recordings.len() as u64));
    for path in recordings {
        let result = judge.recording(path)?;
        bar.suspend(|| eprintln!("{}", line(&result)));
        bar.inc(1);
        results.push(result);
    }
    bar.finish_and_clear();
    judge.finish(&format!("{} recordings", recordings.len()), results)
}

fn scene(arguments: &EvalArguments, level: Level, seed: u64) -> Result<Scene> {
    let wanted = &arguments.scenes;
    let mut scene = generate(wanted.family, level, seed, wanted.frames())?;
    if let Some((width, height)) = wanted.size {
        (scene.camera.width, scene.camera.height) = (width, height);
    }
    if wanted.vary_sensor {
        vary_sensor(&mut scene);
    }
    add_walkers(&mut scene, wanted.walkers);
    scene.validate()?;
    Ok(scene)
}

/// A scene's outcome in a line.
fn line(result: &SceneResult) -> String {
    let of = |(key, name): (&str, &str)| {
        let tally = result.methods.get(key)?;
        let value = tally.figures().get(name).copied()?;
        Some(format!("  {key} {name} {value:.3}"))
    };
    let shown = [("naive", "hole_rate"), ("naive", "for"), ("range", "for"), ("drm", "for"), ("drm", "or")];
    format!("{} {}{}", result.level, result.name, shown.into_iter().filter_map(of).collect::<String>())
}

/// What all scenes have in common.
struct Judge<'a> {
    arguments: &'a EvalArguments,
    config: Config,
    contestants: Vec<Contestant>,
    /// Changes with whatever changes results, so that kept ones are used only where they still hold.
    settings: String,
    /// Captions and files of pictures of recordings without truth.
    shown: Vec<(String, String)>,
}

/// A kept result.
#[derive(Serialize, Deserialize)]
struct Kept {
    settings: String,
    result: SceneResult,
}

impl<'a> Judge<'a> {
    fn new(arguments: &'a EvalArguments) -> Result<Self> {
        let config = arguments.config()?;
        if let Some(folder) = &arguments.keep {
            make_folder(folder)?;
        }
        let mut hasher = DefaultHasher::new();
        weight_files(&config)?.hash(&mut hasher);
        let (shown, mut contestants) = (shown::draw_all(arguments)?, contestants(&config));
        if arguments.frontier {
            contestants.extend(frontier(&config));
        }
        let keys: Vec<_> = contestants.iter().map(|contestant| contestant.key).collect();
        let version = env!("CARGO_PKG_VERSION");
        let settings = format!("{version} {config:?} weights {:x} {keys:?}", hasher.finish());
        Ok(Self { arguments, config, contestants, settings, shown })
    }

    /// A generated scene, or what is kept of it.
    fn scene(&self, scene: &Scene, level: Level) -> Result<SceneResult> {
        self.kept_or(&scene.name, &scene.to_yaml()?, || {
            let adapter = self.arguments.adapter.as_deref();
            let mut source = Generated::open(scene, &self.config, adapter)?;
            self.source(&mut source, &format!("{level:?}"), &scene.name)
        })
    }

    /// A recording, or what is kept of it. Those of generated scenes come under their level, others under `recordings`.
    fn recording(&self, path: &Path) -> Result<SceneResult> {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let about = std::fs::metadata(path).map_err(Error::file(path))?;
        self.kept_or(&name, &format!("{path:?} {} {:?}", about.len(), about.modified().ok()), || {
            let mut source = Recorded::open(path, &self.config)?;
            let level = source.level().map_or("recordings".into(), |level| format!("{level:?}"));
            self.source(&mut source, &level, &name)
        })
    }

    /// What is kept of the input of that name and these contents, or else what `score` says, which is kept.
    fn kept_or(
        &self,
        name: &str,
        contents: &str,
        score: impl FnOnce() -> Result<SceneResult>,
    ) -> Result<SceneResult> {
        let keep = self.arguments.keep.as_ref();
        let path = keep.map(|folder| folder.join(format!("{}.json", file_name(name))));
        let settings = format!("{} {contents}", self.settings);
        if let Some(result) = path.as_deref().and_then(|path| kept(path, &settings)) {
            return Ok(result);
        }
        let result = score()?;
        if let Some(path) = path {
            let bad =
                |error: serde_json::Error| Error::Encode { path: path.clone(), reason: error.to_string() };
            let kept = Kept { settings, result: result.clone() };
            super::save(&path, &serde_json::to_string(&kept).map_err(bad)?)?;
        }
        Ok(result)
    }

    /// Scores a stream of frames; its last picture goes to the page's folder.
    fn source(&self, source: &mut dyn Source, level: &str, name: &str) -> Result<SceneResult> {
        let adapter = self.arguments.adapter.as_deref();
        let named = |error: Error| match error {
            Error::Empty { reason } => Error::Empty { reason: format!("{name}: {reason}") },
            other => other,
        };
        let (result, last) = evaluate(source, &self.contestants, &self.config, adapter).map_err(named)?;
        if let Some(path) = self.picture(name) {
            picture::save(&last, &path)?;
        }
        Ok(SceneResult { name: name.into(), level: level.into(), ..result })
    }

    fn picture(&self, name: &str) -> Option<PathBuf> {
        let folder = self.arguments.html.as_ref()?;
        Some(folder.join(format!("{}.png", file_name(name))))
    }

    /// Prints the tables and writes what was asked for.
    fn finish(&self, title: &str, results: Vec<SceneResult>) -> Result<()> {
        let mut report = Report::new(title, &results);
        for (result, (_, picture)) in results.iter().zip(&mut report.scenes) {
            let path = self.picture(&result.name).filter(|path| path.exists());
            *picture = path.and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
        }
        report.scenes.extend(self.shown.iter().cloned().map(|(caption, file)| (caption, Some(file))));
        print!("{}", report.text());
        self.arguments.write(&report.json(), &report.html())
    }
}

/// A kept result that was made with the same settings.
fn kept(path: &Path, settings: &str) -> Option<SceneResult> {
    let text = std::fs::read_to_string(path).ok()?;
    let kept: Kept = serde_json::from_str(&text).ok()?;
    (kept.settings == settings).then_some(kept.result)
}
