//! Pinhole cameras with ROS distortion models; optical frames are x right, y down, z forward and
//! pixel centres lie at integers (spec 1 §3).

use crate::base::{Error, Result};

/// Lens distortion with ROS's coefficient order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distortion {
    /// Rectified images.
    None,
    /// `plumb_bob`: k1, k2, p1, p2, k3.
    PlumbBob([f64; 5]),
    /// `rational_polynomial`: k1, k2, p1, p2, k3, k4, k5, k6.
    RationalPolynomial([f64; 8]),
}

impl Distortion {
    /// From the fields of a ROS `CameraInfo` (or Foxglove `CameraCalibration`); all-zero
    /// coefficients become [`Distortion::None`].
    ///
    /// # Errors
    /// [`Error::Decode`] for an unknown model, a wrong number of coefficients or one that is not finite.
    pub fn from_ros(model: &str, coefficients: &[f64]) -> Result<Self> {
        let bad = |reason: String| Err(Error::Decode { what: "camera distortion".into(), reason });
        if coefficients.iter().any(|c| !c.is_finite()) {
            return bad(format!("coefficients {coefficients:?} are not all finite"));
        }
        if coefficients.iter().all(|&c| c == 0.0) {
            return Ok(Self::None);
        }
        match (model, coefficients) {
            ("plumb_bob" | "", &[k1, k2, p1, p2]) => Ok(Self::PlumbBob([k1, k2, p1, p2, 0.0])),
            ("plumb_bob" | "", &[k1, k2, p1, p2, k3]) => Ok(Self::PlumbBob([k1, k2, p1, p2, k3])),
            ("rational_polynomial", &[k1, k2, p1, p2, k3, k4, k5, k6, ..]) => {
                Ok(Self::RationalPolynomial([k1, k2, p1, p2, k3, k4, k5, k6]))
            }
            _ => bad(format!(
                "model `{model}` with {} coefficients is not supported; plumb_bob (4 or 5) and rational_polynomial (8) are",
                coefficients.len()
            )),
        }
    }

    /// Coefficients k1, k2, p1, p2, k3, k4, k5, k6 of the rational form, of which the others are cases.
    pub fn rational(&self) -> [f64; 8] {
        match *self {
            Self::None => [0.0; 8],
            Self::PlumbBob([k1, k2, p1, p2, k3]) => [k1, k2, p1, p2, k3, 0.0, 0.0, 0.0],
            Self::RationalPolynomial(k) => k,
        }
    }

    /// Distorted normalised coordinates of an ideal ray (x/z, y/z).
    pub fn distort(&self, ideal: [f64; 2]) -> [f64; 2] {
        let [k1, k2, p1, p2, k3, k4, k5, k6] = self.rational();
        let [x, y] = ideal;
        let r2 = x * x + y * y;
        let radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    /// The ideal ray whose distortion is `distorted`, by fixed-point iteration; `None` where the
    /// iteration does not settle (pixels outside the lens model's valid field).
    pub fn undistort(&self, distorted: [f64; 2]) -> Option<[f64; 2]> {
        if *self == Self::None {
            return Some(distorted);
        }
        let mut ideal = distorted;
        for _ in 0..100 {
            let [x, y] = self.distort(ideal);
            let step = [distorted[0] - x, distorted[1] - y];
            ideal = [ideal[0] + step[0], ideal[1] + step[1]];
            if step[0].abs().max(step[1].abs()) < 1e-10 {
                return Some(ideal);
            }
        }
        None
    }
}

/// A calibrated camera: image size in pixels, focal lengths and principal point in pixels, distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraModel {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Pixels.
    pub fx: f64,
    /// Pixels.
    pub fy: f64,
    /// Pixels.
    pub cx: f64,
    /// Pixels.
    pub cy: f64,
    /// Lens distortion.
    pub distortion: Distortion,
}

impl CameraModel {
    /// Refuses empty images and focal lengths or centres that are zero, negative or not finite.
    ///
    /// # Errors
    /// [`Error::Decode`] that names the field.
    pub fn validate(self) -> Result<Self> {
        let bad = |reason: String| Err(Error::Decode { what: "camera intrinsics".into(), reason });
        if self.width == 0 || self.height == 0 {
            return bad(format!("image size is {}x{}", self.width, self.height));
        }
        for (name, focal) in [("fx", self.fx), ("fy", self.fy)] {
            if !(focal.is_finite() && focal > 0.0) {
                return bad(format!("{name} = {focal} is not a positive number"));
            }
        }
        if !(self.cx.is_finite() && self.cy.is_finite()) {
            return bad(format!("principal point ({}, {}) is not finite", self.cx, self.cy));
        }
        Ok(self)
    }

    /// The ray (x/z, y/z) through the centre of pixel (`u`, `v`); `None` outside the lens model's field.
    pub fn ray(&self, u: f64, v: f64) -> Option<[f64; 2]> {
        self.distortion.undistort([(u - self.cx) / self.fx, (v - self.cy) / self.fy])
    }
}
