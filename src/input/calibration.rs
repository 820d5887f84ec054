//! A calibration as a recording states it, and the camera that it makes of an image: the fields of `sensor_msgs/CameraInfo`
//! as image_geometry reads them (REP 104).
//!
//! K and D are of raw images, P is of rectified ones. Both are given for the whole sensor: an image may be a region of it, or
//! have merged (`binning`) or dropped pixels.

use crate::base::Result;
use crate::message::{decode_error, foxglove, ros2};
use crate::sensor::{CameraModel, Distortion};

/// The matrices, the lens and the sensor's size, as they are stated.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Calibration {
    /// Zero where it is not stated.
    size: [u32; 2],
    binning: [u32; 2],
    /// Offset and size of the region, in pixels of the whole sensor.
    region: Option<([u32; 2], [u32; 2])>,
    raw: Option<Pinhole>,
    rectified: Option<Pinhole>,
    /// What K, or else D, lacks.
    fault: Option<String>,
    lens: Result<Distortion, String>,
    /// Whether D is zero or absent: then images are rectified already.
    without_lens: bool,
    /// Coefficients past the eighth, which are left out.
    left_out: Vec<f64>,
}

/// fx, fy, cx and cy, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pinhole([f64; 4]);

impl Pinhole {
    /// # Errors
    /// Which of the numbers cannot be.
    fn of(fx: f64, fy: f64, cx: f64, cy: f64) -> Result<Self, String> {
        let (width, height, distortion) = (1, 1, Distortion::None);
        let camera = CameraModel { width, height, fx, fy, cx, cy, distortion };
        camera.check_pinhole().map(|()| Self([fx, fy, cx, cy]))
    }

    fn text(self) -> String {
        let [fx, fy, cx, cy] = self.0;
        format!("fx {fx:.2}, fy {fy:.2}, cx {cx:.2}, cy {cy:.2}")
    }
}

/// How a calibration's size fits an image's; the least is the best.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Fit {
    /// As it is stated.
    Stated,
    /// It states no size, and is taken to be for the images'.
    Unsized,
    /// Its binning and region are stated, but its size is already that of the images.
    Reduced,
    /// Images have every n-th pixel.
    Decimated(u32),
}

/// The camera of an image, and what is to be told of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fitted {
    pub(crate) camera: CameraModel,
    pub(crate) fit: Fit,
    pub(crate) notes: Vec<String>,
}

impl Calibration {
    /// # Errors
    /// [`crate::Error::Decode`] where neither K nor P can be used, or the size is that of no image.
    pub(crate) fn of_ros(info: &ros2::CameraInfo) -> Result<Self> {
        let calibration =
            Self::new([info.width, info.height], &info.k, &info.distortion_model, &info.d, &info.p)?;
        let roi = info.roi;
        let (offset, size) = ([roi.x_offset, roi.y_offset], [roi.width, roi.height]);
        let whole = offset == [0, 0] && (size == [0, 0] || size == calibration.size);
        Ok(Self {
            binning: [info.binning_x.max(1), info.binning_y.max(1)],
            region: (!whole).then_some((offset, size)),
            ..calibration
        })
    }

    /// # Errors
    /// As [`Self::of_ros`].
    pub(crate) fn of_foxglove(info: &foxglove::CameraCalibration) -> Result<Self> {
        Self::new([info.width, info.height], &info.k, &info.distortion_model, &info.d, &info.p)
    }

    /// # Errors
    /// As [`Self::of_ros`].
    fn new(size: [u32; 2], k: &[f64], model: &str, d: &[f64], p: &[f64]) -> Result<Self> {
        let bad = |reason: String| Err(decode_error("camera intrinsics", reason));
        if size.contains(&0) && size != [0, 0] {
            return bad(format!("image size is {}x{}", size[0], size[1]));
        }
        let raw = match *k {
            [fx, _, cx, _, fy, cy, _, _, _] => Pinhole::of(fx, fy, cx, cy),
            _ => Err(format!("has {} numbers in place of 9", k.len())),
        };
        let rectified = match *p {
            _ if p.iter().all(|&number| number == 0.0) => Err("is empty".into()),
            [fx, _, cx, _, _, fy, cy, ..] => Pinhole::of(fx, fy, cx, cy),
            _ => Err(format!("has {} numbers in place of 12", p.len())),
        };
        if let (Err(k), Err(p)) = (&raw, &rectified) {
            return bad(format!("K: {k}, and P: {p}"));
        }
        Ok(Self {
            size,
            binning: [1, 1],
            region: None,
            fault: raw.as_ref().err().map(|reason| format!("K: {reason}")),
            raw: raw.ok(),
            rectified: rectified.ok(),
            lens: Distortion::from_ros(model, d).map_err(|error| error.to_string()),
            without_lens: d.iter().all(|&c| c == 0.0),
            left_out: d.iter().skip(8).copied().filter(|&c| c != 0.0).collect(),
        })
    }

