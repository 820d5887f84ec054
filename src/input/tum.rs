//! TUM RGB-D folders: `rgb.txt`, `depth.txt`, `groundtruth.txt` and `camera.yaml`.

use std::collections::VecDeque;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::base::Rigid;
use crate::base::duration_ns;
use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::apart::apart_text;
use crate::input::event::TransformEvent;
use crate::input::frames::Posing;
use crate::input::image_decode::{color_from_file, depth_from_png, read_file};
use crate::input::pose::PoseResolver;
use crate::input::start::open_file;
use crate::input::stated::StatedCamera;
use crate::input::{ReadReport, Recording};
use crate::message::bare_name;
use crate::sensor::{CameraModel, Distortion, SensorKind};
use crate::sensor::{ColorImage, DepthImage, FramePose, RgbdFrame};

/// Largest list that is read, bytes: more than three million images.
const MAX_LIST_BYTES: u64 = 256 << 20;

/// Name of the camera's frame where the configuration gives none.
const CAMERA_FRAME: &str = "camera";

/// `camera.yaml`: the keys of ROS's camera_info files and the unit of depth.
#[derive(Deserialize)]
struct CameraFile {
    image_width: u32,
    image_height: u32,
    #[serde(default)]
    distortion_model: String,
    camera_matrix: Matrix,
    #[serde(default)]
    distortion_coefficients: Matrix,
    depth_scale_m: Option<f64>,
}

/// A row-major matrix; its `rows` and `cols` are not needed.
#[derive(Default, Deserialize)]
struct Matrix {
    data: Vec<f64>,
}

/// An image of a list file.
struct Entry {
    stamp_ns: u64,
    name: String,
}

/// Reads a TUM RGB-D folder; see the module and [`Recording`].
///
/// `groundtruth.txt` gives the camera in the map; the base comes from `static_transforms`, or is
/// derived from the camera and said to be in the notes. Colour and depth share one calibration.
pub struct TumReader {
    folder: PathBuf,
    camera: CameraModel,
    depth_unit_m: f64,
    pair_tolerance_ns: u64,
    map_frame: String,
    camera_frame: String,
    depth: std::vec::IntoIter<Entry>,
    depth_count: u64,
    colors: Vec<Entry>,
    /// Poses still to come, `map_from_camera`, in order of stamps.
    trajectory: VecDeque<(u64, Rigid)>,
    /// Stamp of the newest pose taken in.
    pose_ns: Option<u64>,
    poses: PoseResolver,
    last_ns: Option<u64>,
    posing: Posing,
    report: ReadReport,
}

impl TumReader {
    /// Opens a folder and reads its lists.
    ///
    /// # Errors
    /// [`Error::File`] and [`Error::Format`] for lists and calibrations that are absent or damaged
    /// (`rgb.txt` and `groundtruth.txt` may be absent, which is noted); [`Error::Config`] for a stated
    /// transform that is not a transform.
    pub fn open(folder: &Path, config: &Config) -> Result<Self> {
        let mut report = ReadReport::default();
        let depth = read_list(folder, "depth.txt", &mut report)?;
        let (camera, scale_m) = camera_of(folder, &depth, config)?;
        let mut colors = read_optional(folder, "rgb.txt", &mut report, read_list)?;
        let mut trajectory = read_optional(folder, "groundtruth.txt", &mut report, read_trajectory)?;
        colors.sort_by_key(|entry| entry.stamp_ns);
        trajectory.sort_by_key(|&(stamp_ns, _)| stamp_ns);
        let named = !config.camera_frame.is_empty();
        Ok(Self {
            folder: folder.into(),
            camera,
            depth_unit_m: scale_m.unwrap_or(config.depth_unit_m),
            pair_tolerance_ns: duration_ns(config.pair_tolerance_s),
            map_frame: bare_name(&config.map_frame).into(),
            camera_frame: if named { bare_name(&config.camera_frame).into() } else { CAMERA_FRAME.into() },
            depth_count: depth.len() as u64,
            depth: depth.into_iter(),
            colors,
            trajectory: trajectory.into(),
            pose_ns: None,
            poses: PoseResolver::new(config)?,
            last_ns: None,
            posing: Posing::default(),
            report,
        })
    }

