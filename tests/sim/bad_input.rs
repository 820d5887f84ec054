//! What cannot be in a scene is refused with its key.

use limpid::Error;
use limpid::sim::Scene;

use super::{a_box, small_room};

#[track_caller]
fn refused(change: impl Fn(&mut Scene), key: &str, part: &str) {
    let mut scene = small_room();
    scene.validate().unwrap();
    change(&mut scene);
    match scene.validate() {
        Err(Error::Config { key: got, reason }) => {
            assert!(got == key && reason.contains(part), "{got}: {reason}");
        }
        other => panic!("{other:?} where `{key}` is to be refused"),
    }
}

#[track_caller]
fn yaml_refused(from: &str, to: &str, parts: &[&str]) {
    let yaml = small_room().to_yaml().unwrap();
    assert!(yaml.contains(from), "{from} is not in\n{yaml}");
    let error = Scene::from_yaml(&yaml.replacen(from, to, 1)).unwrap_err().to_string();
    assert!(parts.iter().all(|part| error.contains(part)), "{error}");
}

#[test]
fn unknown_materials_are_named_with_the_nearest() {
    refused(|s| s.floor = "flor".into(), "floor", "nearest is `floor`");
    refused(|s| s.ceiling = "sky".into(), "ceiling", "no `sky`");
    refused(|s| s.rooms[0].walls = "wals".into(), "rooms[0].walls", "nearest is `walls`");
    let mut block = a_box([1.0, 1.0, 0.5], [0.2; 3]);
    block.material = "woood".into();
    refused(|s| s.boxes = vec![block.clone()], "boxes[0].material", "no `woood`");
    refused(|s| s.floor = "glass".into(), "floor", "only panes");
}

#[test]
fn degenerate_geometry_is_named() {
    let at = [1.0, 1.0, 0.5];
    refused(|s| s.boxes.push(a_box(at, [0.0, 0.2, 0.2])), "boxes[0].size_m", "0 is not a length");
    refused(|s| s.boxes.push(a_box(at, [0.1, f64::NAN, 0.2])), "boxes[0].size_m", "NaN");
    refused(|s| s.boxes.push(a_box([f64::INFINITY, 0.0, 0.0], [0.1; 3])), "boxes[0].center_m", "inf");
    let cylinder = |radius_m: f64| limpid::sim::scene::Cylinder {
        base_m: at,
        radius_m,
        height_m: 1.0,
        material: "plain".into(),
    };
    refused(|s| s.cylinders.push(cylinder(-0.1)), "cylinders[0].radius_m", "-0.1");
    refused(|s| s.cylinders.push(cylinder(0.0)), "cylinders[0].radius_m", "0");
    refused(|s| s.rooms[0].max_m = s.rooms[0].min_m, "rooms[0].max_m", "not beyond min_m");
    refused(|s| s.rooms.clear(), "rooms", "none");
    refused(|s| s.ceiling_m = f64::NAN, "ceiling_m", "NaN");
    let pane = |width_m: f64| limpid::sim::scene::Pane {
        center_m: at,
        width_m,
        height_m: 1.0,
        yaw_rad: 0.0,
        material: "glass".into(),
    };
    refused(|s| s.panes.push(pane(f64::NAN)), "panes[0].width_m", "NaN");
    refused(|s| s.panes = vec![pane(0.1); 100], "panes", "too many");
}

#[test]
fn impossible_materials_and_lights_are_named() {
    fn plain(scene: &mut Scene) -> &mut limpid::sim::material::Material {
        scene.materials.get_mut("plain").unwrap()
    }
    refused(|s| plain(s).albedo[1] = 1.5, "materials.plain.albedo", "1.5");
    refused(|s| plain(s).roughness = -0.1, "materials.plain.roughness", "-0.1");
    refused(|s| plain(s).reflectance = 0.1, "materials.plain.reflectance", "glossy");
    refused(|s| plain(s).transmission = 0.5, "materials.plain.transmission", "glass transmits");
    refused(|s| s.ambient.infrared = -1.0, "ambient.infrared", "-1");
    refused(|s| s.imager.electrons = 0.0, "imager.electrons", "0");
    refused(|s| s.matcher.disparities = 0, "matcher.disparities", "16..=256");
    refused(|s| s.camera.width = 100, "camera.width", "multiple of 8");
    refused(|s| s.camera.height = 0, "camera.height", "16..=800");
}

