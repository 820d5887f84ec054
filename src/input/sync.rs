//! Brings together what belongs to a depth image of one camera: colour, confidence, calibration, pose.
//!
//! Depth images wait, in order of their stamps, until what belongs to them has come or can no longer
//! come: a later colour image has passed, images have gone on for [`WAIT_NS`], the queue is full, or
//! the recording is at its end.

use std::collections::{BTreeMap, VecDeque};

use crate::base::Rigid;
use crate::base::duration_ns;
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::event::{Event, Streams};
use crate::input::image_message::ImageMessage;
use crate::input::pose::PoseResolver;
use crate::input::transforms::JUMP_NS;
use crate::sensor::CameraModel;
use crate::sensor::{ColorImage, DepthImage, FramePose, RgbdFrame};

/// How long images go on before a depth image stops waiting, nanoseconds of recording time.
const WAIT_NS: u64 = 2_000_000_000;

/// Most depth images that wait.
const MAX_PENDING: usize = 64;

/// Most colour and most confidence images kept.
const MAX_KEPT: usize = 128;

struct Calibration {
    frame_id: String,
    camera: CameraModel,
    /// The one before that, where it was another: images that wait may still be of it.
    before: Option<CameraModel>,
}

impl Calibration {
    /// The newest for images of a size, or the newest of all.
    fn for_size(&self, width: u32, height: u32) -> CameraModel {
        let all = [Some(self.camera), self.before].into_iter().flatten();
        let mut fitting = all.filter(|camera| (camera.width, camera.height) == (width, height));
        fitting.next().unwrap_or(self.camera)
    }
}

struct Pending {
    index: u64,
    image: ImageMessage,
}

/// See the module.
pub(crate) struct Synchronizer {
    streams: Streams,
    camera_frame: String,
    depth_unit_m: f64,
    pair_tolerance_ns: u64,
    transform_tolerance_ns: u64,
    calibrations: BTreeMap<String, Calibration>,
    /// In order of stamps.
    pending: VecDeque<Pending>,
    colors: VecDeque<ImageMessage>,
    confidences: VecDeque<ImageMessage>,
    ready: VecDeque<RgbdFrame>,
    newest_image_ns: u64,
    last_released_ns: Option<u64>,
}

impl Synchronizer {
    pub(crate) fn new(config: &Config, streams: Streams) -> Self {
        Self {
            streams,
            camera_frame: config.camera_frame.clone(),
            depth_unit_m: config.depth_unit_m,
            pair_tolerance_ns: duration_ns(config.pair_tolerance_s),
            transform_tolerance_ns: duration_ns(config.transform_tolerance_s),
            calibrations: BTreeMap::new(),
            pending: VecDeque::new(),
            colors: VecDeque::new(),
            confidences: VecDeque::new(),
            ready: VecDeque::new(),
            newest_image_ns: 0,
            last_released_ns: None,
        }
    }

    /// The next frame that waits for nothing any more.
    pub(crate) fn pop(&mut self) -> Option<RgbdFrame> {
        self.ready.pop_front()
    }

    /// Whether a usable calibration for depth has come.
    pub(crate) fn calibrated(&self) -> bool {
        !self.calibrations.is_empty()
    }

    /// Stamp of the earliest depth image that waits, nanoseconds.
    pub(crate) fn waiting_ns(&self) -> Option<u64> {
        self.pending.front().map(|pending| pending.image.stamp_ns)
    }

    /// How many depth images wait.
    pub(crate) fn waiting(&self) -> u64 {
        self.pending.len() as u64
    }

