//! The rolling window: what stays keeps its bits, what comes is unknown.

use bytemuck::cast_slice;
use limpid::Config;
use limpid::gpu::{Invocations, ShaderText};
use limpid::map::Window;
use limpid::stage::map::layers::Layers;
use limpid::stage::map::move_window::{params, shader};

use crate::reference::move_window::Kept;
use crate::support::gpu::{Fragment, SENTINEL, skipped};
use crate::support::random::Random;

const SIDE: u32 = 9;

/// The pass of a camera in a map of cameras alone.
fn of_cameras() -> ShaderText {
    shader(Layers { cameras: true, ..Layers::default() }, true)
}

/// Of a cell that the window keeps, its marks too.
fn marks_of(cells: &[[u32; 4]]) -> Vec<[u32; 2]> {
    cells.iter().map(|cell| [cell[2], cell[3]]).collect()
}

fn fragment(side: u32, window: Window, cells: &[[u32; 4]]) -> Fragment {
    Fragment::new()
        .params("move_window_params", &params(&window, side))
        .changed("cells", cells)
        .changed("cell_marks", &marks_of(cells))
        .output("cell_hits", cells.len() * 4)
        .output("seen_through", cells.len())
        .output("counters", 8)
}

/// The ring of cells after the move; asserts that their marks move with them, and that the frame's sums are cleared.
fn moved(side: u32, window: Window, cells: &[[u32; 4]]) -> Vec<[u32; 4]> {
    let invocations = Invocations::area(side.max(8), side);
    let out = fragment(side, window, cells).run(of_cameras(), invocations);
    assert!(
        ["cell_hits", "seen_through", "counters"]
            .iter()
            .flat_map(|name| out.words(name))
            .all(|&word| word == 0)
    );
    let after: Vec<[u32; 4]> = cast_slice(out.words("cells")).to_vec();
    assert_eq!(out.words("cell_marks"), marks_of(&after).as_flattened());
    after
}

fn random_cells(side: u32, random: &mut Random) -> Vec<[u32; 4]> {
    (0..side * side).map(|_| [0; 4].map(|_: u32| random.next() as u32)).collect()
}

fn slot(side: u32, cell: [i64; 2]) -> usize {
    let [x, y] = cell.map(|c| c.rem_euclid(i64::from(side)) as usize);
    y * side as usize + x
}

fn window(origin: [i64; 2], shift: [i32; 2]) -> Window {
    Window { origin, shift, forget: false }
}

#[test]
fn truth_one_cell_to_the_right_forgets_one_column() {
    if skipped() {
        return;
    }
    let before = random_cells(SIDE, &mut Random(3));
    let after = moved(SIDE, window([-3, 14], [1, 0]), &before);
    for y in 14..23 {
        for x in -3..5 {
            assert_eq!(after[slot(SIDE, [x, y])], before[slot(SIDE, [x, y])], "cell ({x}, {y}) stays");
        }
        assert_eq!(after[slot(SIDE, [5, y])], [0; 4], "cell (5, {y}) is new");
    }
}

#[test]
fn truth_no_move_changes_nothing_and_forget_all() {
    if skipped() {
        return;
    }
    let before = random_cells(SIDE, &mut Random(4));
    assert_eq!(moved(SIDE, window([100, -100], [0, 0]), &before), before);
    let forget = Window { origin: [5, 5], shift: [0, 0], forget: true };
    assert!(moved(SIDE, forget, &before).iter().all(|cell| *cell == [0; 4]));
    assert!(moved(SIDE, window([9, 5], [9, 0]), &before).iter().all(|cell| *cell == [0; 4]));
    assert!(moved(SIDE, window([9, 5], [0, -9]), &before).iter().all(|cell| *cell == [0; 4]));
}

#[test]
fn twin_on_a_random_walk() {
    if skipped() {
        return;
    }
    let mut random = Random(11);
    let config = Config { map_size_m: 0.45, ..Config::default() };
    let mut ring = vec![[SENTINEL; 4]; (SIDE * SIDE) as usize];
    let mut kept = Kept::<[u32; 4]>::default();
    let (mut x_m, mut y_m, mut last) = (0.3, -0.2, None);
    for _ in 0..12 {
        let now = Window::around(x_m, y_m, config.resolution_m, SIDE, last);
        ring = moved(SIDE, now, &ring);
        kept.move_to(now.origin, i64::from(SIDE));
        for y in now.origin[1]..now.origin[1] + i64::from(SIDE) {
            for x in now.origin[0]..now.origin[0] + i64::from(SIDE) {
                assert_eq!(ring[slot(SIDE, [x, y])], kept.get([x, y]), "cell ({x}, {y})");
                let mark = [0; 4].map(|_: u32| random.next() as u32);
                kept.cells.insert([x, y], mark);
                ring[slot(SIDE, [x, y])] = mark;
            }
        }
        x_m += f64::from(random.unit()) * 0.6 - 0.3;
        y_m += f64::from(random.unit()) * 0.6 - 0.3;
        last = Some(now);
    }
}

