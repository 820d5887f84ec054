//! How much a source holds, seen from outside: the peak of a process that reads a recording much larger than that.

use std::process::Command;

use limpid::Config;
use limpid::config::{SensorConfig, SensorKind};
use limpid::input::open_source;
use limpid::message::ros2::Image;

use super::synthetic::{Recorder, at_ms, camera_info, header};

/// Where the process that reads finds the recording.
const RECORDING: &str = "LIMPID_TEST_RECORDING";

/// Pixels of the images: 600 kB each.
const SIZE: [u32; 2] = [640, 480];

/// Images of each of the two cameras: 360 MB together.
const IMAGES: u64 = 300;

/// What the process may need at most, kB: 64 images that wait of each camera and 64 frames that wait for their turn.
const MOST_KB: u64 = 200_000;

fn config() -> Config {
    let camera = |name: &str| SensorConfig {
        name: name.into(),
        kind: SensorKind::Camera,
        timeout_s: 0.5,
        parameters: Config { depth_topic: format!("/{name}/depth"), ..Config::default() },
    };
    // The third comes at the end, and blocks what is to be known at the start.
    Config { sensors: ["left", "right", "late"].map(camera).into(), ..Config::default() }
}

fn write(recorder: &mut Recorder, name: &str, ms: u64) {
    let [width, height] = SIZE;
    let mut info = camera_info(at_ms(ms), name);
    (info.width, info.height) = (width, height);
    recorder.info(&format!("/{name}/camera_info"), at_ms(ms), &info);
    let data = vec![3; (2 * width * height) as usize];
    let image = Image {
        header: header(at_ms(ms), name),
        height,
        width,
        encoding: "16UC1".into(),
        is_bigendian: 0,
        step: 2 * width,
        data,
    };
    recorder.image(&format!("/{name}/depth"), at_ms(ms), &image);
}

/// Reads the recording that the environment names; 300 images of each camera, whose poses never come.
#[test]
fn reads_for_the_test_of_memory() {
    let Some(path) = std::env::var_os(RECORDING) else { return };
    let mut source = open_source(path.as_ref(), &config()).unwrap();
    let mut given = 0;
    while source.next().unwrap().is_some() {
        given += 1;
    }
    assert_eq!(given, 2 * IMAGES + 1);
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    let peak_kb: u64 = peak.trim().trim_end_matches(" kB").parse().unwrap();
    assert!(peak_kb < MOST_KB, "{peak_kb} kB");
}

#[test]
#[cfg(target_os = "linux")]
fn memory_stays_bounded_whatever_a_recording_lacks() {
    let mut recorder = Recorder::compressed(Some(mcap::Compression::Zstd));
    recorder.transform("/tf", at_ms(0), ["map", "nothing"], [0.0; 3], [0.0, 0.0, 0.0, 1.0]);
    for i in 0..IMAGES {
        write(&mut recorder, "left", 50 * i);
        write(&mut recorder, "right", 50 * i + 25);
    }
    write(&mut recorder, "late", 50 * IMAGES);
    let saved = recorder.save();
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "read::memory::reads_for_the_test_of_memory"]).env(RECORDING, &saved.path);
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("1 passed"), "{said}");
}