    /// The camera of images of `width` and `height`; `rectified`: their topic's name says that they are.
    ///
    /// # Errors
    /// Why there is none, in words.
    pub(crate) fn camera(&self, [width, height]: [u32; 2], rectified: bool) -> Result<Fitted, String> {
        let mut notes = Vec::new();
        let (pinhole, distortion) = self.lens_of(rectified, &mut notes)?;
        let (fit, offset, scale) = self.fit([width, height])?;
        match fit {
            Fit::Stated => {}
            Fit::Unsized => {
                notes.push(format!("states no size: taken to be for {width}x{height}, as the images are"))
            }
            Fit::Reduced => notes.push(format!(
                "says binning or a region, but is for {width}x{height} as the images are: taken as it is"
            )),
            Fit::Decimated(n) => notes.push(format!(
                "is for {n} times {width}x{height}: the images are taken to hold every {} pixel of it",
                match n {
                    2 => "second".into(),
                    3 => "third".into(),
                    n => format!("{n}th"),
                }
            )),
        }
        let [fx, fy, cx, cy] = pinhole.0;
        let camera = CameraModel {
            width,
            height,
            fx: fx / scale[0],
            fy: fy / scale[1],
            cx: centre(cx - offset[0], scale[0]),
            cy: centre(cy - offset[1], scale[1]),
            distortion,
        };
        let camera = camera.validate().map_err(|error| error.to_string())?;
        Ok(Fitted { camera, fit, notes })
    }

    /// Pinhole and lens of raw or of rectified images.
    fn lens_of(&self, rectified: bool, notes: &mut Vec<String>) -> Result<(Pinhole, Distortion), String> {
        match (self.raw, self.rectified) {
            (Some(raw), Some(p)) if rectified || self.without_lens => {
                if raw.text() != p.text() || !self.without_lens {
                    let why = if rectified { "the topic's name says rectified" } else { "its D is zero" };
                    notes.push(format!("{why}: P without D is taken ({}), not K ({})", p.text(), raw.text()));
                }
                Ok((p, Distortion::None))
            }
            (Some(raw), None) if rectified => {
                if !self.without_lens {
                    notes.push("the topic's name says rectified and P is empty: K without D is taken".into());
                }
                Ok((raw, Distortion::None))
            }
            (Some(raw), _) => {
                if !self.left_out.is_empty() {
                    notes.push(format!(
                        "coefficients of D past the eighth (thin prism, tilt) are left out: {:?}",
                        self.left_out
                    ));
                }
                Ok((raw, self.lens.clone()?))
            }
            (None, Some(p)) => {
                let fault = self.fault.as_deref().unwrap_or("K is missing");
                notes.push(format!("{fault}: P without D is taken ({})", p.text()));
                Ok((p, Distortion::None))
            }
            (None, None) => Err(self.fault.clone().unwrap_or_default()),
        }
    }

    /// How images of a size lie on the sensor: the offset in its pixels and how many of these make one of theirs.
    fn fit(&self, image: [u32; 2]) -> Result<(Fit, [f64; 2], [f64; 2]), String> {
        if self.size == [0, 0] && self.region.is_none() {
            return Ok((Fit::Unsized, [0.0; 2], self.binning.map(f64::from)));
        }
        let (offset, region) = self.region.unwrap_or(([0, 0], self.size));
        let region = if region.contains(&0) { self.size } else { region };
        let reduced = [region[0] / self.binning[0], region[1] / self.binning[1]];
        let (offset, scale) = (offset.map(f64::from), self.binning.map(f64::from));
        if reduced == image {
            return Ok((Fit::Stated, offset, scale));
        }
        if self.size == image {
            return Ok((Fit::Reduced, [0.0; 2], [1.0; 2]));
        }
        let times = reduced[0] / image[0].max(1);
        if times >= 2 && [reduced[0] / times, reduced[1] / times] == image {
            return Ok((Fit::Decimated(times), offset, scale.map(|scale| scale * f64::from(times))));
        }
        let [width, height] = self.size;
        let of = match (reduced == self.size, reduced) {
            (true, _) => String::new(),
            (false, [w, h]) => format!(" ({w}x{h} by its binning and region)"),
        };
        Err(format!("its calibration is for {width}x{height}{of}, but it is {}x{}", image[0], image[1]))
    }
}

/// A centre among pixels that hold `scale` of the sensor's each; those of both lie at integers.
fn centre(at: f64, scale: f64) -> f64 {
    if scale == 1.0 { at } else { (at + 0.5) / scale - 0.5 }
}

/// Whether a topic's name says that its images are rectified: `image_rect`, `image_rect_raw`, `image_rect_color`,
/// `image_rectified`.
pub(crate) fn says_rectified(topic: &str) -> bool {
    topic.to_lowercase().split(['/', '_']).any(|word| ["rect", "rectified"].contains(&word))
}
