//! An analytic room: boxes on a floor, seen by a pinhole camera through exact ray casting.

use glam::DVec3;
use limpid::base::Rigid;
use limpid::sensor::CameraModel;

/// How a surface looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Paint {
    /// One albedo, RGB in [0, 1].
    Plain([f64; 3]),
    /// Squares of 0.5 m in the x-y plane, alternately of the two albedos.
    Checker([f64; 3], [f64; 3]),
}

/// A solid with faces along the axes of the map, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisAlignedBox {
    pub(crate) min_m: DVec3,
    pub(crate) max_m: DVec3,
    pub(crate) paint: Paint,
}

/// Where a ray meets a box first.
struct Hit {
    /// In lengths of the ray's direction.
    distance: f64,
    /// Outward unit normal.
    normal: DVec3,
}

impl AxisAlignedBox {
    pub(crate) fn new(min_m: [f64; 3], max_m: [f64; 3], albedo: [f64; 3]) -> Self {
        Self { min_m: min_m.into(), max_m: max_m.into(), paint: Paint::Plain(albedo) }
    }

    /// Entry of the ray from outside; a ray that starts within the box does not meet it.
    fn enter(&self, origin_m: DVec3, direction: DVec3) -> Option<Hit> {
        let (mut near, mut far, mut axis) = (f64::NEG_INFINITY, f64::INFINITY, 0);
        for i in 0..3 {
            if direction[i] == 0.0 {
                if !(self.min_m[i]..=self.max_m[i]).contains(&origin_m[i]) {
                    return None;
                }
                continue;
            }
            let a = (self.min_m[i] - origin_m[i]) / direction[i];
            let b = (self.max_m[i] - origin_m[i]) / direction[i];
            if a.min(b) > near {
                (near, axis) = (a.min(b), i);
            }
            far = far.min(a.max(b));
        }
        let normal = -DVec3::AXES[axis] * direction[axis].signum();
        (near <= far && near > 1e-9).then_some(Hit { distance: near, normal })
    }

    fn albedo(&self, point_m: DVec3) -> [f64; 3] {
        match self.paint {
            Paint::Plain(albedo) => albedo,
            Paint::Checker(even, odd) => {
                let squares = (point_m.x / 0.5).floor() + (point_m.y / 0.5).floor();
                if squares.rem_euclid(2.0) < 0.5 { even } else { odd }
            }
        }
    }
}

/// A room without a ceiling, its floor at z = 0.
#[derive(Debug, Clone)]
pub(crate) struct Room {
    pub(crate) boxes: Vec<AxisAlignedBox>,
}

/// Where the light comes from.
const LIGHT: DVec3 = DVec3::new(-0.35, -0.5, 0.79);
const WALL_HEIGHT_M: f64 = 2.5;
const THICKNESS_M: f64 = 0.1;

impl Room {
    /// Floor and four walls; the inside is `size_m` along x and y, centred on the map's origin.
    pub(crate) fn empty(size_m: [f64; 2]) -> Self {
        let [x, y] = size_m.map(|side| side / 2.0);
        let (t, h) = (THICKNESS_M, WALL_HEIGHT_M);
        let wall = [0.78, 0.76, 0.70];
        let mut floor = AxisAlignedBox::new([-x - t, -y - t, -t], [x + t, y + t, 0.0], wall);
        floor.paint = Paint::Checker([0.62, 0.50, 0.38], [0.46, 0.36, 0.27]);
        Self {
            boxes: vec![
                floor,
                AxisAlignedBox::new([-x - t, -y - t, 0.0], [-x, y + t, h], wall),
                AxisAlignedBox::new([x, -y - t, 0.0], [x + t, y + t, h], [0.55, 0.66, 0.72]),
                AxisAlignedBox::new([-x, -y - t, 0.0], [x, -y, h], wall),
                AxisAlignedBox::new([-x, y, 0.0], [x, y + t, h], [0.74, 0.62, 0.52]),
            ],
        }
    }