    fn frame(&mut self, index: u64, entry: &Entry) -> Result<RgbdFrame> {
        let decoded = depth_from_png(&read_file(&self.folder.join(&entry.name))?, self.depth_unit_m)?;
        self.fits(&entry.name, decoded.width, decoded.height)?;
        let depth = DepthImage {
            stamp_ns: entry.stamp_ns,
            frame_id: self.camera_frame.clone(),
            camera: self.camera,
            samples: decoded.samples,
        };
        let color = self.color(entry.stamp_ns);
        let (color_missing, color) = (color.as_ref().err().cloned(), color.ok());
        let color_from_depth = color.as_ref().map(|_| Rigid::IDENTITY);
        let pose = self.pose(entry.stamp_ns);
        Ok(RgbdFrame { index, depth, color, color_from_depth, color_missing, confidence: None, pose })
    }

    /// The colour image nearest in time, within the tolerance; or why there is none.
    fn color(&mut self, stamp_ns: u64) -> Result<ColorImage, String> {
        let after = self.colors.partition_point(|entry| entry.stamp_ns < stamp_ns);
        let around = &self.colors[after.saturating_sub(1)..self.colors.len().min(after + 1)];
        let apart_ns = |entry: &&Entry| entry.stamp_ns.abs_diff(stamp_ns);
        let nearest = around.iter().min_by_key(apart_ns);
        let within = nearest.filter(|entry| apart_ns(entry) <= self.pair_tolerance_ns);
        let Some(nearest) = within else {
            return Err(apart_text(nearest.as_ref().map(apart_ns), self.pair_tolerance_ns));
        };
        let (stamp_ns, name) = (nearest.stamp_ns, &nearest.name);
        let image = read_file(&self.folder.join(name)).and_then(|file| color_from_file(&file));
        let checked = image.and_then(|image| self.fits(name, image.width, image.height).map(|()| image));
        match checked {
            Ok(image) => Ok(ColorImage { stamp_ns, camera: self.camera, rgb: image.samples }),
            Err(error) => {
                self.report.skip("rgb.txt", error.to_string(), stamp_ns);
                Err("an image of rgb.txt cannot be used".into())
            }
        }
    }

    fn fits(&self, name: &str, width: u32, height: u32) -> Result<()> {
        if (self.camera.width, self.camera.height) == (width, height) {
            return Ok(());
        }
        let reason = format!(
            "is {width}x{height}, but camera.yaml is for {}x{}",
            self.camera.width, self.camera.height
        );
        Err(Error::Format { path: self.folder.join(name), reason })
    }

    fn pose(&mut self, stamp_ns: u64) -> Option<FramePose> {
        // Up to the first pose after the stamp, so that it can be interpolated; no further, or the poses that later frames
        // need leave the buffer's window.
        while self.pose_ns.is_none_or(|pose_ns| pose_ns <= stamp_ns) {
            let Some((pose_ns, map_from_camera)) = self.trajectory.pop_front() else { break };
            let event = TransformEvent {
                parent: self.map_frame.clone(),
                child: self.camera_frame.clone(),
                stamp_ns: pose_ns,
                fixed: false,
                parent_from_child: Some(map_from_camera),
            };
            self.poses.frames.see(&event);
            self.poses.tree.insert(&self.map_frame, &self.camera_frame, pose_ns, map_from_camera);
            self.pose_ns = Some(pose_ns);
        }
        match self.poses.pose(&self.camera_frame, stamp_ns, self.poses.tolerance_ns) {
            Ok(resolved) => {
                if resolved.base_derived {
                    self.report.note(self.poses.derived_note());
                }
                self.posing.posed += 1;
                Some(resolved.pose)
            }
            Err(error) => {
                let reason = self.poses.missing_reason(&self.camera_frame, &error);
                self.report.skip("depth.txt", reason, stamp_ns);
                self.posing.miss(&self.camera_frame, stamp_ns, &error);
                None
            }
        }
    }
}

