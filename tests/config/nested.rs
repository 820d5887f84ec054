//! Parameters in the nested form: `map`, `sensors` and a section for each sensor.

use limpid::config::{
    InflationLaw, LidarClearsCamera, Method, ROBOT, Scope, SensorConfig, SensorKind, scope_of,
};
use limpid::{Config, Error};

const THREE: &str = "
map: {frame: odom, base_frame: base, size_m: 8.0, resolution_m: 0.1, publish_rate_hz: 5, inflation_law: goal,
      cell_timeout_s: 3.0, lidar_clears_camera: always, passable_over_camera: true, ground_z_m: 0.1}
tau: 0.4
timeout_s: 0.7
sensors: [front, rear, top]
front: {kind: camera, depth_topic: /front/depth, method: range, frame: front_optical}
rear: {kind: camera, depth_topic: /rear/depth, method: naive, timeout_s: 0}
top: {kind: lidar, topic: /points, frame: velodyne, glass: true, max_points: 1000}
";

fn wrapped(text: &str) -> String {
    let inside: String = text.lines().map(|line| format!("    {line}\n")).collect();
    format!("limpid:\n  ros__parameters:\n{inside}")
}

fn sensor<'a>(config: &'a Config, name: &str) -> &'a SensorConfig {
    config.sensors.iter().find(|sensor| sensor.name == name).unwrap()
}

#[test]
fn map_and_sections_are_laid_over_the_flat_keys() {
    let config = Config::from_yaml(THREE).unwrap();
    let map = Config {
        map_frame: "odom".into(),
        base_frame: "base".into(),
        map_size_m: 8.0,
        resolution_m: 0.1,
        scan_map_size_m: 8.0,
        scan_resolution_m: 0.1,
        publish_rate_hz: 5.0,
        inflation_law: InflationLaw::Goal,
        cell_timeout_s: 3.0,
        lidar_clears_camera: LidarClearsCamera::Always,
        passable_over_camera: true,
        ground_z_m: 0.1,
        tau: 0.4,
        timeout_s: 0.7,
        ..Config::default()
    };
    assert_eq!(Config { sensors: Vec::new(), ..config.clone() }, map);
    let names: Vec<_> = config.sensors.iter().map(|sensor| (sensor.name.as_str(), sensor.kind)).collect();
    assert_eq!(
        names,
        [("front", SensorKind::Camera), ("rear", SensorKind::Camera), ("top", SensorKind::Lidar)]
    );
    let front = Config {
        depth_topic: "/front/depth".into(),
        method: Method::Range,
        camera_frame: "front_optical".into(),
        ..map.clone()
    };
    assert_eq!((&sensor(&config, "front").parameters, sensor(&config, "front").timeout_s), (&front, 0.7));
    let rear =
        Config { depth_topic: "/rear/depth".into(), method: Method::Naive, timeout_s: 0.0, ..map.clone() };
    assert_eq!((&sensor(&config, "rear").parameters, sensor(&config, "rear").timeout_s), (&rear, 0.0));
    let top = Config {
        scan_topic: "/points".into(),
        lidar_frame: "velodyne".into(),
        glass: true,
        max_points: 1000,
        ..map
    };
    assert_eq!((&sensor(&config, "top").parameters, sensor(&config, "top").topic()), (&top, "/points"));
}

#[test]
fn the_nested_form_in_ros_shape_means_the_same() {
    assert_eq!(Config::from_yaml(&wrapped(THREE)).unwrap(), Config::from_yaml(THREE).unwrap());
    let error =
        Config::from_yaml("limpid:\n  ros__parameters: {tau: 0.3}\ntau: 0.4\n").unwrap_err().to_string();
    assert!(error.contains("`tau`") && error.contains("line 3"), "{error}");
}

#[test]
fn the_map_of_the_nested_form_holds_for_lidars_without_a_word() {
    let config = Config::from_yaml("sensors: [top]\ntop: {kind: lidar}\n").unwrap();
    for parameters in [&config, &config.sensors[0].parameters] {
        assert_eq!((parameters.scan_map_size_m, parameters.scan_resolution_m), (12.0, 0.05));
    }
}

