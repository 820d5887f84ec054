//! Building a scene piece by piece, keeping pieces apart.

use glam::DVec2;

use super::{Physics, Random};
use crate::sim::footprint::{Shape, footprints};
use crate::sim::material::{Kind, Material, Pattern};
use crate::sim::scene::{Ambient, Block, Cylinder, Lamp, Pane, Room, Scene, Thicket, Trajectory, Window};
use crate::sim::settings::{Camera, Imager, Matcher};
use crate::sim::walls::{Wall, walls};

/// A scene under construction.
pub(super) struct Layout<'a> {
    pub(super) scene: Scene,
    pub(super) random: &'a mut Random,
    pub(super) physics: Physics,
}

impl<'a> Layout<'a> {
    /// Empty rooms with the camera's mount drawn from the spec's ranges.
    pub(super) fn new(rooms: Vec<Room>, physics: Physics, random: &'a mut Random) -> Self {
        let camera = Camera {
            pitch_rad: random.within(0.25, 0.40),
            height_m: random.within(0.35, 0.60),
            ..Camera::default()
        };
        let trajectory = Trajectory {
            waypoints_m: vec![],
            yaw_rad: 0.0,
            step_m: random.within(0.02, 0.04),
            turn_rad: random.within(0.02, 0.05),
            rate_hz: 30.0,
            frames: 1,
            clearance_m: 0.3,
        };
        let day = random.within(0.9, 1.1);
        let scene = Scene {
            name: String::new(),
            seed: 0,
            materials: [("glass".into(), Material::glass())].into(),
            floor: "floor".into(),
            ceiling: "ceiling".into(),
            ceiling_m: random.within(2.5, 3.1),
            rooms,
            boxes: vec![],
            cylinders: vec![],
            walkers: Vec::new(),
            panes: vec![],
            thickets: vec![],
            curtains: vec![],
            open_air: false,
            vessels: vec![],
            sun: None,
            lidar: None,
            lamps: vec![],
            windows: vec![],
            ambient: Ambient { color: [0.3 * day, 0.3, 0.3 / day], infrared: physics.ambient_infrared },
            trajectory,
            camera,
            imager: Imager::default(),
            matcher: Matcher::default(),
        };
        Self { scene, random, physics }
    }

    /// A colour: `tone` in the mean, tinted; and a reflectance in the infrared, where dyes differ less.
    pub(super) fn color(&mut self, tone: f64, tint: f64) -> ([f64; 3], f64) {
        let color = [0; 3].map(|_| (tone * self.random.within(1.0 - tint, 1.0 + tint)).clamp(0.02, 0.9));
        (color, (0.25 + 0.7 * tone * self.random.within(0.8, 1.2)).clamp(0.05, 0.85))
    }

    /// A matt material, with a pattern or without.
    pub(super) fn matt(&mut self, name: &str, tone: f64, pattern: Pattern, scale_m: f64) {
        let (albedo, albedo_ir) = self.color(tone, 0.15);
        let other = tone * self.random.within(0.4, 0.8);
        let pattern_ir = self.color(other, 0.0).1;
        let shade = self.random.within(0.9, 1.1);
        let pattern_albedo =
            [albedo[0] * shade, albedo[1], albedo[2] / shade].map(|c| (c * other / tone).min(0.9));
        let material = Material {
            kind: if pattern == Pattern::None { Kind::Diffuse } else { Kind::Textured },
            albedo,
            albedo_ir,
            pattern,
            pattern_albedo,
            pattern_albedo_ir: albedo_ir + 0.5 * (pattern_ir - albedo_ir),
            pattern_scale_m: scale_m,
            ..Material::default()
        };
        self.scene.materials.insert(name.into(), material);
    }

    /// The floor of the level, with a pattern.
    pub(super) fn floor(&mut self, pattern: Pattern, scale_m: f64) {
        let physics = self.physics;
        let tone = physics.floor_albedo;
        let warm = self.random.within(1.0, 1.25);
        let material = Material {
            kind: if physics.floor_reflectance > 0.0 { Kind::Glossy } else { Kind::Textured },
            albedo: [tone * warm, tone, tone / warm].map(|c| c.min(0.9)),
            albedo_ir: tone,
            pattern,
            pattern_albedo: [0.6 * tone * warm, 0.6 * tone, 0.6 * tone / warm],
            pattern_albedo_ir: 0.92 * tone,
            pattern_scale_m: scale_m,
            reflectance: physics.floor_reflectance,
            roughness: physics.floor_roughness,
            ..Material::default()
        };
        self.scene.materials.insert("floor".into(), material);
    }

    /// Whether a shape keeps `gap_m` from everything that stands there, and lies in a room.
    fn fits(&self, shape: Shape, gap_m: f64) -> bool {
        let inside = |p: DVec2| crate::sim::walls::is_inside(&self.scene, p.x, p.y);
        let points = border(shape);
        let things = footprints(&self.scene);
        let clear = |p: &DVec2| inside(*p) && things.iter().all(|thing| thing.shape.distance_m(*p) >= gap_m);
        points.iter().all(clear)
    }

    /// Puts boxes that belong together where their common outline fits; `false` where it does not.
    pub(super) fn place(&mut self, outline: Shape, gap_m: f64, boxes: Vec<Block>) -> bool {
        let fits = self.fits(outline, gap_m);
        if fits {
            self.scene.boxes.extend(boxes);
        }
        fits
    }

    /// Puts cylinders where their outline fits.
    pub(super) fn place_round(&mut self, outline: Shape, gap_m: f64, cylinders: Vec<Cylinder>) -> bool {
        let fits = self.fits(outline, gap_m);
        if fits {
            self.scene.cylinders.extend(cylinders);
        }
        fits
    }

