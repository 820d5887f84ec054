//! Whether intensities may call things passable: walls stay solid whatever their scale (spec 2 §3).

use limpid::Config;
use limpid::base::Rigid;
use limpid::config::{LayerMeasure, Solidity};
use limpid::map::CellClass;
use limpid::mapper::{Mapper, Options, SensorInfo};
use limpid::sensor::{Columns, Point, Scan, SensorPose};

use crate::support::gpu::skipped;
use crate::support::random::Random;
use crate::support::scan::{ScanFrame, ScanOutput, open, point, posed, scan, step};

/// The lidar stands this high.
const LIDAR_M: f64 = 0.4;
const WALL: f64 = 200.0;
const GRASS: f64 = 60.0;
const FLOOR: f64 = 20.0;

/// A room of 6 by 6 m with a floor, and tall grass in a corner: that is where no returns stand above each other.
fn room(index: u64, [wall, grass, floor]: [f64; 3]) -> Scan {
    let steps = |from: f64, to: f64, step: f64| {
        let count = ((to - from) / step).round() as u32;
        (0..=count).map(move |i| from + f64::from(i) * step)
    };
    let mut points = Vec::new();
    for along in steps(-2.97, 2.97, 0.06) {
        for z in steps(-0.35, 0.45, 0.1) {
            for [x, y] in [[2.97, along], [-2.97, along], [along, 2.97], [along, -2.97]] {
                points.push(point([x, y, z], wall));
            }
        }
    }
    for x in steps(-2.5, 2.5, 0.1) {
        points.extend(steps(-2.5, 0.9, 0.1).map(|y| point([x + 0.05, y + 0.05, -LIDAR_M], floor)));
    }
    let mut random = Random(7);
    for _ in 0..150 {
        let mut within = |low: f64, span: f64| low + span * f64::from(random.unit());
        points.push(point([within(1.0, 1.5), within(1.2, 1.3), within(-0.1, 0.2)], grass));
    }
    scan(index, points)
}

fn at_height(scan: Scan) -> ScanFrame {
    let map_from_base = Rigid::new([0.0, 0.0, LIDAR_M], [0.0, 0.0, 0.0, 1.0]).unwrap();
    posed(scan, SensorPose { map_from_base, base_from_sensor: Rigid::IDENTITY, sweep: None })
}

fn config() -> Config {
    // The floor is told from what stands by the stated ground alone.
    let ground = limpid::config::GroundSource::Stated;
    let gamma = Some(0.5);
    Config { ground, gamma, layer_heights_m: vec![-0.5, 0.0, 0.5], ..Config::default() }
}

fn run(config: &Config, scan: Scan) -> (ScanOutput, String) {
    let frame = at_height(scan);
    let mut pipeline = open(config, &frame);
    let out = step(&mut pipeline, &frame);
    (out, pipeline.mapper.notes()[0].clone())
}

fn class(out: &ScanOutput, x: f64, y: f64) -> u8 {
    out.classes[crate::support::scan::cell(out, x, y)]
}

fn is(class: u8, wanted: CellClass) -> bool {
    class == wanted as u8
}

/// Cells of walls that are not solid, of grass that are solid, and of the floor that are solid.
fn faults(out: &ScanOutput) -> [usize; 3] {
    let middles = |from: f64, count: u32| (0..count).map(move |i| from + 0.05 + 0.1 * f64::from(i));
    let walls = middles(-2.9, 58).flat_map(|at| [[2.95, at], [-2.95, at], [at, 2.95], [at, -2.95]]);
    let grass = middles(1.0, 15).flat_map(|x| middles(1.2, 13).map(move |y| [x, y]));
    let floor = middles(-2.5, 50).flat_map(|x| middles(-2.5, 34).map(move |y| [x, y]));
    let solid = |[x, y]: &[f64; 2]| is(class(out, *x, *y), CellClass::Solid);
    [walls.filter(|at| !solid(at)).count(), grass.filter(solid).count(), floor.filter(solid).count()]
}

fn scaled(factor: f64) -> [f64; 3] {
    [WALL * factor, GRASS * factor, FLOOR * factor]
}

#[test]
fn intensities_that_fit_tell_grass_from_walls() {
    if skipped() {
        return;
    }
    let (out, note) = run(&config(), room(0, scaled(1.0)));
    assert_eq!(faults(&out), [0, 0, 0], "{note}");
    assert!(out.count(CellClass::Passable) > 1000 && note == "full scale of intensities: 255 as configured");
    // In fine cells few returns lie, and the walls still bear the scale out.
    let fine = Config { scan_resolution_m: 0.02, scan_map_size_m: 8.0, inflation_length_m: 0.3, ..config() };
    assert!(run(&fine, room(0, scaled(1.0))).1.starts_with("full scale"));
    let sum = Config { layer_measure: LayerMeasure::Sum, gamma: Some(100.0), ..config() };
    assert!(run(&sum, room(0, scaled(1.0))).1.starts_with("full scale"), "in the measure's own unit");
}

