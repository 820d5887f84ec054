//! FOR, FSR and obstacle recall, counted by hand on small maps.

use limpid::map::Grid;
use limpid::offline::eval::{MapTally, TrueWindow};
use limpid::sim::truth::{FREE, GLASS, OCCUPIED, TruthFrame, UNKNOWN};
use limpid::{Config, Error};

/// Costs reach two cells: 254, then 253 at one cell (0.05 m), then 252 exp(-10 (d - 0.05)).
fn config() -> Config {
    Config { inflation_radius_m: 0.1, inscribed_radius_m: 0.05, ..Config::default() }
}

fn grid(width: u32, height: u32) -> Grid {
    Grid { origin_x_m: 1.0, origin_y_m: -0.5, resolution_m: 0.05, width, height }
}

fn truth(grid: Grid, cells: &[i8]) -> TruthFrame {
    let (depth_m, material) = (vec![1.0], vec![1]);
    TruthFrame { stamp_ns: 0, width: 1, height: 1, depth_m, material, grid, cells: cells.to_vec() }
}

/// A row of ten cells: free but for an obstacle at 5 and what is unknown from 9 on.
const ROW: [i8; 10] = [FREE, FREE, FREE, FREE, FREE, OCCUPIED, FREE, FREE, FREE, UNKNOWN];

fn row() -> TrueWindow {
    TrueWindow::new(&truth(grid(10, 1), &ROW), &grid(10, 1), &config()).unwrap()
}

fn tally(costmap: &[u8], truth: &TrueWindow) -> MapTally {
    let mut tally = MapTally::default();
    tally.observe(costmap, truth).unwrap();
    tally
}

#[test]
fn truth_is_inflated_by_the_maps_own_law() {
    // exp(-10 * 0.05) * 252 = 152.8.
    assert_eq!(row().costs, [0, 0, 0, 152, 253, 254, 253, 152, 0, 255]);
    // Unknown is overwritten only from 253 up.
    let cells = [UNKNOWN, UNKNOWN, UNKNOWN, OCCUPIED, GLASS, UNKNOWN];
    let window = TrueWindow::new(&truth(grid(6, 1), &cells), &grid(6, 1), &config()).unwrap();
    assert_eq!(window.costs, [255, 255, 253, 254, 254, 253]);
    // In the plane, by Euclidean distance: the corner of 2 x 2 cells is 0.0707 m off.
    let mut square = [FREE; 9];
    square[0] = OCCUPIED;
    let window = TrueWindow::new(&truth(grid(3, 3), &square), &grid(3, 3), &config()).unwrap();
    assert_eq!(window.costs, [254, 253, 152, 253, 204, 0, 152, 0, 0]);
}

#[test]
fn a_false_obstacle_blocks_the_free_cells_around_it_but_for_borders() {
    // Of cells 0 to 2 and 8 the border's neighbours 2 and 8 are left out.
    let blocked: Vec<u16> = (0..10).map(|cell| row().free_within(cell, 2)).collect();
    assert_eq!(blocked, [2, 2, 2, 1, 0, 0, 0, 0, 0, 0]);
    // In the plane a disc of radius 2 has 13 cells; at the edge and in the corner of the window less of it is there.
    let open = TrueWindow::new(&truth(grid(7, 7), &[FREE; 49]), &grid(7, 7), &config()).unwrap();
    assert_eq!([24, 21, 0].map(|cell| open.free_within(cell, 2)), [13, 9, 6]);
}

#[test]
fn a_perfect_map_scores_perfectly() {
    let perfect = tally(&row().costs, &row());
    // F_gt: cells 0, 1, 2 and 8; cells 2 and 8 lie beside the border, 1 a cell further.
    assert_eq!(perfect.free, [4, 2, 1]);
    for margin in 0..3 {
        assert_eq!(perfect.false_occupied_rate(margin), Some(0.0));
        assert_eq!(perfect.free_space_recall(margin), Some(1.0));
    }
    assert_eq!((perfect.obstacle_recall(), perfect.near_obstacle_recall()), (Some(1.0), Some(1.0)));
    assert_eq!(perfect.glass_recall(), None);
}

#[test]
fn counts_by_hand() {
    // The obstacle a cell too near (lethal at 4), a phantom's foot at 0, cell 1 unknown.
    let shifted = tally(&[7, 255, 152, 253, 254, 253, 152, 0, 0, 255], &row());
    assert_eq!(shifted.free, [4, 2, 1]);
    assert_eq!(shifted.free_called_occupied, [2, 1, 1]);
    assert_eq!(shifted.free_called_free, [1, 0, 0]);
    assert_eq!((shifted.false_occupied_rate(0), shifted.false_occupied_rate(1)), (Some(0.5), Some(0.5)));
    assert_eq!((shifted.free_space_recall(0), shifted.free_space_recall(1)), (Some(0.25), Some(0.0)));
    // Not lethal where it stands, but beside.
    assert_eq!((shifted.obstacle_recall(), shifted.near_obstacle_recall()), (Some(0.0), Some(1.0)));
}

