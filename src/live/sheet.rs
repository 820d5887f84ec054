//! The costmap as Nav2's StaticLayer wants it (spec 5 §2): a grid with a margin whose origin holds while the window moves inside
//! it, and rectangles of it. A full map makes the layer not current for a cycle, so it is sent only when it must be.

use std::collections::VecDeque;

use crate::map::Grid;

/// Occupancy of a cell of which nothing is known, as a byte.
const UNKNOWN: u8 = (-1_i8).cast_unsigned();

/// How far from a whole cell the origins of two grids of one lattice may lie, cells.
const OFF_LATTICE: f64 = 0.01;

/// An update covers so many windows before it too: one that was overtaken by the full map is made good by the next.
const LATELY: usize = 10;

/// A rectangle of cells of the sheet: first column and row, columns and rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Rectangle {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

impl Rectangle {
    /// The smallest that holds both.
    fn and(self, other: Self) -> Self {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        let right = (self.x + self.width).max(other.x + other.width);
        let top = (self.y + self.height).max(other.y + other.height);
        Self { x, y, width: right - x, height: top - y }
    }
}

/// What is to be sent.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Page {
    /// The whole grid.
    Full {
        /// With the margin.
        grid: Grid,
        /// Occupancies as bytes, row by row.
        data: Vec<u8>,
    },
    /// A rectangle of the grid that was sent last.
    Update {
        /// First column.
        x: u32,
        /// First row.
        y: u32,
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Occupancies as bytes, row by row.
        data: Vec<u8>,
    },
}

/// See the module.
#[derive(Debug, Clone, Default)]
pub(super) struct Sheet {
    margin_m: f64,
    /// What was sent in full last: the frame, and the grid.
    sent: Option<(String, Grid)>,
    /// Whether the next page is a full one all the same.
    whole: bool,
    /// Where the window was in it lately, the newest last.
    windows: VecDeque<Rectangle>,
}

impl Sheet {
    pub(super) fn new(margin_m: f64) -> Self {
        Self { margin_m, ..Self::default() }
    }

    /// The next page is a full one: somebody came who has missed updates. Its grid stays where the window is still inside, so
    /// that updates which overtake it fit those who have the grid of before.
    pub(super) fn begin_anew(&mut self) {
        self.whole = true;
    }

    /// What to send of a window with `occupancy` as bytes, row by row.
    pub(super) fn turn(&mut self, frame: &str, window: &Grid, occupancy: &[u8]) -> Page {
        if let Some((sent_frame, grid)) = &self.sent
            && sent_frame == frame
            && let Some(now) = place(grid, window)
        {
            let all = self.windows.iter().fold(now, |all, &before| all.and(before));
            self.windows.push_back(now);
            if self.windows.len() > LATELY {
                self.windows.pop_front();
            }
            if std::mem::take(&mut self.whole) {
                let grid = *grid;
                return Page::Full { grid, data: framed(grid.width, grid.height, now, occupancy) };
            }
            let inside = Rectangle { x: now.x - all.x, y: now.y - all.y, ..now };
            let data = framed(all.width, all.height, inside, occupancy);
            return Page::Update { x: all.x, y: all.y, width: all.width, height: all.height, data };
        }
        let grid = self.with_margin(window);
        let margin = (grid.width - window.width) / 2;
        let inside = Rectangle { x: margin, y: margin, width: window.width, height: window.height };
        self.sent = Some((frame.into(), grid));
        self.whole = false;
        self.windows = VecDeque::from([inside]);
        Page::Full { grid, data: framed(grid.width, grid.height, inside, occupancy) }
    }

    fn with_margin(&self, window: &Grid) -> Grid {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few thousand cells at most"
        )]
        let margin = (self.margin_m / window.resolution_m).round() as u32;
        let shift_m = f64::from(margin) * window.resolution_m;
        Grid {
            origin_x_m: window.origin_x_m - shift_m,
            origin_y_m: window.origin_y_m - shift_m,
            width: window.width + 2 * margin,
            height: window.height + 2 * margin,
            resolution_m: window.resolution_m,
        }
    }
}

/// Where a window lies in a grid, if it does.
fn place(grid: &Grid, window: &Grid) -> Option<Rectangle> {
    if grid.resolution_m != window.resolution_m {
        return None;
    }
    let along = |window_m: f64, grid_m: f64, cells: u32, of: u32| {
        let cell = (window_m - grid_m) / grid.resolution_m;
        let whole = cell.round();
        let fits =
            (cell - whole).abs() < OFF_LATTICE && whole >= 0.0 && whole + f64::from(cells) <= f64::from(of);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 0..=of")]
        fits.then_some(whole as u32)
    };
    Some(Rectangle {
        x: along(window.origin_x_m, grid.origin_x_m, window.width, grid.width)?,
        y: along(window.origin_y_m, grid.origin_y_m, window.height, grid.height)?,
        width: window.width,
        height: window.height,
    })
}