#[test]
#[expect(clippy::too_many_lines, reason = "one refusal after another, of the same vessel")]
fn impossible_vessels_are_named() {
    fn put(scene: &mut Scene, profile_m: &[[f64; 2]]) {
        scene.materials.insert("body".into(), limpid::sim::material::Material::clear(1.5));
        scene.vessels.push(super::clear::vessel([1.0, 1.0, 0.5], profile_m, "body"));
    }
    let refused = |change: fn(&mut Scene), key: &str, part: &str| {
        refused(
            |s| {
                put(s, &[[0.0, 0.0], [0.1, 0.0], [0.1, 0.2]]);
                change(s);
            },
            key,
            part,
        );
    };
    refused(|s| s.vessels[0].profile_m[2][0] = -0.1, "vessels[0].profile_m", "-0.1");
    refused(|s| s.vessels[0].profile_m[2][1] = f64::NAN, "vessels[0].profile_m", "NaN");
    refused(|s| s.vessels[0].profile_m[2] = [0.0, 0.0], "vessels[0].profile_m", "does not rise");
    refused(|s| s.vessels[0].profile_m.truncate(1), "vessels[0].profile_m", "two corners");
    refused(|s| s.vessels[0].profile_m[1] = [0.0, 0.0], "vessels[0].profile_m", "twice");
    refused(|s| s.vessels[0].base_m[0] = f64::INFINITY, "vessels[0].base_m", "inf");
    refused(|s| s.vessels[0].material = "bodi".into(), "vessels[0].material", "nearest is `body`");
    refused(|s| s.vessels[0].fill_m = Some(0.1), "vessels[0].contents", "missing");
    refused(|s| s.vessels[0].contents = Some("body".into()), "vessels[0].fill_m", "missing");
    // A solid body has no inside.
    let fill = |s: &mut Scene| {
        (s.vessels[0].fill_m, s.vessels[0].contents) = (Some(0.1), Some("plain".into()));
    };
    refused(fill, "vessels[0].fill_m", "inner wall");
    refused(
        |s| {
            s.vessels[0].material = "plain".into();
            (s.vessels[0].fill_m, s.vessels[0].contents) = (Some(0.1), Some("plain".into()));
        },
        "vessels[0].fill_m",
        "clear",
    );
    refused(|s| s.vessels = vec![s.vessels[0].clone(); 30], "vessels", "too many");
    refused(
        |s| {
            let corner = |k: u32| [0.1, 0.01 * f64::from(k)];
            s.vessels[0].profile_m = (0..100).map(corner).collect();
        },
        "vessels",
        "99 are too many",
    );
    fn body(scene: &mut Scene) -> &mut limpid::sim::material::Material {
        scene.materials.get_mut("body").unwrap()
    }
    refused(|s| body(s).refractive_index = 0.9, "materials.body.refractive_index", "0.9");
    refused(|s| body(s).bump = f64::NAN, "materials.body.bump", "NaN");
    refused(|s| body(s).bump_scale_m = 0.0, "materials.body.bump_scale_m", "0");
    refused(
        |s| s.materials.get_mut("plain").unwrap().refractive_index = 1.5,
        "materials.plain.refractive_index",
        "only glass",
    );
}

#[test]
fn an_impossible_sun_is_named() {
    let sun = |elevation_rad: f64, infrared: f64| limpid::sim::sun::Sun {
        yaw_rad: 0.0,
        elevation_rad,
        color: [1.0; 3],
        infrared,
    };
    refused(|s| s.sun = Some(sun(-0.1, 1.0)), "sun.elevation_rad", "-0.1");
    refused(|s| s.sun = Some(sun(2.0, 1.0)), "sun.elevation_rad", "2");
    refused(|s| s.sun = Some(sun(0.5, f64::NAN)), "sun.infrared", "NaN");
}

