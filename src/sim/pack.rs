//! A scene as the shaders take it.

use bytemuck::Zeroable;
use glam::{DVec2, DVec3, UVec4, Vec4};

use super::material::{Kind, Material};
use super::scene::{Block, Scene};
use super::walls::walls;
use crate::stage::single;

/// Rectangles that fit.
pub(crate) const QUADS: usize = 64;
/// Boxes that fit.
pub(crate) const BOXES: usize = 48;
/// Cylinders that fit.
pub(crate) const CYLINDERS: usize = 16;
/// Lights that fit.
pub(crate) const LIGHTS: usize = 16;
/// Materials that fit.
pub(crate) const MATERIALS: usize = 32;

/// Boxes with two lengths below this cast no shadow.
const SLENDER_M: f64 = 0.12;

crate::params! {
    /// A scene in `shaders/lib/sim/scene.wgsl`, which explains the fields.
    pub struct SimScene {
        /// Rectangles, boxes, cylinders, lights.
        pub counts: UVec4,
        /// Material of floor and ceiling, rectangles and boxes that cast shadows.
        pub room: UVec4,
        /// r, g, b, infrared.
        pub ambient: Vec4,
        /// Ceiling height.
        pub size: Vec4,
        /// Plane of each rectangle.
        pub quad_plane: [Vec4; 64],
        /// Its width.
        pub quad_u: [Vec4; 64],
        /// Its height.
        pub quad_v: [Vec4; 64],
        /// Its material.
        pub quad_material: [UVec4; 64],
        /// Centre of each box and cosine of its yaw.
        pub box_center: [Vec4; 48],
        /// Half its lengths and sine of its yaw.
        pub box_half: [Vec4; 48],
        /// Its material.
        pub box_material: [UVec4; 48],
        /// x, y and radius of each cylinder.
        pub cylinder_axis: [Vec4; 16],
        /// Its bottom and top.
        pub cylinder_span: [Vec4; 16],
        /// Its material.
        pub cylinder_material: [UVec4; 16],
        /// Centre of each light and its area over pi.
        pub light_place: [Vec4; 16],
        /// Where it faces.
        pub light_normal: [Vec4; 16],
        /// r, g, b, infrared.
        pub light_radiance: [Vec4; 16],
        /// r, g, b, infrared of each material.
        pub albedo: [Vec4; 32],
        /// Of its pattern.
        pub pattern_albedo: [Vec4; 32],
        /// Kind and scale of its pattern.
        pub pattern: [Vec4; 32],
        /// Reflectance, roughness, transmission, kind.
        pub optics: [Vec4; 32],
        /// r, g, b, infrared.
        pub emission: [Vec4; 32],
    }
}

fn vec4(x: f64, y: f64, z: f64, w: f64) -> Vec4 {
    Vec4::new(single(x), single(y), single(z), single(w))
}