/// A grid of so many cells, unknown but for the rectangle that holds `occupancy`.
fn framed(width: u32, height: u32, inside: Rectangle, occupancy: &[u8]) -> Vec<u8> {
    let mut data = vec![UNKNOWN; width as usize * height as usize];
    let rows = occupancy.chunks_exact((inside.width as usize).max(1)).take(inside.height as usize);
    for (row, cells) in rows.enumerate() {
        let start = (inside.y as usize + row) * width as usize + inside.x as usize;
        data[start..start + cells.len()].copy_from_slice(cells);
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(x_m: f64, y_m: f64) -> Grid {
        Grid { origin_x_m: x_m, origin_y_m: y_m, resolution_m: 0.5, width: 3, height: 2 }
    }

    /// What a subscriber holds that has taken all pages: the grid, and its cells.
    #[derive(Default)]
    struct Subscriber(Option<(Grid, Vec<u8>)>);

    impl Subscriber {
        fn take(&mut self, page: Page) -> bool {
            match page {
                Page::Full { grid, data } => {
                    assert_eq!(data.len(), (grid.width * grid.height) as usize);
                    self.0 = Some((grid, data));
                    true
                }
                Page::Update { x, y, width, height, data } => {
                    let (grid, cells) = self.0.as_mut().unwrap();
                    assert_eq!(data.len(), (width * height) as usize);
                    for (at, &cell) in (0..).zip(&data) {
                        let (column, row) = (x + at % width, y + at / width);
                        cells[(row * grid.width + column) as usize] = cell;
                    }
                    false
                }
            }
        }

        /// Occupancy at a place; unknown outside.
        fn at(&self, x_m: f64, y_m: f64) -> u8 {
            let (grid, cells) = self.0.as_ref().unwrap();
            grid.cell_at(x_m, y_m)
                .map_or(UNKNOWN, |[column, row]| cells[(row * grid.width + column) as usize])
        }
    }

    #[test]
    fn a_subscriber_holds_the_window_and_nothing_else_wherever_it_moves() {
        let (mut sheet, mut subscriber) = (Sheet::new(1.0), Subscriber::default());
        let path = [
            (0.0, 0.0),
            (0.5, 0.0),
            (1.0, 1.0),
            (-1.0, -1.0),
            (-1.5, -1.0),
            (7.0, 3.0),
            (7.5, 2.5),
            (6.0, 2.0),
        ];
        let mut full = Vec::new();
        for (number, &(x_m, y_m)) in (1..).zip(&path) {
            let page = sheet.turn("map", &window(x_m, y_m), &[number; 6]);
            full.push(subscriber.take(page));
            for column in -20..40 {
                for row in -20..30 {
                    let at = (f64::from(column) * 0.5 + 0.25, f64::from(row) * 0.5 + 0.25);
                    let inside = window(x_m, y_m).cell_at(at.0, at.1).is_some();
                    assert_eq!(
                        subscriber.at(at.0, at.1),
                        if inside { number } else { UNKNOWN },
                        "{number}: {at:?}"
                    );
                }
            }
        }
        // In full only where the window leaves the margin of 1 m around where it was sent in full last.
        assert_eq!(full, [true, false, false, false, true, true, false, false]);
    }

    #[test]
    fn another_frame_resolution_or_lattice_and_a_newcomer_have_a_full_map() {
        let turned = |sheet: &mut Sheet, frame: &str, grid: Grid| {
            matches!(sheet.turn(frame, &grid, &[0; 6]), Page::Full { .. })
        };
        let mut sheet = Sheet::new(1.0);
        assert!(turned(&mut sheet, "map", window(0.0, 0.0)));
        assert!(!turned(&mut sheet, "map", window(0.0, 0.0)));
        assert!(turned(&mut sheet, "odom", window(0.0, 0.0)));
        assert!(turned(&mut sheet, "odom", window(0.2, 0.0)), "off the lattice");
        assert!(turned(&mut sheet, "odom", Grid { resolution_m: 0.25, ..window(0.0, 0.0) }));
        assert!(!turned(&mut sheet, "odom", Grid { resolution_m: 0.25, ..window(0.25, 0.0) }));
        sheet.begin_anew();
        let page = sheet.turn("odom", &Grid { resolution_m: 0.25, ..window(0.25, 0.0) }, &[0; 6]);
        let Page::Full { grid, .. } = page else { panic!("{page:?}") };
        assert_eq!(grid.origin_x_m, -1.0, "the grid stays, so that updates fit who has it already");
        assert!(!turned(&mut sheet, "odom", Grid { resolution_m: 0.25, ..window(0.25, 0.0) }));
    }
}
