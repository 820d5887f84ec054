//! Glass within the lidar path: the map, what is written, panes from a file.

use crate::support::scan::{ScanFrame, ScanOptions, ScanOutput, ScanPipeline, by_intensity};
use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::config::GroundSource;
use limpid::input::points;
use limpid::input::points::Options;
use limpid::map::CellClass;
use limpid::map::PaneSet;
use limpid::map::clean::cleaned;
use limpid::map::glass::PointClass;
use limpid::map::pane_file::{panes_to_yaml, read_panes};
use limpid::mapper::SensorInfo;
use limpid::offline::labeller::Labeller;
use limpid::output::{McapSink, PngSink, Sink};
use limpid::sensor::Scan;
use limpid::sensor::{SensorPose, Sweep};
use limpid::stage::glass::MOST_POINTS;

use super::memory::blind;
use crate::support::glass_room::{GlassRoom, WALL_X_M};
use crate::support::gpu::skipped;

fn config() -> Config {
    let layer_heights_m = vec![-0.5, 0.0, 0.5, 2.5];
    Config { glass: true, deskew: false, scan_map_size_m: 30.0, layer_heights_m, ..by_intensity() }
}

fn frame(scan: Scan, room: &GlassRoom) -> ScanFrame {
    let map_from_base = Rigid { rotation: DQuat::from_rotation_z(room.yaw), translation_m: room.sensor_m };
    let pose = SensorPose { map_from_base, base_from_sensor: Rigid::IDENTITY, sweep: None };
    ScanFrame { scan, map_frame: "map".into(), pose: Some(pose), goal_m: None }
}

fn frames(count: u64) -> Vec<ScanFrame> {
    let room = |number: u64| GlassRoom { yaw: 0.2 * number as f64, ..GlassRoom::default() };
    (0..count)
        .map(|number| {
            let (mut scan, _) = room(number).scan();
            (scan.index, scan.stamp_ns) = (number, 1_000_000_000 + number * 100_000_000);
            frame(scan, &room(number))
        })
        .collect()
}

fn run(config: &Config, frames: &[ScanFrame], together: usize) -> Vec<ScanOutput> {
    let mut pipeline = ScanPipeline::open(config, &frames[0], &ScanOptions::default()).unwrap();
    let mut outputs = Vec::new();
    for some in frames.chunks(together) {
        some.iter().for_each(|frame| pipeline.submit(frame).unwrap());
        while let Some(output) = pipeline.receive().unwrap() {
            outputs.push(output);
        }
    }
    outputs
}

/// Cost at a place in the map.
fn cost(output: &ScanOutput, x_m: f64, y_m: f64) -> u8 {
    let grid = &output.grid;
    let cell = |m: f64, origin_m: f64| ((m - origin_m) / grid.resolution_m).floor() as usize;
    output.costmap[cell(y_m, grid.origin_y_m) * grid.width as usize + cell(x_m, grid.origin_x_m)]
}

#[test]
fn truth_the_pane_is_lethal_and_what_it_mirrors_is_not() {
    if skipped() {
        return;
    }
    let frames = frames(1);
    let with = &run(&config(), &frames, 1)[0];
    let without = &run(&Config { glass: false, ..config() }, &frames, 1)[0];
    for y_m in [-1.5, -0.5, 0.0, 0.7, 1.6] {
        assert_eq!(cost(with, WALL_X_M, y_m), 254, "the pane at y = {y_m}");
    }
    // The mirrored back wall lies at x = 12; that of the house opposite, which is real, at 16 is out of the map.
    let marked_at_12 = |output: &ScanOutput| {
        let places =
            (-3..=3).flat_map(|i| (-20..=20).map(move |k| (12.0 + 0.05 * f64::from(i), 0.1 * f64::from(k))));
        places.map(|(x_m, y_m)| cost(output, x_m, y_m)).filter(|&cost| cost != 0 && cost != 255).count()
    };
    assert!(marked_at_12(without) > 3, "the control: without glass the mirrored wall is in the map");
    assert_eq!(marked_at_12(with), 0);
    assert!(without.glass.is_none() && with.glass.is_some());
}

#[test]
fn truth_a_pane_of_a_moving_scan_is_placed_by_the_pose_at_the_stamp() {
    if skipped() {
        return;
    }
    // The lidar drove 1 m within the revolution. Its stamp is that of the last point, and all but one were fired then.
    let mut frame = frames(1).remove(0);
    frame.scan.columns.time = true;
    frame.scan.points[0].time_s = -0.1;
    let pose = frame.pose.as_mut().unwrap();
    let map_from_last = pose.map_from_sensor();
    let translation_m = map_from_last.translation_m - DVec3::X;
    let map_from_first = Rigid { translation_m, ..map_from_last };
    pose.sweep = Some(Sweep { first_s: -0.1, last_s: 0.0, map_from_first, map_from_last });
    let output = &run(&Config { deskew: true, ..config() }, &[frame], 1)[0];
    for y_m in [-1.5, -0.5, 0.0, 0.7, 1.6] {
        assert_eq!(cost(output, WALL_X_M, y_m), 254, "the pane at y = {y_m}");
        assert_ne!(
            cost(output, WALL_X_M - 1.0, y_m),
            254,
            "where the pane was from the first pose, y = {y_m}"
        );
    }
}