#[test]
fn the_example_of_a_robot_is_right() {
    let config = Config::from_yaml(ROBOT).unwrap();
    let kinds: Vec<_> = config.sensors.iter().map(|sensor| sensor.kind).collect();
    assert_eq!(kinds, [SensorKind::Camera, SensorKind::Camera, SensorKind::Lidar]);
    assert!(sensor(&config, "top").parameters.glass);
    assert_eq!(sensor(&config, "top").timeout_s, 0.3);
    assert_eq!(sensor(&config, "rear").parameters.map_frame, "odom");
}

#[test]
fn a_key_stands_where_it_belongs_and_nowhere_else() {
    for (key, value) in serde_json::to_value(Config::default()).unwrap().as_object().unwrap() {
        let scope = scope_of(key).unwrap();
        let place = |section: &str| match section {
            "map" => format!("map: {{{key}: {value}}}"),
            kind => format!("sensors: [one]\none: {{kind: {kind}, {key}: {value}}}"),
        };
        for (section, fits) in [
            ("map", scope == Scope::Map),
            ("camera", matches!(scope, Scope::Camera | Scope::Sensor)),
            ("lidar", matches!(scope, Scope::Lidar | Scope::Sensor)),
        ] {
            let read = Config::from_yaml(&place(section));
            assert_eq!(read.is_ok(), fits, "`{key}` in {section}: {read:?}");
        }
    }
}