    /// A thicket where its outline fits; `false` where it does not.
    pub(super) fn place_thicket(&mut self, outline: Shape, gap_m: f64, thicket: Thicket) -> bool {
        let fits = self.fits(outline, gap_m);
        if fits {
            self.scene.thickets.push(thicket);
        }
        fits
    }

    /// A glass pane standing on the floor, where it fits.
    pub(super) fn glass_pane(&mut self, width_m: f64, height_m: f64) -> bool {
        let at = self.anywhere();
        let yaw_rad = self.random.within(0.0, std::f64::consts::PI);
        let half = DVec2::from_angle(yaw_rad).perp() * width_m / 2.0;
        let fits = self.fits(Shape::Segment(at - half, at + half), 0.35);
        if fits {
            let center_m = [at.x, at.y, height_m / 2.0];
            self.scene.panes.push(Pane { center_m, width_m, height_m, yaw_rad, material: "glass".into() });
        }
        fits
    }

    /// A point in one of the rooms, larger ones more often.
    pub(super) fn anywhere(&mut self) -> DVec2 {
        let areas: Vec<f64> =
            self.scene.rooms.iter().map(|r| (r.max_m[0] - r.min_m[0]) * (r.max_m[1] - r.min_m[1])).collect();
        let mut left = self.random.unit() * areas.iter().sum::<f64>();
        let mut chosen = 0;
        for (index, area) in areas.iter().enumerate() {
            chosen = index;
            left -= area;
            if left < 0.0 {
                break;
            }
        }
        let room = &self.scene.rooms[chosen];
        let (min_m, max_m) = (room.min_m, room.max_m);
        DVec2::new(self.random.within(min_m[0], max_m[0]), self.random.within(min_m[1], max_m[1]))
    }

    /// A piece of wall of at least that length and a point on it that far from its ends; the wall's yaw.
    pub(super) fn on_a_wall(&mut self, length_m: f64) -> Option<(DVec2, f64)> {
        let long = |wall: &Wall| DVec2::from(wall.ends_m[0]).distance(wall.ends_m[1].into()) > length_m + 0.2;
        let walls: Vec<Wall> = walls(&self.scene).into_iter().filter(long).collect();
        if walls.is_empty() {
            return None;
        }
        let wall = self.random.pick(&walls);
        let [a, b] = wall.ends_m.map(DVec2::from_array);
        let margin = (length_m / 2.0 + 0.05) / a.distance(b);
        let at = a.lerp(b, self.random.within(margin, 1.0 - margin));
        Some((at, DVec2::from(wall.normal).to_angle()))
    }

    /// Something flat on a wall: a picture, a mirror.
    pub(super) fn hang(&mut self, width_m: f64, height_m: f64, middle_m: f64, material: &str) {
        if let Some((at, yaw_rad)) = self.on_a_wall(width_m) {
            let at = at + DVec2::from_angle(yaw_rad) * 0.008;
            let center_m = [at.x, at.y, middle_m];
            self.scene.panes.push(Pane { center_m, width_m, height_m, yaw_rad, material: material.into() });
        }
    }

    /// A window in a wall.
    pub(super) fn window(&mut self, width_m: f64, height_m: f64, middle_m: f64, color: [f64; 3]) {
        if let Some((at, yaw_rad)) = self.on_a_wall(width_m) {
            let at = at + DVec2::from_angle(yaw_rad) * 0.004;
            let center_m = [at.x, at.y, middle_m];
            let infrared = self.physics.window_infrared;
            self.scene.windows.push(Window { center_m, width_m, height_m, yaw_rad, color, infrared });
        }
    }

    /// Lamps at even distances under the ceiling of every room.
    pub(super) fn lamps(&mut self, spacing_m: f64, size_m: [f64; 2], color: [f64; 3]) {
        let infrared = self.physics.lamp_infrared;
        let height = self.scene.ceiling_m - 0.01;
        let mut lamps = Vec::new();
        for room in &self.scene.rooms {
            let spans = [0, 1].map(|axis| room.max_m[axis] - room.min_m[axis]);
            let rows = spans.map(|span| (span / spacing_m).round().clamp(1.0, 3.0));
            let at = |axis: usize, k: f64| room.min_m[axis] + spans[axis] * (k + 0.5) / rows[axis];
            let (mut x, mut y) = (0.0, 0.0);
            while y < rows[1] {
                lamps.push(Lamp { center_m: [at(0, x), at(1, y), height], size_m, color, infrared });
                x += 1.0;
                if x >= rows[0] {
                    (x, y) = (0.0, y + 1.0);
                }
            }
        }
        lamps.truncate(10);
        self.scene.lamps = lamps;
    }
}

/// Points around a shape, and its middle.
fn border(shape: Shape) -> Vec<DVec2> {
    const STEPS: u32 = 8;
    let around = (0..4 * STEPS).map(|i| f64::from(i) / f64::from(STEPS));
    match shape {
        Shape::Rectangle(center, half, turn) | Shape::Oval(center, half, turn) => {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(DVec2::from);
            let along = |t: f64| {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 0..4")]
                let side = t.floor() as usize;
                center + turn.rotate(half * corners[side].lerp(corners[(side + 1) % 4], t.fract()))
            };
            around.map(along).chain([center]).collect()
        }
        Shape::Disc(center, radius) => {
            let point = |t: f64| center + DVec2::from_angle(t * std::f64::consts::FRAC_PI_2) * radius;
            around.map(point).chain([center]).collect()
        }
        Shape::Segment(a, b) => around.map(|t| a.lerp(b, t / 4.0)).chain([b]).collect(),
    }
}
