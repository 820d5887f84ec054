//! Parameters from YAML: the flat form, and the nested one with `map`, `sensors` and a section for each sensor (spec 4 §1).

use serde_json::{Map, Value};

use super::document::{self, Entry, Node};
use super::keys::Place;
use super::sensors::{MAX_SENSORS, check_name};
use super::{Config, SensorConfig, SensorKind, bad_key};
use crate::base::{Error, Result, nearest, plain};

/// The parameters that a file has for the node of that name; not yet validated.
pub(super) fn parse(text: &str, node: &str) -> Result<Config> {
    let parts = Parts::of(parameters(document::read(text)?, node)?);
    let names = parts.sensors.as_ref().map(listed_names).transpose()?;
    let names = names.unwrap_or_default();
    parts.check_sections(&names)?;
    let mut base = Stated::default();
    for entry in &parts.flat {
        base.state(Place::Top, "", entry)?;
    }
    let nested = parts.map.is_some() || parts.sensors.is_some();
    if nested {
        base.refuse_lidar_map()?;
    }
    if let Some(map) = &parts.map {
        base.state_map(map)?;
    }
    let sensor = |name: &String| sensor(name, &parts, &base, nested);
    let sensors = names.iter().map(sensor).collect::<Result<_>>()?;
    let mut config = Config { sensors, ..base.config(nested)? };
    config.change_all(bare_frames);
    Ok(config)
}

/// Frames without leading slashes, which ROS 1 writes and which mean nothing.
fn bare_frames(config: &mut Config) {
    let stated =
        config.static_transforms.iter_mut().flat_map(|stated| [&mut stated.parent, &mut stated.child]);
    let own =
        [&mut config.map_frame, &mut config.base_frame, &mut config.camera_frame, &mut config.lidar_frame];
    for frame in own.into_iter().chain(stated) {
        frame.drain(..frame.len() - frame.trim_start_matches('/').len());
    }
}

/// Whether a section of a ROS 2 parameter file concerns the node of that full name: by its name, or as one of all (`/**`).
fn concerns(section: &str, node: &str) -> bool {
    let base = node.rsplit('/').next().unwrap_or(node);
    let own = section.trim_start_matches('/');
    own == "**" || own == node.trim_start_matches('/') || own == base || own.strip_prefix("**/") == Some(base)
}

/// The entries under `NODE: ros__parameters:` and `/**: ros__parameters:`, what comes later over what came before; under the
/// only node's, whatever it is called; or those at the root.
fn parameters(mut root: Vec<Entry>, node: &str) -> Result<Vec<Entry>> {
    let is_node = |entry: &Entry| match &entry.node {
        Node::Section(inside) => inside.iter().any(|entry| entry.key == "ros__parameters"),
        _ => false,
    };
    let is_own = |entry: &Entry| concerns(&entry.key, node);
    if !root.iter().any(|entry| is_node(entry) || is_own(entry)) {
        return Ok(root);
    }
    if let Some(other) = root.iter().find(|entry| !is_node(entry) && !is_own(entry)) {
        let beside = root.iter().find(|entry| is_node(entry) || is_own(entry)).map_or("", |entry| &entry.key);
        return Err(other.fault(&other.key, format!("stands beside `{beside}`, outside the parameters")));
    }
    if root.iter().any(is_own) {
        root.retain(is_own);
    } else if root.len() > 1 {
        let names: Vec<_> = root.iter().map(|entry| format!("`{}`", entry.key)).collect();
        let base = node.rsplit('/').next().unwrap_or(node);
        let reason = format!("has no parameters in this file, but {} have", names.join(", "));
        return Err(bad_key(base, reason));
    }
    let mut merged = Vec::new();
    for entry in root {
        merge(&mut merged, of_node(entry)?);
    }
    Ok(merged)
}

/// The parameters of a node's section.
fn of_node(entry: Entry) -> Result<Vec<Entry>> {
    let name = entry.key.clone();
    let inside = section(entry, &name)?;
    match inside.iter().position(|entry| entry.key == "ros__parameters") {
        Some(place) => only_section(inside, place, &format!("{name}.ros__parameters")),
        None => {
            let other = inside.first().map(|entry| format!(", but `{}`", entry.key)).unwrap_or_default();
            Err(bad_key(&name, format!("has no `ros__parameters` under it{other}")))
        }
    }
}

