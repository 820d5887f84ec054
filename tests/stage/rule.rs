//! The rule: its table, and its verdicts cell by cell.

use limpid::config::LidarClearsCamera;
use limpid::gpu::{Invocations, ShaderText};
use limpid::map::CellClass;
use limpid::map::Verdict;
use limpid::map::rule::*;
use limpid::stage::map::layers::Layers;
use limpid::stage::map::rule::{RuleMoment, params, shader};

use crate::reference::rule::{self as twin, Camera, Cell, Clock, Lidar, Seen, Switches, Word};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const ALL: Layers = Layers { cameras: true, looks: false, lidars: true, panes: true, drops: true };
const HEIGHT_MIN_M: f64 = 0.1;
const SWITCHES: Switches = Switches { passable_cost: 50, passable_over_camera: false, clears: Some(false) };

fn settings(switches: &Switches) -> RuleSettings {
    RuleSettings {
        passable_cost: switches.passable_cost,
        passable_over_camera: switches.passable_over_camera,
        lidar_clears_camera: match switches.clears {
            None => LidarClearsCamera::Never,
            Some(false) => LidarClearsCamera::Doubtful,
            Some(true) => LidarClearsCamera::Always,
        },
    }
}

/// The records of a cell: (cells, cell_marks, solid_cells, pane_cells, drop_cells).
type Records = ([u32; 4], [u32; 2], [u32; 4], [u32; 2], [u32; 4]);

fn records(cell: &Cell) -> Records {
    let sensor = |sensor: usize| (sensor as u32 + 1) << 24;
    let camera = cell.camera.map_or(([0; 4], [0; 2]), |seen| {
        let state = [Camera::Unknown, Camera::Free, Camera::Occupied].iter().position(|s| *s == seen.state);
        let top = ((cell.hits[1] - HEIGHT_MIN_M) * 65536.0).round() as u32 + 2;
        let low = ((cell.hits[0] - HEIGHT_MIN_M) * 1024.0).round() as u32;
        let mean_r = (cell.mean_r * 255.0).round() as u32;
        ([0, state.unwrap() as u32 | 0x300, 1, top], [seen.tick, low | mean_r << 16 | sensor(seen.sensor)])
    });
    let solid = cell.lidar.map_or([0; 4], |seen| {
        let class = match seen.state {
            Lidar::Unknown => CellClass::Unknown,
            Lidar::Free => CellClass::Free,
            Lidar::Solid => CellClass::Solid,
            Lidar::Passable => CellClass::Passable,
            Lidar::Transparent => CellClass::Transparent,
        };
        let steps = |m: f64| ((m + 32.0) * 1024.0).round() as u32;
        let [low, high, gap] = cell.crossing.unwrap_or([-32.0, -32.0, 0.0]);
        let heights = steps(low) | steps(high) << 16;
        [class as u32 | 7 << 20, seen.tick, heights, (gap * 1024.0).round() as u32 | sensor(seen.sensor)]
    });
    let pane = cell.pane.map_or([0; 2], |seen| [3 | sensor(seen.sensor), seen.tick]);
    // One that was a drop and is none any more has a record, too.
    let drop = cell.drop.map_or([5, 7, sensor(3), 9], |seen| [5, seen.tick, sensor(seen.sensor) | 1, 0]);
    (camera.0, camera.1, solid, pane, drop)
}

fn fragment(cells: &[Cell], side: u32, origin_slot: [u32; 2], clock: &Clock<'_>, layers: Layers) -> Fragment {
    let params = params(&RuleMoment {
        side,
        origin_slot,
        now: clock.now,
        fresh_since: clock.fresh_since,
        cell_timeout: clock.cell_timeout,
        height_min_m: HEIGHT_MIN_M as f32,
    });
    let records: Vec<_> = cells.iter().map(records).collect();
    let of = |i: usize| {
        let [x, y] = [i as u32 % side, i as u32 / side];
        let slot = |at: u32, first: u32| (at + side - first) % side;
        (slot(y, origin_slot[1]) * side + slot(x, origin_slot[0])) as usize
    };
    // Slot by slot: the record of the window cell that lies there.
    let ring: Vec<Records> = (0..cells.len()).map(|slot| records[of(slot)]).collect();
    let mut fragment = Fragment::new().params("rule_params", &params).output("verdicts", cells.len());
    if layers.cameras {
        fragment = fragment
            .input("cells", &ring.iter().map(|r| r.0).collect::<Vec<_>>())
            .input("cell_marks", &ring.iter().map(|r| r.1).collect::<Vec<_>>());
    }
    if layers.lidars {
        fragment = fragment.input("solid_cells", &ring.iter().map(|r| r.2).collect::<Vec<_>>());
    }
    if layers.panes {
        fragment = fragment.input("pane_cells", &ring.iter().map(|r| r.3).collect::<Vec<_>>());
    }
    if layers.drops {
        fragment = fragment.input("drop_cells", &ring.iter().map(|r| r.4).collect::<Vec<_>>());
    }
    fragment
}

