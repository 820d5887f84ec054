//! Parameters from files and texts.

use std::path::Path;

use super::{Config, parse};
use crate::base::{Error, Result};

/// What a node is called unless it is said otherwise.
const NODE: &str = "limpid";

impl Config {
    /// Reads a YAML file; see [`Config::from_yaml`].
    ///
    /// # Errors
    /// As [`Config::from_yaml`], with the file's name; and [`Error::File`].
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_for(path, NODE)
    }

    /// As [`Config::read`], for a node of that full name: its section, and `/**`, of a ROS 2 parameter file count.
    ///
    /// # Errors
    /// As [`Config::read`].
    pub fn read_for(path: &Path, node: &str) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
        let file = path.display();
        Self::of_yaml(&text, node).map_err(|error| match error {
            Error::Config { key, reason } => Error::Config { key, reason: format!("{reason}, in {file}") },
            Error::Yaml(text) => Error::Yaml(format!("{file}: {text}")),
            other => other,
        })
    }

    /// From YAML text: the keys at the top level, or under `limpid: ros__parameters:` as ROS 2
    /// parameter files have them, laid over those under `/**`. Missing keys keep their defaults.
    ///
    /// The flat form states the keys of this struct. The nested form states the map's keys under `map`, a list of names
    /// under `sensors`, and one section for each name with its `kind` and the keys that belong to it; flat keys beside
    /// them hold for every sensor.
    ///
    /// # Errors
    /// [`Error::Yaml`] with line, column and snippet where the text is not YAML. [`Error::Config`] with the line for
    /// unknown keys (with the nearest known one), wrong types, a thing stated twice, and a list of sensors and
    /// sections that do not fit; and from [`Config::validate`].
    pub fn from_yaml(text: &str) -> Result<Self> {
        Self::of_yaml(text, NODE)
    }

    fn of_yaml(text: &str, node: &str) -> Result<Self> {
        let config = parse::parse(text, node)?;
        config.validate()?;
        Ok(config)
    }
}
