//! What a run says of the ground: one line, and warnings that name what to look at.

use glam::{DMat3, DQuat, DVec3};
use limpid::base::Rigid;
use limpid::config::Method;
use limpid::input::SourceReport;
use limpid::map::{Ground, GroundFrom, GroundPlane};
use limpid::run::Mistake;
use limpid::sensor::{CameraInfo, FramePose, Observation, RgbdFrame};
use limpid::{Config, Options, Result, RunReport, SensorInfo, Source, run};

use crate::cli::{limpid as command, succeeds};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, Scene, frame, pose, small_camera};
use crate::support::{data_dir, data_path};

/// Frames as a source.
struct Frames {
    sensors: Vec<SensorInfo>,
    frames: std::vec::IntoIter<RgbdFrame>,
}

impl Source for Frames {
    fn sensors(&self) -> &[SensorInfo] {
        &self.sensors
    }

    fn next(&mut self) -> Result<Option<Observation>> {
        Ok(self.frames.next().map(|frame| Observation::of_frame(0, "map", frame)))
    }

    fn report(&self) -> SourceReport {
        SourceReport::default()
    }

    fn count_hint(&self) -> Option<u64> {
        None
    }
}

/// The report of a run over frames of a room whose camera is at `truly` and is told to be at `told`.
fn report(config: &Config, truly: FramePose, told: FramePose) -> RunReport {
    let walls = [
        Block::new([4.0, -9.0, 0.0], [4.2, 9.0, 2.5]),
        Block::new([-9.0, 2.0, 0.0], [9.0, 2.2, 2.5]),
        Block::new([2.0, -0.5, 0.0], [2.4, 0.1, 0.6]),
    ];
    let seen = Scene::of(&walls).frame(0, small_camera(), truly);
    let frames: Vec<_> =
        (0..4).map(|index| frame(index, small_camera(), Some(told), seen.depth.samples.clone())).collect();
    let sensors = vec![SensorInfo::camera(config, CameraInfo::of_frames(&frames).unwrap())];
    let mut source = Frames { sensors, frames: frames.into_iter() };
    run(&mut source, 0..u64::MAX, config, &Options::default(), &mut [], &mut |_| ()).unwrap()
}

fn config() -> Config {
    Config { method: Method::Range, ..Config::default() }
}

fn turned(pose: FramePose, turn: DQuat) -> FramePose {
    let Rigid { rotation, translation_m } = pose.base_from_camera;
    FramePose { base_from_camera: Rigid { rotation: rotation * turn, translation_m }, ..pose }
}

/// In front of the base's middle, so that the base is known.
fn mounted() -> FramePose {
    let mut mounted = pose(0.0, 0.0, 0.0, 0.6, 0.3);
    mounted.base_from_camera.translation_m.x = 0.2;
    mounted
}

#[test]
fn a_right_mount_is_said_in_one_line_and_warns_of_nothing() {
    if skipped() {
        return;
    }
    let report = report(&config(), mounted(), mounted());
    assert_eq!(report.warnings, [""; 0]);
    let text = report.sensors[0].ground.text("camera").unwrap();
    assert!(text.starts_with("floor 0.60 m below the camera, tilted 0."), "{text}");
    assert!(text.ends_with(" degrees (seen in 4 of 4)"), "{text}");
}

#[test]
fn mistakes_of_a_mount_are_named() {
    if skipped() {
        return;
    }
    let body_from_optical = DQuat::from_mat3(&DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X));
    for (mistake, turn, part) in [
        (Mistake::UpsideDown, DQuat::from_rotation_z(std::f64::consts::PI), "upside down"),
        (Mistake::Optical, body_from_optical.conjugate(), "optical frame"),
        (Mistake::Sideways, DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2), "stands on its side"),
    ] {
        let report = report(&config(), mounted(), turned(mounted(), turn));
        let mount =
            report.sensors[0].mount.unwrap_or_else(|| panic!("{mistake:?}: {:?}", report.sensors[0].ground));
        assert_eq!(mount.mistake, mistake);
        assert!((mount.below_m - 0.6).abs() < 0.03, "{mount:?}");
        assert_eq!(report.sensors[0].ground.seen, 0, "{mistake:?}: {:?}", report.sensors[0].ground);
        let warning = &report.warnings[0];
        assert!(warning.starts_with("camera: no floor is seen") && warning.contains(part), "{warning}");
        assert!(warning.contains("static_transforms"), "{warning}");
    }
}

