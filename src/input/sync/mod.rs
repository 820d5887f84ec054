//! Brings together what belongs to a depth image of one camera: colour, confidence, calibration, pose.
//!
//! Depth images wait, in order of their stamps, until what belongs to them has come or can no longer
//! come: a later colour image has passed, images have gone on for [`WAIT_NS`], the queue is full, or
//! the recording is at its end.

mod frame;

use std::collections::VecDeque;

use crate::base::duration_ns;
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::calibrations::{Calibrations, CalibrationsOfTopic};
use crate::input::event::{Event, Streams};
use crate::input::frames::Posing;
use crate::input::image_message::ImageMessage;
use crate::input::pose::PoseResolver;
use crate::input::stated::StatedCamera;
use crate::input::transforms::JUMP_NS;
use crate::message::bare_name;
use crate::sensor::RgbdFrame;

/// How long images go on before a depth image stops waiting, nanoseconds of recording time.
const WAIT_NS: u64 = 2_000_000_000;

/// Most depth images that wait.
const MAX_PENDING: usize = 64;

/// Most colour and most confidence images kept.
const MAX_KEPT: usize = 128;

struct Pending {
    index: u64,
    image: ImageMessage,
    /// When it came, nanoseconds of [`Synchronizer::tell_time`].
    arrived_ns: u64,
}

/// See the module.
pub(crate) struct Synchronizer {
    streams: Streams,
    camera_frame: String,
    depth_unit_m: f64,
    float_depth_unit_m: f64,
    pair_tolerance_ns: u64,
    transform_tolerance_ns: u64,
    /// That of depth, where the configuration states it.
    stated: Option<StatedCamera>,
    calibrations: Calibrations,
    /// In order of stamps.
    pending: VecDeque<Pending>,
    colors: VecDeque<ImageMessage>,
    confidences: VecDeque<ImageMessage>,
    ready: VecDeque<RgbdFrame>,
    newest_image_ns: u64,
    last_released_ns: Option<u64>,
    /// How depth images fared that asked for a pose.
    pub(crate) posing: Posing,
    now_ns: u64,
    /// How long an image waits at most by the clock, where there is one.
    patience_ns: Option<u64>,
}

impl Synchronizer {
    pub(crate) fn new(config: &Config, streams: Streams) -> Self {
        Self {
            streams,
            camera_frame: bare_name(&config.camera_frame).into(),
            depth_unit_m: config.depth_unit_m,
            float_depth_unit_m: config.float_depth_unit_m,
            pair_tolerance_ns: duration_ns(config.pair_tolerance_s),
            transform_tolerance_ns: duration_ns(config.transform_tolerance_s),
            stated: StatedCamera::of(config),
            calibrations: Calibrations::default(),
            pending: VecDeque::new(),
            colors: VecDeque::new(),
            confidences: VecDeque::new(),
            ready: VecDeque::new(),
            newest_image_ns: 0,
            last_released_ns: None,
            posing: Posing::default(),
            now_ns: 0,
            patience_ns: None,
        }
    }

    /// From now on an image waits by the clock too, at most so long.
    #[cfg(feature = "ros2")]
    pub(crate) fn be_patient_for(&mut self, patience_ns: u64) {
        self.patience_ns = Some(patience_ns);
    }

    /// What the clock says, nanoseconds.
    #[cfg(feature = "ros2")]
    pub(crate) fn tell_time(&mut self, now_ns: u64) {
        self.now_ns = now_ns;
    }

    /// The next frame that waits for nothing any more.
    pub(crate) fn pop(&mut self) -> Option<RgbdFrame> {
        self.ready.pop_front()
    }

    /// Whether a usable calibration for depth has come.
    pub(crate) fn calibrated(&self) -> bool {
        self.stated.is_some() || !self.calibrations.is_empty()
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
            Event::Calibration { topic, frame_id, calibration } => {
                self.calibrations.take(topic, frame_id, calibration);
            }
        }
        self.settle(poses, report);
        self.forget();
    }

    /// Releases what waits for nothing any more.
    pub(crate) fn settle(&mut self, poses: &PoseResolver, report: &mut ReadReport) {
        while self.pending.front().is_some_and(|front| self.settled(front, poses)) {
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
            let reason = match stamp_ns {
                0 => "its stamp is 0, as that of the depth image before: what recorded it does not stamp",
                _ => "its stamp is not after the previous depth image's",
            };
            report.skip(&self.streams.depth, reason, stamp_ns);
            return;
        }
        self.newest_image_ns = self.newest_image_ns.max(stamp_ns);
        self.pending.insert(waiting, Pending { index, image, arrived_ns: self.now_ns });
    }

    fn settled(&self, Pending { image, arrived_ns, .. }: &Pending, poses: &PoseResolver) -> bool {
        let waited = self.newest_image_ns > image.stamp_ns.saturating_add(WAIT_NS)
            || self.patience_ns.is_some_and(|patience| self.now_ns >= arrived_ns.saturating_add(patience));
        waited || self.pending.len() > MAX_PENDING || self.complete(image, poses)
    }

    fn complete(&self, image: &ImageMessage, poses: &PoseResolver) -> bool {
        let passed = |stream: &Option<String>, kept: &VecDeque<ImageMessage>| {
            stream.is_none() || kept.back().is_some_and(|newest| newest.stamp_ns >= image.stamp_ns)
        };
        passed(&self.streams.color, &self.colors)
            && passed(&self.streams.confidence, &self.confidences)
            && (self.stated.is_some() || self.depth_calibrations(&image.frame_id).is_some())
            && (!self.streams.has_transforms || poses.settled(self.depth_frame(image), image.stamp_ns))
    }

    /// The calibrations of the depth images of a frame.
    fn depth_calibrations(&self, frame_id: &str) -> Option<&CalibrationsOfTopic> {
        self.calibrations.of_or_only(self.streams.depth_info.as_deref(), frame_id)
    }

    /// The optical frame of the depth camera.
    fn depth_frame<'a>(&'a self, image: &'a ImageMessage) -> &'a str {
        if self.camera_frame.is_empty() { &image.frame_id } else { &self.camera_frame }
    }

    fn release_front(&mut self, poses: &PoseResolver, report: &mut ReadReport) {
        let Some(Pending { index, image, .. }) = self.pending.pop_front() else { return };
        self.last_released_ns = Some(image.stamp_ns);
        match self.depth(&image, report) {
            Ok(depth) => {
                let frame = self.frame(index, &image, depth, poses, report);
                self.ready.push_back(frame);
            }
            Err(reason) => report.skip(&self.streams.depth, reason, image.stamp_ns),
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