/// Lays entries over others: a value replaces one of its key, a section is laid over one of its name.
fn merge(under: &mut Vec<Entry>, over: Vec<Entry>) {
    for entry in over {
        match (under.iter_mut().find(|known| known.key == entry.key), entry.node) {
            (Some(Entry { node: Node::Section(known), .. }), Node::Section(inside)) => merge(known, inside),
            (Some(known), node) => *known = Entry { node, ..entry },
            (None, node) => under.push(Entry { node, ..entry }),
        }
    }
}

/// The entries of the section at `place`, which has nothing beside it.
fn only_section(mut entries: Vec<Entry>, place: usize, name: &str) -> Result<Vec<Entry>> {
    let entry = entries.swap_remove(place);
    if let Some(other) = entries.first() {
        return Err(other.fault(&other.key, format!("stands beside `{name}`, outside the parameters")));
    }
    section(entry, name)
}

fn section(entry: Entry, name: &str) -> Result<Vec<Entry>> {
    match entry.node {
        Node::Section(inside) => Ok(inside),
        Node::Value(Value::Null) => Ok(Vec::new()),
        _ => Err(entry.fault(name, "is not a section")),
    }
}

/// A file's entries by what they are.
#[derive(Default)]
struct Parts {
    map: Option<Entry>,
    sensors: Option<Entry>,
    sections: Vec<Entry>,
    flat: Vec<Entry>,
}

impl Parts {
    fn of(entries: Vec<Entry>) -> Self {
        let mut parts = Self::default();
        for entry in entries {
            match (entry.key.as_str(), &entry.node) {
                ("map", _) => parts.map = Some(entry),
                ("sensors", _) => parts.sensors = Some(entry),
                (_, Node::Section(_)) => parts.sections.push(entry),
                _ => parts.flat.push(entry),
            }
        }
        parts
    }

    fn without_section(&self, name: &str) -> Error {
        let reason = "is named by `sensors` and has no section";
        match &self.sensors {
            Some(list) => list.fault(name, reason),
            None => bad_key(name, reason.into()),
        }
    }

    /// Every section has a sensor, and every sensor a section.
    fn check_sections(&self, names: &[String]) -> Result<()> {
        for section in &self.sections {
            let key = &section.key;
            if super::scope_of(key).is_some() {
                return Err(section.fault(key, "takes a value, not a section"));
            }
            if !names.contains(key) {
                let reason = match names {
                    [] => format!("is a section of no sensor: a list `sensors: [{key}]` would name it"),
                    names => format!(
                        "is a section that `sensors` does not name; the nearest name there is `{}`",
                        { nearest(key, names.iter().map(String::as_str)) }
                    ),
                };
                return Err(section.fault(key, reason));
            }
        }
        for name in names {
            if let Some(entry) = self.flat.iter().find(|entry| entry.key == *name) {
                return Err(
                    entry.fault(name, "is a sensor's section, and needs `kind: camera` or `kind: lidar`")
                );
            }
            if !self.sections.iter().any(|section| section.key == *name) {
                return Err(self.without_section(name));
            }
        }
        Ok(())
    }
}

fn listed_names(entry: &Entry) -> Result<Vec<String>> {
    let bad = |reason: String| Err(entry.fault("sensors", reason));
    let Node::Value(Value::Array(values)) = &entry.node else {
        return bad("is not a list of names: [front, rear]".into());
    };
    if values.is_empty() || values.len() > MAX_SENSORS {
        return bad(format!("names {}; 1 to {MAX_SENSORS} are supported", values.len()));
    }
    let mut names = Vec::with_capacity(values.len());
    for value in values {
        let Some(name) = value.as_str() else { return bad(format!("{value} is not a name")) };
        check_name(name)?;
        if names.iter().any(|before| before == name) {
            return bad(format!("names `{name}` twice"));
        }
        names.push(name.to_owned());
    }
    Ok(names)
}

