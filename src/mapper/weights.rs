//! The weight files of the networks that a map runs.

use std::path::Path;
use std::sync::Arc;

use super::SensorInfo;
use crate::base::{Error, Result};
use crate::config::{Config, Fusion, Method, Solidity};
use crate::gpu::Context;
use crate::network::Backend;
use crate::network::weights::{self, Network};
use crate::sensor::CameraInfo;
use crate::stage::camera::drm::Drm;
use crate::stage::camera::map_reliability::{self, MapReliability, knows_cells_of};
use crate::stage::lidar::solidity::{self, SolidityModel};

/// The bytes of the weight files that a configuration names, or else that limpid comes with, of the camera's network, of map
/// reliability and of solidity: what a result depends on beside its parameters.
///
/// # Errors
/// [`Error::File`].
pub fn weight_files(config: &Config) -> Result<Vec<Vec<u8>>> {
    let named = [(&config.weights, weights::SHIPPED), (&config.learned_weights, map_reliability::SHIPPED)];
    let read = named.into_iter().map(|(path, shipped)| match path.as_str() {
        "" => Ok(shipped.to_vec()),
        path => std::fs::read(path).map_err(Error::file(path)),
    });
    read.chain([Ok(solidity::SHIPPED.to_vec())]).collect()
}

/// The network of method drm; `None` for the others.
pub(super) fn load_drm(
    config: &Config,
    sensor: &SensorInfo,
    info: &CameraInfo,
    context: &Context,
) -> Result<Option<Drm>> {
    if config.method != Method::Drm {
        return Ok(None);
    }
    if info.color.is_none() {
        let why = sensor.color_missing.as_ref().map(|why| format!(": {why}")).unwrap_or_default();
        let reason = format!(
            "drm needs colour images, and none with a calibration is among the first frames{why} (auto and range take depth alone)"
        );
        return Err(Error::Config { key: "method".into(), reason });
    }
    let network = match config.weights.as_str() {
        "" => Network::shipped()?,
        file => Network::read(Path::new(file))?,
    };
    Ok(Some(Drm { network: Arc::new(network), backend: Backend::of(context) }))
}

/// The network of map reliability; `None` for the other fusions.
pub(super) fn load_map_reliability(fusion: Fusion, config: &Config) -> Result<Option<Arc<MapReliability>>> {
    if fusion != Fusion::Learned {
        return Ok(None);
    }
    let side_m = config.resolution_m;
    if !knows_cells_of(side_m) {
        let reason =
            format!("`learned` knows cells of 0.04 to 0.06 m, not of {side_m} m; `evidence` knows all");
        return Err(Error::Config { key: "fusion".into(), reason });
    }
    let network = match config.learned_weights.as_str() {
        "" => MapReliability::shipped()?,
        path => MapReliability::from_bytes(&std::fs::read(path).map_err(Error::file(path))?)?,
    };
    Ok(Some(Arc::new(network)))
}

/// The model of learned solidity; `None` where cells are solid by something else.
pub(super) fn load_solidity(config: &Config) -> Result<Option<Arc<SolidityModel>>> {
    let learned = config.settled_solidity() == Solidity::Learned;
    learned.then(|| SolidityModel::shipped().map(Arc::new)).transpose()
}
