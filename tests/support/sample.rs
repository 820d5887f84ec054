//! Frames and results with known values for the writers' tests.

use std::path::PathBuf;

use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::map::{
    CameraUpdate, CellClass, Counters, FrameImages, FrameLayers, Grid, LidarUpdate, MapUpdate, Seen, State,
    Update, Verdict,
};
use limpid::mapper::SensorInfo;
use limpid::sensor::{CameraInfo, DepthImage, DepthSamples, Observation, RgbdFrame};
use tempfile::TempDir;

use super::drive;
use super::room::Room;
use super::scan::scan;

pub(crate) const STAMP_NS: u64 = 1_700_000_001_234_567_890;
/// The depth image is younger than the colour image that the result's stamp comes from.
pub(crate) const DEPTH_STAMP_NS: u64 = STAMP_NS + 7_000_000;

/// A folder for a test's output: a temporary one, or `LIMPID_KEEP_OUTPUT`, to look at what was written.
pub(crate) fn output_folder() -> (TempDir, PathBuf) {
    let temporary = TempDir::new().unwrap();
    let folder =
        std::env::var_os("LIMPID_KEEP_OUTPUT").map_or_else(|| temporary.path().to_owned(), PathBuf::from);
    std::fs::create_dir_all(&folder).unwrap();
    (temporary, folder)
}

/// A camera of that name.
pub(crate) fn camera(name: &str, config: &Config) -> SensorInfo {
    let info = CameraInfo {
        depth: drive::camera(),
        float_depth: false,
        color: None,
        color_aligned: false,
        confidence: false,
    };
    SensorInfo { name: name.into(), ..SensorInfo::camera(config, info) }
}

/// A lidar of that name.
pub(crate) fn lidar(name: &str, config: &Config) -> SensorInfo {
    SensorInfo { name: name.into(), ..SensorInfo::lidar(config, scan(0, Vec::new())) }
}

/// One camera.
pub(crate) fn alone() -> [SensorInfo; 1] {
    [camera("camera", &Config::default())]
}

/// 3x2 pixels of depth in a frame called `optical`.
pub(crate) fn frame(samples: DepthSamples) -> RgbdFrame {
    let mut camera = drive::camera();
    (camera.width, camera.height) = (3, 2);
    let depth = DepthImage { stamp_ns: DEPTH_STAMP_NS, frame_id: "optical".into(), camera, samples };
    RgbdFrame {
        index: 12,
        depth,
        color: None,
        color_from_depth: None,
        color_missing: None,
        confidence: None,
        pose: None,
    }
}

/// What a frame came as.
pub(crate) fn observed(frame: RgbdFrame) -> Observation {
    Observation::of_frame(0, "map", frame)
}

/// 3x2 pixels of 16UC1 depth in a frame called `optical`.
pub(crate) fn input() -> Observation {
    observed(frame(millimetres()))
}

pub(crate) fn millimetres() -> DepthSamples {
    DepthSamples::Integer { raw: vec![1000, 1001, 1002, 1003, 0, 65535], unit_m: 0.001 }
}

/// Reliability of the 3x2 pixels; the third is tau itself as the GPU has it.
pub(crate) const RELIABILITY: [f32; 6] = [1.0, 0.5, 0.3, 0.301, 0.0, 0.0];

