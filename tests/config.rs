//! Parameters from YAML.

use limpid::Config;
use limpid::config::{EXAMPLE, Method};

#[test]
fn the_example_states_every_key_with_its_default() {
    assert_eq!(Config::from_yaml(EXAMPLE).unwrap(), Config::default());
    let keys = serde_json::to_value(Config::default()).unwrap();
    for key in keys.as_object().unwrap().keys() {
        let stated = EXAMPLE.lines().any(|line| line.starts_with(&format!("    {key}: ")));
        assert!(stated, "`{key}` is missing in testdata/config/limpid.yaml");
    }
}

#[test]
fn keys_at_the_top_level_and_in_ros_shape_mean_the_same() {
    let flat = Config::from_yaml("method: naive\ntau: 0.4\n").unwrap();
    let wrapped =
        Config::from_yaml("limpid:\n  ros__parameters:\n    method: naive\n    tau: 0.4\n").unwrap();
    assert_eq!(flat, wrapped);
    assert_eq!((flat.method, flat.tau), (Method::Naive, 0.4));
    assert_eq!(Config::from_yaml("# nothing\n\n").unwrap(), Config::default());
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest_and_its_place() {
    let error = Config::from_yaml("tau: 0.3\nresolution: 0.05\n").unwrap_err().to_string();
    assert!(error.contains("nearest key is `resolution_m`"), "{error}");
    assert!(error.contains("line 2"), "{error}");
}

#[test]
fn a_key_given_twice_or_of_the_wrong_type_is_refused() {
    for text in ["tau: 0.3\ntau: 0.4\n", "tau: high\n", "method: best\n", "tau: [0.3\n"] {
        assert!(Config::from_yaml(text).is_err(), "{text}");
    }
}

#[test]
fn impossible_values_name_their_key() {
    for (text, key) in [
        ("resolution_m: 0.0", "resolution_m"),
        ("resolution_m: .nan", "resolution_m"),
        ("map_size_m: 1.0e9", "map_size_m"),
        ("tau: 1.5", "tau"),
        ("lambda: -0.1", "lambda"),
        ("free_threshold: 0.9", "free_threshold"),
        ("height_min_m: 3.0", "height_min_m"),
        ("depth_min_m: 20.0", "depth_min_m"),
        ("inscribed_radius_m: 2.0", "inscribed_radius_m"),
        ("inflation_radius_m: 100.0", "inflation_radius_m"),
        ("confirmations: 0", "confirmations"),
        ("temporal_hits: 6", "temporal_hits"),
        ("ground_z_m: .inf", "ground_z_m"),
    ] {
        let error = Config::from_yaml(text).unwrap_err().to_string();
        assert!(error.contains(&format!("`{key}`")), "{text}: {error}");
    }
}
