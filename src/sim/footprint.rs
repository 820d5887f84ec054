//! Where things stand on the floor: distances for clearance, and cells for the true map.

use glam::DVec2;

use super::scene::Scene;
use super::walls::walls;

/// What stands on a piece of floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// Centre, half lengths, cosine and sine of the yaw.
    Rectangle(DVec2, DVec2, DVec2),
    /// Centre and radius.
    Disc(DVec2, f64),
    /// From one end to the other.
    Segment(DVec2, DVec2),
}

impl Shape {
    /// Distance of a point from the shape, 0 inside, metres.
    pub(crate) fn distance_m(&self, at: DVec2) -> f64 {
        match *self {
            Self::Rectangle(center, half, turn) => {
                let local = turn.conjugate_rotate(at - center);
                (local.abs() - half).max(DVec2::ZERO).length()
            }
            Self::Disc(center, radius) => (at.distance(center) - radius).max(0.0),
            Self::Segment(a, b) => {
                let along = b - a;
                let share = ((at - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                at.distance(a + share * along)
            }
        }
    }
}

trait Turn {
    fn conjugate_rotate(self, v: DVec2) -> DVec2;
}

impl Turn for DVec2 {
    /// `v` turned back by this unit vector.
    fn conjugate_rotate(self, v: DVec2) -> DVec2 {
        DVec2::new(self.x * v.x + self.y * v.y, self.x * v.y - self.y * v.x)
    }
}

/// A thing's footprint, its span of heights, and what it is.
#[derive(Debug, Clone)]
pub(crate) struct Footprint {
    /// On the floor.
    pub(crate) shape: Shape,
    /// From bottom to top, metres.
    pub(crate) span_m: [f64; 2],
    /// Key in the scene.
    pub(crate) key: String,
    /// Whether it is a glass pane.
    pub(crate) glass: bool,
}

/// Footprints of everything in the scene, walls included.
pub(crate) fn footprints(scene: &Scene) -> Vec<Footprint> {
    let is_glass = |name: &String| scene.materials.get(name).is_some_and(|m| m.transmission > 0.0);
    let mut all = Vec::new();
    for wall in walls(scene) {
        let [a, b] = wall.ends_m.map(DVec2::from_array);
        let key = format!("rooms[{}]", wall.room);
        all.push(Footprint {
            shape: Shape::Segment(a, b),
            span_m: [0.0, scene.ceiling_m],
            key,
            glass: false,
        });
    }
    for (index, block) in scene.boxes.iter().enumerate() {
        let [x, y, z] = block.center_m;
        let [w, d, h] = block.size_m;
        let shape =
            Shape::Rectangle(DVec2::new(x, y), DVec2::new(w, d) / 2.0, DVec2::from_angle(block.yaw_rad));
        let span_m = [z - h / 2.0, z + h / 2.0];
        all.push(Footprint {
            shape,
            span_m,
            key: format!("boxes[{index}]"),
            glass: is_glass(&block.material),
        });
    }
    for (index, cylinder) in scene.cylinders.iter().enumerate() {
        let [x, y, z] = cylinder.base_m;
        let shape = Shape::Disc(DVec2::new(x, y), cylinder.radius_m);
        let (span_m, key) = ([z, z + cylinder.height_m], format!("cylinders[{index}]"));
        all.push(Footprint { shape, span_m, key, glass: is_glass(&cylinder.material) });
    }
    for (index, pane) in scene.panes.iter().enumerate() {
        let [x, y, z] = pane.center_m;
        let half = DVec2::from_angle(pane.yaw_rad).perp() * pane.width_m / 2.0;
        let center = DVec2::new(x, y);
        let shape = Shape::Segment(center - half, center + half);
        let span_m = [z - pane.height_m / 2.0, z + pane.height_m / 2.0];
        all.push(Footprint {
            shape,
            span_m,
            key: format!("panes[{index}]"),
            glass: is_glass(&pane.material),
        });
    }
    all
}
