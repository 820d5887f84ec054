//! What belongs to a depth image that waits for nothing any more, as one frame.

use std::collections::VecDeque;

use crate::base::Rigid;
use crate::input::ReadReport;
use crate::input::apart::apart_text;
use crate::input::calibrations::fitted;
use crate::input::image_message::ImageMessage;
use crate::input::pose::PoseResolver;
use crate::input::sync::Synchronizer;
use crate::sensor::{CameraModel, ColorImage, DepthImage, FramePose, RgbdFrame};

impl Synchronizer {
    /// The depth image, or why there is none.
    pub(super) fn depth(&self, image: &ImageMessage, report: &mut ReadReport) -> Result<DepthImage, String> {
        let decoded = image.depth(self.depth_unit_m).map_err(|error| error.to_string())?;
        let size = [decoded.width, decoded.height];
        let camera = match &self.stated {
            Some(stated) => stated.camera(size).map_err(|error| error.to_string())?,
            None => {
                let missing = || self.uncalibrated(Some(&image.frame_id));
                let calibrations = self.depth_calibrations(&image.frame_id).ok_or_else(missing)?;
                let name = self.info_name();
                fitted(calibrations.camera(size, &self.streams.depth)?, &name, &self.streams.depth, report)
            }
        };
        Ok(DepthImage {
            stamp_ns: image.stamp_ns,
            frame_id: self.depth_frame(image).into(),
            camera,
            samples: decoded.samples.in_metres(self.float_depth_unit_m),
        })
    }

    /// Where the depth image's calibration is expected, for messages.
    fn info_name(&self) -> String {
        match &self.streams.depth_info {
            Some(topic) => format!("`{topic}`"),
            None => "any calibration topic for its frame".into(),
        }
    }

    /// That depth has no calibration, and what was wrong with those that came.
    pub(crate) fn uncalibrated(&self, frame_id: Option<&str>) -> String {
        let refused = self.calibrations.why_refused(self.streams.depth_info.as_deref(), frame_id);
        format!("no usable calibration came on {}{refused}", self.info_name())
    }

    pub(super) fn frame(
        &mut self,
        index: u64,
        image: &ImageMessage,
        depth: DepthImage,
        poses: &PoseResolver,
        report: &mut ReadReport,
    ) -> RgbdFrame {
        let Colored { color, color_from_depth, color_missing } = self.colored(image, &depth, poses, report);
        let confidence = self.confidence(&depth, report);
        let pose = self.pose(&depth, poses, report);
        RgbdFrame { index, depth, color, color_from_depth, color_missing, confidence, pose }
    }

    /// The colour of a depth image and its place, as far as they can be had.
    fn colored(
        &self,
        image: &ImageMessage,
        depth: &DepthImage,
        poses: &PoseResolver,
        report: &mut ReadReport,
    ) -> Colored {
        let message = match self.nearest(&self.colors, image.stamp_ns) {
            Some(message) => message,
            None => return Colored::without(self.no_color_near(image.stamp_ns)),
        };
        let color = match self.color(message, image, depth, report) {
            Ok(color) => color,
            Err(reason) => {
                report.skip(self.streams.color.as_deref().unwrap_or("colour"), &*reason, message.stamp_ns);
                return Colored::without(reason);
            }
        };
        let placed = self.color_from_depth(&message.frame_id, image, poses);
        let color_missing = placed.as_ref().err().cloned();
        color_missing.iter().for_each(|reason| report.note(&**reason));
        Colored { color: Some(color), color_from_depth: placed.ok(), color_missing }
    }

    /// Why no colour image is near a stamp, with the distance of the nearest to a step.
    fn no_color_near(&self, stamp_ns: u64) -> String {
        if self.streams.color.is_none() {
            return "the recording has no colour of this camera".into();
        }
        let apart = self.colors.iter().map(|image| image.stamp_ns.abs_diff(stamp_ns)).min();
        apart_text(apart, self.pair_tolerance_ns)
    }