#[test]
fn truth_a_pane_high_above_the_ground_is_not_in_the_way() {
    if skipped() {
        return;
    }
    let frames = frames(1);
    let glass = |config: &Config, frames: &[ScanFrame]| {
        let output = &run(config, frames, 1)[0];
        let grid = &output.grid;
        let cell = |m: f64, origin_m: f64| ((m - origin_m) / grid.resolution_m).floor() as usize;
        // The wall is the border of two cells.
        [WALL_X_M - 0.05, WALL_X_M + 0.05].into_iter().any(|x_m| {
            let at = cell(-1.5, grid.origin_y_m) * grid.width as usize + cell(x_m, grid.origin_x_m);
            output.classes[at] == CellClass::Transparent as u8
        })
    };
    assert!(glass(&config(), &frames), "it stands 0.9 m below to 1.4 m above the ground of the map");
    let deep = Config { ground_z_m: -4.0, ground: GroundSource::Stated, ..config() };
    assert!(!glass(&deep, &frames), "it begins 3.1 m above the ground");
    // Without poses the ground is not known.
    let room = GlassRoom { yaw: 0.0, sensor_m: DVec3::ZERO, ..GlassRoom::default() };
    let still = ScanFrame { pose: Some(SensorPose::SENSOR), ..frame(room.scan().0, &room) };
    assert!(glass(&deep, &[still]));
}

#[test]
fn scans_up_to_as_many_points_as_cells_can_number_are_taken() {
    if skipped() {
        return;
    }
    let mut frame = frames(1).remove(0);
    let mut pipeline = ScanPipeline::open(&config(), &frame, &ScanOptions::default()).unwrap();
    let mut labeller = Labeller::open(&config(), &frame.scan, None, false).unwrap();
    let last = *frame.scan.points.last().unwrap();
    for points in [240_000, MOST_POINTS as usize] {
        frame.scan.points.resize(points, last);
        pipeline.submit(&frame).unwrap();
        let labelled = pipeline.receive().unwrap().unwrap().glass.unwrap();
        assert_eq!((labelled.classes.len(), labelled.panes.len()), (points, 1));
        assert_eq!(labeller.label(&frame.scan, Rigid::IDENTITY).unwrap().classes.len(), points);
    }
    frame.scan.points.push(last);
    let refused = [
        pipeline.submit(&frame).err(),
        ScanPipeline::open(&config(), &frame, &ScanOptions::default()).err(),
        labeller.label(&frame.scan, Rigid::IDENTITY).err(),
    ];
    for error in refused {
        let error = error.unwrap().to_string();
        assert!(error.contains("262145 points") && error.contains("262144"), "{error}");
    }
}

#[test]
fn truth_maps_do_not_depend_on_where_the_map_counts_from() {
    if skipped() {
        return;
    }
    // Places and cells of powers of two, so that rounding in f64 decides nothing.
    let config = Config { scan_resolution_m: 0.125, ..config() };
    let drive = |offset_m: DVec3| {
        let mut frames = frames(4);
        for (number, frame) in frames.iter_mut().enumerate() {
            let room = GlassRoom {
                yaw: 0.2 * number as f64,
                sensor_m: DVec3::new(0.25 + 0.125 * number as f64, 0.1875, 0.0),
                ..GlassRoom::default()
            };
            let pose = frame.pose.as_mut().unwrap();
            pose.map_from_base.translation_m = room.sensor_m + offset_m;
            frame.scan.points = room.scan().0.points;
        }
        run(&config, &frames, 3)
    };
    let (here, utm) = (drive(DVec3::ZERO), drive(DVec3::new(4.0e5, 5.0e6, 0.0)));
    for (here, utm) in here.iter().zip(&utm) {
        assert!(here.count(CellClass::Transparent) > 25);
        assert_eq!((&here.classes, &here.costmap, &here.glass), (&utm.classes, &utm.costmap, &utm.glass));
    }
}

#[test]
fn labels_do_not_depend_on_how_many_scans_are_under_way() {
    if skipped() {
        return;
    }
    let frames = frames(5);
    let (alone, together) = (run(&config(), &frames, 1), run(&config(), &frames, 3));
    assert_eq!(alone.len(), 5);
    assert_eq!(alone, together);
    let hits: Vec<u32> = alone.iter().map(|output| output.glass.as_ref().unwrap().panes[0].hits).collect();
    assert_eq!(hits, [1, 2, 3, 4, 5]);
}