fn words(out: &[u32]) -> Vec<Word> {
    let word = |&word: &u32| {
        let verdict = Verdict(word);
        (verdict.cost().into(), verdict.row(), verdict.sensor(), (verdict.age_s() * 10.0).round() as u32)
    };
    out.iter().map(word).collect()
}

fn run(text: ShaderText, cells: &[Cell], side: u32, clock: &Clock<'_>, layers: Layers) -> Vec<Word> {
    let out =
        fragment(cells, side, [2 % side, 5 % side], clock, layers).run(text, Invocations::area(side, side));
    words(out.words("verdicts"))
}

const EMPTY: Cell =
    Cell { pane: None, lidar: None, crossing: None, camera: None, hits: [0.3, 0.5], mean_r: 1.0, drop: None };

fn lidar(state: Lidar) -> Cell {
    Cell { lidar: Some(Seen { state, tick: 900, sensor: 1 }), ..EMPTY }
}

fn camera(state: Camera) -> Cell {
    Cell { camera: Some(Seen { state, tick: 800, sensor: 0 }), ..EMPTY }
}

/// Free by a lidar whose beams lie dense, occupied by a doubtful camera before.
fn refuted() -> Cell {
    Cell {
        lidar: lidar(Lidar::Free).lidar,
        crossing: Some([0.1, 0.9, 0.05]),
        camera: camera(Camera::Occupied).camera,
        mean_r: 0.5,
        ..EMPTY
    }
}

/// The ground drops away there.
fn drop(cell: Cell) -> Cell {
    Cell { drop: Some(Seen { state: (), tick: 950, sensor: 4 }), ..cell }
}

const CLOCK: Clock<'static> = Clock { now: 1000, fresh_since: &[0; 16], cell_timeout: 0 };

/// What one cell gets.
fn one(switches: &Switches, clock: &Clock<'_>, cell: Cell) -> Word {
    let got = run(shader(ALL, &settings(switches), 16), &[cell], 1, clock, ALL)[0];
    assert_eq!(got, twin::rule(switches, clock, &cell), "{cell:?}");
    got
}

#[test]
fn every_row_applies_in_a_case_and_its_negative_does_not() {
    if skipped() {
        return;
    }
    let with_camera = |cell: Cell, state| Cell { camera: camera(state).camera, ..cell };
    let pane = Cell { pane: Some(Seen { state: (), tick: 990, sensor: 2 }), ..lidar(Lidar::Solid) };
    let apart = Cell { crossing: Some([0.1, 0.9, 0.11]), ..refuted() };
    for (cell, want, negative) in [
        (pane, (254, 1, Some(2), 1), lidar(Lidar::Solid)),
        (with_camera(lidar(Lidar::Solid), Camera::Free), (254, 2, Some(1), 10), lidar(Lidar::Free)),
        (lidar(Lidar::Transparent), (254, 3, Some(1), 10), lidar(Lidar::Passable)),
        (
            with_camera(lidar(Lidar::Passable), Camera::Occupied),
            (254, 4, Some(0), 20),
            lidar(Lidar::Passable),
        ),
        (refuted(), (0, 5, Some(1), 10), apart),
        (apart, (254, 6, Some(0), 20), refuted()),
        (with_camera(lidar(Lidar::Passable), Camera::Free), (50, 7, Some(1), 10), lidar(Lidar::Free)),
        (lidar(Lidar::Free), (0, 8, Some(1), 10), camera(Camera::Free)),
        (camera(Camera::Free), (0, 9, Some(0), 20), EMPTY),
        (camera(Camera::Unknown), (255, 10, None, 0), camera(Camera::Free)),
        (drop(EMPTY), (254, 12, Some(4), 5), EMPTY),
        (drop(lidar(Lidar::Free)), (254, 12, Some(4), 5), drop(lidar(Lidar::Solid))),
        (drop(refuted()), (254, 12, Some(4), 5), refuted()),
    ] {
        assert_eq!(one(&SWITCHES, &CLOCK, cell), want);
        assert_ne!(one(&SWITCHES, &CLOCK, negative).1, want.1, "the negative of row {}", want.1);
    }
    assert_eq!(one(&SWITCHES, &CLOCK, EMPTY), (255, 10, None, 0));
}

