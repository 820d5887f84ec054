//! Recordings without ground truth on the page.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use limpid::input::open;
use limpid::offline::eval::pairs::file_name;
use limpid::offline::eval::{picture, shown};
use limpid::{Config, Error, Result};

use super::EvalArguments;

/// A recording, and its parameters where they are not those of all.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ToShow {
    recording: PathBuf,
    config: Option<PathBuf>,
}

impl FromStr for ToShow {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        let (recording, config) = match text.split_once(',') {
            Some((recording, config)) => (recording, Some(config.into())),
            None => (text, None),
        };
        Ok(Self { recording: recording.into(), config })
    }
}

impl ToShow {
    /// What is read of it.
    pub(super) fn paths(&self) -> impl Iterator<Item = &Path> {
        [Some(&self.recording), self.config.as_ref()].into_iter().flatten().map(PathBuf::as_path)
    }

    /// The last two parts of its path: folders of a data set are numbers often.
    fn name(&self) -> String {
        let parts: Vec<_> = self.recording.iter().map(|part| part.to_string_lossy()).collect();
        parts[parts.len().saturating_sub(2)..].join("/")
    }
}

/// Draws what was asked for into the page's folder; captions and names of files.
pub(super) fn draw_all(arguments: &EvalArguments) -> Result<Vec<(String, String)>> {
    let Some(folder) = &arguments.html else { return Ok(Vec::new()) };
    arguments.show.iter().map(|to_show| draw(arguments, to_show, folder)).collect()
}

fn draw(arguments: &EvalArguments, to_show: &ToShow, folder: &Path) -> Result<(String, String)> {
    let config = match &to_show.config {
        Some(path) => {
            let own = Config::read(path)?;
            let weights = arguments.weights.clone().unwrap_or_else(|| own.weights.clone());
            Config { weights, ..own }
        }
        None => arguments.base_config()?,
    };
    let path = &to_show.recording;
    let in_file = |error: Error| match error {
        Error::Empty { reason } => Error::Empty { reason: format!("{}: {reason}", path.display()) },
        other => other,
    };
    let shown =
        shown::show(&mut *open(path, &config)?, &config, arguments.adapter.as_deref()).map_err(in_file)?;
    let file = format!("shown-{}.png", file_name(&to_show.name()));
    picture::save_shown(&shown, &folder.join(&file))?;
    let caption = format!("{} (no ground truth; after {} frames)", to_show.name(), shown.frames);
    Ok((caption, file))
}