    fn nearest<'a>(&self, kept: &'a VecDeque<ImageMessage>, stamp_ns: u64) -> Option<&'a ImageMessage> {
        kept.iter()
            .filter(|image| image.stamp_ns.abs_diff(stamp_ns) <= self.pair_tolerance_ns)
            .min_by_key(|image| image.stamp_ns.abs_diff(stamp_ns))
    }

    fn color(
        &self,
        message: &ImageMessage,
        image: &ImageMessage,
        depth: &DepthImage,
        report: &mut ReadReport,
    ) -> Result<ColorImage, String> {
        let decoded = message.color().map_err(|error| error.to_string())?;
        let (info, topic) = (self.streams.color_info.as_deref(), self.streams.color.as_deref());
        let topic = topic.unwrap_or_default();
        let size = [decoded.width, decoded.height];
        let camera = match self.calibrations.of(info, &message.frame_id) {
            Some(own) => fitted(own.camera(size, topic)?, "for colour", topic, report),
            None if message.frame_id == image.frame_id => fits(depth.camera, size)?,
            None => {
                let refused = self.calibrations.why_refused(info, Some(&message.frame_id));
                return Err(format!("no usable calibration came for the colour camera{refused}"));
            }
        };
        Ok(ColorImage { stamp_ns: message.stamp_ns, camera, rgb: decoded.samples })
    }

    fn color_from_depth(
        &self,
        color_frame: &str,
        image: &ImageMessage,
        poses: &PoseResolver,
    ) -> Result<Rigid, String> {
        if color_frame == image.frame_id {
            return Ok(Rigid::IDENTITY);
        }
        let depth_frame = self.depth_frame(image);
        let found = poses.lookup(color_frame, depth_frame, image.stamp_ns, self.transform_tolerance_ns);
        found.map_err(|error| format!("no transform from `{depth_frame}` to `{color_frame}`: {error}"))
    }

    fn confidence(&self, depth: &DepthImage, report: &mut ReadReport) -> Option<Vec<f32>> {
        let message = self.nearest(&self.confidences, depth.stamp_ns)?;
        let decoded = message.confidence().map_err(|error| error.to_string()).and_then(|decoded| {
            let same = (decoded.width, decoded.height) == (depth.camera.width, depth.camera.height);
            if same { Ok(decoded.samples) } else { Err("its size is not the depth image's".into()) }
        });
        let topic = self.streams.confidence.as_deref().unwrap_or("confidence");
        decoded.map_err(|reason| report.skip(topic, reason, message.stamp_ns)).ok()
    }

    fn pose(
        &mut self,
        depth: &DepthImage,
        poses: &PoseResolver,
        report: &mut ReadReport,
    ) -> Option<FramePose> {
        match poses.pose(&depth.frame_id, depth.stamp_ns, self.transform_tolerance_ns) {
            Ok(resolved) => {
                if resolved.base_derived {
                    report.note(poses.derived_note());
                }
                self.posing.posed += 1;
                Some(resolved.pose)
            }
            Err(error) => {
                self.posing.miss(&depth.frame_id, depth.stamp_ns, &error);
                let reason = poses.missing_reason(&depth.frame_id, &error);
                report.skip(&self.streams.depth, reason, depth.stamp_ns);
                None
            }
        }
    }
}

/// A frame's colour and its place, or what is missing.
struct Colored {
    color: Option<ColorImage>,
    color_from_depth: Option<Rigid>,
    color_missing: Option<String>,
}

impl Colored {
    fn without(reason: String) -> Self {
        Self { color: None, color_from_depth: None, color_missing: Some(reason) }
    }
}

fn fits(camera: CameraModel, [width, height]: [u32; 2]) -> Result<CameraModel, String> {
    if [camera.width, camera.height] == [width, height] {
        return Ok(camera);
    }
    Err(format!("its calibration is for {}x{}, but it is {width}x{height}", camera.width, camera.height))
}