#[test]
fn refuting_needs_beams_at_the_hits_after_them_and_doubt() {
    if skipped() {
        return;
    }
    let row = |cell| one(&SWITCHES, &CLOCK, cell).1;
    let crossing = |low, high, gap| Cell { crossing: Some([low, high, gap]), ..refuted() };
    assert_eq!(row(crossing(0.328, 0.472, 0.09)), 5, "within 0.03 m of both ends");
    assert_eq!(row(crossing(0.335, 0.5, 0.05)), 6, "nothing near the lowest hit");
    assert_eq!(row(crossing(0.3, 0.465, 0.05)), 6, "nothing near the highest");
    assert_eq!(row(crossing(0.2, 0.9, 0.09)), 6, "no beam need have passed near either end");
    assert_eq!(row(crossing(0.2, 0.9, 0.058)), 5, "some beam has");
    assert_eq!(row(Cell { crossing: None, ..refuted() }), 6, "no heights are known");
    let tick = |tick| Cell { lidar: Some(Seen { state: Lidar::Free, tick, sensor: 1 }), ..refuted() };
    assert_eq!((row(tick(801)), row(tick(800)), row(tick(10))), (5, 6, 6), "newer than the hits");
    let sure = Cell { mean_r: 0.61, ..refuted() };
    assert_eq!(row(sure), 6);
    assert_eq!(one(&Switches { clears: Some(true), ..SWITCHES }, &CLOCK, sure).1, 5);
    assert_eq!(one(&Switches { clears: None, ..SWITCHES }, &CLOCK, refuted()).1, 6);
    let both = Cell { camera: camera(Camera::Occupied).camera, ..lidar(Lidar::Passable) };
    let over = Switches { passable_over_camera: true, passable_cost: 77, ..SWITCHES };
    assert_eq!(one(&over, &CLOCK, both), (77, 4, Some(1), 10));
}

#[test]
fn stale_free_and_passable_cells_are_unknown_and_lethal_ones_stay() {
    if skipped() {
        return;
    }
    let mut fresh_since = [0; 16];
    fresh_since[1] = u32::MAX;
    let lidar_out = Clock { fresh_since: &fresh_since, ..CLOCK };
    assert_eq!(one(&SWITCHES, &lidar_out, lidar(Lidar::Free)), (255, 11, Some(1), 10));
    assert_eq!(one(&SWITCHES, &lidar_out, lidar(Lidar::Passable)), (255, 11, Some(1), 10));
    assert_eq!(one(&SWITCHES, &lidar_out, refuted()).1, 11);
    assert_eq!(one(&SWITCHES, &lidar_out, lidar(Lidar::Solid)).1, 2);
    assert_eq!(one(&SWITCHES, &lidar_out, drop(lidar(Lidar::Free))).1, 12, "a drop stays");
    let both = |state| Cell { camera: camera(Camera::Free).camera, ..lidar(state) };
    assert_eq!(one(&SWITCHES, &lidar_out, both(Lidar::Free)), (0, 8, Some(0), 20), "a camera saw through it");
    assert_eq!(one(&SWITCHES, &lidar_out, both(Lidar::Passable)), (50, 7, Some(0), 20));
    fresh_since[0] = u32::MAX;
    let all_out = Clock { fresh_since: &fresh_since, ..CLOCK };
    assert_eq!(one(&SWITCHES, &all_out, both(Lidar::Free)).1, 11);
    assert_eq!(one(&SWITCHES, &all_out, camera(Camera::Free)), (255, 11, Some(0), 20));
    assert_eq!(one(&SWITCHES, &all_out, camera(Camera::Occupied)).1, 6);
    fresh_since[0] = 800;
    let since = Clock { fresh_since: &fresh_since, ..CLOCK };
    assert_eq!(one(&SWITCHES, &since, camera(Camera::Free)).1, 9, "seen since it came back");
    fresh_since[0] = 801;
    let later = Clock { fresh_since: &fresh_since, ..CLOCK };
    assert_eq!(one(&SWITCHES, &later, camera(Camera::Free)).1, 11);
    for (cell_timeout, row) in [(199, 11), (200, 9), (0, 9)] {
        assert_eq!(one(&SWITCHES, &Clock { cell_timeout, ..CLOCK }, camera(Camera::Free)).1, row);
    }
}

