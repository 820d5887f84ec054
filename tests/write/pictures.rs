//! Pictures: colours at known places.

use std::path::Path;

use image::RgbImage;
use limpid::Config;
use limpid::map::{CellClass, Grid, MapUpdate, Update};
use limpid::mapper::SensorInfo;
use limpid::output::{PngSink, Sink};
use tempfile::TempDir;

use crate::support::sample;

const FREE: [u8; 3] = [48, 48, 48];
const LETHAL: [u8; 3] = [255, 0, 255];
const INSCRIBED: [u8; 3] = [0, 255, 255];
const UNKNOWN: [u8; 3] = [0x70, 0x89, 0x86];

fn pictures(output: &Update) -> (RgbImage, Option<RgbImage>) {
    let folder = TempDir::new().unwrap();
    pictures_in(folder.path(), output)
}

fn pictures_in(folder: &Path, output: &Update) -> (RgbImage, Option<RgbImage>) {
    let folder = folder.join("png");
    let mut sink = PngSink::create(&folder, &Config::default(), &sample::alone()).unwrap();
    sink.write(output, Some(&sample::input())).unwrap();
    sink.finish().unwrap();
    let read = |name: &str| {
        let path = folder.join(format!("{:06}-{name}.png", output.index));
        path.exists().then(|| image::open(path).unwrap().to_rgb8())
    };
    (read("costmap").unwrap(), read("reliability"))
}

/// 12x10 free cells of 60 px, the robot in the middle.
fn small(costs: &[((u32, u32), u8)]) -> Update {
    let grid = Grid { origin_x_m: 0.0, origin_y_m: 0.0, resolution_m: 0.25, width: 12, height: 10 };
    let mut costmap = vec![0; 120];
    for &((x, y), cost) in costs {
        costmap[(y * 12 + x) as usize] = cost;
    }
    let map_from_base = limpid::base::Rigid::new([1.6, 1.1, 0.0], [0.0, 0.0, 0.0, 1.0]).unwrap();
    let mut output = sample::with_camera(|camera| camera.images = None);
    let map = output.map.as_mut().unwrap();
    (map.grid, map.costmap) = (grid, costmap);
    Update { map_from_base, ..output }
}

/// Colour at the middle of a cell, `row` counted from the picture's top.
fn cell(picture: &RgbImage, column: u32, row: u32) -> [u8; 3] {
    picture.get_pixel(column * 60 + 30, row * 60 + 30).0
}

#[test]
fn north_is_up_and_costs_have_rviz_colours() {
    let output =
        small(&[((2, 9), 254), ((3, 9), 253), ((4, 9), 255), ((5, 9), 1), ((6, 9), 252), ((0, 8), 128)]);
    let (picture, none) = pictures(&output);
    assert!(none.is_none(), "no images, no reliability picture");
    assert_eq!(picture.width(), 720);
    assert_eq!(cell(&picture, 2, 0), LETHAL, "largest y is the top row");
    assert_eq!(cell(&picture, 2, 9), FREE, "and not the bottom row");
    assert_eq!([3, 4, 5, 6].map(|x| cell(&picture, x, 0)), [INSCRIBED, UNKNOWN, [3, 0, 252], [250, 0, 5]]);
    assert_eq!(cell(&picture, 0, 1), [128, 0, 127], "cost 128 is occupancy 50");
    // Whole cells, to the pixel.
    assert_eq!([119, 120, 179, 180].map(|x| picture.get_pixel(x, 59).0), [FREE, LETHAL, LETHAL, INSCRIBED]);
    assert_eq!(picture.get_pixel(120, 60).0, FREE);
}

#[test]
fn robot_points_along_its_heading() {
    let heading = |yaw: f64| {
        let mut output = small(&[]);
        output.map_from_base.rotation = glam::DQuat::from_rotation_z(yaw);
        pictures(&output).0
    };
    // Base at (1.6, 1.1) m: 240 px a metre from the bottom left of 720x600.
    let (x, y) = (384_u32, 600_u32 - 264);
    let white = |picture: &RgbImage, dx: i32, dy: i32| {
        picture.get_pixel(x.wrapping_add_signed(dx), y.wrapping_add_signed(dy)).0 == [255; 3]
    };
    let east = heading(0.0);
    assert!(white(&east, 0, 0) && white(&east, 45, 0) && !white(&east, 0, -45) && !white(&east, 0, 45));
    let north = heading(std::f64::consts::FRAC_PI_2);
    assert!(white(&north, 0, -45) && !white(&north, 45, 0) && !white(&north, 0, 50), "north is up");
}