    /// 6 m x 5 m with a sofa, a cupboard, a crate, a low box, a mat too low to be an obstacle, a table
    /// and a slab at 2.2 m that a robot passes under.
    pub(crate) fn living_room() -> Self {
        let mut room = Self::empty([6.0, 5.0]);
        room.boxes.extend([
            AxisAlignedBox::new([-0.6, 1.6, 0.0], [1.4, 2.4, 0.75], [0.20, 0.42, 0.36]),
            AxisAlignedBox::new([2.4, 0.2, 0.0], [2.9, 1.5, 1.9], [0.50, 0.30, 0.18]),
            AxisAlignedBox::new([0.35, 0.55, 0.0], [0.75, 0.95, 0.4], [0.80, 0.55, 0.15]),
            AxisAlignedBox::new([0.2, -1.9, 0.0], [0.6, -1.5, 0.2], [0.65, 0.16, 0.16]),
            AxisAlignedBox::new([-0.6, -0.4, 0.0], [0.0, 0.2, 0.03], [0.30, 0.32, 0.55]),
            AxisAlignedBox::new([-1.6, 1.3, 2.2], [-0.4, 2.1, 2.3], [0.85, 0.85, 0.85]),
        ]);
        room.boxes.extend(table([1.0, -1.4], [2.2, -0.6]));
        room
    }

    /// True depth along the optical axis, metres, row-major from the top left; 0 where nothing is hit.
    pub(crate) fn depth(&self, camera: &CameraModel, map_from_camera: Rigid) -> Vec<f32> {
        self.view(camera, map_from_camera).0
    }

    /// Shaded RGB, `3 * width * height` bytes; black where nothing is hit.
    pub(crate) fn color(&self, camera: &CameraModel, map_from_camera: Rigid) -> Vec<u8> {
        self.view(camera, map_from_camera).1
    }

    /// Depth and colour at once.
    pub(crate) fn view(&self, camera: &CameraModel, map_from_camera: Rigid) -> (Vec<f32>, Vec<u8>) {
        let (mut depth_m, mut rgb) = (Vec::new(), Vec::new());
        for v in 0..camera.height {
            for u in 0..camera.width {
                let (depth, color) = self.look(camera, map_from_camera, u, v).unwrap_or_default();
                depth_m.push(depth);
                rgb.extend(color);
            }
        }
        (depth_m, rgb)
    }

    /// Whether something solid stands at (`x_m`, `y_m`) between the heights `z_min_m` and `z_max_m`.
    pub(crate) fn occupied_at(&self, x_m: f64, y_m: f64, z_min_m: f64, z_max_m: f64) -> bool {
        self.boxes.iter().any(|solid| {
            let inside = |axis: usize, value: f64| (solid.min_m[axis]..=solid.max_m[axis]).contains(&value);
            inside(0, x_m) && inside(1, y_m) && solid.min_m.z < z_max_m && solid.max_m.z > z_min_m
        })
    }

    /// Depth and colour of the nearest surface on the ray of a pixel. The ray has z = 1, so distance is depth.
    fn look(&self, camera: &CameraModel, map_from_camera: Rigid, u: u32, v: u32) -> Option<(f32, [u8; 3])> {
        let [x, y] = camera.ray(u.into(), v.into())?;
        let direction = map_from_camera.rotation * DVec3::new(x, y, 1.0);
        let origin_m = map_from_camera.translation_m;
        let hits = self.boxes.iter().filter_map(|solid| Some((solid, solid.enter(origin_m, direction)?)));
        let (solid, hit) = hits.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))?;

        let albedo = solid.albedo(origin_m + direction * hit.distance);
        let brightness = 0.45 + 0.55 * hit.normal.dot(LIGHT.normalize()).max(0.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "32-bit depth is the format; float-to-integer casts saturate"
        )]
        Some((hit.distance as f32, albedo.map(|a| (255.0 * a * brightness).round() as u8)))
    }
}

/// A top at 0.72 to 0.75 m on four legs of 5 cm.
fn table(min_m: [f64; 2], max_m: [f64; 2]) -> Vec<AxisAlignedBox> {
    const LEG_M: f64 = 0.05;
    let wood = [0.58, 0.42, 0.24];
    let [[x0, y0], [x1, y1]] = [min_m, max_m];
    let mut parts = vec![AxisAlignedBox::new([x0, y0, 0.72], [x1, y1, 0.75], wood)];
    for (x, y) in [(x0, y0), (x1 - LEG_M, y0), (x0, y1 - LEG_M), (x1 - LEG_M, y1 - LEG_M)] {
        parts.push(AxisAlignedBox::new([x, y, 0.0], [x + LEG_M, y + LEG_M, 0.72], wood));
    }
    parts
}