fn random_cell(random: &mut Random) -> Cell {
    let seen = |random: &mut Random| (random.below(1100) + 1, random.below(16) as usize);
    let lidars =
        [Lidar::Unknown, Lidar::Free, Lidar::Free, Lidar::Solid, Lidar::Passable, Lidar::Transparent];
    let cameras = [Camera::Unknown, Camera::Free, Camera::Occupied, Camera::Occupied];
    let (lidar, camera) = (lidars[random.below(6) as usize], cameras[random.below(4) as usize]);
    let [(a, b), (c, d), (e, f)] = [seen(random), seen(random), seen(random)];
    // Heights are whole steps, and none lies at a limit.
    let step = |steps: u32| f64::from(steps * 8 + 1) / 1024.0;
    let low = HEIGHT_MIN_M + step(random.below(30));
    let low_m = step(random.below(60));
    let crossing = [low_m, step(30 + random.below(60)).max(low_m), step(random.below(16))];
    Cell {
        pane: random.chance(0.1).then_some(Seen { state: (), tick: a, sensor: b }),
        lidar: (lidar != Lidar::Unknown).then_some(Seen { state: lidar, tick: c, sensor: d }),
        crossing: random.chance(0.8).then_some(crossing),
        camera: random.chance(0.8).then_some(Seen { state: camera, tick: e, sensor: f }),
        hits: [low, low + step(random.below(20))],
        mean_r: f64::from(random.below(256)) / 255.0,
        drop: random.chance(0.1).then(|| Seen { state: (), tick: a + 1, sensor: f }),
    }
}

#[test]
fn twin_at_all_sizes_and_switches() {
    if skipped() {
        return;
    }
    let mut rows = [0; 13];
    for (number, side) in [1, 7, 8, 9, 33].into_iter().enumerate() {
        let mut random = Random(60 + number as u64);
        for (clears, passable_over_camera) in [(None, false), (Some(false), true), (Some(true), false)] {
            let switches = Switches { passable_cost: 50, passable_over_camera, clears };
            let cells: Vec<Cell> = (0..side * side).map(|_| random_cell(&mut random)).collect();
            let fresh_since: Vec<u32> =
                (0..16).map(|_| [0, 500, u32::MAX][random.below(3) as usize]).collect();
            let clock = Clock { now: 1000, fresh_since: &fresh_since, cell_timeout: [0, 700][number % 2] };
            let got = run(shader(ALL, &settings(&switches), 16), &cells, side, &clock, ALL);
            let want: Vec<Word> = cells.iter().map(|cell| twin::rule(&switches, &clock, cell)).collect();
            for (at, (got, want)) in got.iter().zip(&want).enumerate() {
                assert_eq!(got, want, "side {side}, {switches:?}, {:?}", cells[at]);
                rows[want.1 as usize] += 1;
            }
        }
    }
    assert!(rows[1..].iter().all(|count| *count > 3), "all rows occur: {rows:?}");
}

#[test]
fn layers_that_a_map_lacks_say_nothing() {
    if skipped() {
        return;
    }
    let mut random = Random(77);
    let cells: Vec<Cell> = (0..81).map(|_| random_cell(&mut random)).collect();
    for bits in 1..16_u32 {
        let layers = Layers {
            cameras: bits & 1 != 0,
            lidars: bits & 2 != 0,
            panes: bits & 4 != 0,
            drops: bits & 8 != 0,
            looks: false,
        };
        let got = run(shader(layers, &settings(&SWITCHES), 16), &cells, 9, &CLOCK, layers);
        let heard = |cell: &Cell| Cell {
            pane: cell.pane.filter(|_| layers.panes),
            lidar: cell.lidar.filter(|_| layers.lidars),
            camera: cell.camera.filter(|_| layers.cameras),
            drop: cell.drop.filter(|_| layers.drops),
            ..*cell
        };
        let want: Vec<Word> = cells.iter().map(|cell| twin::rule(&SWITCHES, &CLOCK, &heard(cell))).collect();
        assert_eq!(got, want, "{layers:?}");
    }
}