#[test]
fn wrong_cells_are_told_apart() {
    // A row of twelve free cells with an obstacle at each end: a phantom four cells from the first, one five from both.
    let mut cells = [FREE; 12];
    (cells[0], cells[11]) = (OCCUPIED, OCCUPIED);
    let window = TrueWindow::new(&truth(grid(12, 1), &cells), &grid(12, 1), &config()).unwrap();
    let of = |lethal: &[usize], first: u8, last: u8| {
        let mut costmap = [0; 12];
        (costmap[0], costmap[11]) = (first, last);
        lethal.iter().for_each(|&cell| costmap[cell] = 254);
        tally(&costmap, &window)
    };
    let phantoms = of(&[4, 5, 6], 254, 254);
    assert_eq!((phantoms.lethal_too_near, phantoms.lethal_in_the_open), (1, 2));
    assert_eq!(phantoms.largest_loss(), Some(("lethal in the open", 1.0)));
    let missed = of(&[], 255, 0);
    assert_eq!((missed.missed_unknown, missed.missed_known), (1, 1));
    assert_eq!(of(&[1], 255, 255).missed_unknown, 1, "beside a lethal cell it is not missed");
    assert_eq!(of(&[], 254, 254).largest_loss(), None);
    let mut sum = phantoms;
    sum.add(&missed);
    assert_eq!(
        (sum.lethal_too_near, sum.lethal_in_the_open, sum.missed_unknown, sum.missed_known),
        (1, 2, 1, 1)
    );
}

#[test]
fn an_empty_map_scores_best_but_for_recall() {
    let empty = tally(&[0; 10], &row());
    assert_eq!((empty.false_occupied_rate(1), empty.free_space_recall(1)), (Some(0.0), Some(1.0)));
    assert_eq!((empty.obstacle_recall(), empty.near_obstacle_recall()), (Some(0.0), Some(0.0)));
    let unknown = tally(&[255; 10], &row());
    assert_eq!((unknown.false_occupied_rate(1), unknown.free_space_recall(1)), (Some(0.0), Some(0.0)));
}

#[test]
fn glass_counts_apart_and_keeps_its_surroundings() {
    let cells = [FREE, FREE, FREE, FREE, GLASS, OCCUPIED];
    let window = TrueWindow::new(&truth(grid(6, 1), &cells), &grid(6, 1), &config()).unwrap();
    let missed = tally(&[0, 0, 0, 0, 0, 254], &window);
    assert_eq!((missed.solid, missed.solid_lethal, missed.glass, missed.glass_lethal), (1, 1, 1, 0));
    assert_eq!(missed.free, [2, 1, 0], "cells near glass are not free");
    let mut sum = missed;
    sum.add(&tally(&[0, 0, 0, 0, 254, 254], &window));
    assert_eq!((sum.glass_recall(), sum.obstacle_recall(), sum.free), (Some(0.5), Some(1.0), [4, 2, 0]));
}

#[test]
fn the_window_is_cut_out_of_the_true_map() {
    // Two cells to the right and one up, and one row and column beyond the true map.
    let true_cells: Vec<i8> = (0..12).map(|i| if i == 6 { OCCUPIED } else { FREE }).collect();
    let window = Grid { origin_x_m: 1.1, origin_y_m: -0.45, width: 3, height: 3, ..grid(4, 3) };
    let cut = TrueWindow::new(&truth(grid(4, 3), &true_cells), &window, &config()).unwrap();
    let unknown = UNKNOWN;
    assert_eq!(cut.cells, [OCCUPIED, FREE, unknown, FREE, FREE, unknown, unknown, unknown, unknown]);
}

#[test]
fn maps_that_do_not_fit_are_refused() {
    let error = |window: Grid| TrueWindow::new(&truth(grid(10, 1), &ROW), &window, &config()).unwrap_err();
    let coarse = error(Grid { resolution_m: 0.1, ..grid(10, 1) });
    assert!(matches!(&coarse, Error::Input { reason, .. } if reason.contains("0.1 m")), "{coarse}");
    let across = error(Grid { origin_x_m: 1.02, ..grid(10, 1) });
    assert!(matches!(&across, Error::Input { reason, .. } if reason.contains("across")), "{across}");
    let nowhere = error(Grid { origin_x_m: f64::NAN, ..grid(10, 1) });
    assert!(matches!(nowhere, Error::Input { .. }));
    let error = MapTally::default().observe(&[0; 3], &row()).unwrap_err();
    assert!(matches!(&error, Error::Input { reason, .. } if reason.contains("3 cells")), "{error}");
}
