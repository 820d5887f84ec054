//! Rigid transforms between frames, named `to_from_source` as in `map_from_camera`.

use glam::{DMat3, DQuat, DVec3};

/// A rigid transform: rotation, then translation, metres. Frames follow REP 103 and REP 105.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    /// Unit quaternion.
    pub rotation: DQuat,
    /// Metres.
    pub translation_m: DVec3,
}

impl Rigid {
    /// The transform that changes nothing.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation_m: DVec3::ZERO };

    /// From a translation (metres) and a quaternion (x, y, z, w) of any non-zero length;
    /// `None` when a number is not finite or the quaternion has no length.
    pub fn new(translation_m: [f64; 3], rotation_xyzw: [f64; 4]) -> Option<Self> {
        let rotation = DQuat::from_array(rotation_xyzw);
        let translation_m = DVec3::from_array(translation_m);
        let usable = translation_m.is_finite() && rotation.is_finite() && rotation.length() > 1e-6;
        usable.then(|| Self { rotation: rotation.normalize(), translation_m })
    }

    /// `a_from_b * b_from_c = a_from_c`.
    pub fn then(self, inner: Self) -> Self {
        Self {
            rotation: (self.rotation * inner.rotation).normalize(),
            translation_m: self.transform_point(inner.translation_m),
        }
    }

    /// The same pose in a frame of the same axes whose origin is at `origin_m`.
    #[must_use]
    pub fn from_origin(self, origin_m: DVec3) -> Self {
        Self { translation_m: self.translation_m - origin_m, ..self }
    }

    /// `b_from_a` of `a_from_b`.
    pub fn inverse(self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { rotation, translation_m: rotation * -self.translation_m }
    }

    /// The point in the outer frame, metres.
    pub fn transform_point(self, point_m: DVec3) -> DVec3 {
        self.rotation * point_m + self.translation_m
    }

    /// Between `self` (`share` 0) and `other` (`share` 1): linear in translation, slerp in rotation.
    pub fn interpolate(self, other: Self, share: f64) -> Self {
        Self {
            rotation: self.rotation.slerp(other.rotation, share),
            translation_m: self.translation_m.lerp(other.translation_m, share),
        }
    }

    /// The rotation as a matrix.
    pub fn rotation_matrix(self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }
}

/// f64 values as the f32 that shaders and points have.
#[expect(clippy::cast_possible_truncation, reason = "f32 is the precision of shaders and points")]
pub(crate) fn single(value: f64) -> f32 {
    value as f32
}
