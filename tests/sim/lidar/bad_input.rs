//! What cannot be of a lidar and of thin things is refused with its key.

use limpid::Error;
use limpid::sim::Scene;
use limpid::sim::lidar::LidarSimulator;
use limpid::sim::scene::{Curtain, Thicket};
use limpid::sim::write::recorder;

use super::room_with_lidar;
use crate::support::gpu::{context, skipped};

#[track_caller]
fn refused(change: impl Fn(&mut Scene), key: &str, part: &str) {
    let mut scene = room_with_lidar();
    scene.curtains.push(Curtain {
        center_m: [1.5, 0.0, 1.0],
        width_m: 1.0,
        height_m: 2.0,
        yaw_rad: 0.0,
        spacing_m: 0.05,
        string_width_m: 0.005,
        material: "plain".into(),
    });
    scene.thickets.push(Thicket {
        center_m: [-1.5, 0.0, 0.5],
        size_m: [1.0; 3],
        yaw_rad: 0.0,
        outline: limpid::sim::scene::Outline::Box,
        density_per_m3: 100.0,
        element_width_m: 0.01,
        element_length_m: 0.1,
        material: "plain".into(),
        solid: false,
    });
    scene.validate().unwrap();
    change(&mut scene);
    match scene.validate() {
        Err(Error::Config { key: got, reason }) => {
            assert!(got == key && reason.contains(part), "{got}: {reason}");
        }
        other => panic!("{other:?} where `{key}` is to be refused"),
    }
}

#[test]
fn keys_of_lidars_and_thin_things_are_named() {
    refused(|s| s.lidar.as_mut().unwrap().subrays = 0, "lidar.subrays", "0 is not in 1..=32");
    refused(|s| s.lidar.as_mut().unwrap().subrays = 33, "lidar.subrays", "33");
    refused(|s| s.lidar.as_mut().unwrap().rate_hz = f64::NAN, "lidar.rate_hz", "NaN");
    refused(|s| s.lidar.as_mut().unwrap().rate_hz = 0.0, "lidar.rate_hz", "0");
    refused(|s| s.lidar.as_mut().unwrap().height_m = -1.0, "lidar.height_m", "-1");
    refused(|s| s.lidar.as_mut().unwrap().tilt_rad[1] = f64::INFINITY, "lidar.tilt_rad", "inf");
    refused(|s| s.lidar.as_mut().unwrap().intensity_gain = 0.0, "lidar.intensity_gain", "0");
    refused(|s| s.thickets[0].density_per_m3 = -1.0, "thickets[0].density_per_m3", "-1");
    refused(|s| s.thickets[0].density_per_m3 = f64::NAN, "thickets[0].density_per_m3", "NaN");
    refused(|s| s.thickets[0].element_width_m = 0.0, "thickets[0].element_width_m", "0");
    refused(|s| s.thickets[0].size_m[2] = 0.0, "thickets[0].size_m", "0 is not a length");
    refused(|s| s.thickets[0].material = "glass".into(), "thickets[0].material", "only panes");
    refused(|s| s.curtains[0].spacing_m = 0.0, "curtains[0].spacing_m", "0 is not a length");
    refused(|s| s.curtains[0].material = "beads".into(), "curtains[0].material", "no `beads`");
    refused(|s| s.curtains = vec![s.curtains[0].clone(); 9], "curtains", "9 are too many, 8 fit");
    refused(|s| s.thickets = vec![s.thickets[0].clone(); 25], "thickets", "25 are too many, 24 fit");
}

#[test]
fn scenes_of_older_recordings_are_read_and_say_nothing_new() {
    let mut scene = room_with_lidar();
    let yaml = scene.to_yaml().unwrap();
    assert_eq!(Scene::from_yaml(&yaml).unwrap(), scene);
    scene.lidar = None;
    let yaml = scene.to_yaml().unwrap();
    for key in ["lidar", "thickets", "curtains", "open_air"] {
        assert!(!yaml.contains(key), "{key}\n{yaml}");
    }
    assert_eq!(Scene::from_yaml(&yaml).unwrap(), scene);
}

#[test]
fn a_scene_without_a_lidar_and_a_folder_of_images_are_refused() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let scene = room_with_lidar();
    let reason = recorder(&folder.path().join("images"), &scene, false).err().unwrap().to_string();
    assert!(reason.contains("lidar") && reason.contains("MCAP"), "{reason}");
    let none = Scene { lidar: None, ..scene };
    let reason = LidarSimulator::with_context(&none, &context()).err().unwrap().to_string();
    assert!(reason.contains("lidar"), "{reason}");
}