#[test]
fn a_camera_in_a_wall_and_a_way_through_things_are_named() {
    refused(|s| s.trajectory.waypoints_m.clear(), "trajectory.waypoints_m", "none");
    refused(|s| s.trajectory.waypoints_m = vec![[f64::NAN, 0.0]], "trajectory.waypoints_m[0]", "NaN");
    refused(|s| s.trajectory.waypoints_m = vec![[9.0, 0.0]], "trajectory.waypoints_m", "in no room");
    refused(|s| s.trajectory.step_m = 0.05, "trajectory.step_m", "0.04");
    let way = |s: &mut Scene| {
        s.trajectory.waypoints_m = vec![[-2.0, 0.0], [2.0, 0.0]];
        s.trajectory.frames = 200;
    };
    refused(
        |s| {
            way(s);
            s.boxes.push(a_box([1.0, 0.0, 0.5], [0.3, 0.3, 1.0]));
        },
        "trajectory.waypoints_m",
        "boxes[0]",
    );
    refused(
        |s| {
            s.trajectory.clearance_m = 0.0;
            s.boxes.push(a_box([0.1, 0.0, 0.5], [0.1, 0.1, 0.2]));
            s.camera.forward_m = 0.1;
        },
        "camera",
        "inside boxes[0]",
    );
    refused(
        |s| {
            s.trajectory.waypoints_m = vec![[2.5, 0.0]];
            s.camera.forward_m = 0.9;
        },
        "camera.forward_m",
        "camera is in no room",
    );
    refused(|s| (s.ceiling_m, s.camera.height_m) = (0.4, 0.5), "camera.height_m", "above the ceiling");
}

#[test]
fn yaml_that_is_no_scene_is_refused() {
    yaml_refused("ceiling_m:", "celing_m:", &["celing_m"]);
    yaml_refused("kind: textured", "kind: shiny", &["shiny"]);
    yaml_refused("albedo_ir:", "albedo_nir:", &["albedo_nir"]);
    yaml_refused("yaw_rad:", "yaw_deg:", &["yaw_deg"]);
    yaml_refused("ceiling_m: 2.5", "ceiling_m: .nan", &["ceiling_m", "NaN"]);
    yaml_refused("ceiling_m: 2.5", "ceiling_m: high", &["ceiling_m"]);
    assert!(Scene::from_yaml("").is_err());
    assert!(Scene::from_yaml("[1, 2]").is_err());
    let missing = Scene::read("no/such/scene.yaml".as_ref()).unwrap_err().to_string();
    assert!(missing.contains("no/such/scene.yaml"), "{missing}");
    let scene = small_room();
    assert_eq!(Scene::from_yaml(&scene.to_yaml().unwrap()).unwrap(), scene);
}

#[test]
fn the_command_says_what_is_wrong_and_exits_with_2() {
    let limpid = |arguments: &[&str]| {
        let output =
            std::process::Command::new(env!("CARGO_BIN_EXE_limpid")).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let refused = |arguments: &[&str], part: &str| {
        let (code, text) = limpid(arguments);
        assert!(code == Some(2) && text.contains(part), "{code:?}: {text}");
    };
    refused(&["sim"], "SCENE");
    refused(&["sim", "--seed", "1", "--no-camera"], "--lidar");
    refused(&["sim", "--seed", "1", "--lidar", "vlp64"], "vlp16");
    refused(&["sim", "--seed", "1", "--lidar", "vlp16", "-o", "no-such-folder-of-images"], "MCAP");
    refused(&["sim", "--seed", "1", "--level", "L9"], "L9");
    refused(&["sim", "--seed", "1", "--size", "848"], "WxH");
    refused(&["sim", "--seed", "1", "--size", "100x80"], "camera.width");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.yaml");
    let mut scene = small_room();
    scene.floor = "flor".into();
    std::fs::write(&file, scene.to_yaml().unwrap()).unwrap();
    refused(&["sim", file.to_str().unwrap()], "`floor`");
    std::fs::write(&file, "name: [").unwrap();
    refused(&["sim", file.to_str().unwrap()], "scene.yaml");
}