#[test]
fn what_is_written_reads_back() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("glass.mcap");
    let frames = frames(2);
    let outputs = run(&config(), &frames, 1);
    let sensors = [SensorInfo::lidar(&config(), frames[0].scan.clone())];
    let mut mcap = McapSink::create(&path, &config(), &sensors).unwrap();
    let mut png = PngSink::create(folder.path(), &config(), &sensors).unwrap();
    for (frame, output) in frames.iter().zip(&outputs) {
        mcap.write(&output.update, Some(&frame.observation())).unwrap();
        png.write(&output.update, Some(&frame.observation())).unwrap();
    }
    mcap.finish().unwrap();
    for (topic, clean) in [("/limpid/glass/points", false), ("/limpid/glass/cleaned", true)] {
        let options = Options { topic: Some(topic.into()), ..Options::default() };
        let mut scans = points::open(&path, &options).unwrap();
        for (frame, output) in frames.iter().zip(&outputs) {
            let read = scans.next_scan().unwrap().unwrap();
            let labelled = output.glass.as_ref().unwrap();
            assert!(read.columns.ring && read.columns.return_type);
            let places: Vec<[f32; 3]> = match clean {
                true => cleaned(&frame.scan, labelled).map(|p| p.place_m.as_vec3().to_array()).collect(),
                false => frame.scan.points.iter().map(|point| point.position_m()).collect(),
            };
            let got: Vec<[f32; 3]> = read.points.iter().map(|point| point.position_m()).collect();
            assert_eq!(got, places, "{topic}");
        }
    }
    let bytes = std::fs::read(&path).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let markers: Vec<_> = messages.filter(|m| m.channel.topic == "/limpid/glass/panes").collect();
    let schema = markers[0].channel.schema.as_ref().unwrap();
    assert_eq!((markers.len(), schema.name.as_str()), (2, "visualization_msgs/msg/MarkerArray"));
    let picture = image::open(folder.path().join("000001-glass.png")).unwrap().to_rgb8();
    let has = |color: [u8; 3]| picture.pixels().filter(|pixel| pixel.0 == color).count();
    assert!(has([120, 255, 240]) > 100 && has([255, 92, 200]) > 100 && has([255, 166, 32]) > 50);
}

#[test]
fn panes_from_a_file_label_a_scan_that_shows_none() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("panes.yaml");
    let first = &run(&config(), &frames(1), 1)[0];
    let map_from_lidar = first.map_from_base.then(first.base_from_sensor);
    let found = &first.glass.as_ref().unwrap().panes;
    let panes = PaneSet::of_scan(found, map_from_lidar);
    std::fs::write(&path, panes_to_yaml(&panes)).unwrap();
    assert_eq!(read_panes(&path).unwrap(), panes);
    let room = GlassRoom { yaw: -0.9, sensor_m: DVec3::new(-0.5, 0.4, 0.0), ..GlassRoom::default() };
    let blind = [frame(blind(room.scan()), &room)];
    let loaded = Config { glass_panes: path.to_string_lossy().into_owned(), ..config() };
    let labelled = run(&loaded, &blind, 1)[0].glass.clone().unwrap();
    assert_eq!((labelled.panes.len(), labelled.counters.found_panes), (1, 0));
    assert!(labelled.classes.iter().any(|(class, _)| *class == PointClass::Reflection));
    let empty = run(&config(), &blind, 1)[0].glass.clone().unwrap();
    assert!(empty.panes.is_empty(), "the control");
}

#[test]
fn files_that_hold_no_panes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("panes.yaml");
    let refused = |text: &str, part: &str| {
        std::fs::write(&path, text).unwrap();
        let error = read_panes(&path).unwrap_err().to_string();
        assert!(error.contains("panes.yaml") && error.contains(part), "{error}");
    };
    refused("panes: 3", "panes");
    refused("windows: []", "`windows` is unknown");
    let good = "panes:\n  - {id: 1, normal: [1.0, 0.0, 0.0], distance_m: 4.0, level_axis: [0.0, 1.0, 0.0], \
                extent_m: [-1.0, 1.0, -1.0, 1.0], bright_above: 0.0, hits: 1, misses: 0, age: 1}\n";
    std::fs::write(&path, good).unwrap();
    let read = read_panes(&path).unwrap();
    assert_eq!((read.panes.len(), read.origin_m), (1, DVec3::ZERO), "without an origin: the map's");
    refused(&format!("origin_m: [0.0, .inf, 0.0]\n{good}"), "origin_m is not finite");
    refused(&good.replace("id: 1,", "id: 0,"), "pane 0 is none");
    refused(&good.replace("normal: [1.0", "normal: [2.0"), "pane 1 is none");
    refused(&good.replace("distance_m: 4.0", "distance_m: .nan"), "none");
    refused(&good.replace("[-1.0, 1.0, -1.0", "[1.0, -1.0, -1.0"), "pane 1 is none");
    let many = format!("panes:\n{}", good.trim_start_matches("panes:\n").repeat(17));
    refused(&many, "at most 16");
    assert_eq!(panes_to_yaml(&PaneSet::default()).lines().last(), Some("panes: []"));
}