impl Recording for TumReader {
    fn next_frame(&mut self) -> Result<Option<RgbdFrame>> {
        while let Some(entry) = self.depth.next() {
            let index = self.report.depth_images;
            self.report.depth_images += 1;
            if self.last_ns.is_some_and(|last_ns| entry.stamp_ns <= last_ns) {
                let reason = "its stamp is not after the previous depth image's";
                self.report.skip("depth.txt", reason, entry.stamp_ns);
                continue;
            }
            self.last_ns = Some(entry.stamp_ns);
            match self.frame(index, &entry) {
                Ok(frame) => return Ok(Some(frame)),
                Err(error) => self.report.skip("depth.txt", error.to_string(), entry.stamp_ns),
            }
        }
        let without = "the folder has no poses (groundtruth.txt)";
        let told = self.poses.explain(&self.posing, SensorKind::Camera, without, "");
        told.into_iter().for_each(|told| self.report.tell_frames(told));
        Ok(None)
    }

    fn report(&self) -> &ReadReport {
        &self.report
    }

    fn frame_count_hint(&self) -> Option<u64> {
        Some(self.depth_count)
    }
}

/// What `camera.yaml` holds, for those who have none: TUM's own sequences have it in their documentation alone.
const CAMERA_EXAMPLE: &str = "\
image_width: 640
image_height: 480
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.0, 0.0, 0.0, 0.0, 0.0]}
camera_matrix: {rows: 3, cols: 3, data: [525.0, 0.0, 319.5, 0.0, 525.0, 239.5, 0.0, 0.0, 1.0]}
depth_scale_m: 0.0002
";

/// The calibration and metres per count of depth: of `camera.yaml`, or else as the configuration states them for images of
/// the size of the first.
fn camera_of(folder: &Path, depth: &[Entry], config: &Config) -> Result<(CameraModel, Option<f64>)> {
    let path = folder.join("camera.yaml");
    if path.exists() {
        return read_camera(&path);
    }
    let Some(stated) = StatedCamera::of(config) else {
        let reason = format!(
            "is missing. It holds the calibration that depth and colour share and the metres per count of depth \
             (0.0002 in TUM's own sequences, whose 16-bit images count 5000 to the metre), for instance:\n\n{CAMERA_EXAMPLE}\n\
             Or state `camera_matrix` and `depth_unit_m` in the configuration"
        );
        return Err(Error::Format { path, reason });
    };
    let first = depth.iter().find_map(|entry| {
        let file = read_file(&folder.join(&entry.name)).ok()?;
        depth_from_png(&file, config.depth_unit_m).ok()
    });
    let none = || Error::Format {
        path: folder.join("depth.txt"),
        reason: "names no 16-bit PNG that can be read".into(),
    };
    let first = first.ok_or_else(none)?;
    Ok((stated.camera([first.width, first.height])?, None))
}

/// The calibration and metres per count of depth, where the file says.
fn read_camera(path: &Path) -> Result<(CameraModel, Option<f64>)> {
    let bad = |reason: String| Error::Format { path: path.into(), reason };
    let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
    let file: CameraFile = serde_saphyr::from_str(&text).map_err(|error| bad(error.to_string()))?;
    let &[fx, _, cx, _, fy, cy, _, _, _] = &file.camera_matrix.data[..] else {
        return Err(bad(format!(
            "camera_matrix has {} numbers in place of 9",
            file.camera_matrix.data.len()
        )));
    };
    if let Some(scale_m) = file.depth_scale_m.filter(|scale_m| !(scale_m.is_finite() && *scale_m > 0.0)) {
        return Err(bad(format!("depth_scale_m = {scale_m} is not a positive number")));
    }
    let distortion = Distortion::from_ros(&file.distortion_model, &file.distortion_coefficients.data)
        .map_err(|error| bad(error.to_string()))?;
    let camera =
        CameraModel { width: file.image_width, height: file.image_height, fx, fy, cx, cy, distortion };
    Ok((camera.validate().map_err(|error| bad(error.to_string()))?, file.depth_scale_m))
}