    /// What of an image jumps back by more than a second: then the caller has this start over.
    pub(crate) fn jump(&self, event: &Event) -> Option<&'static str> {
        let newest_ns = |kept: &VecDeque<ImageMessage>| kept.back().map(|newest| newest.stamp_ns);
        let (what, newest_ns, image) = match event {
            Event::Depth(image) => {
                let newest_ns = self.pending.back().map(|newest| newest.image.stamp_ns);
                ("depth stamps", newest_ns.or(self.last_released_ns), image)
            }
            Event::Color(image) => ("colour stamps", newest_ns(&self.colors), image),
            Event::Confidence(image) => ("confidence stamps", newest_ns(&self.confidences), image),
            Event::Calibration { .. } => return None,
        };
        newest_ns.is_some_and(|ns| image.stamp_ns.saturating_add(JUMP_NS) < ns).then_some(what)
    }

    /// Takes in what the recording says next.
    pub(crate) fn push(&mut self, event: Event, poses: &PoseResolver, report: &mut ReadReport) {
        match event {
            Event::Depth(image) => self.push_depth(image, report),
            Event::Color(image) => {
                self.newest_image_ns = self.newest_image_ns.max(image.stamp_ns);
                keep(&mut self.colors, image);
            }
            Event::Confidence(image) => keep(&mut self.confidences, image),
            Event::Calibration { topic, frame_id, camera } => {
                let old = self.calibrations.remove(&topic);
                let before = old.and_then(|old| Some(old.camera).filter(|was| *was != camera).or(old.before));
                self.calibrations.insert(topic, Calibration { frame_id, camera, before });
            }
        }
        self.settle(poses, report);
        self.forget();
    }

    /// Releases what waits for nothing any more.
    pub(crate) fn settle(&mut self, poses: &PoseResolver, report: &mut ReadReport) {
        while self.pending.front().is_some_and(|front| self.settled(&front.image, poses)) {
            self.release_front(poses, report);
        }
    }

    /// Nothing more can come for the images that wait.
    pub(crate) fn finish(&mut self, poses: &PoseResolver, report: &mut ReadReport) {
        while !self.pending.is_empty() {
            self.release_front(poses, report);
        }
    }

    /// A looped recording or a clock set back: what waits is released with what is known, and
    /// everything with a stamp is forgotten.
    pub(crate) fn start_over(&mut self, poses: &PoseResolver, report: &mut ReadReport) {
        self.finish(poses, report);
        self.colors.clear();
        self.confidences.clear();
        self.newest_image_ns = 0;
        self.last_released_ns = None;
    }

    fn push_depth(&mut self, image: ImageMessage, report: &mut ReadReport) {
        let index = report.depth_images;
        report.depth_images += 1;
        let stamp_ns = image.stamp_ns;
        let waiting = self.pending.partition_point(|other| other.image.stamp_ns < stamp_ns);
        let taken = self.pending.get(waiting).is_some_and(|other| other.image.stamp_ns == stamp_ns);
        if taken || self.last_released_ns.is_some_and(|last_ns| stamp_ns <= last_ns) {
            let reason = "its stamp is not after the previous depth image's";
            report.skip(&self.streams.depth, reason, stamp_ns);
            return;
        }
        self.newest_image_ns = self.newest_image_ns.max(stamp_ns);
        self.pending.insert(waiting, Pending { index, image });
    }

    fn settled(&self, image: &ImageMessage, poses: &PoseResolver) -> bool {
        let waited = self.newest_image_ns > image.stamp_ns.saturating_add(WAIT_NS);
        waited || self.pending.len() > MAX_PENDING || self.complete(image, poses)
    }

    fn complete(&self, image: &ImageMessage, poses: &PoseResolver) -> bool {
        let passed = |stream: &Option<String>, kept: &VecDeque<ImageMessage>| {
            stream.is_none() || kept.back().is_some_and(|newest| newest.stamp_ns >= image.stamp_ns)
        };
        passed(&self.streams.color, &self.colors)
            && passed(&self.streams.confidence, &self.confidences)
            && self.depth_calibration(&image.frame_id).is_some()
            && (!self.streams.has_transforms || poses.settled(self.depth_frame(image), image.stamp_ns))
    }

    /// The optical frame of the depth camera.
    fn depth_frame<'a>(&'a self, image: &'a ImageMessage) -> &'a str {
        if self.camera_frame.is_empty() { &image.frame_id } else { &self.camera_frame }
    }

    /// The calibration on `topic`, or without one that of the frame.
    fn calibration(&self, topic: Option<&str>, frame_id: &str) -> Option<&Calibration> {
        match topic {
            Some(topic) => self.calibrations.get(topic),
            None => self.calibrations.values().find(|calibration| calibration.frame_id == frame_id),
        }
    }

    /// As [`Self::calibration`]; without a topic, the only one there is serves too.
    fn depth_calibration(&self, frame_id: &str) -> Option<&Calibration> {
        let topic = self.streams.depth_info.as_deref();
        let only = || match self.calibrations.values().collect::<Vec<_>>()[..] {
            [only] if topic.is_none() => Some(only),
            _ => None,
        };
        self.calibration(topic, frame_id).or_else(only)
    }

    fn release_front(&mut self, poses: &PoseResolver, report: &mut ReadReport) {
        let Some(Pending { index, image }) = self.pending.pop_front() else { return };
        self.last_released_ns = Some(image.stamp_ns);
        match self.depth(&image) {
            Ok(depth) => {
                let frame = self.frame(index, &image, depth, poses, report);
                self.ready.push_back(frame);
            }
            Err(reason) => report.skip(&self.streams.depth, reason, image.stamp_ns),
        }
    }

    /// The depth image, or why there is none.
    fn depth(&self, image: &ImageMessage) -> Result<DepthImage, String> {
        let decoded = image.depth(self.depth_unit_m).map_err(|error| error.to_string())?;
        let calibration = self
            .depth_calibration(&image.frame_id)
            .ok_or_else(|| format!("no usable calibration came on {}", self.info_name()))?;
        let camera = calibration.for_size(decoded.width, decoded.height);
        fits(&camera, decoded.width, decoded.height)?;
        Ok(DepthImage {
            stamp_ns: image.stamp_ns,
            frame_id: self.depth_frame(image).into(),
            camera,
            samples: decoded.samples,
        })
    }

    /// Where the depth image's calibration is expected, for messages.
    pub(crate) fn info_name(&self) -> String {
        match &self.streams.depth_info {
            Some(topic) => format!("`{topic}`"),
            None => "any calibration topic for its frame".into(),
        }
    }

    fn frame(
        &mut self,
        index: u64,
        image: &ImageMessage,
        depth: DepthImage,
        poses: &PoseResolver,
        report: &mut ReadReport,
    ) -> RgbdFrame {
        let color_message = self.nearest(&self.colors, image.stamp_ns);
        let color = color_message.and_then(|message| {
            self.color(message, image, &depth)
                .map_err(|reason| self.count_color(message, reason, report))
                .ok()
        });
        let color_frame = color_message.map(|message| message.frame_id.clone());
        let color_from_depth = color
            .as_ref()
            .and(color_frame)
            .and_then(|frame| self.color_from_depth(&frame, image, poses, report));
        let confidence = self.confidence(&depth, report);
        let pose = self.pose(&depth, poses, report);
        RgbdFrame { index, depth, color, color_from_depth, confidence, pose }
    }

    fn count_color(&self, message: &ImageMessage, reason: String, report: &mut ReadReport) {
        report.skip(self.streams.color.as_deref().unwrap_or("colour"), reason, message.stamp_ns);
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
    ) -> Result<ColorImage, String> {
        let decoded = message.color().map_err(|error| error.to_string())?;
        let own = self
            .calibration(self.streams.color_info.as_deref(), &message.frame_id)
            .map(|calibration| calibration.for_size(decoded.width, decoded.height));
        let shared = (message.frame_id == image.frame_id).then_some(depth.camera);
        let camera = own.or(shared).ok_or("no usable calibration came for the colour camera")?;
        fits(&camera, decoded.width, decoded.height)?;
        Ok(ColorImage { stamp_ns: message.stamp_ns, camera, rgb: decoded.samples })
    }

    fn color_from_depth(
        &self,
        color_frame: &str,
        image: &ImageMessage,
        poses: &PoseResolver,
        report: &mut ReadReport,
    ) -> Option<Rigid> {
        if color_frame == image.frame_id {
            return Some(Rigid::IDENTITY);
        }
        let depth_frame = self.depth_frame(image);
        let found = poses.lookup(color_frame, depth_frame, image.stamp_ns, self.transform_tolerance_ns);
        found
            .map_err(|error| {
                report.note(format!("no transform from `{depth_frame}` to `{color_frame}`: {error}"))
            })
            .ok()
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

    fn pose(&self, depth: &DepthImage, poses: &PoseResolver, report: &mut ReadReport) -> Option<FramePose> {
        match poses.pose(&depth.frame_id, depth.stamp_ns, self.transform_tolerance_ns) {
            Ok(resolved) => {
                if resolved.base_derived {
                    report.note(poses.derived_note());
                }
                Some(resolved.pose)
            }
            Err(error) => {
                let reason = poses.missing_reason(&depth.frame_id, &error);
                report.skip(&self.streams.depth, reason, depth.stamp_ns);
                None
            }
        }
    }

    /// Drops images too old for any depth image that waits or may come.
    fn forget(&mut self) {
        let span_ns = WAIT_NS.saturating_add(self.pair_tolerance_ns);
        let oldest_ns = self.newest_image_ns.saturating_sub(span_ns);
        for kept in [&mut self.colors, &mut self.confidences] {
            while kept.front().is_some_and(|image| image.stamp_ns < oldest_ns) {
                kept.pop_front();
            }
        }
    }
}

/// Inserts by stamp, with a bounded number kept.
fn keep(kept: &mut VecDeque<ImageMessage>, image: ImageMessage) {
    let at = kept.partition_point(|other| other.stamp_ns <= image.stamp_ns);
    kept.insert(at, image);
    if kept.len() > MAX_KEPT {
        kept.pop_front();
    }
}

fn fits(camera: &CameraModel, width: u32, height: u32) -> Result<(), String> {
    if (camera.width, camera.height) == (width, height) {
        return Ok(());
    }
    Err(format!("its calibration is for {}x{}, but it is {width}x{height}", camera.width, camera.height))
}