/// What came of the frame, with a grid of 16x17 cells (272) whose first 256 costs are 0..=255.
pub(crate) fn output() -> Update {
    let costmap: Vec<u8> = (0..=255).chain([0; 16]).collect();
    let cells = costmap.len();
    let layer = |value: f32| (0..cells).map(|i| if i == 20 { value } else { 0.0 }).collect::<Vec<f32>>();
    let camera = CameraUpdate {
        counters: Counters { pixels: 6, valid: 4, low_reliability: 3, hits: 2, ..Counters::default() },
        low_reliability_fraction: 0.5,
        degraded: false,
        depth_alone: None,
        images: Some(FrameImages {
            width: 3,
            height: 2,
            depth_m: vec![1.0, 1.001, 1.002, 1.003, 0.0, 0.0],
            reliability: RELIABILITY.to_vec(),
            color: None,
        }),
        layers: Some(FrameLayers {
            evidence: layer(-1.0),
            occupancy: layer(0.25),
            occupied: layer(1.0),
            free: layer(0.0),
        }),
        cell_inputs: Vec::new(),
    };
    let map = MapUpdate {
        grid: Grid { origin_x_m: 1.05, origin_y_m: -2.45, resolution_m: 0.05, width: 16, height: 17 },
        costmap,
        verdicts: Vec::new(),
        classes: Vec::new(),
        towards_goal: None,
        state: State::Ok,
        sensors: vec![State::Ok],
    };
    Update {
        sensor: Some(0),
        index: 12,
        stamp_ns: STAMP_NS,
        map_frame: "map".into(),
        ground: None,
        map_from_base: Rigid {
            rotation: DQuat::from_rotation_z(0.5),
            translation_m: DVec3::new(1.5, -2.0, 0.25),
        },
        base_from_sensor: drive::base_from_camera(),
        seen: Some(Seen::Camera(camera)),
        map: Some(map),
        pass_start_ms: vec![0.0, 0.5, 0.75],
        pass_ms: vec![("ingest".into(), 0.5), ("fuse".into(), 0.25), ("ingest".into(), 0.125)],
    }
}

/// The same with other values for the camera.
pub(crate) fn with_camera(change: impl FnOnce(&mut CameraUpdate)) -> Update {
    let mut update = output();
    let Some(Seen::Camera(camera)) = &mut update.seen else { panic!("a camera's") };
    change(camera);
    update
}

/// The same with other images.
pub(crate) fn with_images(change: impl FnOnce(&mut FrameImages)) -> Update {
    with_camera(|camera| change(camera.images.as_mut().unwrap()))
}

/// The same with another map.
pub(crate) fn with_map(change: impl FnOnce(&mut MapUpdate)) -> Update {
    let mut update = output();
    change(update.map.as_mut().unwrap());
    update
}

/// What came of a scan of no points: the same map, all of its cells of class free.
pub(crate) fn scan_output() -> Update {
    let lidar =
        LidarUpdate { points: 0, pose_jumped: false, glass: None, layers: None, solidity_inputs: Vec::new() };
    let update = with_map(|map| map.classes = vec![CellClass::Free as u8; map.costmap.len()]);
    Update { seen: Some(Seen::Lidar(lidar)), pass_ms: Vec::new(), pass_start_ms: Vec::new(), ..update }
}

/// A published map of two sensors, the second of them stale, in which every row of the rule has a cell; of the first cell the
/// second sensor says that it is glass, since 2.5 s.
pub(crate) fn published() -> Update {
    let update = with_map(|map| {
        map.verdicts = vec![Verdict::pack(0, 8, Some(1), 3); map.costmap.len()];
        for (cell, (row, cost)) in ROWS.into_iter().enumerate() {
            map.verdicts[cell] = Verdict::pack(cost, row, Some(1), 25);
        }
        map.classes = vec![CellClass::Free as u8; map.costmap.len()];
        (map.state, map.sensors) = (State::Stale, vec![State::Ok, State::Stale]);
    });
    Update { sensor: None, index: 3, seen: None, base_from_sensor: Rigid::IDENTITY, ..update }
}

/// Rows of the rule with their costs.
pub(crate) const ROWS: [(u32, u8); 11] =
    [(1, 254), (2, 254), (3, 254), (4, 254), (5, 0), (6, 254), (7, 50), (8, 0), (9, 0), (10, 255), (11, 255)];

