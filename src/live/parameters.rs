//! The node's parameters as ROS 2 asks for them and sets them.

use serde_json::Value;

use crate::base::{Error, Result};
use crate::config::{Config, EXAMPLE};
use crate::message::service::{
    ListParametersReply, ListParametersRequest, Parameter, ParameterDescriptor, ParameterKind,
    ParameterValue, SetResult,
};

/// Parameters that may change while the node runs; for the others it has to be started again.
const CHANGEABLE: [&str; 5] =
    ["publish_rate_hz", "publish_deadline_s", "degraded_speed_percent", "wait_s", "full_map_m"];

/// What stands between the parts of a name.
const SEPARATOR: char = '.';

/// A parameter's value as ROS 2 has it. What ROS 2 has no kind for is told as JSON.
fn value_of(json: &Value) -> ParameterValue {
    let of = |kind: ParameterKind| ParameterValue { kind: kind as u8, ..ParameterValue::default() };
    match json {
        Value::Null => of(ParameterKind::NotSet),
        Value::Bool(value) => ParameterValue { bool_value: *value, ..of(ParameterKind::Bool) },
        Value::Number(number) => match (number.is_f64(), number.as_i64()) {
            (false, Some(value)) => ParameterValue { integer_value: value, ..of(ParameterKind::Integer) },
            _ => ParameterValue {
                double_value: number.as_f64().unwrap_or_default(),
                ..of(ParameterKind::Double)
            },
        },
        Value::String(text) => ParameterValue { string_value: text.clone(), ..of(ParameterKind::Text) },
        Value::Array(values) if values.iter().all(Value::is_number) => {
            let double_array_value = values.iter().filter_map(Value::as_f64).collect();
            ParameterValue { double_array_value, ..of(ParameterKind::Doubles) }
        }
        Value::Array(_) | Value::Object(_) => {
            ParameterValue { string_value: json.to_string(), ..of(ParameterKind::Text) }
        }
    }
}

/// A value that a peer states, as JSON.
fn json_of(value: &ParameterValue) -> Result<Value, String> {
    const KINDS: [ParameterKind; 9] = [
        ParameterKind::NotSet,
        ParameterKind::Bool,
        ParameterKind::Integer,
        ParameterKind::Double,
        ParameterKind::Text,
        ParameterKind::Bools,
        ParameterKind::Integers,
        ParameterKind::Doubles,
        ParameterKind::Texts,
    ];
    let finite = |value: f64| {
        let number = serde_json::Number::from_f64(value).map(Value::Number);
        number.ok_or_else(|| format!("{value} is not a finite number"))
    };
    match KINDS.into_iter().find(|kind| *kind as u8 == value.kind) {
        Some(ParameterKind::Bool) => Ok(value.bool_value.into()),
        Some(ParameterKind::Integer) => Ok(value.integer_value.into()),
        Some(ParameterKind::Double) => finite(value.double_value),
        Some(ParameterKind::Text) => Ok(value.string_value.clone().into()),
        Some(ParameterKind::Bools) => Ok(value.bool_array_value.clone().into()),
        Some(ParameterKind::Integers) => Ok(value.integer_array_value.clone().into()),
        Some(ParameterKind::Doubles) => {
            let values: Result<Vec<_>, _> = value.double_array_value.iter().copied().map(finite).collect();
            values.map(Value::Array)
        }
        Some(ParameterKind::Texts) => Ok(value.string_array_value.clone().into()),
        Some(ParameterKind::NotSet) => Err("a parameter cannot be deleted".into()),
        None => Err(format!("values of kind {} are not taken", value.kind)),
    }
}

/// What `limpid config` says of a parameter.
fn description(name: &str) -> String {
    let key = name.rsplit(SEPARATOR).next().unwrap_or(name);
    let lines = EXAMPLE.lines().map(str::trim_start);
    let line = lines.filter_map(|line| line.strip_prefix(key)?.strip_prefix(':')).next();
    line.and_then(|line| line.split_once("# ")).map(|(_, said)| said.trim().to_owned()).unwrap_or_default()
}

/// The values of parameters in the order of their names; one that there is not has none.
pub(super) fn get(config: &Config, names: &[String]) -> Vec<ParameterValue> {
    let listed = config.listed();
    let value = |name: &String| {
        let known = listed.iter().find(|(known, _)| known == name);
        known.map(|(_, value)| value_of(value)).unwrap_or_default()
    };
    names.iter().map(value).collect()
}

/// What there is to say of parameters in the order of their names.
pub(super) fn describe(config: &Config, names: &[String]) -> Vec<ParameterDescriptor> {
    let described = |(name, value): (&String, ParameterValue)| ParameterDescriptor {
        name: name.clone(),
        kind: value.kind,
        description: description(name),
        read_only: !CHANGEABLE.contains(&name.as_str()),
        ..ParameterDescriptor::default()
    };
    names.iter().zip(get(config, names)).map(described).collect()
}