/// A sensor from its section, laid over what holds for all.
fn sensor(name: &str, parts: &Parts, base: &Stated, nested: bool) -> Result<SensorConfig> {
    let Some(entry) = parts.sections.iter().find(|section| section.key == name) else {
        return Err(parts.without_section(name));
    };
    let Node::Section(entries) = &entry.node else { return Err(entry.fault(name, "is not a section")) };
    let kind = kind_of(name, entry, entries)?;
    let mut own = Stated::default();
    for entry in entries.iter().filter(|entry| entry.key != "kind") {
        let flat = own.state(Place::Sensor(kind), &format!("{name}."), entry)?;
        // The flat one is the default of every sensor, so that a sensor's own is no second statement.
        if flat != "timeout_s" {
            base.refuse_second(flat, &format!("{name}.{}", entry.key), entry)?;
        }
    }
    let parameters = base.with(own).config(nested)?;
    Ok(SensorConfig { name: name.to_owned(), kind, timeout_s: parameters.timeout_s, parameters })
}

fn kind_of(name: &str, section: &Entry, entries: &[Entry]) -> Result<SensorKind> {
    let Some(entry) = entries.iter().find(|entry| entry.key == "kind") else {
        return Err(section.fault(name, "has no `kind`: `kind: camera` or `kind: lidar`"));
    };
    let stated = match &entry.node {
        Node::Value(value) => value.as_str().map_or_else(|| value.to_string(), str::to_owned),
        _ => "a section".into(),
    };
    SensorKind::ALL.into_iter().find(|kind| kind.name() == stated).ok_or_else(|| {
        entry.fault(&format!("{name}.kind"), format!("{stated} is unknown: there are camera and lidar"))
    })
}

/// The flat keys that a file states, with their values and the names under which it states them.
#[derive(Debug, Default, Clone)]
struct Stated {
    values: Map<String, Value>,
    names: Vec<(&'static str, String)>,
}

impl Stated {
    /// Takes a key with its value; `section` is the prefix of its name. Returns the flat key.
    fn state(&mut self, place: Place, section: &str, entry: &Entry) -> Result<&'static str> {
        let name = format!("{section}{}", entry.key);
        let flat = place.flat_key(&entry.key).map_err(|reason| entry.fault(&name, reason))?;
        self.refuse_second(flat, &name, entry)?;
        let value = match &entry.node {
            Node::Value(value) => value.clone(),
            Node::NotFinite(value) => {
                return Err(entry.fault(&name, format!("{value} is not a finite number")));
            }
            Node::Section(_) => return Err(entry.fault(&name, "takes a value, not a section")),
        };
        let alone = Map::from_iter([(flat.to_owned(), value.clone())]);
        serde_json::from_value::<Config>(Value::Object(alone))
            .map_err(|error| entry.fault(&name, plain(&error)))?;
        self.values.insert(flat.to_owned(), value);
        self.names.push((flat, name));
        Ok(flat)
    }

    fn state_map(&mut self, map: &Entry) -> Result<()> {
        match &map.node {
            Node::Section(entries) => {
                entries.iter().try_for_each(|entry| self.state(Place::Map, "map.", entry).map(|_| ()))
            }
            Node::Value(Value::Null) => Ok(()),
            _ => Err(map.fault("map", "is not a section")),
        }
    }

    /// One thing is stated once.
    fn refuse_second(&self, flat: &str, name: &str, entry: &Entry) -> Result<()> {
        match self.names.iter().find(|(stated, _)| *stated == flat) {
            Some((_, first)) => {
                Err(entry.fault(name, format!("and `{first}` state one thing: take one of them out")))
            }
            None => Ok(()),
        }
    }

    fn refuse_lidar_map(&self) -> Result<()> {
        for (flat, nested) in [("scan_map_size_m", "map.size_m"), ("scan_resolution_m", "map.resolution_m")] {
            if self.values.contains_key(flat) {
                let reason =
                    format!("is stated beside `map` or `sensors`, where `{nested}` holds for lidars too");
                return Err(bad_key(flat, reason));
            }
        }
        Ok(())
    }

    fn with(&self, own: Self) -> Self {
        let mut all = self.clone();
        all.values.extend(own.values);
        all.names.extend(own.names);
        all
    }

    /// The parameters. Nested, the map's size and resolution hold for lidars too.
    fn config(&self, nested: bool) -> Result<Config> {
        let config: Config = serde_json::from_value(Value::Object(self.values.clone()))
            .map_err(|error| Error::Yaml(error.to_string()))?;
        Ok(if nested {
            Config { scan_map_size_m: config.map_size_m, scan_resolution_m: config.resolution_m, ..config }
        } else {
            config
        })
    }
}