#[test]
fn a_pose_that_is_not_finite_draws_no_robot() {
    let mut output = small(&[]);
    output.map_from_base.translation_m.x = f64::NAN;
    let (picture, _) = pictures(&output);
    assert_eq!(picture.get_pixel(384, 336).0, FREE);
}

#[test]
fn reliability_leaves_trusted_pixels_and_reddens_the_rest() {
    let output = sample::with_images(|images| {
        images.color = Some([[40_u8, 80, 160]; 6].concat());
        images.depth_m = vec![1.0, 1.0, 1.0, 1.0, 0.0, 1.0];
        images.reliability = vec![1.0, 0.3, 0.0, 0.65, 0.0, 1.0];
    });
    let picture = pictures(&output).1.unwrap();
    // 640 / 3 rounds up to 214 px a pixel.
    let at = |x: u32, y: u32| picture.get_pixel(x * 214 + 107, y * 214 + 107).0;
    assert_eq!(at(0, 0), [40, 80, 160], "trusted: as it was");
    assert_eq!(at(2, 1), [40, 80, 160], "trusted, bottom right");
    assert_eq!(at(1, 0), at(2, 0), "tau and 0 are tinted alike");
    assert!(at(1, 0)[0] > 180 && at(1, 0)[2] < 90, "{:?} is red", at(1, 0));
    assert!(at(0, 1)[0] > 40 && at(0, 1)[0] < at(1, 0)[0], "in between: {:?}", at(0, 1));
    let hole: std::collections::BTreeSet<_> =
        (0..20).map(|i| picture.get_pixel(214 + 90 + i, 214 + 107).0).collect();
    assert_eq!(hole, [[9, 18, 35], [74, 78, 92]].into(), "dark and hatched");
}

#[test]
fn without_colour_near_is_lighter_than_far() {
    let output = sample::with_images(|images| {
        images.depth_m = vec![0.5, 5.0, 1.0, 1.0, 1.0, 1.0];
        images.reliability = vec![1.0; 6];
    });
    let picture = pictures(&output).1.unwrap();
    let [near, far] = [107, 321].map(|x| picture.get_pixel(x, 107).0);
    assert!(near[0] > far[0] + 50 && near[0] == near[2], "{near:?} {far:?}");
}

#[test]
fn what_the_colour_camera_does_not_see_is_drawn_as_without_colour() {
    let output = |color: Option<Vec<u8>>| {
        sample::with_images(|images| {
            images.depth_m = vec![0.5, 0.5, 5.0, 0.0, 1.0, 1.0];
            images.reliability = vec![1.0; 6];
            images.color = color;
        })
    };
    let without = pictures(&output(None)).1.unwrap();
    // Unseen, nearly black, unseen; without depth, seen, seen.
    let rgb = [[0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 0, 0], [40, 80, 160], [9, 9, 9]];
    let with = pictures(&output(Some(rgb.concat()))).1.unwrap();
    let at = |picture: &RgbImage, x: u32, y: u32| picture.get_pixel(x * 214 + 107, y * 214 + 107).0;
    for x in [0, 2] {
        assert_eq!(at(&with, x, 0), at(&without, x, 0), "the depth in grey");
    }
    assert_ne!(at(&with, 0, 0), at(&with, 2, 0), "and not one grey for all");
    assert_eq!([at(&with, 1, 0), at(&with, 1, 1)], [[1, 0, 0], [40, 80, 160]], "colour where there is one");
    let hole: std::collections::BTreeSet<_> = (0..20).map(|i| with.get_pixel(90 + i, 214 + 107).0).collect();
    assert_eq!(hole, [[0, 0, 0], [74, 78, 92]].into(), "no depth stays dark");
}

/// The only picture that the map of `sensors` gives, and its name.
fn map_picture(kept: &str, output: &Update, sensors: &[SensorInfo]) -> (String, RgbImage) {
    let (_temporary, folder) = sample::output_folder();
    let folder = folder.join(kept);
    let mut sink = PngSink::create(&folder, &Config::default(), sensors).unwrap();
    sink.write(output, None).unwrap();
    let mut files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let path = files.next().unwrap();
    assert!(files.next().is_none());
    (path.file_name().unwrap().to_str().unwrap().into(), image::open(path).unwrap().to_rgb8())
}

/// Colours of the bottom row's cells, where the map is 12 cells wide and 1000 pixels hold 83 a cell.
fn bottom_row(picture: &RgbImage) -> Vec<[u8; 3]> {
    (0..12).map(|x| picture.get_pixel(x * 83 + 41, 9 * 83 + 41).0).collect()
}