fn count(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// An upright or level rectangle: centre, and half its width and height as vectors.
struct Quad {
    center: DVec3,
    u: DVec3,
    v: DVec3,
}

impl Quad {
    /// Facing `yaw_rad`.
    fn upright(center_m: [f64; 3], width_m: f64, height_m: f64, yaw_rad: f64) -> Self {
        let along = DVec2::from_angle(yaw_rad).perp() * width_m / 2.0;
        Self { center: DVec3::from_array(center_m), u: along.extend(0.0), v: DVec3::Z * height_m / 2.0 }
    }

    /// Its normal: `u` x `v`, which faces the yaw of [`Self::upright`].
    fn normal(&self) -> DVec3 {
        self.u.cross(self.v).normalize()
    }
}

impl SimScene {
    /// Packs a checked scene.
    pub fn pack(scene: &Scene) -> Self {
        let mut packed = Self::zeroed();
        packed.ambient = light_of(scene.ambient.color, scene.ambient.infrared);
        packed.size = vec4(scene.ceiling_m, 0.0, 0.0, 0.0);
        for (slot, material) in scene.materials.values().enumerate() {
            packed.put_material(slot, material);
        }
        packed.room = UVec4::new(slot(scene, &scene.floor), slot(scene, &scene.ceiling), 0, 0);
        packed.put_walls(scene);
        packed.put_solids(scene);
        packed.put_panes(scene);
        packed.put_lights(scene);
        packed
    }

    fn put_material(&mut self, slot: usize, material: &Material) {
        self.albedo[slot] = light_of(material.albedo, material.albedo_ir);
        self.pattern_albedo[slot] = light_of(material.pattern_albedo, material.pattern_albedo_ir);
        self.pattern[slot] = vec4(f64::from(material.pattern.code()), material.pattern_scale_m, 0.0, 0.0);
        let kind = f64::from(material.kind.code());
        self.optics[slot] = vec4(material.reflectance, material.roughness, material.transmission, kind);
    }

    fn put_quad(&mut self, quad: &Quad, material: u32) {
        let index = self.counts.x as usize;
        let normal = quad.normal();
        let axis = |half: DVec3| {
            let unit = half / half.length_squared();
            vec4(unit.x, unit.y, unit.z, unit.dot(quad.center))
        };
        self.quad_plane[index] = vec4(normal.x, normal.y, normal.z, normal.dot(quad.center));
        self.quad_u[index] = axis(quad.u);
        self.quad_v[index] = axis(quad.v);
        self.quad_material[index] = UVec4::new(material, 0, 0, 0);
        self.counts.x += 1;
    }

    /// Walls come first, for they may cast shadows; those of one room cannot, since no light is outside.
    fn put_walls(&mut self, scene: &Scene) {
        for wall in walls(scene) {
            let [a, b] = wall.ends_m.map(DVec2::from_array);
            let quad = Quad {
                center: a.midpoint(b).extend(scene.ceiling_m / 2.0),
                u: ((b - a) / 2.0).extend(0.0),
                v: DVec3::Z * scene.ceiling_m / 2.0,
            };
            self.put_quad(&quad, slot(scene, &scene.rooms[wall.room].walls));
        }
        self.room.z = if scene.rooms.len() > 1 { self.counts.x } else { 0 };
    }

    fn put_solids(&mut self, scene: &Scene) {
        // Those that cast shadows come first.
        let (casting, slender): (Vec<&Block>, _) = scene.boxes.iter().partition(|block| casts_shadow(block));
        self.room.w = count(casting.len());
        for (index, block) in casting.into_iter().chain(slender).enumerate() {
            let [x, y, z] = block.center_m;
            let half = DVec3::from_array(block.size_m) / 2.0;
            let (sine, cosine) = block.yaw_rad.sin_cos();
            self.box_center[index] = vec4(x, y, z, cosine);
            self.box_half[index] = vec4(half.x, half.y, half.z, sine);
            self.box_material[index] = UVec4::new(slot(scene, &block.material), 0, 0, 0);
        }
        for (index, cylinder) in scene.cylinders.iter().enumerate() {
            let [x, y, z] = cylinder.base_m;
            self.cylinder_axis[index] = vec4(x, y, cylinder.radius_m, 0.0);
            self.cylinder_span[index] = vec4(z, z + cylinder.height_m, 0.0, 0.0);
            self.cylinder_material[index] = UVec4::new(slot(scene, &cylinder.material), 0, 0, 0);
        }
        self.counts.y = count(scene.boxes.len());
        self.counts.z = count(scene.cylinders.len());
    }

    fn put_panes(&mut self, scene: &Scene) {
        for pane in &scene.panes {
            let quad = Quad::upright(pane.center_m, pane.width_m, pane.height_m, pane.yaw_rad);
            self.put_quad(&quad, slot(scene, &pane.material));
        }
    }

    fn put_lights(&mut self, scene: &Scene) {
        for lamp in &scene.lamps {
            let [width_m, depth_m] = lamp.size_m;
            let quad = Quad {
                center: DVec3::from_array(lamp.center_m),
                u: DVec3::Y * depth_m / 2.0,
                v: DVec3::X * width_m / 2.0,
            };
            let radiance = light_of(lamp.color, lamp.infrared);
            self.put_light(&quad, radiance, Kind::Lamp, scene.materials.len());
        }
        for window in &scene.windows {
            let quad = Quad::upright(window.center_m, window.width_m, window.height_m, window.yaw_rad);
            let radiance = light_of(window.color, window.infrared);
            self.put_light(&quad, radiance, Kind::Window, scene.materials.len());
        }
    }

    fn put_light(&mut self, quad: &Quad, radiance: Vec4, kind: Kind, materials: usize) {
        let index = self.counts.w as usize;
        let material = materials + index;
        let area_m2 = 4.0 * quad.u.length() * quad.v.length();
        let (at, normal) = (quad.center, quad.normal());
        self.light_place[index] = vec4(at.x, at.y, at.z, area_m2 / std::f64::consts::PI);
        self.light_normal[index] = vec4(normal.x, normal.y, normal.z, 0.0);
        self.light_radiance[index] = radiance;
        self.emission[material] = radiance;
        self.optics[material] = vec4(0.0, 0.0, 0.0, f64::from(kind.code()));
        self.put_quad(quad, count(material));
        self.counts.w += 1;
    }
}

/// Legs and strips are too slender for a shadow worth a ray.
fn casts_shadow(block: &Block) -> bool {
    let mut lengths = block.size_m;
    lengths.sort_by(f64::total_cmp);
    lengths[1] >= SLENDER_M
}

fn light_of([r, g, b]: [f64; 3], infrared: f64) -> Vec4 {
    vec4(r, g, b, infrared)
}

/// Number of a material: they are in order of their names.
fn slot(scene: &Scene, name: &str) -> u32 {
    count(scene.materials.keys().position(|known| known == name).unwrap_or(0))
}
