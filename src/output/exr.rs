//! Buffers of every result as OpenEXR images, with its figures as JSON beside them.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use serde::Serialize;

use crate::base::Result;
use crate::base::Rigid;
use crate::config::Config;
use crate::config::SensorInfo;
use crate::map::{
    CameraUpdate, CellClass, Counters, Ground, GroundFrom, GroundPlane, LidarUpdate, MapUpdate, Seen, State,
    Update, Verdict,
};
use crate::output::{
    FileNames, Sink, create_folder, encode_error, grid_mismatch, narrow, pass_sums_ms, save_in_folder,
};
use crate::sensor::Observation;

/// Writes `DIR/NNNNNN/<buffer>.exr` and `DIR/NNNNNN/frame.json`, `NNNNNN` being the number of the frame or of the scan. Where
/// the map has several sensors, what is a sensor's own goes to `DIR/<name>/NNNNNN` and what is the map's to
/// `DIR/map/NNNNNN`.
///
/// Each EXR has one 32-bit float channel `Y`. Images have their own size; grids are stored with row 0 = smallest y. Buffers
/// that an update does not hold are left out:
///
/// - of the map: `costmap`; `class` ([`CellClass`] as its number); of its verdicts (spec 4 §4) `cost` before inflation,
///   `reason` (row of the rule), `sensor` (counted from 1; 0: none) and `age_s` (seconds);
/// - of a camera: `depth_m` and `reliability` (images), `evidence`, `occupancy`, `occupied`;
/// - of a lidar: `intensity_<layer>`, `true_positive`, `false_positive`, `false_negative`, `inflated`, `plan`.
pub struct DumpSink {
    folder: PathBuf,
    names: FileNames,
}

impl DumpSink {
    /// Creates the folder `folder` unless it is there; `sensors` as [`Update::sensor`] counts them.
    ///
    /// # Errors
    /// [`crate::Error::File`] where it cannot be created.
    pub fn create(folder: &Path, _config: &Config, sensors: &[SensorInfo]) -> Result<Self> {
        create_folder(folder)?;
        Ok(Self { folder: folder.into(), names: FileNames::of(sensors) })
    }

    /// Writes one folder of an update, `name` being the one above it; empty: there is none.
    fn write_part(
        &self,
        name: &str,
        update: &Update,
        map: Option<&MapUpdate>,
        seen: Option<&Seen>,
    ) -> Result<()> {
        // To join an empty name changes nothing.
        let above = self.folder.join(name);
        create_folder(&above)?;
        let folder = above.join(format!("{:06}", update.index));
        create_folder(&folder)?;
        if let Some(map) = map {
            write_map(&folder, map)?;
        }
        let cells = |count: usize| cells(update.map.as_ref(), count);
        match seen {
            Some(Seen::Camera(camera)) => write_camera(&folder, camera, cells)?,
            Some(Seen::Lidar(lidar)) => write_lidar(&folder, lidar, cells)?,
            None => {}
        }
        write_json(&folder.join("frame.json"), &Record::of(update, map, seen))
    }
}

