//! Walls around the union of a scene's rooms.

use super::scene::Scene;

/// A straight piece of wall from floor to ceiling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Wall {
    /// Its ends on the floor, metres.
    pub(crate) ends_m: [[f64; 2]; 2],
    /// Unit normal into the room.
    pub(crate) normal: [f64; 2],
    /// The room whose material it has.
    pub(crate) room: usize,
}

/// Whether a point lies in a room.
pub(crate) fn is_inside(scene: &Scene, x_m: f64, y_m: f64) -> bool {
    room_at(scene, x_m, y_m).is_some()
}

fn room_at(scene: &Scene, x_m: f64, y_m: f64) -> Option<usize> {
    scene.rooms.iter().position(|room| {
        (room.min_m[0]..room.max_m[0]).contains(&x_m) && (room.min_m[1]..room.max_m[1]).contains(&y_m)
    })
}

/// All coordinates along an axis at which rooms begin or end.
fn lines(scene: &Scene, axis: usize) -> Vec<f64> {
    let mut lines: Vec<f64> = scene.rooms.iter().flat_map(|r| [r.min_m[axis], r.max_m[axis]]).collect();
    lines.sort_by(f64::total_cmp);
    lines.dedup();
    lines
}

/// The walls, none in the open air: between a cell of the rooms' lines that is inside and one that is not.
pub(crate) fn walls(scene: &Scene) -> Vec<Wall> {
    if scene.open_air {
        return Vec::new();
    }
    let lines = [lines(scene, 0), lines(scene, 1)];
    let mut walls = Vec::new();
    for across in 0..2 {
        let along = 1 - across;
        for &at in &lines[across] {
            let mut row: Vec<Wall> = Vec::new();
            for piece in lines[along].windows(2) {
                let Some(wall) = piece_of_wall(scene, across, at, [piece[0], piece[1]]) else { continue };
                match row.last_mut() {
                    Some(last) if joins(last, &wall) => last.ends_m[1] = wall.ends_m[1],
                    _ => row.push(wall),
                }
            }
            walls.extend(row);
        }
    }
    walls
}

fn joins(last: &Wall, next: &Wall) -> bool {
    last.ends_m[1] == next.ends_m[0] && last.normal == next.normal && last.room == next.room
}

/// The wall on the line `across` = `at` between two coordinates along it, if exactly one side is inside.
fn piece_of_wall(scene: &Scene, across: usize, at: f64, along_m: [f64; 2]) -> Option<Wall> {
    const ASIDE_M: f64 = 1e-6;
    let middle = f64::midpoint(along_m[0], along_m[1]);
    let room_beside = |offset: f64| {
        if across == 0 { room_at(scene, at + offset, middle) } else { room_at(scene, middle, at + offset) }
    };
    let (room, side) = match (room_beside(-ASIDE_M), room_beside(ASIDE_M)) {
        (Some(room), None) => (room, -1.0),
        (None, Some(room)) => (room, 1.0),
        _ => return None,
    };
    let point = |along: f64| if across == 0 { [at, along] } else { [along, at] };
    let normal = if across == 0 { [side, 0.0] } else { [0.0, side] };
    Some(Wall { ends_m: along_m.map(point), normal, room })
}