/// The names of the parameters within sections, no deeper than is asked for.
pub(super) fn list(config: &Config, asked: &ListParametersRequest) -> ListParametersReply {
    let within = |name: &str| {
        let after = |prefix: &String| match name.strip_prefix(prefix.as_str()) {
            Some("") => Some(""),
            Some(rest) => rest.strip_prefix(SEPARATOR),
            None => None,
        };
        let shallow = |rest: &str| {
            asked.depth == 0 || u64::try_from(rest.split(SEPARATOR).count()).is_ok_and(|n| n <= asked.depth)
        };
        match asked.prefixes[..] {
            [] => shallow(name),
            _ => asked.prefixes.iter().filter_map(after).any(shallow),
        }
    };
    let names: Vec<String> =
        config.listed().into_iter().map(|(name, _)| name).filter(|name| within(name)).collect();
    let sections = names.iter().filter_map(|name| name.rsplit_once(SEPARATOR));
    let mut prefixes: Vec<String> = sections.map(|(section, _)| section.to_owned()).collect();
    prefixes.dedup();
    ListParametersReply { names, prefixes }
}

/// Sets a parameter, or says why not: then nothing has changed.
pub(super) fn set(config: &mut Config, parameter: &Parameter) -> SetResult {
    match with(config, parameter) {
        Ok(changed) => {
            *config = changed;
            SetResult { successful: true, reason: String::new() }
        }
        Err(reason) => SetResult { successful: false, reason },
    }
}

fn with(config: &Config, Parameter { name, value }: &Parameter) -> Result<Config, String> {
    let json = json_of(value)?;
    let mut changed = config.clone();
    let said = |error: Error| error.to_string();
    changed.set(name, &json.to_string()).map_err(said)?;
    if !CHANGEABLE.contains(&name.as_str()) && changed != *config {
        let changeable = CHANGEABLE.join(", ");
        return Err(format!(
            "`{name}` cannot change while the node runs: start it with `-p {name}:={json}`; these can: {changeable}"
        ));
    }
    changed.validate().map_err(said)?;
    Ok(changed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(name: &str, value: ParameterValue) -> Parameter {
        Parameter { name: name.into(), value }
    }

    fn double(double_value: f64) -> ParameterValue {
        ParameterValue { kind: ParameterKind::Double as u8, double_value, ..ParameterValue::default() }
    }

    #[test]
    fn every_parameter_has_a_kind_and_a_description() {
        let config = Config::default();
        let names = list(&config, &ListParametersRequest::default()).names;
        for of in describe(&config, &names) {
            assert!(!of.description.is_empty(), "{}", of.name);
            // These have no value unless one is stated.
            assert_eq!(of.kind == 0, ["velodyne_model", "gamma"].contains(&of.name.as_str()), "{}", of.name);
        }
        let asked = describe(&config, &["tau".into(), "wait_s".into()]);
        let read_only: Vec<bool> = asked.iter().map(|of| of.read_only).collect();
        assert_eq!(read_only, [true, false]);
    }

    #[test]
    fn names_are_listed_by_section_and_depth() {
        let yaml =
            "sensors: [front, top]\nfront: {kind: camera, depth_topic: /d}\ntop: {kind: lidar, topic: /p}";
        let config = Config::from_yaml(yaml).unwrap();
        let listed = |prefixes: &[&str], depth| {
            let prefixes = prefixes.iter().map(|&prefix| prefix.to_owned()).collect();
            list(&config, &ListParametersRequest { prefixes, depth })
        };
        let all = listed(&[], 0);
        assert!(all.names.contains(&"front.tau".into()) && all.names.contains(&"map_frame".into()));
        assert_eq!(all.prefixes, ["front", "top"]);
        assert!(listed(&[], 1).names.iter().all(|name| !name.contains('.')));
        assert!(listed(&["top"], 0).names.iter().all(|name| name.starts_with("top.")));
        assert!(listed(&["to"], 0).names.is_empty());
    }

    #[test]
    fn only_what_may_change_is_set_and_only_to_what_is_valid() {
        let mut config = Config::default();
        let set =
            |config: &mut Config, name: &str, value: ParameterValue| set(config, &parameter(name, value));
        assert!(set(&mut config, "publish_rate_hz", double(5.0)).successful);
        assert!(
            set(&mut config, "wait_s", value_of(&Value::from(1))).successful,
            "a whole number is one too"
        );
        assert_eq!((config.publish_rate_hz, config.wait_s), (5.0, 1.0));
        let before = config.clone();
        for (name, value, said) in [
            ("tau", double(0.25), "`tau` cannot change"),
            ("taux", double(0.25), "`tau`"),
            ("publish_rate_hz", double(0.0), "positive"),
            ("publish_rate_hz", double(f64::NAN), "finite"),
            ("publish_rate_hz", value_of(&Value::from("fast")), "publish_rate_hz"),
            ("publish_rate_hz", ParameterValue::default(), "deleted"),
            ("publish_rate_hz", ParameterValue { kind: 77, ..ParameterValue::default() }, "kind 77"),
        ] {
            let result = set(&mut config, name, value);
            assert!(!result.successful && result.reason.contains(said), "{name}: {result:?}");
        }
        assert_eq!(config, before);
        // To what it is already.
        assert!(set(&mut config, "tau", double(before.tau)).successful);
    }

    #[test]
    fn a_list_and_a_text_are_told_as_they_are() {
        let config = Config::default();
        let values =
            get(&config, &["goal_m".into(), "map_frame".into(), "camera_matrix".into(), "no".into()]);
        let kinds: Vec<u8> = values.iter().map(|value| value.kind).collect();
        assert_eq!(kinds, [8, 4, 8, 0]);
        assert_eq!((values[1].string_value.as_str(), values[2].double_array_value.len()), ("map", 9));
    }
}
