//! A scene as the shaders take it.

use bytemuck::Zeroable;
use glam::{DVec2, DVec3, UVec4, Vec4};

use super::cluster::{Item, Table, bounds, clusters};
use super::material::{Kind, Material};
use super::scene::{Outline, Pane, Scene};
use super::vessel::Frustum;
use super::walls::{Wall, walls};
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
/// Curtains that fit.
pub(crate) const CURTAINS: usize = 8;
/// Thickets that fit.
pub(crate) const THICKETS: usize = 24;
/// Vessels that fit.
pub(crate) const VESSELS: usize = 12;
/// Pieces of their surfaces that fit.
pub(crate) const FRUSTUMS: usize = 56;

/// Height of the ceiling where there is none, metres.
const SKY_M: f64 = 1e8;

crate::params! {
    /// A scene in `shaders/lib/sim/scene.wgsl`, which explains the fields.
    pub struct SimScene {
        /// Lights, clusters, curtains, thickets.
        pub counts: UVec4,
        /// Material of floor and ceiling.
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
        /// Least corner of each cluster.
        pub cluster_low: [Vec4; 48],
        /// Its greatest corner.
        pub cluster_high: [Vec4; 48],
        /// Its rectangles, boxes, cylinders and pieces of a vessel.
        pub cluster_range: [UVec4; 48],
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
        /// Kind and scale of its pattern; its crumples.
        pub pattern: [Vec4; 32],
        /// Reflectance, roughness, transmission, kind.
        pub optics: [Vec4; 32],
        /// r, g, b, infrared.
        pub emission: [Vec4; 32],
        /// Plane of each curtain.
        pub curtain_plane: [Vec4; 8],
        /// Its width.
        pub curtain_u: [Vec4; 8],
        /// Its height.
        pub curtain_v: [Vec4; 8],
        /// Spacing and width of its strings, half its width, material.
        pub curtain_look: [Vec4; 8],
        /// Centre of each thicket and cosine of its yaw.
        pub thicket_center: [Vec4; 24],
        /// Half its lengths and sine of its yaw.
        pub thicket_half: [Vec4; 24],
        /// Extinction, width of elements, material, outline.
        pub thicket_look: [Vec4; 24],
        /// Place and radii of each piece of a vessel.
        pub frustum_axis: [Vec4; 56],
        /// Its heights, refractive indices, material, and which side the body is on.
        pub frustum_look: [UVec4; 56],
        /// Towards the sun, and whether it shines.
        pub sun_direction: Vec4,
        /// r, g, b, infrared.
        pub sun_radiance: Vec4,
    }
}

fn vec4(x: f64, y: f64, z: f64, w: f64) -> Vec4 {
    Vec4::new(single(x), single(y), single(z), single(w))
}