impl Sink for DumpSink {
    fn write(&mut self, update: &Update, _observation: Option<&Observation>) -> Result<()> {
        let (map, seen) = (update.map.as_ref(), update.seen.as_ref());
        let (of_map, of_sensor) = (self.names.map(), self.names.sensor(update));
        if of_map == of_sensor {
            return self.write_part(of_map, update, map, seen);
        }
        if map.is_some() {
            self.write_part(of_map, update, map, None)?;
        }
        if seen.is_some() {
            self.write_part(of_sensor, update, None, seen)?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
}

/// Width and height of a grid of `count` cells: the map's, or of a square where the map is not there.
fn cells(map: Option<&MapUpdate>, count: usize) -> (usize, usize) {
    let side = count.isqrt();
    map.map_or((side, side), |map| (map.grid.width as usize, map.grid.height as usize))
}

fn write_map(folder: &Path, map: &MapUpdate) -> Result<()> {
    if let Some(reason) = grid_mismatch(map) {
        return Err(encode_error(folder, reason));
    }
    let size = cells(Some(map), map.costmap.len());
    let write = |name: &str, samples| write_exr(&folder.join(format!("{name}.exr")), size, samples);
    write("costmap", map.costmap.iter().map(|&cost| f32::from(cost)).collect())?;
    if !map.classes.is_empty() {
        write("class", map.classes.iter().map(|&class| f32::from(class)).collect())?;
    }
    if !map.verdicts.is_empty() {
        let of_all = |value: fn(Verdict) -> f32| map.verdicts.iter().map(|&verdict| value(verdict)).collect();
        write("cost", of_all(|verdict| f32::from(verdict.cost())))?;
        write("reason", of_all(|verdict| f32::from(verdict.reason())))?;
        write("sensor", of_all(|verdict| f32::from(verdict.sensor_number())))?;
        write("age_s", of_all(|verdict| narrow(verdict.age_s())))?;
    }
    Ok(())
}

fn write_camera(folder: &Path, camera: &CameraUpdate, cells: impl Fn(usize) -> (usize, usize)) -> Result<()> {
    let write = |name: &str, size, samples: &[f32]| {
        write_exr(&folder.join(format!("{name}.exr")), size, samples.to_vec())
    };
    if let Some(layers) = &camera.layers {
        for (name, samples) in
            [("evidence", &layers.evidence), ("occupancy", &layers.occupancy), ("occupied", &layers.occupied)]
        {
            write(name, cells(samples.len()), samples)?;
        }
    }
    if let Some(images) = &camera.images {
        let pixels = (images.width as usize, images.height as usize);
        write("depth_m", pixels, &images.depth_m)?;
        write("reliability", pixels, &images.reliability)?;
    }
    Ok(())
}

fn write_lidar(folder: &Path, lidar: &LidarUpdate, cells: impl Fn(usize) -> (usize, usize)) -> Result<()> {
    for (name, values) in lidar.layers.iter().flat_map(|layers| &layers.grids) {
        write_exr(&folder.join(format!("{name}.exr")), cells(values.len()), values.clone())?;
    }
    Ok(())
}

/// An image of `size` (width, height) with one 32-bit float channel `Y`.
///
/// # Errors
/// [`Error::File`], [`Error::Encode`] where the samples do not fill it.
pub(crate) fn write_exr(path: &Path, size: (usize, usize), samples: Vec<f32>) -> Result<()> {
    if size.0 * size.1 != samples.len() || samples.is_empty() {
        return Err(encode_error(
            path,
            format!("{} samples do not fill {}x{}", samples.len(), size.0, size.1),
        ));
    }
    let channel = AnyChannel::new("Y", FlatSamples::F32(samples));
    let channels = AnyChannels::sort([channel].into_iter().collect());
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::SMALL_FAST_LOSSLESS, channels);
    // Frames are written beside the GPU's work: one thread is enough and leaves the others alone.
    let mut bytes = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    written.map_err(|e| encode_error(path, e))?;
    save_in_folder(path, &bytes.into_inner())
}

fn write_json(path: &Path, record: &impl Serialize) -> Result<()> {
    let mut text = serde_json::to_string_pretty(record).map_err(|e| encode_error(path, e))?;
    text.push('\n');
    save_in_folder(path, text.as_bytes())
}

/// `frame.json`: the keys that apply.
#[derive(Serialize)]
struct Record<'a> {
    stamp_ns: u64,
    map_frame: &'a str,
    map_from_base: PoseRecord,
    #[serde(skip_serializing_if = "Option::is_none")]
    state: Option<State>,
    #[serde(flatten)]
    map: Option<MapRecord>,
    #[serde(flatten)]
    seen: Option<SeenRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ground: Option<GroundRecord>,
    pass_ms: BTreeMap<&'a str, f64>,
}

