//! Shortest ways over a grid of prices: A* of crate `pathfinding`, then straightened where a straight line costs no more.

use glam::DVec2;
use pathfinding::directed::astar::astar;

use crate::map::{Grid, MapUpdate};

/// Price of a cell that cannot be crossed.
pub const BLOCKED: u32 = u32::MAX;

/// Price of a free cell.
pub const FREE_PRICE: u32 = 100;

/// What the dearest cell that can be crossed costs more than a free one, as a multiple (Nav2's Smac planner: 2).
const COST_WEIGHT: u32 = 2;

/// Cost of a cell from which it cannot be crossed: Nav2's inscribed.
const INSCRIBED: u8 = 253;

/// Cost of an unknown cell.
const UNKNOWN: u8 = 255;

/// Where the goal's cell is blocked, a cell this near does as well, metres (Nav2's planner: 0.5).
const GOAL_TOLERANCE_M: f64 = 0.5;

/// Floor around window and goal that is planned over, metres.
const MARGIN_M: f64 = 3.0;

/// Lengths of steps, in hundredths of a cell.
const STRAIGHT: u32 = 100;
const DIAGONAL: u32 = 141;

/// Length between places at which a straight line is priced, cells.
const SAMPLE_CELLS: f64 = 0.5;

/// Prices of cells, row 0 = smallest y.
#[derive(Debug, Clone, PartialEq)]
pub struct Prices {
    /// Geometry of the cells.
    pub grid: Grid,
    /// [`FREE_PRICE`] and up, or [`BLOCKED`].
    pub cells: Vec<u32>,
}

/// Price of crossing a cell of that cost; unknown cells are as dear as the dearest known one.
pub fn price_of(cost: u8) -> u32 {
    match cost {
        UNKNOWN => FREE_PRICE * (1 + COST_WEIGHT),
        INSCRIBED.. => BLOCKED,
        cost => FREE_PRICE + FREE_PRICE * COST_WEIGHT * u32::from(cost) / 252,
    }
}

impl Prices {
    /// Of a costmap, and of unknown floor around it that reaches past robot and goal.
    pub fn around(map: &MapUpdate, robot: DVec2, goal: DVec2) -> Self {
        let (window, cell_m) = (&map.grid, map.grid.resolution_m);
        let low = DVec2::new(window.origin_x_m, window.origin_y_m);
        let high = low + DVec2::new(f64::from(window.width), f64::from(window.height)) * cell_m;
        let before = ((low - robot.min(goal) + MARGIN_M).max(DVec2::ZERO) / cell_m).ceil();
        let after = ((robot.max(goal) + MARGIN_M - high).max(DVec2::ZERO) / cell_m).ceil();
        let (left, below) = (whole(before.x), whole(before.y));
        let grid = Grid {
            origin_x_m: low.x - before.x * cell_m,
            origin_y_m: low.y - before.y * cell_m,
            resolution_m: cell_m,
            width: window.width + left + whole(after.x),
            height: window.height + below + whole(after.y),
        };
        let mut cells = vec![price_of(UNKNOWN); grid.width as usize * grid.height as usize];
        for (row, costs) in (0_u32..).zip(map.costmap.chunks_exact(window.width as usize)) {
            let first = (row + below) as usize * grid.width as usize + left as usize;
            for (cell, &cost) in cells[first..].iter_mut().zip(costs) {
                *cell = price_of(cost);
            }
        }
        Self { grid, cells }
    }

    /// Price at a place; outside is blocked.
    pub fn at(&self, place: DVec2) -> u32 {
        self.grid.cell_at(place.x, place.y).map_or(BLOCKED, |[x, y]| self.of(x, y))
    }

    fn of(&self, x: u32, y: u32) -> u32 {
        self.cells.get((y * self.grid.width + x) as usize).copied().unwrap_or(BLOCKED)
    }

    /// The cheapest way, from place to place, at most half a metre between two; `None` where there is none.
    pub fn way(&self, from: DVec2, to: DVec2) -> Option<Vec<DVec2>> {
        let (start, goal) = (self.grid.cell_at(from.x, from.y)?, self.grid.cell_at(to.x, to.y)?);
        let reach = if self.of(goal[0], goal[1]) == BLOCKED { GOAL_TOLERANCE_M } else { 0.0 };
        let reach_cells = reach / self.grid.resolution_m;
        let near = |cell: &[u32; 2]| {
            let [x, y] = [0, 1].map(|axis| f64::from(cell[axis].abs_diff(goal[axis])));
            x.hypot(y) <= reach_cells
        };
        let left = |cell: &[u32; 2]| octile(*cell, goal) * FREE_PRICE;
        let (cells, _) = astar(&start, |cell| self.steps(*cell), left, near)?;
        let mut way: Vec<DVec2> =
            cells.iter().map(|&[x, y]| DVec2::from_array(self.grid.centre_m(x, y))).collect();
        if let Some(first) = way.first_mut() {
            *first = from;
        }
        if reach == 0.0 {
            way.push(to);
        }
        Some(self.straightened(&way))
    }