/// A published map of 12x10 cells, the bottom row having one of each row of the rule, then an inflated one of row 8.
fn by_row(change: impl FnOnce(&mut MapUpdate)) -> Update {
    let mut output = sample::published();
    let map = output.map.as_mut().unwrap();
    map.grid = Grid { origin_x_m: 0.0, origin_y_m: 0.0, resolution_m: 0.25, width: 12, height: 10 };
    map.verdicts.truncate(120);
    map.classes.truncate(120);
    map.costmap = vec![0; 120];
    let of_row = [4, 2, 4, 2, 1, 2, 3, 1, 1, 0, 0, 5];
    for (cell, class) in of_row.into_iter().enumerate() {
        map.classes[cell] = CellClass::ALL[class] as u8;
        map.costmap[cell] = sample::ROWS.get(cell).map_or(252, |(_, cost)| *cost);
    }
    change(map);
    // Away from the bottom row.
    output.map_from_base.translation_m = [1.5, 2.0, 0.0].into();
    output
}

#[test]
fn verdicts_tell_glass_occupied_and_stale_apart() {
    let config = Config::default();
    let sensors = [sample::camera("front", &config), sample::lidar("top", &config)];
    let (name, picture) = map_picture("map-verdicts", &by_row(|_| ()), &sensors);
    assert_eq!(name, "map-000003-map.png");
    let (solid, passable, transparent) = ([250, 246, 236], [74, 178, 84], [255, 206, 48]);
    let (free, unknown, inflated) = ([24, 26, 30], [82, 88, 92], [72, 112, 214]);
    let (glass, occupied, stale) = ([44, 190, 214], [244, 120, 72], [122, 92, 70]);
    let want =
        [glass, solid, transparent, occupied, free, occupied, passable, free, free, unknown, stale, inflated];
    assert_eq!(bottom_row(&picture), want);
    // All of them are in the legend, under the map of 830 pixels.
    let legend = |color| picture.enumerate_pixels().any(|(_, y, pixel)| y > 830 && pixel.0 == color);
    assert!(want.into_iter().all(legend));
    // The legend has two lines, and no ground beside the map, which would look free.
    assert_eq!((picture.width(), picture.height()), (12 * 83, 10 * 83 + 66 + 26));

    let (name, picture) = map_picture("map-classes", &by_row(|map| map.verdicts.clear()), &sensors[1..]);
    assert_eq!(name, "000003-map.png");
    let want = [
        transparent,
        solid,
        transparent,
        solid,
        free,
        solid,
        passable,
        free,
        free,
        unknown,
        unknown,
        inflated,
    ];
    assert_eq!(bottom_row(&picture), want, "by class alone");
    let has = |color| picture.pixels().any(|pixel| pixel.0 == color);
    assert!(!has(glass) && !has(occupied) && !has(stale), "nor in the legend");

    let (name, _) = map_picture("map-costs", &by_row(|map| map.classes.clear()), &sensors);
    assert_eq!(name, "map-000003-costmap.png");
}

#[test]
fn pictures_of_several_cameras_bear_their_names() {
    let folder = TempDir::new().unwrap();
    let config = Config::default();
    let trusting = Config { tau: 0.0, ..Config::default() };
    let sensors = [sample::camera("front", &config), sample::camera("rear", &trusting)];
    let mut sink = PngSink::create(folder.path(), &config, &sensors).unwrap();
    for sensor in [0, 1] {
        let output = Update { sensor: Some(sensor), map: None, ..sample::output() };
        sink.write(&output, Some(&sample::input())).unwrap();
    }
    let read = |name: &str| image::open(folder.path().join(name)).unwrap().to_rgb8();
    let [front, rear] = ["front", "rear"].map(|name| read(&format!("{name}-000012-reliability.png")));
    assert_ne!(front, rear, "each with its own tau");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    let error = sink.write(&Update { sensor: Some(2), map: None, ..sample::output() }, None).unwrap_err();
    assert!(error.to_string().contains("unknown sensor"), "{error}");
}

#[test]
fn a_real_scene_has_all_parts() {
    let (_temporary, folder) = sample::output_folder();
    let (costmap, reliability) = pictures_in(&folder, &sample::picture());
    assert_eq!((costmap.width(), costmap.height()), (720, 720 + 66));
    let reliability = reliability.unwrap();
    assert_eq!((reliability.width(), reliability.height()), (640, 480 + 66));
    let count = |color: [u8; 3]| costmap.pixels().filter(|p| p.0 == color).count();
    for color in [FREE, LETHAL, INSCRIBED, UNKNOWN, [255; 3]] {
        assert!(count(color) > 200, "{color:?}: {} pixels", count(color));
    }
}