/// As `read`, but a file that is absent is noted and empty.
fn read_optional<T>(
    folder: &Path,
    name: &str,
    report: &mut ReadReport,
    read: impl Fn(&Path, &str, &mut ReadReport) -> Result<Vec<T>>,
) -> Result<Vec<T>> {
    if folder.join(name).exists() {
        return read(folder, name, report);
    }
    report.note(format!("the folder has no {name}"));
    Ok(Vec::new())
}

/// The lines `stamp name` of a list; others are counted.
fn read_list(folder: &Path, name: &str, report: &mut ReadReport) -> Result<Vec<Entry>> {
    read_lines(folder, name, report, |fields| match *fields {
        [stamp, name] => Some(Entry { stamp_ns: parse_stamp_ns(stamp)?, name: name.into() }),
        _ => None,
    })
}

/// The lines `stamp tx ty tz qx qy qz qw` of a trajectory; others are counted.
fn read_trajectory(folder: &Path, name: &str, report: &mut ReadReport) -> Result<Vec<(u64, Rigid)>> {
    read_lines(folder, name, report, |fields| {
        let (stamp, numbers) = fields.split_first()?;
        let numbers = numbers.iter().map(|number| number.parse()).collect::<Result<Vec<f64>, _>>().ok()?;
        match numbers[..] {
            [tx, ty, tz, qx, qy, qz, qw] => {
                Some((parse_stamp_ns(stamp)?, Rigid::new([tx, ty, tz], [qx, qy, qz, qw])?))
            }
            _ => None,
        }
    })
}

/// The poses of a trajectory file, lines `stamp tx ty tz qx qy qz qw` (seconds, metres, quaternion), in its order: stamp in
/// nanoseconds and pose. Other lines are passed over.
///
/// # Errors
/// [`Error::File`]; [`Error::Format`] where no line is a pose.
pub fn trajectory(path: &Path) -> Result<Vec<(u64, Rigid)>> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let poses = read_trajectory(folder, &name, &mut ReadReport::default())?;
    if poses.is_empty() {
        return Err(Error::Format { path: path.into(), reason: "has no line `t x y z qx qy qz qw`".into() });
    }
    Ok(poses)
}

fn read_lines<T>(
    folder: &Path,
    name: &str,
    report: &mut ReadReport,
    parse: impl Fn(&[&str]) -> Option<T>,
) -> Result<Vec<T>> {
    let path = folder.join(name);
    let mut text = String::new();
    let mut file = open_file(&path)?.take(MAX_LIST_BYTES + 1);
    file.read_to_string(&mut text).map_err(Error::file(&path))?;
    if text.len() as u64 > MAX_LIST_BYTES {
        return Err(Error::Format { path, reason: "is larger than 256 MiB: no list of images is".into() });
    }
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let mut parsed = Vec::new();
    for line in lines {
        match parse(&line.split_whitespace().collect::<Vec<_>>()) {
            Some(value) => parsed.push(value),
            None => report.skip(name, "the line does not have the fields of its list", 0),
        }
    }
    Ok(parsed)
}

/// Nanoseconds of decimal seconds, exact; digits past the ninth are dropped.
fn parse_stamp_ns(text: &str) -> Option<u64> {
    let (seconds, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    if seconds.is_empty() || !digits(seconds) || !digits(fraction) {
        return None;
    }
    let nanos: String = fraction.chars().chain("000000000".chars()).take(9).collect();
    seconds.parse::<u64>().ok()?.checked_mul(1_000_000_000)?.checked_add(nanos.parse().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_exact_to_the_nanosecond() {
        assert_eq!(parse_stamp_ns("1700000000.333333"), Some(1_700_000_000_333_333_000));
        assert_eq!(parse_stamp_ns("1305031102.175304321"), Some(1_305_031_102_175_304_321));
        assert_eq!(parse_stamp_ns("7"), Some(7_000_000_000));
        for bad in ["", ".5", "-1.0", "1e9", "1.0x", "99999999999999999999"] {
            assert_eq!(parse_stamp_ns(bad), None, "{bad}");
        }
    }
}
