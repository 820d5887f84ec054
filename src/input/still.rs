//! A folder with one depth image and, if there is one, the colour image that goes with it.

use std::path::{Path, PathBuf};

use crate::base::Rigid;
use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::frames::Posing;
use crate::input::image_decode::{color_from_file, depth_from_file, read_file};
use crate::input::pose::PoseResolver;
use crate::input::stated::StatedCamera;
use crate::input::{ReadReport, Recording};
use crate::message::bare_name;
use crate::sensor::{CameraModel, SensorKind};
use crate::sensor::{ColorImage, DepthImage, RgbdFrame};

/// Name of the camera's frame where the configuration gives none.
const CAMERA_FRAME: &str = "camera";

/// Reads one still pair, named by `depth_file`, `color_file` and `camera_matrix`; see [`Recording`].
///
/// Colour and depth are aligned; the pose comes from `static_transforms`, to `camera_frame` or, where
/// that is empty, to `camera`. The frame's stamp is 0.
pub struct StillReader {
    folder: PathBuf,
    config: Config,
    poses: PoseResolver,
    done: bool,
    report: ReadReport,
}

impl StillReader {
    /// Prepares to read; the images are opened with the first frame.
    ///
    /// # Errors
    /// [`Error::Config`] without a `depth_file` or with transforms that are none.
    pub fn open(folder: &Path, config: &Config) -> Result<Self> {
        if config.depth_file.is_empty() {
            let reason = "names the depth image of a still pair, but is empty".into();
            return Err(Error::Config { key: "depth_file".into(), reason });
        }
        Ok(Self {
            folder: folder.into(),
            poses: PoseResolver::new(config)?,
            config: config.clone(),
            done: false,
            report: ReadReport::default(),
        })
    }

    fn frame(&mut self) -> Result<RgbdFrame> {
        let path = self.folder.join(&self.config.depth_file);
        let decoded = depth_from_file(&read_file(&path)?, self.config.depth_unit_m)?;
        let camera = self.camera([decoded.width, decoded.height])?;
        let named = !self.config.camera_frame.is_empty();
        let frame_id =
            if named { bare_name(&self.config.camera_frame).to_owned() } else { CAMERA_FRAME.into() };
        let pose = match self.poses.pose(&frame_id, 0, self.poses.tolerance_ns) {
            Ok(resolved) => {
                if resolved.base_derived {
                    self.report.note(self.poses.derived_note());
                }
                Some(resolved.pose)
            }
            Err(error) => {
                let reason = self.poses.missing_reason(&frame_id, &error);
                self.report.skip(&self.config.depth_file, reason, 0);
                let mut posing = Posing::default();
                posing.miss(&frame_id, 0, &error);
                let told =
                    self.poses.explain(&posing, SensorKind::Camera, "a still pair has no transforms", "");
                told.into_iter().for_each(|told| self.report.tell_frames(told));
                None
            }
        };
        let color = self.color(camera)?;
        let color_from_depth = color.as_ref().map(|_| Rigid::IDENTITY);
        let depth = DepthImage {
            stamp_ns: 0,
            frame_id,
            camera,
            samples: decoded.samples.in_metres(self.config.float_depth_unit_m),
        };
        let color_missing = color.is_none().then(|| "the configuration names no color_file".into());
        Ok(RgbdFrame { index: 0, depth, color, color_from_depth, color_missing, confidence: None, pose })
    }

    fn camera(&self, size: [u32; 2]) -> Result<CameraModel> {
        let missing = || {
            let reason = "is needed for a still pair: fx 0 cx 0 fy cy 0 0 1 in pixels, and fx = 0 now".into();
            Error::Config { key: "camera_matrix".into(), reason }
        };
        StatedCamera::of(&self.config).ok_or_else(missing)?.camera(size)
    }

    fn color(&self, camera: CameraModel) -> Result<Option<ColorImage>> {
        if self.config.color_file.is_empty() {
            return Ok(None);
        }
        let path = self.folder.join(&self.config.color_file);
        let image = color_from_file(&read_file(&path)?)?;
        if (image.width, image.height) != (camera.width, camera.height) {
            let reason = format!(
                "is {}x{}, but the depth image {}x{}: the pair must be aligned",
                image.width, image.height, camera.width, camera.height
            );
            return Err(Error::Format { path, reason });
        }
        Ok(Some(ColorImage { stamp_ns: 0, camera, rgb: image.samples }))
    }
}

impl Recording for StillReader {
    fn next_frame(&mut self) -> Result<Option<RgbdFrame>> {
        if self.done {
            return Ok(None);
        }
        self.done = true;
        self.report.depth_images = 1;
        self.frame().map(Some)
    }

    fn report(&self) -> &ReadReport {
        &self.report
    }

    fn frame_count_hint(&self) -> Option<u64> {
        Some(1)
    }
}