/// What concerns the map.
#[derive(Serialize)]
struct MapRecord {
    origin_x_m: f64,
    origin_y_m: f64,
    resolution_m: f64,
    width: u32,
    height: u32,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    cells: BTreeMap<&'static str, usize>,
}

/// What concerns a sensor.
#[derive(Serialize)]
#[serde(untagged)]
enum SeenRecord {
    Camera { base_from_camera: PoseRecord, low_reliability_fraction: f64, counters: Counters },
    Lidar { base_from_lidar: PoseRecord, points: usize },
}

/// The ground as the sensor knows it.
#[derive(Serialize)]
struct GroundRecord {
    from: GroundFrom,
    agrees: bool,
    seen: bool,
    sensor_height_m: f64,
    support: f64,
    area_m2: f64,
    pierced_m2: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    plane: Option<PlaneRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    above_stated_m: Option<f64>,
}

/// A plane below the sensor.
#[derive(Serialize)]
struct PlaneRecord {
    normal: [f64; 3],
    below_m: f64,
    tilt_deg: f64,
    messages: u32,
}

impl From<&Ground> for GroundRecord {
    fn from(ground: &Ground) -> Self {
        let plane = |plane: GroundPlane| PlaneRecord {
            normal: plane.normal.to_array(),
            below_m: plane.below_m,
            tilt_deg: plane.tilt_deg(),
            messages: plane.messages,
        };
        Self {
            from: ground.from,
            agrees: ground.agrees,
            seen: ground.seen,
            sensor_height_m: ground.sensor_height_m,
            support: ground.support,
            area_m2: ground.area_m2,
            pierced_m2: ground.pierced_m2,
            plane: ground.plane.map(plane),
            above_stated_m: ground.above_stated_m,
        }
    }
}

#[derive(Serialize)]
struct PoseRecord {
    translation_m: [f64; 3],
    rotation_xyzw: [f64; 4],
}

impl From<Rigid> for PoseRecord {
    fn from(rigid: Rigid) -> Self {
        Self { translation_m: rigid.translation_m.to_array(), rotation_xyzw: rigid.rotation.to_array() }
    }
}

impl<'a> Record<'a> {
    fn of(update: &'a Update, map: Option<&MapUpdate>, seen: Option<&Seen>) -> Self {
        Self {
            stamp_ns: update.stamp_ns,
            map_frame: &update.map_frame,
            map_from_base: update.map_from_base.into(),
            state: map.map(|map| map.state).or_else(|| seen?.state()),
            map: map.map(MapRecord::of),
            seen: seen.map(|seen| SeenRecord::of(seen, update.base_from_sensor)),
            ground: update.ground.as_ref().filter(|_| seen.is_some()).map(GroundRecord::from),
            pass_ms: pass_sums_ms(update).into_iter().collect(),
        }
    }
}

impl MapRecord {
    fn of(map: &MapUpdate) -> Self {
        let classes = CellClass::ALL.into_iter().filter(|_| !map.classes.is_empty());
        Self {
            origin_x_m: map.grid.origin_x_m,
            origin_y_m: map.grid.origin_y_m,
            resolution_m: map.grid.resolution_m,
            width: map.grid.width,
            height: map.grid.height,
            cells: classes.map(|class| (class.name(), map.count(class))).collect(),
        }
    }
}

impl SeenRecord {
    fn of(seen: &Seen, base_from_sensor: Rigid) -> Self {
        match seen {
            Seen::Camera(camera) => Self::Camera {
                base_from_camera: base_from_sensor.into(),
                low_reliability_fraction: camera.low_reliability_fraction,
                counters: camera.counters,
            },
            Seen::Lidar(lidar) => {
                Self::Lidar { base_from_lidar: base_from_sensor.into(), points: lidar.points }
            }
        }
    }
}