/// A result that looks like a real one: the living room's truth with nav2's inflation, the camera's
/// view with an unreliable patch and a hole. For pictures.
pub(crate) fn picture() -> Update {
    let (room, camera) = (Room::living_room(), drive::camera());
    let stamp_ns = drive::image_stamp_ns(12);
    let grid = Grid { origin_x_m: -6.0, origin_y_m: -6.0, resolution_m: 0.05, width: 240, height: 240 };
    let depth_m = room.depth(&camera, drive::map_from_camera(stamp_ns));
    let mut images = FrameImages {
        width: camera.width,
        height: camera.height,
        reliability: depth_m.iter().map(|&d| if d > 0.0 { 0.97 } else { 0.0 }).collect(),
        depth_m,
        color: Some(room.color(&camera, drive::map_from_camera(stamp_ns))),
    };
    spoil(&mut images);
    let mut update = with_camera(|camera| {
        (camera.low_reliability_fraction, camera.degraded) = (0.62, true);
        camera.images = Some(images);
    });
    let map = update.map.as_mut().unwrap();
    (map.costmap, map.grid) = (inflated_truth(&room, &grid), grid);
    Update { stamp_ns, map_from_base: drive::map_from_base(stamp_ns), ..update }
}

/// Low reliability in one ellipse, a hole in another.
fn spoil(images: &mut FrameImages) {
    for y in 0..images.height {
        for x in 0..images.width {
            let pixel = (y * images.width + x) as usize;
            let radius = |cx: f32, cy: f32, rx: f32, ry: f32| {
                #[expect(clippy::cast_precision_loss, reason = "pixel numbers are small")]
                let (x, y) = (x as f32, y as f32);
                ((x - cx) / rx).hypot((y - cy) / ry)
            };
            let glare = radius(60.0, 85.0, 42.0, 26.0);
            if glare < 1.0 {
                images.reliability[pixel] = 0.9 * glare.powi(2);
            }
            if radius(66.0, 88.0, 15.0, 9.0) < 1.0 || radius(140.0, 24.0, 14.0, 18.0) < 1.0 {
                (images.depth_m[pixel], images.reliability[pixel]) = (0.0, 0.0);
            }
        }
    }
}

/// The room's truth with Nav2's inflation (spec 1 §3); unknown outside the walls and in one corner.
fn inflated_truth(room: &Room, grid: &Grid) -> Vec<u8> {
    const RADIUS_CELLS: i32 = 11;
    let cells: Vec<_> = (0..grid.height).flat_map(|y| (0..grid.width).map(move |x| (x, y))).collect();
    let centre = |i: u32, origin_m: f64| origin_m + (f64::from(i) + 0.5) * grid.resolution_m;
    let mut distance_m = vec![f64::INFINITY; cells.len()];
    for &(x, y) in &cells {
        if !room.occupied_at(centre(x, grid.origin_x_m), centre(y, grid.origin_y_m), 0.1, 2.0) {
            continue;
        }
        for dy in -RADIUS_CELLS..=RADIUS_CELLS {
            for dx in -RADIUS_CELLS..=RADIUS_CELLS {
                let cell = (y.wrapping_add_signed(dy) * grid.width + x.wrapping_add_signed(dx)) as usize;
                distance_m[cell] = distance_m[cell].min(f64::from(dx).hypot(dy.into()) * grid.resolution_m);
            }
        }
    }
    let cost = |(&(x, y), distance_m): (&(u32, u32), f64)| {
        let (x_m, y_m) = (centre(x, grid.origin_x_m), centre(y, grid.origin_y_m));
        let seen = x_m.abs() < 3.0 && y_m.abs() < 2.5 && !(x_m > 1.0 && y_m < -1.4);
        cost_of_distance(distance_m, seen)
    };
    cells.iter().zip(distance_m).map(cost).collect()
}

fn cost_of_distance(distance_m: f64, seen: bool) -> u8 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 252")]
    match distance_m {
        0.0 => 254,
        _ if !seen => 255,
        d if d <= 0.1 => 253,
        d if d <= 0.55 => (252.0 * (-10.0 * (d - 0.1)).exp()) as u8,
        _ => 0,
    }
}
