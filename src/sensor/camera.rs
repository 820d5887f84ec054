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
    /// `equidistant`, the fisheye lens of Kannala and Brandt: k1, k2, k3, k4 of the angle from the axis.
    Fisheye([f64; 4]),
}

/// Widest angle from the axis at which a fisheye pixel has a ray, radians: x/z and y/z go to infinity at a right angle.
const WIDEST_RAD: f64 = 1.55;

impl Distortion {
    /// From the fields of a ROS `CameraInfo` (or Foxglove `CameraCalibration`); all-zero
    /// coefficients become [`Distortion::None`], as image_geometry has it. Which of the polynomial models is meant is told by
    /// the number of coefficients, as OpenCV does; those past the eighth are left out.
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
        let name = model.to_lowercase().replace([' ', '-'], "_");
        let is_fisheye =
            ["equidistant", "fisheye", "kannala_brandt", "kannala_brandt4"].contains(&name.as_str());
        let is_polynomial = ["", "plumb_bob", "radtan", "rational_polynomial"].contains(&name.as_str());
        match *coefficients {
            [k1, k2, k3, k4] if is_fisheye => Ok(Self::Fisheye([k1, k2, k3, k4])),
            [k1, k2, p1, p2] if is_polynomial => Ok(Self::PlumbBob([k1, k2, p1, p2, 0.0])),
            [k1, k2, p1, p2, k3] if is_polynomial => Ok(Self::PlumbBob([k1, k2, p1, p2, k3])),
            [k1, k2, p1, p2, k3, k4, k5, k6, ref more @ ..]
                if is_polynomial && [0, 4, 6].contains(&more.len()) =>
            {
                Ok(Self::RationalPolynomial([k1, k2, p1, p2, k3, k4, k5, k6]))
            }
            _ => bad(format!(
                "model `{model}` with {} coefficients is not supported; plumb_bob (4 or 5), rational_polynomial (8, 12 or 14) and equidistant (4) are",
                coefficients.len()
            )),
        }
    }

    /// Coefficients as shaders take them: k1, k2, p1, p2, k3, k4, k5, k6 of the rational form, of which the other polynomials
    /// are cases; of a fisheye lens k1, k2, k3, k4 and zeros.
    pub fn coefficients(&self) -> [f64; 8] {
        match *self {
            Self::None => [0.0; 8],
            Self::PlumbBob([k1, k2, p1, p2, k3]) => [k1, k2, p1, p2, k3, 0.0, 0.0, 0.0],
            Self::RationalPolynomial(k) => k,
            Self::Fisheye([k1, k2, k3, k4]) => [k1, k2, k3, k4, 0.0, 0.0, 0.0, 0.0],
        }
    }

    /// Whether the lens is of the fisheye model.
    pub fn is_fisheye(&self) -> bool {
        matches!(self, Self::Fisheye(_))
    }

    /// Distorted normalised coordinates of an ideal ray (x/z, y/z).
    pub fn distort(&self, ideal: [f64; 2]) -> [f64; 2] {
        let [x, y] = ideal;
        if let Self::Fisheye(k) = *self {
            let r = x.hypot(y);
            let scale = if r > 1e-9 { bent(r.atan(), k) / r } else { 1.0 };
            return [x * scale, y * scale];
        }
        let [k1, k2, p1, p2, k3, k4, k5, k6] = self.coefficients();
        let r2 = x * x + y * y;
        let radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    /// The ideal ray whose distortion is `distorted`, by fixed-point iteration, of a fisheye lens by Newton's; `None` where the
    /// iteration does not settle (pixels outside the lens model's valid field) and 1.55 rad or more from the axis.
    pub fn undistort(&self, distorted: [f64; 2]) -> Option<[f64; 2]> {
        match *self {
            Self::None => return Some(distorted),
            Self::Fisheye(k) => {
                let r = distorted[0].hypot(distorted[1]);
                let angle = unbent(r, k).filter(|&angle| angle < WIDEST_RAD)?;
                let scale = if r > 1e-9 { angle.tan() / r } else { 1.0 };
                return Some(distorted.map(|at| at * scale));
            }
            _ => {}
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

/// Distance from the centre, in focal lengths, at which a fisheye lens shows what is `angle` from the axis.
fn bent(angle: f64, [k1, k2, k3, k4]: [f64; 4]) -> f64 {
    let a2 = angle * angle;
    angle * (1.0 + a2 * (k1 + a2 * (k2 + a2 * (k3 + a2 * k4))))
}

/// The angle in [0, pi] that is shown at a distance; `None` beyond where the distance stops growing with the angle.
fn unbent(distance: f64, k: [f64; 4]) -> Option<f64> {
    let [k1, k2, k3, k4] = k;
    let mut angle = distance.min(std::f64::consts::FRAC_PI_2);
    for _ in 0..50 {
        let a2 = angle * angle;
        let slope = 1.0 + a2 * (3.0 * k1 + a2 * (5.0 * k2 + a2 * (7.0 * k3 + a2 * 9.0 * k4)));
        if slope <= 0.0 {
            return None;
        }
        let step = (distance - bent(angle, k)) / slope;
        angle = (angle + step).clamp(0.0, std::f64::consts::PI);
        if step.abs() < 1e-12 {
            return Some(angle);
        }
    }
    None
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
        match self.check_pinhole() {
            Ok(()) => Ok(self),
            Err(reason) => bad(reason),
        }
    }

    /// Which of focal lengths and centre cannot be.
    pub(crate) fn check_pinhole(&self) -> Result<(), String> {
        for (name, focal) in [("fx", self.fx), ("fy", self.fy)] {
            if !(focal.is_finite() && focal > 0.0) {
                return Err(format!("{name} = {focal} is not a positive number"));
            }
        }
        if !(self.cx.is_finite() && self.cy.is_finite()) {
            return Err(format!("principal point ({}, {}) is not finite", self.cx, self.cy));
        }
        Ok(())
    }

    /// The ray (x/z, y/z) through the centre of pixel (`u`, `v`); `None` outside the lens model's field.
    pub fn ray(&self, u: f64, v: f64) -> Option<[f64; 2]> {
        self.distortion.undistort([(u - self.cx) / self.fx, (v - self.cy) / self.fy])
    }

    /// As [`Self::ray`]; past the widest angle of a fisheye lens the ray of that angle on the same side.
    pub(crate) fn ray_or_edge(&self, u: f64, v: f64) -> Option<[f64; 2]> {
        let ray = self.ray(u, v);
        if ray.is_some() || !self.distortion.is_fisheye() {
            return ray;
        }
        let [x, y] = [(u - self.cx) / self.fx, (v - self.cy) / self.fy];
        let scale = WIDEST_RAD.tan() / x.hypot(y).max(1e-9);
        Some([x * scale, y * scale])
    }
}