#[test]
fn poison_gives_verdicts_of_the_table() {
    if skipped() {
        return;
    }
    let side = 9_u32;
    let words = |words: usize| vec![u32::MAX; 81 * words];
    let clock = Clock { now: 0, ..CLOCK };
    let filled = |layers: Layers| {
        let mut fragment = fragment(&[EMPTY; 81], side, [0, 0], &clock, Layers::default());
        for (name, bytes) in layers.buffers() {
            fragment = fragment.input(name, &words(bytes as usize / 4));
        }
        fragment.run(shader(layers, &settings(&SWITCHES), 16), Invocations::area(side, side))
    };
    for layers in [ALL, Layers { panes: false, ..ALL }, Layers { cameras: true, ..Layers::default() }] {
        for verdict in filled(layers).words("verdicts") {
            let verdict = Verdict(*verdict);
            assert!((1..=12).contains(&verdict.row()), "{verdict:?}");
            assert!([0, 50, 254, 255].contains(&verdict.cost()), "{verdict:?}");
        }
    }
}

#[test]
fn the_table_is_that_of_the_specification() {
    let numbers: Vec<u32> = ROWS.iter().map(|row| row.number).collect();
    assert_eq!(numbers, (1..=13).collect::<Vec<_>>());
    let count = |state: CellClass| CLASS_STATES[state as usize];
    assert_eq!(count(CellClass::Solid), lidar::SOLID);
    assert_eq!(count(CellClass::Passable), lidar::PASSABLE);
    assert_eq!(count(CellClass::Transparent), lidar::TRANSPARENT);
    assert_eq!((count(CellClass::Unknown), count(CellClass::Free)), (lidar::UNKNOWN, lidar::FREE));
    let text = rule_markdown();
    assert_eq!(text.lines().count(), 15);
    let source = include_str!("../../src/map/rule.rs");
    let documented =
        source.lines().filter_map(|line| line.strip_prefix("//! |")).map(|line| format!("|{line}"));
    assert_eq!(documented.collect::<Vec<_>>(), text.lines().collect::<Vec<_>>(), "the module's own table");
    for line in [
        "| 1 | pane | any | any | glass | 254 |",
        "| 2 | none | solid | any | solid | 254 |",
        "| 4 | none | passable | occupied | occupied, or passable with `passable_over_camera` | 254, or the passable cost with `passable_over_camera` |",
        "| 8 | none | free | unknown or free | free | 0 |",
        "| 11 | any verdict of free or passable whose evidence is stale | | | stale | 255 |",
        "| 12 | any verdict that is not lethal, where the ground drops away | | | drop | 254 |",
    ] {
        assert!(text.lines().any(|written| written == line), "{line}\n{text}");
    }
}

#[test]
fn every_combination_of_states_has_a_row_and_the_order_matters() {
    let default = RuleSettings::default();
    let lidars = CLASS_STATES.into_iter().chain([lidar::FREE | lidar::REFUTING]);
    let cameras = CELL_STATES.into_iter().chain([camera::OCCUPIED | camera::DOUBTFUL]);
    let states: Vec<[u32; 3]> = [panes::NONE, panes::PANE]
        .into_iter()
        .flat_map(|pane| lidars.clone().map(move |lidar| (pane, lidar)))
        .flat_map(|(pane, lidar)| cameras.clone().map(move |camera| [pane, lidar, camera]))
        .collect();
    assert_eq!(states.len(), 2 * 6 * 4);
    let row_of = |rows: &[Row], [panes, lidar, camera]: [u32; 3]| {
        rows.iter().find(|r| r.panes & panes != 0 && r.lidar & lidar != 0 && r.camera & camera != 0).copied()
    };
    let mut reversed = ROWS;
    reversed.reverse();
    let mut changed = 0;
    for state in &states {
        let [panes, lidar, camera] = *state;
        let row = rule(&default, panes, lidar, camera).expect("a row");
        assert_eq!(Some(row), row_of(&ROWS, *state));
        changed += usize::from(row_of(&reversed, *state) != Some(row));
    }
    assert!(changed > 0, "rows overlap, so that their order counts");
}
