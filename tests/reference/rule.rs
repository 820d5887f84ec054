//! The verdict of one cell in plain words (spec 4 §2, §3).

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lidar {
    Unknown,
    Free,
    Solid,
    Passable,
    Transparent,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Camera {
    Unknown,
    Free,
    Occupied,
}

/// What a layer's record holds: tick and sensor of its evidence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<T> {
    pub(crate) state: T,
    pub(crate) tick: u32,
    pub(crate) sensor: usize,
}

/// One cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    pub(crate) pane: Option<Seen<()>>,
    pub(crate) lidar: Option<Seen<Lidar>>,
    /// Lowest and highest crossing and the largest gap between two, metres above the ground.
    pub(crate) crossing: Option<[f64; 3]>,
    pub(crate) camera: Option<Seen<Camera>>,
    /// Lowest and highest hit, metres above the ground.
    pub(crate) hits: [f64; 2],
    pub(crate) mean_r: f64,
    /// Whether the ground drops away.
    pub(crate) drop: Option<Seen<()>>,
}

/// The switches.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Switches {
    pub(crate) passable_cost: u32,
    pub(crate) passable_over_camera: bool,
    /// None: never; else whether also of sure cameras.
    pub(crate) clears: Option<bool>,
}

/// Ages.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock<'a> {
    pub(crate) now: u32,
    pub(crate) fresh_since: &'a [u32],
    pub(crate) cell_timeout: u32,
}

/// (cost, row, sensor, age in tenths).
pub(crate) type Word = (u32, u32, Option<usize>, u32);

/// Beams prove the cell empty at both ends of the hits and in between.
fn refutes(cell: &Cell) -> bool {
    let Some([low, high, gap]) = cell.crossing else { return false };
    let end = |beyond: f64| beyond.abs() <= 0.03 || (beyond > 0.0 && gap <= 0.06);
    gap <= 0.1 && end(cell.hits[0] - low) && end(high - cell.hits[1])
}

/// The verdict.
pub(crate) fn rule(switches: &Switches, clock: &Clock<'_>, cell: &Cell) -> Word {
    let verdict = rule_of_layers(switches, clock, cell);
    match cell.drop {
        Some(drop) if verdict.0 != 254 => {
            (254, 12, Some(drop.sensor), (clock.now.saturating_sub(drop.tick) / 10).min(32767))
        }
        _ => verdict,
    }
}

fn rule_of_layers(switches: &Switches, clock: &Clock<'_>, cell: &Cell) -> Word {
    let age = |tick: u32| clock.now.saturating_sub(tick);
    let stale = |tick: u32, sensor: usize| {
        tick < clock.fresh_since[sensor] || (clock.cell_timeout > 0 && age(tick) > clock.cell_timeout)
    };
    let word = |cost, row, tick, sensor| (cost, row, Some(sensor), (age(tick) / 10).min(32767));
    let lidar = cell.lidar.map_or(Lidar::Unknown, |seen| seen.state);
    let camera = cell.camera.map_or(Camera::Unknown, |seen| seen.state);
    let by_lidar = |cost, row| cell.lidar.map(|seen| word(cost, row, seen.tick, seen.sensor)).unwrap();
    let by_camera = |cost, row| cell.camera.map(|seen| word(cost, row, seen.tick, seen.sensor)).unwrap();
    // Where the lidar's evidence is stale, a camera's that is fresh and says free stands in.
    let soft = |cost, row| {
        let seen = cell.lidar.unwrap();
        if !stale(seen.tick, seen.sensor) {
            return by_lidar(cost, row);
        }
        match cell.camera {
            Some(other) if camera == Camera::Free && !stale(other.tick, other.sensor) => by_camera(cost, row),
            _ => by_lidar(255, 11),
        }
    };
    if let Some(pane) = cell.pane {
        return word(254, 1, pane.tick, pane.sensor);
    }
    match (lidar, camera) {
        (Lidar::Solid, _) => by_lidar(254, 2),
        (Lidar::Transparent, _) => by_lidar(254, 3),
        (Lidar::Passable, Camera::Occupied) if switches.passable_over_camera => {
            soft(switches.passable_cost, 4)
        }
        (Lidar::Passable, Camera::Occupied) => by_camera(254, 4),
        (_, Camera::Occupied) => {
            let newer = cell.lidar.zip(cell.camera).is_some_and(|(lidar, camera)| lidar.tick > camera.tick);
            let may = switches.clears.is_some_and(|sure_too| sure_too || cell.mean_r < 0.6);
            if lidar == Lidar::Free && newer && may && refutes(cell) { soft(0, 5) } else { by_camera(254, 6) }
        }
        (Lidar::Passable, _) => soft(switches.passable_cost, 7),
        (Lidar::Free, _) => soft(0, 8),
        (Lidar::Unknown, Camera::Free) => {
            let seen = cell.camera.unwrap();
            if stale(seen.tick, seen.sensor) { by_camera(255, 11) } else { by_camera(0, 9) }
        }
        (Lidar::Unknown, Camera::Unknown) => (255, 10, None, 0),
    }
}
