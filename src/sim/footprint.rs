//! Where things stand on the floor: distances for clearance, and cells for the true map.

use glam::DVec2;

use super::scene::{Cylinder, Outline, Scene};
use super::walls::walls;

/// What stands on a piece of floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// Centre, half lengths, cosine and sine of the yaw.
    Rectangle(DVec2, DVec2, DVec2),
    /// The ellipse in that.
    Oval(DVec2, DVec2, DVec2),
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
            // Short of its least curvature: good enough for clearances, right at 0.
            Self::Oval(center, half, turn) => {
                let local = turn.conjugate_rotate(at - center) / half;
                ((local.length() - 1.0) * half.min_element()).max(0.0)
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
    /// Whether a robot can pass it: grass, strings.
    pub(crate) passable: bool,
}

impl Footprint {
    fn solid(shape: Shape, span_m: [f64; 2], key: String) -> Self {
        Self { shape, span_m, key, glass: false, passable: false }
    }
}

/// Footprints of everything in the scene, walls included.
pub(crate) fn footprints(scene: &Scene) -> Vec<Footprint> {
    let is_glass = |name: &String| scene.materials.get(name).is_some_and(|m| m.transmission > 0.0);
    let mut all = Vec::new();
    for wall in walls(scene) {
        let [a, b] = wall.ends_m.map(DVec2::from_array);
        let key = format!("rooms[{}]", wall.room);
        all.push(Footprint::solid(Shape::Segment(a, b), [0.0, scene.ceiling_m], key));
    }
    for (index, block) in scene.boxes.iter().enumerate() {
        let (shape, span_m) = upright_box(block.center_m, block.size_m, block.yaw_rad);
        let glass = is_glass(&block.material);
        all.push(Footprint { glass, ..Footprint::solid(shape, span_m, format!("boxes[{index}]")) });
    }
    for (index, cylinder) in scene.cylinders.iter().enumerate() {
        let glass = is_glass(&cylinder.material);
        all.push(Footprint { glass, ..standing(cylinder, format!("cylinders[{index}]")) });
    }
    for (index, vessel) in scene.vessels.iter().enumerate() {
        let [x, y, _] = vessel.base_m;
        let shape = Shape::Disc(DVec2::new(x, y), vessel.radius_m());
        let key = format!("vessels[{index}]");
        let glass = is_glass(&vessel.material);
        all.push(Footprint { glass, ..Footprint::solid(shape, vessel.span_m(), key) });
    }
    for (index, pane) in scene.panes.iter().enumerate() {
        let (shape, span_m) = upright_plane(pane.center_m, [pane.width_m, pane.height_m], pane.yaw_rad);
        let glass = is_glass(&pane.material);
        all.push(Footprint { glass, ..Footprint::solid(shape, span_m, format!("panes[{index}]")) });
    }
    for (index, curtain) in scene.curtains.iter().enumerate() {
        let size_m = [curtain.width_m, curtain.height_m];
        let (shape, span_m) = upright_plane(curtain.center_m, size_m, curtain.yaw_rad);
        let key = format!("curtains[{index}]");
        all.push(Footprint { passable: true, ..Footprint::solid(shape, span_m, key) });
    }
    for (index, thicket) in scene.thickets.iter().enumerate().filter(|(_, t)| t.density_per_m3 > 0.0) {
        let (shape, span_m) = upright_box(thicket.center_m, thicket.size_m, thicket.yaw_rad);
        let shape = match (shape, thicket.outline) {
            (Shape::Rectangle(center, half, turn), Outline::Ellipsoid) => Shape::Oval(center, half, turn),
            (shape, _) => shape,
        };
        let key = format!("thickets[{index}]");
        all.push(Footprint { passable: !thicket.solid, ..Footprint::solid(shape, span_m, key) });
    }
    all
}

/// The footprint of an opaque cylinder.
pub(crate) fn standing(cylinder: &Cylinder, key: String) -> Footprint {
    let [x, y, z] = cylinder.base_m;
    Footprint::solid(Shape::Disc(DVec2::new(x, y), cylinder.radius_m), [z, z + cylinder.height_m], key)
}

/// Outline on the floor and span of heights of a box.
fn upright_box([x, y, z]: [f64; 3], [w, d, h]: [f64; 3], yaw_rad: f64) -> (Shape, [f64; 2]) {
    let half = DVec2::new(w, d) / 2.0;
    (Shape::Rectangle(DVec2::new(x, y), half, DVec2::from_angle(yaw_rad)), [z - h / 2.0, z + h / 2.0])
}

/// The same of a rectangle that faces `yaw_rad`.
fn upright_plane([x, y, z]: [f64; 3], [width_m, height_m]: [f64; 2], yaw_rad: f64) -> (Shape, [f64; 2]) {
    let (center, half) = (DVec2::new(x, y), DVec2::from_angle(yaw_rad).perp() * width_m / 2.0);
    (Shape::Segment(center - half, center + half), [z - height_m / 2.0, z + height_m / 2.0])
}