#[test]
fn the_window_is_centred_by_whole_cells_and_saturates() {
    let config = Config::default();
    let at = |x, y, before| Window::around(x, y, config.resolution_m, 240, before);
    assert_eq!(at(0.0, -0.001, None), Window { origin: [-120, -121], shift: [0, 0], forget: true });
    let first = at(0.0, 0.0, None);
    assert_eq!(at(0.049, 0.051, Some(first)).shift, [0, 1]);
    assert_eq!(at(1e300, -1e300, Some(first)).shift, [240, -240]);
    assert!(at(f64::NAN, 0.0, Some(first)).origin_slot(240).iter().all(|&slot| slot < 240));
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    fragment(1, window([0, 0], [0, 0]), &[[1; 4]]).refuses_nothing(of_cameras());
    for side in [1, 7, 8, 9] {
        let before = random_cells(side, &mut Random(6));
        assert_eq!(moved(side, window([2, 3], [0, 0]), &before), before);
        let all = i32::try_from(side).unwrap();
        assert!(moved(side, window([2, 3], [all, 0]), &before).iter().all(|cell| *cell == [0; 4]));
    }
}

#[test]
fn poison_in_the_ring_is_kept_or_forgotten_but_not_read() {
    if skipped() {
        return;
    }
    let nan = [f32::NAN.to_bits(), u32::MAX, u32::MAX, u32::MAX];
    let before = vec![nan; (SIDE * SIDE) as usize];
    let after = moved(SIDE, window([0, 0], [0, 4]), &before);
    assert_eq!(after.iter().filter(|cell| **cell == nan).count(), 9 * 5);
    assert_eq!(after.iter().filter(|cell| **cell == [0; 4]).count(), 9 * 4);
    let huge = window([i64::MAX - 9, i64::MIN], [0, 0]);
    assert_eq!(moved(SIDE, huge, &before), before);
}

#[test]
fn all_layers_of_a_map_move_alike() {
    if skipped() {
        return;
    }
    let window = window([-3, 14], [1, -2]);
    let mut random = Random(12);
    for bits in 1..32_u32 {
        let layers = Layers {
            cameras: bits & 1 != 0,
            lidars: bits & 2 != 0,
            panes: bits & 4 != 0,
            drops: bits & 8 != 0,
            looks: bits & 16 != 0,
        };
        let before: Vec<(&str, Vec<u32>)> = layers
            .buffers()
            .map(|(name, bytes)| {
                let words = (SIDE * SIDE) as usize * bytes as usize / 4;
                (name, (0..words).map(|_| random.next() as u32 | 1).collect())
            })
            .collect();
        for frame in [true, false] {
            let mut fragment = Fragment::new().params("move_window_params", &params(&window, SIDE));
            for (name, words) in &before {
                fragment = fragment.changed(name, words);
            }
            if frame {
                let cells = (SIDE * SIDE) as usize;
                fragment = fragment
                    .output("cell_hits", 4 * cells)
                    .output("seen_through", cells)
                    .output("counters", 8);
            }
            let out = fragment.run(shader(layers, frame), Invocations::area(SIDE, SIDE));
            for (name, words) in &before {
                let each = words.len() / (SIDE * SIDE) as usize;
                for (x, y) in (0..9).flat_map(|y| (0..9).map(move |x| (x, y))) {
                    let at = each * slot(SIDE, [x - 3, y + 14]);
                    let stays = x < 8 && y >= 2;
                    let want = if stays { words[at..at + each].to_vec() } else { vec![0; each] };
                    assert_eq!(out.words(name)[at..at + each], want, "{name} at ({x}, {y})");
                }
            }
            let sums = ["cell_hits", "seen_through", "counters"];
            assert!(!frame || sums.iter().flat_map(|name| out.words(name)).all(|&word| word == 0));
        }
    }
}