#[test]
fn a_wrong_ground_z_is_named_with_the_right_one() {
    if skipped() {
        return;
    }
    for (ground_z_m, part) in
        [(0.25, "0.25 m below ground_z_m (0.25)"), (-0.2, "0.20 m above ground_z_m (-0.2)")]
    {
        let report = report(&Config { ground_z_m, ..config() }, mounted(), mounted());
        let [warning] = report.warnings.as_slice() else { panic!("{:?}", report.warnings) };
        assert!(warning.contains(part) && warning.contains("ground_z_m: "), "{warning}");
    }
    let report = report(&Config { ground_z_m: 0.08, ..config() }, mounted(), mounted());
    assert_eq!(report.warnings, [""; 0], "within 0.1 m");
}

#[test]
fn a_ground_z_that_nobody_set_is_named_only_where_heights_count_from_it() {
    if skipped() {
        return;
    }
    // A map that begins at the camera: the floor lies 0.5 m below z = 0, and is seen in every frame.
    let mut told = mounted();
    told.map_from_base.translation_m.z -= 0.3;
    let of_default = report(&config(), mounted(), told);
    assert_eq!(of_default.sensors[0].ground.seen, 4, "{:?}", of_default.sensors[0].ground);
    assert_eq!(of_default.warnings, [""; 0]);
    let set = report(&Config { ground_z_m: 0.01, ..config() }, mounted(), told);
    assert!(set.warnings[0].contains("0.31 m below ground_z_m (0.01)"), "{:?}", set.warnings);
    // Seen late: the frames before it count from what nobody set.
    let mut late = of_default.sensors[0].ground.clone();
    late.stated = 1;
    assert!(late.warning(0.0, false).unwrap().contains("1 of 4 messages"));
}

#[test]
fn heights_above_the_ground_that_is_used() {
    let level = GroundPlane { normal: DVec3::Z, below_m: 0.6, messages: 3 };
    let ground = Ground {
        from: GroundFrom::Seen,
        agrees: false,
        sensor_height_m: 0.6,
        plane: Some(GroundPlane { normal: DVec3::new(-0.6, 0.0, 0.8), ..level }),
        seen: true,
        refused_m: None,
        support: 1.0,
        area_m2: 2.0,
        pierced_m2: 0.0,
        above_stated_m: None,
    };
    let place = DVec3::new(1.0, 5.0, 0.5);
    assert!((ground.height_of(place) - 0.4).abs() < 1e-12, "above the tilted plane");
    for other in [Ground { agrees: true, ..ground }, Ground { from: GroundFrom::Other, ..ground }] {
        assert!((other.height_of(place) - 1.1).abs() < 1e-12, "above a level one");
    }
}

#[test]
fn a_camera_whose_height_is_wrong_by_a_metre_sees_no_ground_where_its_base_stands() {
    if skipped() {
        return;
    }
    let mut told = mounted();
    told.base_from_camera.translation_m.z += 1.0;
    let report = report(&config(), mounted(), told);
    let warning = &report.warnings[0];
    assert!(warning.contains("no floor at ground_z_m (0)") && warning.contains("1.00 m above"), "{warning}");
}

/// What `limpid run` prints for a recording of the folder of field cases; `None`, said aloud, where that is absent.
fn printed(case: &str, arguments: &[&str]) -> Option<String> {
    let folder = data_dir(case)?;
    let path = if folder.is_dir() { folder.join("in.mcap") } else { data_path(case) };
    let mut all = vec!["run", path.to_str().unwrap()];
    all.extend(arguments);
    Some(succeeds(&command(&all)))
}

#[test]
fn real_mounts_and_floors() {
    if skipped() {
        return;
    }
    if let Some(text) = printed("field/upside-down-tf-upright", &["--method", "range"]) {
        assert!(text.contains("upside down") && text.contains("0.61 m below the sensor"), "{text}");
    }
    if let Some(text) = printed("field/reference", &["--method", "range"]) {
        assert!(text.contains("floor 0.60 m below the camera, tilted 0.0 degrees"), "{text}");
        assert!(!text.contains("warning:") && text.contains("245 lethal"), "{text}");
    }
    if let Some(text) = printed("field/lidar-reference", &[]) {
        assert!(text.contains("floor 0.80 m below the lidar, tilted 0.0 degrees"), "{text}");
    }
    // NumPy finds the floor 1.482 m below the lidar, tilted by 7.7 to 7.9 degrees to its axes.
    if let Some(text) = printed("lidar/3dref.mcap", &["-c", "testdata/config/3dref.yaml"]) {
        assert!(text.contains("floor 1.49 m below the lidar, tilted 7.5 degrees (seen in 6 of 6)"), "{text}");
    }
}
