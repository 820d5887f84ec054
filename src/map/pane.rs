//! A pane of glass.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4, Vec3, Vec4};

use crate::base::Rigid;

/// Panes that are kept (`KEPT_PANES`).
pub const KEPT_PANES: usize = 16;

/// A pane: the plane `normal . x = distance` and a rectangle on it, in the frame that it is given in. Laid out as shaders
/// keep it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Pane {
    /// Unit normal; w: distance of the plane from the origin along it, metres.
    pub normal: Vec4,
    /// Unit axis u in the plane, level where the plane stands; w: intensity above which a return on it is frame, 0 where
    /// not known, below 0 of a mirror.
    pub level: Vec4,
    /// Least and largest u, least and largest v = normal x u, metres.
    pub extent_m: Vec4,
    /// Counts panes from 1; 0: no pane.
    pub id: u32,
    /// Scans that found it.
    pub hits: u32,
    /// Scans in a row whose beams went through its place.
    pub misses: u32,
    /// Scans since it was first found.
    pub age: u32,
}

impl Pane {
    /// Unit normal.
    pub fn unit_normal(&self) -> Vec3 {
        self.normal.truncate()
    }

    /// Whether it is a mirror, behind which nothing shows.
    pub fn is_mirror(&self) -> bool {
        self.level.w < 0.0
    }

    /// Its four corners in order, metres.
    pub fn corners_m(&self) -> [DVec3; 4] {
        let n = self.unit_normal().as_dvec3();
        let u = self.level.truncate().as_dvec3();
        let v = n.cross(u);
        let [u0, u1, v0, v1] = self.extent_m.to_array().map(f64::from);
        let foot = n * f64::from(self.normal.w);
        [[u0, v0], [u1, v0], [u1, v1], [u0, v1]].map(|[a, b]| foot + u * a + v * b)
    }

    /// Its centre, metres.
    pub fn centre_m(&self) -> DVec3 {
        self.corners_m().iter().sum::<DVec3>() / 4.0
    }

    /// The same pane in another frame, whose origin must be near: coordinates are f32.
    pub fn moved(&self, to_from_frame: Rigid) -> Self {
        let turned = |v: Vec4| to_from_frame.rotation * v.truncate().as_dvec3();
        let (normal, level) = (turned(self.normal), turned(self.level));
        let shift = to_from_frame.translation_m;
        let distance_m = f64::from(self.normal.w) + normal.dot(shift);
        let [u, v] = [level.dot(shift), normal.cross(level).dot(shift)];
        Self {
            normal: normal.extend(distance_m).as_vec4(),
            level: level.extend(self.level.w.into()).as_vec4(),
            extent_m: (self.extent_m.as_dvec4() + DVec4::new(u, u, v, v)).as_vec4(),
            ..*self
        }
    }

    /// Where a point comes from that the pane mirrors: p' = p - 2 (n . p - d) n (spec 3 §6).
    pub fn mirrored_m(&self, point_m: DVec3) -> DVec3 {
        let n = self.unit_normal().as_dvec3();
        point_m - 2.0 * (n.dot(point_m) - f64::from(self.normal.w)) * n
    }
}