/// Every text is refused in one line that says all of its parts.
fn refused(cases: &[(&str, &[&str])]) {
    for (text, said) in cases {
        let error = Config::from_yaml(text).unwrap_err();
        assert!(matches!(error, Error::Config { .. }), "{text}: {error:?}");
        let message = error.to_string();
        for part in *said {
            assert!(message.contains(part), "{text}\n{message}\nlacks: {part}");
        }
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn one_thing_stated_twice_is_refused_with_both_names() {
    refused(&[
        ("map_size_m: 10\nmap: {size_m: 12}", &["`map.size_m`", "`map_size_m`", "line 2"]),
        ("scan_map_size_m: 10\nmap: {size_m: 12}", &["`scan_map_size_m`", "`map.size_m`"]),
        (
            "sensors: [a]\nscan_resolution_m: 0.1\na: {kind: lidar}",
            &["`scan_resolution_m`", "`map.resolution_m`"],
        ),
        (
            "depth_topic: /d\nsensors: [a]\na: {kind: camera, depth_topic: /d}",
            &["`a.depth_topic`", "`depth_topic`"],
        ),
        (
            "scan_topic: /d\nsensors: [a]\na: {kind: lidar, topic: /d}",
            &["`a.topic`", "`scan_topic`", "line 3"],
        ),
        ("sensors: [a]\na: {kind: lidar, topic: /d, scan_topic: /d}", &["`a.topic`", "`a.scan_topic`"]),
    ]);
}

#[test]
fn keys_and_values_that_do_not_fit_their_section_are_refused() {
    refused(&[
        (
            "sensors: [a]\na:\n  kind: camera\n  methd: drm",
            &["`a.methd`", "nearest key is `method`", "line 4"],
        ),
        ("map: {size: 12}", &["`map.size`", "nearest key is `size_m`"]),
        ("map: {tau: 0.3}", &["`map.tau`", "camera's key"]),
        ("map: 12", &["`map`", "not a section"]),
        ("sensors: [a]\na: {kind: lidar, tau: 0.3}", &["`a.tau`", "camera's key"]),
        ("sensors: [a]\na: {kind: camera, glass: true}", &["`a.glass`", "lidar's key"]),
        ("sensors: [a]\na: {kind: camera, map_size_m: 9}", &["`a.map_size_m`", "under `map`"]),
        ("sensors: [a]\na: {kind: camera, tau: high}", &["`a.tau`", "line 2", "high"]),
        ("sensors: [a]\na: {kind: camera, tau: 1.5}", &["`tau`", "sensor `a`"]),
        ("sensors: [a]\na: {kind: camera, tau: {}}", &["`a.tau`", "not a section"]),
        ("sensors: [a]\na: {kind: lidar, timeout_s: -1}", &["`a.timeout_s`", "-1"]),
        ("sensors: [a]\na: {kind: lidar, timeout_s: .nan}", &["`a.timeout_s`", "NaN"]),
        ("tau: {a: 1}", &["`tau`", "not a section"]),
    ]);
}

#[test]
fn sections_and_the_list_of_sensors_must_fit() {
    refused(&[
        ("sensors: [a]\na: {kind: sonar}", &["`a.kind`", "sonar", "camera and lidar"]),
        ("sensors: [a]\na: {depth_topic: /d}", &["`a`", "no `kind`"]),
        ("sensors: [a]\na:", &["`a`", "needs `kind: camera`"]),
        ("sensors: [a, b]\na: {kind: camera}", &["`b`", "no section", "line 1"]),
        (
            "sensors: [front]\nfront: {kind: camera}\nfrnt: {kind: camera}",
            &["`frnt`", "nearest", "`front`", "line 3"],
        ),
        ("front: {kind: camera}", &["`front`", "`sensors: [front]`"]),
        ("sensors: []", &["`sensors`", "names 0"]),
        ("sensors: [a, a]\na: {kind: camera}", &["`sensors`", "`a` twice"]),
        ("sensors: [map]\nmap: {kind: camera}", &["`map`", "cannot be a sensor's name"]),
        ("sensors: [tau]\ntau: {kind: camera}", &["`tau`", "cannot be a sensor's name"]),
        ("sensors: [a/b]\na/b: {kind: camera}", &["`a/b`", "holds a `/`"]),
        ("sensors: ['']\n'': {kind: camera}", &["empty name"]),
        ("sensors: [1]\n1: {kind: camera}", &["1 is not a name"]),
        ("sensors: front\nfront: {kind: camera}", &["not a list"]),
    ]);
}

#[test]
fn sensors_that_cannot_be_told_apart_are_refused() {
    refused(&[
        (
            "sensors: [a, b]\na: {kind: camera, depth_topic: /d}\nb: {kind: camera, depth_topic: /d}",
            &["`a` and `b`", "one topic, /d"],
        ),
        (
            "sensors: [a, b]\na: {kind: lidar, topic: /d}\nb: {kind: lidar, scan_topic: /d}",
            &["one topic, /d"],
        ),
        ("depth_topic: /d\nsensors: [a, b]\na: {kind: camera}\nb: {kind: camera}", &["one topic, /d"]),
        ("sensors: [a, b]\na: {kind: camera}\nb: {kind: camera}", &["`a` and `b`", "`depth_topic`"]),
        ("sensors: [a, b]\na: {kind: lidar}\nb: {kind: lidar}", &["`a` and `b`", "`topic`"]),
    ]);
}

#[test]
fn sixteen_sensors_are_taken_and_seventeen_refused() {
    let many = |count: usize| {
        let names: Vec<_> = (0..count).map(|i| format!("s{i}")).collect();
        let sections: String =
            names.iter().map(|name| format!("{name}: {{kind: camera, depth_topic: /{name}}}\n")).collect();
        Config::from_yaml(&format!("sensors: [{}]\n{sections}", names.join(", ")))
    };
    assert_eq!(many(16).unwrap().sensors.len(), 16);
    let error = many(17).unwrap_err().to_string();
    assert!(error.contains("names 17"), "{error}");
}

#[test]
fn a_camera_and_a_lidar_may_both_be_found_by_type() {
    let config = Config::from_yaml("sensors: [a, b]\na: {kind: camera}\nb: {kind: lidar}\n").unwrap();
    assert!(config.sensors.iter().all(|sensor| sensor.topic().is_empty()));
}

#[test]
fn sensors_that_a_program_makes_are_checked_as_those_of_a_file() {
    let one = SensorConfig {
        name: "one".into(),
        kind: SensorKind::Lidar,
        timeout_s: 0.5,
        parameters: Config::default(),
    };
    let check = |sensors: Vec<SensorConfig>| Config { sensors, ..Config::default() }.validate();
    check(vec![one.clone()]).unwrap();
    for (sensors, said) in [
        (vec![one.clone(), one.clone()], "`one` twice"),
        (vec![SensorConfig { name: String::new(), ..one.clone() }], "empty name"),
        (vec![SensorConfig { timeout_s: f64::NAN, ..one.clone() }], "`one.timeout_s`"),
        (vec![SensorConfig { parameters: Config { tau: 2.0, ..Config::default() }, ..one.clone() }], "`tau`"),
        (vec![one; 17], "names 17"),
    ] {
        let error = check(sensors).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn a_change_for_all_reaches_every_sensor() {
    let mut config = Config::from_yaml(THREE).unwrap();
    config.change_all(|parameters| parameters.method = Method::Median);
    assert_eq!(config.method, Method::Median);
    assert!(config.sensors.iter().all(|sensor| sensor.parameters.method == Method::Median));
}