#[test]
fn whatever_the_scale_walls_are_solid_the_floor_is_not_and_the_note_names_the_key() {
    if skipped() {
        return;
    }
    let absent = Scan { columns: Columns { intensity: false, ..Columns::default() }, ..room(0, scaled(0.0)) };
    let automatic = Config { intensity_full_scale: 0.0, ..config() };
    let high = Config { gamma: Some(0.95), ..config() };
    let cases: [(&Config, Scan, &str); 9] = [
        (&config(), absent, "`intensity_field`"),
        (&config(), room(0, scaled(0.0)), "the intensity is 0 in every return"),
        (&config(), room(0, [77.0; 3]), "the intensity is 77 in every return"),
        (&config(), room(0, [250.0; 3]), "the intensity is 250 in every return"),
        (&config(), room(0, scaled(1.0 / 255.0)), "`intensity_full_scale` 255"),
        (&config(), room(0, scaled(257.0)), "above the full scale of 255"),
        (&config(), room(0, scaled(-1.0)), "`intensity_full_scale` 255"),
        (&automatic, room(0, scaled(0.0)), "the intensity is 0 in every return"),
        (&high, room(0, scaled(1.0)), "0 % are above `gamma` 0.95"),
    ];
    for (case, (config, scan, part)) in cases.into_iter().enumerate() {
        let (out, note) = run(config, scan);
        let [walls, grass, floor] = faults(&out);
        assert_eq!([walls, floor], [0, 0], "case {case}: {note}");
        assert!(grass > 50, "what stands is solid, case {case}: {note}");
        assert!(note.contains("nothing is passable") && note.contains(part), "case {case}: {note}");
    }
}

#[test]
fn the_user_s_word_holds() {
    if skipped() {
        return;
    }
    let dim = room(0, scaled(0.1));
    let by = |solidity| run(&Config { solidity, ..config() }, dim.clone());
    let (out, note) = by(Solidity::Intensity);
    assert!(out.count(CellClass::Solid) == 0 && note.starts_with("full scale"), "{note}");
    let bright = run(&Config { solidity: Solidity::Standing, ..config() }, room(0, scaled(1.0)));
    assert!(faults(&bright.0)[1] > 50 && bright.1.contains("solidity: standing"), "{}", bright.1);
}

#[test]
fn few_returns_of_many_decide_a_cell_and_an_unknown_floor_leaves_nothing_out() {
    if skipped() {
        return;
    }
    // One return of a post among thirty of the floor around its foot.
    let mut points = vec![point([1.05, 0.05, -LIDAR_M], 0.0); 30];
    points.push(point([1.05, 0.05, -0.2], 0.0));
    points.push(point([1.55, 0.05, -LIDAR_M], 0.0));
    let (out, note) = run(&config(), scan(0, points.clone()));
    assert!(is(class(&out, 1.05, 0.05), CellClass::Solid), "{note}");
    assert!(is(class(&out, 1.55, 0.05), CellClass::Passable), "the floor: {note}");
    let own = crate::support::scan::still(scan(0, points));
    let out = step(&mut open(&config(), &own), &own);
    assert!(is(class(&out, 1.55, 0.05), CellClass::Solid), "no height of the lidar is known");
}

/// A scan of nothing but a floor.
fn open_space(index: u64) -> Scan {
    let whole = room(index, scaled(1.0));
    let points = whole.points.iter().filter(|point| f64::from(point.intensity) == FLOOR);
    Scan { points: points.copied().collect(), ..whole }
}

#[test]
fn what_is_seen_later_turns_the_verdict_twice_at_most() {
    if skipped() {
        return;
    }
    let first = at_height(open_space(0));
    let mut pipeline = open(&config(), &first);
    let mut grass_is_solid = |scan: Scan| faults(&step(&mut pipeline, &at_height(scan)))[1] > 50;
    let mut numbers = 1..;
    let mut next = |factor: f64| room(numbers.next().unwrap(), scaled(factor));
    assert!(!grass_is_solid(open_space(0)), "there is none");
    // Walls bear the scale out at once; dim ones then contradict it when they outweigh these, and for good.
    assert!(!grass_is_solid(next(1.0)));
    let turned = (0..6).position(|_| grass_is_solid(next(0.1))).unwrap();
    assert!(turned > 0, "one bad scan is not believed");
    for _ in 0..20 {
        assert!(grass_is_solid(next(1.0)), "it does not flicker");
    }
    let note = &pipeline.mapper.notes()[0];
    assert!(note.contains("nothing is passable") && note.contains("`gamma`"), "{note}");
}

#[test]
fn each_lidar_is_judged_by_its_own_scans() {
    if skipped() {
        return;
    }
    let scans = [room(0, scaled(1.0)), room(0, scaled(1.0 / 255.0))];
    let infos = [0, 1].map(|at: usize| SensorInfo {
        name: format!("lidar {at}"),
        ..SensorInfo::lidar(&config(), scans[at].clone())
    });
    let mut mapper = Mapper::open(&config(), &infos, &Options::default()).unwrap();
    for (sensor, scan) in scans.into_iter().enumerate() {
        let observation = limpid::Observation { sensor, ..at_height(scan).observation() };
        assert_eq!(mapper.submit(&observation).unwrap(), limpid::Submitted::Taken);
    }
    while mapper.wait().unwrap().is_some() {}
    let notes = mapper.notes();
    let of = |name: &str| notes.iter().find(|note| note.starts_with(name)).unwrap();
    assert!(of("lidar 0: ").contains("full scale of intensities: 255"), "{notes:?}");
    assert!(of("lidar 1: ").contains("nothing is passable"), "{notes:?}");
}

#[test]
fn what_cannot_be_measured_is_no_reason_to_trust() {
    if skipped() {
        return;
    }
    // A handful of upright cells says nothing.
    let points: Vec<Point> = (0..9).map(|i| point([1.05, 0.05, 0.05 * f64::from(i)], 200.0)).collect();
    let (_, note) = run(&config(), scan(0, [points, vec![point([2.0, 0.0, 0.1], 3.0)]].concat()));
    assert!(note.contains("too little stands upright (1 cells)") && note.contains("solidity"), "{note}");
    let (out, note) = run(&config(), scan(0, Vec::new()));
    assert!(out.count(CellClass::Solid) == 0 && note.contains("no return has been seen"), "{note}");
}
