//! Parameters from YAML.

use limpid::Config;
use limpid::config::{EXAMPLE, InflationLaw, Method, scope_of};

mod nested;

#[test]
fn the_example_states_every_key_with_its_default() {
    assert_eq!(Config::from_yaml(EXAMPLE).unwrap(), Config::default());
    // A file whose values were lost on the way would give the defaults, too.
    let other = EXAMPLE.replace("    timeout_s: 0.5 ", "    timeout_s: 0.7 ");
    assert_eq!(Config::from_yaml(&other).unwrap(), Config { timeout_s: 0.7, ..Config::default() });
    let keys = serde_json::to_value(Config::default()).unwrap();
    for key in keys.as_object().unwrap().keys() {
        let stated = EXAMPLE.lines().any(|line| line.starts_with(&format!("    {key}: ")));
        assert!(stated, "`{key}` is missing in testdata/config/limpid.yaml");
        assert!(scope_of(key).is_some(), "`{key}` belongs neither to the map nor to a sensor");
    }
}

#[test]
fn every_example_is_read() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/config");
    let mut read = 0;
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        // A list of still pairs, not parameters.
        if !path.ends_with("cleargrasp-pairs.yaml") {
            Config::read(&path).unwrap();
            read += 1;
        }
    }
    assert!(read > 10, "{read} files in {folder}");
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
fn a_file_for_several_nodes_gives_each_its_own_and_what_is_for_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("params.yaml");
    let read = |text: &str, node: &str| {
        std::fs::write(&path, text).unwrap();
        Config::read_for(&path, node).map_err(|error| error.to_string())
    };
    let file = "
