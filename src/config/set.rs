//! Single parameters, as ROS 2 states them on a command line.

use serde_json::Value;

use super::keys::Place;
use super::{Config, bad_key};
use crate::base::{Result, nearest};

impl Config {
    /// Sets one parameter: `KEY` or `map.KEY` for all, `SENSOR.KEY` for a sensor that the configuration names. The value is
    /// YAML. [`Config::validate`] says afterwards whether everything fits.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for a key that is unknown or belongs elsewhere, and for a value of another type.
    pub fn set(&mut self, key: &str, yaml: &str) -> Result<()> {
        let bad = |reason: String| bad_key(key, reason);
        let value: Value = serde_saphyr::from_str(yaml).map_err(|error| bad(error.to_string()))?;
        let Some((section, short)) = key.split_once('.') else {
            return self.set_all(Place::Top.flat_key(key).map_err(bad)?, key, &value);
        };
        if section == "map" {
            return self.set_all(Place::Map.flat_key(short).map_err(bad)?, key, &value);
        }
        let names: Vec<String> = self.sensors.iter().map(|sensor| sensor.name.clone()).collect();
        let Some(sensor) = self.sensors.iter_mut().find(|sensor| sensor.name == section) else {
            let near = nearest(section, names.iter().map(String::as_str).chain(["map"]));
            return Err(bad(format!("names no sensor; the nearest name is `{near}`")));
        };
        let flat = Place::Sensor(sensor.kind).flat_key(short).map_err(bad)?;
        sensor.parameters = sensor.parameters.with(flat, key, &value)?;
        if flat == "timeout_s" {
            sensor.timeout_s = sensor.parameters.timeout_s;
        }
        Ok(())
    }

    /// All parameters as ROS 2 lists them: names that [`Config::set`] takes, and values. Where the configuration names sensors,
    /// what belongs to one has its name in front.
    pub fn listed(&self) -> Vec<(String, Value)> {
        let values = |config: &Self| serde_json::to_value(config).unwrap_or_default();
        let own = values(self);
        let top = if self.sensors.is_empty() { Place::Top } else { Place::Map };
        let mut listed: Vec<_> = top.flat_keys().map(|key| (key.to_owned(), own[key].clone())).collect();
        for sensor in &self.sensors {
            let values = values(&sensor.parameters);
            let named = Place::Sensor(sensor.kind).flat_keys();
            listed.extend(named.map(|key| (format!("{}.{key}", sensor.name), values[key].clone())));
        }
        listed.sort_by(|a, b| a.0.cmp(&b.0));
        listed
    }

    fn set_all(&mut self, flat: &str, key: &str, value: &Value) -> Result<()> {
        let mut sensors = std::mem::take(&mut self.sensors);
        for sensor in &mut sensors {
            sensor.parameters = sensor.parameters.with(flat, key, value)?;
            if flat == "timeout_s" {
                sensor.timeout_s = sensor.parameters.timeout_s;
            }
        }
        *self = Self { sensors, ..self.with(flat, key, value)? };
        Ok(())
    }

    /// These parameters, without sensors, with a value for one of them; `key` names it in errors.
    fn with(&self, flat: &str, key: &str, value: &Value) -> Result<Self> {
        let bad = |error: serde_json::Error| bad_key(key, error.to_string());
        let mut all = serde_json::to_value(self).map_err(bad)?;
        if let Some(place) = all.get_mut(flat) {
            *place = value.clone();
        }
        serde_json::from_value(all).map_err(bad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Error;

    fn robot() -> Config {
        let yaml =
            "sensors: [front, top]\nfront: {kind: camera, depth_topic: /d}\ntop: {kind: lidar, topic: /p}";
        Config::from_yaml(yaml).unwrap()
    }

    #[test]
    fn a_parameter_is_set_where_it_belongs() {
        let mut config = robot();
        let stated = [("tau", "0.4"), ("map.size_m", "8"), ("front.timeout_s", "2"), ("top.glass", "true")];
        for (key, value) in stated.into_iter().chain([("map_frame", "odom"), ("goal_m", "[1, 2]")]) {
            config.set(key, value).unwrap();
        }
        config.validate().unwrap();
        assert_eq!((config.tau, config.map_size_m, config.map_frame.as_str()), (0.4, 8.0, "odom"));
        assert_eq!(config.goal_m, [1.0, 2.0]);
        let [front, top] = &config.sensors[..] else { panic!("{config:?}") };
        assert_eq!((front.timeout_s, top.timeout_s), (2.0, Config::default().timeout_s));
        assert_eq!((front.parameters.tau, front.parameters.map_size_m), (0.4, 8.0));
        assert!(top.parameters.glass && !front.parameters.glass && !config.glass);
        config.set("timeout_s", "1.5").unwrap();
        assert!(config.sensors.iter().all(|sensor| sensor.timeout_s == 1.5));
    }

    #[test]
    fn all_that_is_listed_can_be_set_to_what_it_is() {
        for config in [robot(), Config::default()] {
            let mut again = config.clone();
            let listed = config.listed();
            assert!(listed.len() > 100, "{}", listed.len());
            for (key, value) in &listed {
                again.set(key, &value.to_string()).unwrap();
            }
            assert_eq!(again, config);
        }
    }

    #[test]
    fn what_is_unknown_or_of_another_type_is_named() {
        for (key, value, said) in [
            ("taux", "0.4", "`tau`"),
            ("frnt.tau", "0.4", "`front`"),
            ("front.glass", "true", "lidar's key"),
            ("map.tau", "0.4", "camera's key"),
            ("tau", "high", "invalid type"),
            ("method", "best", "unknown variant"),
            ("tau", "[0.4", "tau"),
        ] {
            let error = robot().set(key, value).unwrap_err();
            assert!(matches!(&error, Error::Config { key: named, .. } if named == key), "{error}");
            assert!(error.to_string().contains(said), "{error}");
        }
    }
}
