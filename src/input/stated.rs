//! A camera that the configuration states: `camera_matrix`, `distortion` and `distortion_model`.

use crate::base::{Error, Result};
use crate::config::Config;
use crate::sensor::{CameraModel, Distortion};

/// See the module.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StatedCamera {
    matrix: [f64; 9],
    distortion_model: String,
    distortion: Vec<f64>,
}

impl StatedCamera {
    /// `None` where the configuration states none.
    pub(crate) fn of(config: &Config) -> Option<Self> {
        (config.camera_matrix != [0.0; 9]).then(|| Self {
            matrix: config.camera_matrix,
            distortion_model: config.distortion_model.clone(),
            distortion: config.distortion.clone(),
        })
    }

    /// The camera of images of a size.
    ///
    /// # Errors
    /// [`Error::Config`] for focal lengths, centres and coefficients that cannot be.
    pub(crate) fn camera(&self, [width, height]: [u32; 2]) -> Result<CameraModel> {
        let bad = |key: &str| {
            let key = key.to_owned();
            move |error: Error| Error::Config { key, reason: error.to_string() }
        };
        let [fx, _, cx, _, fy, cy, ..] = self.matrix;
        let distortion =
            Distortion::from_ros(&self.distortion_model, &self.distortion).map_err(bad("distortion"))?;
        let camera = CameraModel { width, height, fx, fy, cx, cy, distortion };
        camera.validate().map_err(bad("camera_matrix"))
    }
}