fn count(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// An upright or level rectangle: centre, half its width and height as vectors, material.
struct Quad {
    center: DVec3,
    u: DVec3,
    v: DVec3,
    material: u32,
    casts: bool,
}

impl Quad {
    /// Facing `yaw_rad`.
    fn upright(center_m: [f64; 3], width_m: f64, height_m: f64, yaw_rad: f64) -> Self {
        let along = DVec2::from_angle(yaw_rad).perp() * width_m / 2.0;
        let (u, v) = (along.extend(0.0), DVec3::Z * height_m / 2.0);
        Self { center: DVec3::from_array(center_m), u, v, material: 0, casts: false }
    }

    /// Facing down.
    fn level(center_m: [f64; 3], [width_m, depth_m]: [f64; 2]) -> Self {
        let (u, v) = (DVec3::Y * depth_m / 2.0, DVec3::X * width_m / 2.0);
        Self { center: DVec3::from_array(center_m), u, v, material: 0, casts: false }
    }

    /// Plane, width and height as the shader has them.
    fn packed(&self) -> (Vec4, Vec4, Vec4) {
        let row = |v: DVec3| vec4(v.x, v.y, v.z, v.dot(self.center));
        let axis = |half: DVec3| row(half / half.length_squared());
        (row(self.normal()), axis(self.u), axis(self.v))
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
        packed.size = vec4(if scene.open_air { SKY_M } else { scene.ceiling_m }, 0.0, 0.0, 0.0);
        for (slot, material) in scene.materials.values().enumerate() {
            packed.put_material(slot, material);
        }
        packed.room = UVec4::new(slot(scene, &scene.floor), slot(scene, &scene.ceiling), 0, 0);
        let mut quads = walls_and_panes(scene);
        packed.put_lights(scene, &mut quads);
        packed.put_clusters(scene, &quads);
        packed.put_thin(scene);
        packed.put_sun(scene);
        packed
    }

    fn put_thin(&mut self, scene: &Scene) {
        for (index, curtain) in scene.curtains.iter().enumerate() {
            let quad = Quad::upright(curtain.center_m, curtain.width_m, curtain.height_m, curtain.yaw_rad);
            (self.curtain_plane[index], self.curtain_u[index], self.curtain_v[index]) = quad.packed();
            let material = f64::from(slot(scene, &curtain.material));
            self.curtain_look[index] =
                vec4(curtain.spacing_m, curtain.string_width_m, curtain.width_m / 2.0, material);
            self.counts.z += 1;
        }
        for (index, thicket) in scene.thickets.iter().enumerate() {
            let [x, y, z] = thicket.center_m;
            let half = DVec3::from_array(thicket.size_m) / 2.0;
            let (sine, cosine) = thicket.yaw_rad.sin_cos();
            self.thicket_center[index] = vec4(x, y, z, cosine);
            self.thicket_half[index] = vec4(half.x, half.y, half.z, sine);
            let material = f64::from(slot(scene, &thicket.material));
            let kind = u8::from(thicket.outline == Outline::Ellipsoid) + 2 * u8::from(thicket.solid);
            self.thicket_look[index] =
                vec4(thicket.extinction_per_m(), thicket.element_width_m, material, f64::from(kind));
            self.counts.w += 1;
        }
    }

    fn put_material(&mut self, slot: usize, material: &Material) {
        self.albedo[slot] = light_of(material.albedo, material.albedo_ir);
        self.pattern_albedo[slot] = light_of(material.pattern_albedo, material.pattern_albedo_ir);
        let pattern = f64::from(material.pattern.code());
        self.pattern[slot] = vec4(pattern, material.pattern_scale_m, material.bump, material.bump_scale_m);
        let kind = f64::from(material.kind.code());
        self.optics[slot] = vec4(material.reflectance, material.roughness, material.transmission, kind);
    }

    /// Puts everything into the tables, cluster by cluster.
    fn put_clusters(&mut self, scene: &Scene, quads: &[Quad]) {
        let mut next = [0_usize; 4];
        let alone = vessels(scene).map(|vessel| vec![vessel]);
        for mut cluster in clusters(items(scene, quads)).into_iter().chain(alone) {
            cluster.sort_by_key(|item| !item.casts);
            let index = self.counts.y as usize;
            let (low, high) = bounds(&cluster);
            self.cluster_low[index] = vec4(low.x, low.y, low.z, 0.0);
            self.cluster_high[index] = vec4(high.x, high.y, high.z, 0.0);
            let first = next;
            let mut range = UVec4::ZERO;
            for item in &cluster {
                let slot = &mut next[item.table as usize];
                match item.table {
                    Table::Quad => self.put_quad(*slot, &quads[item.index]),
                    Table::Box => self.put_box(*slot, scene, item.index),
                    Table::Cylinder => self.put_cylinder(*slot, scene, item.index),
                    Table::Vessel => range.w = self.put_vessel(slot, scene, item),
                }
                *slot += usize::from(item.table != Table::Vessel);
            }
            for table in 0..3 {
                let casts = cluster.iter().filter(|item| item.table as usize == table && item.casts).count();
                let shadows = if table < 2 { count((first[table] + casts) << 16) } else { 0 };
                range[table] = count(first[table] | (next[table] << 8)) | shadows;
            }
            self.cluster_range[index] = range;
            self.counts.y += 1;
        }
    }

    /// Puts a vessel's cones and then its discs from `slot` on; their range as the shader has it.
    fn put_vessel(&mut self, slot: &mut usize, scene: &Scene, item: &Item) -> u32 {
        let vessel = &scene.vessels[item.index];
        let (discs, cones): (Vec<_>, Vec<_>) = vessel.frustums(scene).into_iter().partition(Frustum::is_disc);
        let (first, cones_end, end) = (*slot, *slot + cones.len(), *slot + cones.len() + discs.len());
        for frustum in cones.into_iter().chain(discs) {
            let [x, y, z] = vessel.base_m;
            let ([low_r, low], [high_r, high]) = (frustum.low_m, frustum.high_m);
            self.frustum_axis[*slot] = vec4(x, y, low_r, high_r);
            let [low, high] = [z + low, z + high].map(|height| single(height).to_bits());
            let [body, around] = frustum.indices.map(fixed_point);
            let away = if frustum.facing < 0.0 { 256 } else { 0 };
            let material = self::slot(scene, &frustum.material) + away;
            self.frustum_look[*slot] = UVec4::new(low, high, body | (around << 16), material);
            *slot += 1;
        }
        count(first | (cones_end << 8) | (end << 16) | (usize::from(item.casts) << 24))
    }

    fn put_quad(&mut self, index: usize, quad: &Quad) {
        (self.quad_plane[index], self.quad_u[index], self.quad_v[index]) = quad.packed();
        self.quad_material[index] = UVec4::new(quad.material, 0, 0, 0);
    }

    fn put_box(&mut self, index: usize, scene: &Scene, number: usize) {
        let block = &scene.boxes[number];
        let [x, y, z] = block.center_m;
        let half = DVec3::from_array(block.size_m) / 2.0;
        let (sine, cosine) = block.yaw_rad.sin_cos();
        self.box_center[index] = vec4(x, y, z, cosine);
        self.box_half[index] = vec4(half.x, half.y, half.z, sine);
        let clear = u32::from(!casts(scene, &block.material));
        let refractive_index = scene.materials.get(&block.material).map_or(1.0, |m| m.refractive_index);
        let bits = single(refractive_index).to_bits();
        self.box_material[index] = UVec4::new(slot(scene, &block.material), clear, bits, 0);
    }

    fn put_cylinder(&mut self, index: usize, scene: &Scene, number: usize) {
        let cylinder = &scene.cylinders[number];
        let [x, y, z] = cylinder.base_m;
        self.cylinder_axis[index] = vec4(x, y, cylinder.radius_m, 0.0);
        self.cylinder_span[index] = vec4(z, z + cylinder.height_m, 0.0, 0.0);
        self.cylinder_material[index] = UVec4::new(slot(scene, &cylinder.material), 0, 0, 0);
    }

    fn put_sun(&mut self, scene: &Scene) {
        if let Some(sun) = &scene.sun {
            let level = DVec2::from_angle(sun.yaw_rad) * sun.elevation_rad.cos();
            self.sun_direction = vec4(level.x, level.y, sun.elevation_rad.sin(), 1.0);
            self.sun_radiance = light_of(sun.color, sun.infrared);
        }
    }

    fn put_lights(&mut self, scene: &Scene, quads: &mut Vec<Quad>) {
        for lamp in &scene.lamps {
            let quad = Quad::level(lamp.center_m, lamp.size_m);
            let radiance = light_of(lamp.color, lamp.infrared);
            quads.push(self.put_light(quad, radiance, Kind::Lamp, scene.materials.len()));
        }
        for window in &scene.windows {
            let quad = Quad::upright(window.center_m, window.width_m, window.height_m, window.yaw_rad);
            let radiance = light_of(window.color, window.infrared);
            quads.push(self.put_light(quad, radiance, Kind::Window, scene.materials.len()));
        }
    }

    fn put_light(&mut self, quad: Quad, radiance: Vec4, kind: Kind, materials: usize) -> Quad {
        let index = self.counts.x as usize;
        let material = materials + index;
        let area_m2 = 4.0 * quad.u.length() * quad.v.length();
        let (at, normal) = (quad.center, quad.normal());
        self.light_place[index] = vec4(at.x, at.y, at.z, area_m2 / std::f64::consts::PI);
        self.light_normal[index] = vec4(normal.x, normal.y, normal.z, 0.0);
        self.light_radiance[index] = radiance;
        self.emission[material] = radiance;
        self.optics[material] = vec4(0.0, 0.0, 0.0, f64::from(kind.code()));
        self.counts.x += 1;
        Quad { material: count(material), ..quad }
    }
}

fn walls_and_panes(scene: &Scene) -> Vec<Quad> {
    let wall = |wall: Wall| {
        let [a, b] = wall.ends_m.map(DVec2::from_array);
        let v = DVec3::Z * scene.ceiling_m / 2.0;
        let (center, u) = (a.midpoint(b).extend(scene.ceiling_m / 2.0), ((b - a) / 2.0).extend(0.0));
        Quad { center, u, v, material: slot(scene, &scene.rooms[wall.room].walls), casts: true }
    };
    let pane = |pane: &Pane| Quad {
        material: slot(scene, &pane.material),
        casts: casts(scene, &pane.material),
        ..Quad::upright(pane.center_m, pane.width_m, pane.height_m, pane.yaw_rad)
    };
    walls(scene).into_iter().map(wall).chain(scene.panes.iter().map(pane)).collect()
}

/// Whether something of a material casts shadows: anything but glass.
fn casts(scene: &Scene, material: &str) -> bool {
    scene.materials.get(material).is_some_and(|material| material.transmission == 0.0)
}

/// The vessels by their bounds.
fn vessels(scene: &Scene) -> impl Iterator<Item = Item> {
    scene.vessels.iter().enumerate().map(|(index, vessel)| {
        let ([x, y, _], [bottom, top]) = (vessel.base_m, vessel.span_m());
        let reach = DVec2::splat(vessel.radius_m());
        let low = (DVec2::new(x, y) - reach).extend(bottom);
        let high = (DVec2::new(x, y) + reach).extend(top);
        Item { table: Table::Vessel, index, casts: casts(scene, &vessel.material), low, high }
    })
}

/// Everything else that rays may meet, by its bounds.
fn items(scene: &Scene, quads: &[Quad]) -> Vec<Item> {
    let item = |table, index, casts, center: DVec3, reach: DVec3| Item {
        table,
        index,
        casts,
        low: center - reach,
        high: center + reach,
    };
    let quads = quads.iter().enumerate();
    let quads = quads.map(|(i, q)| item(Table::Quad, i, q.casts, q.center, q.u.abs() + q.v.abs()));
    let boxes = scene.boxes.iter().enumerate().map(|(i, block)| {
        let half = DVec3::from_array(block.size_m) / 2.0;
        let (sine, cosine) = block.yaw_rad.sin_cos();
        let (s, c) = (sine.abs(), cosine.abs());
        let reach = DVec3::new(c * half.x + s * half.y, s * half.x + c * half.y, half.z);
        item(Table::Box, i, casts(scene, &block.material), DVec3::from_array(block.center_m), reach)
    });
    let cylinders = scene.cylinders.iter().enumerate().map(|(i, cylinder)| {
        let reach = DVec3::new(cylinder.radius_m, cylinder.radius_m, cylinder.height_m / 2.0);
        let center = DVec3::from_array(cylinder.base_m) + DVec3::Z * reach.z;
        item(Table::Cylinder, i, true, center, reach)
    });
    quads.chain(boxes).chain(cylinders).collect()
}

/// A refractive index below 4 in 1/16384.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 0..65536")]
fn fixed_point(index: f64) -> u32 {
    (index * 16384.0).round().clamp(0.0, 65535.0) as u32
}

fn light_of([r, g, b]: [f64; 3], infrared: f64) -> Vec4 {
    vec4(r, g, b, infrared)
}

/// Number of a material: they are in order of their names.
fn slot(scene: &Scene, name: &str) -> u32 {
    count(scene.materials.keys().position(|known| known == name).unwrap_or(0))
}