/**: {ros__parameters: {tau: 0.4, map_size_m: 8.0, use_sim_time: true}}
controller_server: {ros__parameters: {anything: 1}}
limpid: {ros__parameters: {tau: 0.5}}
/robot/eyes: {ros__parameters: {tau: 0.6}}
";
    for (node, tau) in
        [("limpid", 0.5), ("/limpid", 0.5), ("/robot/limpid", 0.5), ("/robot/eyes", 0.6), ("ears", 0.4)]
    {
        let config = read(file, node).unwrap();
        assert_eq!((config.tau, config.map_size_m, config.use_sim_time), (tau, 8.0, true), "{node}");
    }
    // Sections are laid over each other key by key.
    let sensors = "
/**: {ros__parameters: {sensors: [eye], eye: {kind: camera, depth_topic: /d, tau: 0.4}}}
/**/limpid: {ros__parameters: {eye: {tau: 0.5}}}
";
    let config = read(sensors, "limpid").unwrap();
    assert_eq!((config.sensors[0].parameters.tau, config.sensors[0].topic()), (0.5, "/d"));
    // The only node's are taken whatever it is called; of several none is guessed.
    assert_eq!(read("eyes: {ros__parameters: {tau: 0.4}}", "limpid").unwrap().tau, 0.4);
    let two = "eyes: {ros__parameters: {tau: 0.4}}\nears: {ros__parameters: {tau: 0.5}}";
    let error = read(two, "limpid").unwrap_err();
    assert!(error.contains("`limpid`") && error.contains("`eyes`, `ears`"), "{error}");
    let error = read("/**: {ros__parameters: {tau: 0.4}}\ntau: 0.5", "limpid").unwrap_err();
    assert!(error.contains("`tau`") && error.contains("beside `/**`"), "{error}");
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest_and_its_place() {
    let error = Config::from_yaml("tau: 0.3\nresolution: 0.05\n").unwrap_err().to_string();
    assert!(error.contains("nearest key is `resolution_m`"), "{error}");
    assert!(error.contains("line 2"), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    // `map` is a key too, and a small part of this one.
    let error = Config::from_yaml("map_sise_m: 8.0").unwrap_err().to_string();
    assert!(error.contains("nearest key is `map_size_m`"), "{error}");
}

#[test]
fn messages_name_the_nearest_key_and_no_library() {
    for (text, part) in [
        ("static_transforms: [{parent: a, chidl: b}]\n", "`chidl` is unknown; the nearest key is `child`"),
        ("tau: high\n", "expected a number"),
        ("glass: 7\n", "expected true or false"),
        ("tau: 0.3\ntau: 0.4\n", "duplicate mapping key: tau"),
        ("limpid:\n  ros_parameters:\n    tau: 0.3\n", "no `ros__parameters` under it, but `ros_parameters`"),
    ] {
        let error = Config::from_yaml(text).unwrap_err().to_string();
        assert!(error.contains(part), "{text}: {error}");
        let foreign = ["expected one of `parent`", "f64", "DuplicateKeyPolicy"];
        assert!(!foreign.iter().any(|word| error.contains(word)), "{text}: {error}");
    }
    let scene = include_str!("../../testdata/corridor.yaml").replace("step_m:", "stepp_m:");
    let error = limpid::sim::Scene::from_yaml(&scene).unwrap_err().to_string();
    assert!(error.contains("the nearest key is `step_m`") && error.lines().count() == 1, "{error}");
}

#[test]
fn parameters_of_all_nodes_and_of_another_name_are_read() {
    for name in ["/**", "/limpid", "limpid_front"] {
        let config = Config::from_yaml(&format!("{name}:\n  ros__parameters:\n    tau: 0.4\n")).unwrap();
        assert_eq!(config.tau, 0.4, "{name}");
    }
}

#[test]
fn leading_slashes_of_frames_mean_nothing() {
    let text = "map_frame: /odom\nstatic_transforms: [{parent: /a, child: //b, translation_m: [0, 0, 0], \
                rotation_xyzw: [0, 0, 0, 1]}]\n";
    let config = Config::from_yaml(text).unwrap();
    let stated = &config.static_transforms[0];
    assert_eq!([&config.map_frame, &stated.parent, &stated.child], ["odom", "a", "b"]);
}

#[test]
fn numbers_and_booleans_may_be_written_as_ros_writes_them() {
    let config =
        Config::from_yaml("glass: yes\nmap_size_m: 8\npair_tolerance_s: 1e-2\nweights: 'no'\n").unwrap();
    let expected = Config {
        glass: true,
        map_size_m: 8.0,
        pair_tolerance_s: 0.01,
        weights: "no".into(),
        ..Config::default()
    };
    assert_eq!(config, expected);
}

#[test]
fn the_inflation_law_follows_the_cameras_unless_it_is_stated() {
    let law = |text: &str| Config::from_yaml(text).unwrap();
    assert_eq!(law("").inflation_law(true), InflationLaw::Nav2);
    assert_eq!(law("").inflation_law(false), InflationLaw::Goal);
    assert_eq!(law("inflation_law: nav2").inflation_law(false), InflationLaw::Nav2);
    assert_eq!(law("inflation_law: goal").inflation_law(true), InflationLaw::Goal);
}

#[test]
fn configuration_knows_sensors_and_nothing_above_them() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/config");
    let mut uses = 0;
    for file in std::fs::read_dir(folder).unwrap() {
        let path = file.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        for rest in text.split("crate::").skip(1) {
            let first = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap();
            assert!(["base", "sensor", "Error"].contains(&first), "{}: crate::{first}", path.display());
            uses += 1;
        }
    }
    assert!(uses > 5, "{uses} uses of limpid's modules in {folder}");
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
        ("publish_rate_hz: 0.0", "publish_rate_hz"),
        ("timeout_s: -0.1", "timeout_s"),
        ("timeout_s: .nan", "timeout_s"),
        ("cell_timeout_s: -1", "cell_timeout_s"),
        ("order_window_s: -0.1", "order_window_s"),
        ("wait_s: -0.1", "wait_s"),
        ("publish_deadline_s: .nan", "publish_deadline_s"),
        ("full_map_m: 51", "full_map_m"),
        ("degraded_speed_percent: 0", "degraded_speed_percent"),
        ("degraded_speed_percent: 101", "degraded_speed_percent"),
        ("max_points: 0", "max_points"),
        ("max_points: 1048577", "max_points"),
        ("lidar_clears_camera: sometimes", "lidar_clears_camera"),
        ("inflation_law: nav3", "inflation_law"),
    ] {
        let error = Config::from_yaml(text).unwrap_err().to_string();
        assert!(error.contains(&format!("`{key}`")), "{text}: {error}");
    }
}