    /// Cells beside one that can be entered, with the price of that; corners are not cut.
    fn steps(&self, [x, y]: [u32; 2]) -> impl IntoIterator<Item = ([u32; 2], u32)> {
        const AROUND: [(i32, i32); 8] =
            [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)];
        AROUND.into_iter().filter_map(move |(dx, dy)| {
            let (to_x, to_y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
            if to_x >= self.grid.width || to_y >= self.grid.height {
                return None;
            }
            let length = if dx != 0 && dy != 0 { DIAGONAL } else { STRAIGHT };
            let price = self.of(to_x, to_y);
            let cut = length == DIAGONAL && (self.of(x, to_y) == BLOCKED || self.of(to_x, y) == BLOCKED);
            (price != BLOCKED && !cut).then(|| ([to_x, to_y], length * price))
        })
    }

    /// The same way with straight lines in place of stairs, wherever these cost no more.
    fn straightened(&self, way: &[DVec2]) -> Vec<DVec2> {
        let mut paid = vec![0.0];
        for pair in way.windows(2) {
            let before = paid.last().copied().unwrap_or(0.0);
            paid.push(before + self.line(pair[0], pair[1]).unwrap_or(f64::INFINITY));
        }
        let mut corners: Vec<DVec2> = way.first().copied().into_iter().collect();
        let mut at = 0;
        while at + 1 < way.len() {
            let cheaper = |next: &usize| {
                self.line(way[at], way[*next]).is_some_and(|price| price <= (paid[*next] - paid[at]) * 1.001)
            };
            at = (at + 2..way.len()).rev().find(cheaper).unwrap_or(at + 1);
            corners.push(way[at]);
        }
        corners
    }

    /// Price of a straight line, metres times price; `None` where it is blocked (its own start apart).
    fn line(&self, from: DVec2, to: DVec2) -> Option<f64> {
        let length = from.distance(to);
        let steps = whole((length / (SAMPLE_CELLS * self.grid.resolution_m)).ceil()).max(1);
        let start = self.grid.cell_at(from.x, from.y);
        let mut sum = 0.0;
        for step in 1..=steps {
            let place = from.lerp(to, f64::from(step) / f64::from(steps));
            match self.at(place) {
                BLOCKED if self.grid.cell_at(place.x, place.y) != start => return None,
                BLOCKED => sum += f64::from(FREE_PRICE),
                price => sum += f64::from(price),
            }
        }
        Some(sum / f64::from(steps) * length)
    }
}

/// Length of the shortest way over free cells, hundredths of a cell.
fn octile(a: [u32; 2], b: [u32; 2]) -> u32 {
    let [x, y] = [0, 1].map(|axis| a[axis].abs_diff(b[axis]));
    STRAIGHT * (x.max(y) - x.min(y)) + DIAGONAL * x.min(y)
}

/// Length of a way, metres.
pub fn length_m(way: &[DVec2]) -> f64 {
    way.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// The place that lies `along_m` behind the place of the way nearest to `at`; its end where the way is shorter.
pub fn ahead(way: &[DVec2], at: DVec2, along_m: f64) -> Option<DVec2> {
    let (mut best, mut from) = (f64::INFINITY, (0, 0.0));
    for (index, pair) in way.windows(2).enumerate() {
        let along = pair[1] - pair[0];
        let share = ((at - pair[0]).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        let distance = at.distance(pair[0] + share * along);
        if distance < best {
            (best, from) = (distance, (index, share));
        }
    }
    let (index, share) = from;
    let mut left_m = along_m + share * way.get(index)?.distance(*way.get(index + 1)?);
    for pair in way[index..].windows(2) {
        let length = pair[0].distance(pair[1]);
        if left_m <= length && length > 0.0 {
            return Some(pair[0].lerp(pair[1], left_m / length));
        }
        left_m -= length;
    }
    way.last().copied()
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates; counts of cells")]
fn whole(value: f64) -> u32 {
    value as u32
}
