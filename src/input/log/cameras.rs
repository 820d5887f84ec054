//! Which images of a log are depth, which are colour, and which of them belong to one camera: by what their first messages
//! show (encoding, frame), then by their topics' names.

use crate::config::Config;
use crate::input::image_message::Shows;
use crate::input::log::topics::{Channel, Channels, Kind};

/// Words of topics and frames that name an image and not its camera.
const STREAM_WORDS: [&str; 38] = [
    "depth",
    "color",
    "colour",
    "rgb",
    "rgbd",
    "image",
    "images",
    "img",
    "raw",
    "rect",
    "rectified",
    "mono",
    "stereo",
    "aligned",
    "to",
    "registered",
    "compressed",
    "compresseddepth",
    "theora",
    "ffmpeg",
    "transport",
    "data",
    "stream",
    "optical",
    "frame",
    "link",
    "hd",
    "qhd",
    "sd",
    "vga",
    "sensor",
    "camerainfo",
    "info",
    "hw",
    "sw",
    "points",
    "cloud",
    "pointcloud",
];

/// Words of images of 16 bits or floats that are not depth.
const OTHER_WORDS: [&str; 9] =
    ["infra", "infrared", "ir", "confidence", "disparity", "thermal", "amplitude", "intensity", "nir"];

/// Words of pictures that are made of others.
const MADE_WORDS: [&str; 13] = [
    "colormap",
    "colorized",
    "overlay",
    "debug",
    "mask",
    "label",
    "labels",
    "semantic",
    "segmentation",
    "annotated",
    "detection",
    "detections",
    "result",
];

/// The words of a name in lower case, `_0` and the like of `Depth_0` apart.
fn words(name: &str) -> Vec<String> {
    let split = name.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    split.map(str::to_lowercase).collect()
}

fn without_digits(word: &str) -> &str {
    word.trim_end_matches(|c: char| c.is_ascii_digit())
}

/// What of a name tells of its camera: the words that name no image, nor count one.
fn camera_of(name: &str) -> Vec<String> {
    let mut after_stream = false;
    let names_camera = |word: &String| {
        let is_number = word.chars().all(|c| c.is_ascii_digit());
        let is_stream = STREAM_WORDS.contains(&word.as_str()) || (after_stream && is_number);
        after_stream = is_stream && !is_number;
        !is_stream
    };
    words(name).into_iter().filter(names_camera).collect()
}

/// Whether a name has all words of another.
fn has_all(name: &[String], of: &[String]) -> bool {
    of.iter().all(|word| name.contains(word))
}

/// The topic without what image transports add.
fn base_of(topic: &str) -> &str {
    let end = topic.rsplit_once('/').filter(|(_, last)| {
        let last = last.to_lowercase();
        ["compressed", "compresseddepth", "theora", "ffmpeg", "zstd"].contains(&last.as_str())
    });
    end.map_or(topic, |(base, _)| base)
}

fn shows(channel: &Channel) -> Option<&Shows> {
    channel.look.as_ref()?.shows.as_ref()
}

fn frame_of(channel: &Channel) -> Option<&str> {
    channel.look.as_ref().map(|look| look.frame_id.as_str()).filter(|frame| !frame.is_empty())
}

/// Image transports may offer `compressedDepth` of colour too.
fn says_depth(topic: &str) -> bool {
    base_of(topic).to_lowercase().contains("depth")
}

/// Whether a name says that its image is neither depth nor colour, after the last word that says depth.
fn says_other(topic: &str) -> bool {
    let words = words(base_of(topic));
    let after_depth = words.iter().rposition(|word| word.contains("depth")).map_or(0, |at| at + 1);
    words[after_depth..].iter().any(|word| OTHER_WORDS.contains(&without_digits(word)))
}

fn says_color(topic: &str) -> bool {
    let topic = topic.to_lowercase();
    ["color", "colour", "rgb"].iter().any(|word| topic.contains(word))
}

/// The depth topics: those that are named so, and those whose messages are depth. A log with clouds may have images of a
/// lidar's ranges and intensities, which have no calibration.
///
/// The best come first: those whose messages are depth before those of which it is not known; those that are
/// named depth; those with colour of the same camera; those with a calibration; those aligned to colour; raw before packed
/// images; then by name.
pub(super) fn depth_topics(channels: &Channels) -> Vec<&Channel> {
    let has_scans = channels.of_kind(Kind::is_scan).next().is_some();
    let is_depth = |channel: &&Channel| {
        let by_content =
            || shows(channel) == Some(&Shows::Depth) && (!has_scans || has_calibration(channels, channel));
        !says_other(&channel.topic) && (says_depth(&channel.topic) || by_content())
    };
    let mut all: Vec<&Channel> = channels.of_kind(Kind::is_image).filter(is_depth).collect();
    let depths = all.clone();
    let rank = |channel: &&Channel| {
        let known = match shows(channel) {
            Some(Shows::Depth) => 0,
            None => 1,
            Some(_) => 2,
        };
        let packed = !channel.kind.is_some_and(Kind::is_raw_image);
        (
            known,
            !says_depth(&channel.topic),
            color_among(channels, channel, &depths).is_none(),
            !has_calibration(channels, channel),
            !channel.topic.contains("aligned_depth_to_color"),
            packed,
            packed && !channel.topic.contains("compressedDepth"),
            channel.topic.clone(),
        )
    };
    all.sort_by_cached_key(rank);
    all
}

/// The depth topic that is read where none is configured.
pub(super) fn find_depth(channels: &Channels) -> Option<String> {
    depth_topics(channels).first().map(|channel| channel.topic.clone())
}

fn has_calibration(channels: &Channels, image: &Channel) -> bool {
    let same_frame =
        |channel: &Channel| frame_of(image).is_some_and(|frame| frame_of(channel) == Some(frame));
    sibling_info(channels, &image.topic).is_some() || channels.of_kind(Kind::is_calibration).any(same_frame)
}

/// How many names two topics have in common from the root of the tree of names.
pub(super) fn shared_names(a: &str, b: &str) -> usize {
    a.split('/').zip(b.split('/')).take_while(|(a, b)| a == b).count()
}

/// How surely two images are of one camera: by their frames, by the words of their topics, by their place in the tree of
/// names. `None`: they are not.
fn kinship(a: &Channel, b: &Channel) -> Option<(bool, bool, usize)> {
    let same_frame = frame_of(a).is_some_and(|frame| frame_of(b) == Some(frame));
    let (of_a, of_b) = (camera_of(&a.topic), camera_of(&b.topic));
    let same_words = of_a == of_b;
    let alike = has_all(&of_a, &of_b) || has_all(&of_b, &of_a);
    let of_frame = |channel: &Channel| frame_of(channel).map(camera_of).filter(|words| !words.is_empty());
    let same_frames = of_frame(a).is_some_and(|words| of_frame(b) == Some(words));
    (same_frame || alike || same_frames).then(|| (same_frame, same_words, shared_names(&a.topic, &b.topic)))
}

/// The colour topic of the camera of a depth topic, where there is one: one whose messages are colour before one that merely
/// may be, one that is named colour, one in the same frame, the nearest in the tree of names, raw before packed images.
pub(super) fn find_color(channels: &Channels, depth: &str) -> Option<String> {
    let depths = depth_topics(channels);
    let depth = channels.of_kind(Kind::is_image).find(|channel| channel.topic == depth)?;
    color_among(channels, depth, &depths).map(|channel| channel.topic.clone())
}

/// As [`find_color`]; colour that is nearer to one of the `depths` of another camera is that one's.
fn color_among<'a>(channels: &'a Channels, depth: &Channel, depths: &[&Channel]) -> Option<&'a Channel> {
    let of_depth = camera_of(&depth.topic);
    let others: Vec<_> = depths.iter().filter(|other| camera_of(&other.topic) != of_depth).collect();
    let is_own = |color: &&Channel| {
        let own = kinship(color, depth);
        own.is_some() && others.iter().all(|other| kinship(color, other) <= own)
    };
    let found = channels
        .of_kind(Kind::is_image)
        .filter(|channel| channel.topic != depth.topic && may_be_color(channel, &depth.topic));
    found.filter(is_own).min_by_key(|color| color_rank(color, depth))
}

/// Whether an image may be a camera's colour.
fn may_be_color(channel: &Channel, depth: &str) -> bool {
    let shared = shared_names(&channel.topic, depth);
    let own = channel.topic.split('/').skip(shared).collect::<Vec<_>>().join("/");
    let words = words(base_of(&own));
    let is_made =
        words.iter().any(|word| MADE_WORDS.contains(&without_digits(word)) || word.contains("depth"));
    let is_named = says_color(&channel.topic) || channel.topic.to_lowercase().contains("image");
    let may_be = match shows(channel) {
        Some(Shows::Depth) => false,
        Some(Shows::Color) => true,
        Some(Shows::Other(_)) => says_color(&channel.topic),
        Some(Shows::Grey) => is_named,
        None => is_named && !channel.topic.to_lowercase().contains("depth"),
    };
    may_be && !is_made && !says_other(&channel.topic)
}

fn color_rank(color: &Channel, depth: &Channel) -> impl Ord + use<> {
    let known = match shows(color) {
        Some(Shows::Color) => 0,
        None => 1,
        Some(Shows::Grey) => 2,
        Some(_) => 3,
    };
    let (same_frame, same_words, shared) = kinship(color, depth).unwrap_or_default();
    (
        known,
        !says_color(&color.topic),
        !same_frame,
        !same_words,
        usize::MAX - shared,
        !color.kind.is_some_and(Kind::is_raw_image),
        color.topic.clone(),
    )
}

/// What else there is of cameras, for the user, where the configuration does not say what is read.
pub(super) fn unread(channels: &Channels, depth: &str, color: Option<&str>, config: &Config) -> Vec<String> {
    let mut notes = Vec::new();
    let list = |topics: &[&Channel], read: &str| {
        let mut bases: Vec<&str> = topics.iter().map(|channel| base_of(&channel.topic)).collect();
        bases.retain(|base| *base != base_of(read));
        bases.sort_unstable();
        bases.dedup();
        bases.join(", ")
    };
    let depths = depth_topics(channels);
    let readable: Vec<&Channel> = depths
        .iter()
        .filter(|channel| matches!(shows(channel), None | Some(Shows::Depth)))
        .copied()
        .collect();
    let others = list(&readable, depth);
    if config.depth_topic.is_empty() && !others.is_empty() {
        notes.push(format!(
            "other depth topics, not read: {others}. `depth_topic` takes one of them; to read several cameras at once give each a section under `sensors` (`limpid config --robot` prints an example)"
        ));
    }
    let is_color = |channel: &&Channel| shows(channel) == Some(&Shows::Color) && may_be_color(channel, depth);
    let colors: Vec<&Channel> = channels.of_kind(Kind::is_image).filter(is_color).collect();
    let others = list(&colors, color.unwrap_or(""));
    if config.color_topic.is_empty() && color.is_none() && !others.is_empty() {
        notes.push(format!(
            "colour of other cameras, by its name and frame, not read: {others}; if it is this one's, set `color_topic`"
        ));
    }
    notes
}

/// The clouds that a depth camera's driver makes of its own images, by their fields and frames, or as they are named depth of
/// a camera; none where there is no depth image.
pub(super) fn clouds_of_cameras(channels: &Channels) -> Vec<String> {
    let depths = depth_topics(channels);
    let is_cameras = |channel: &&Channel| {
        let Some(layout) = channels.layout(&channel.topic).filter(|layout| !layout.is_of_lidar()) else {
            return false;
        };
        let words = camera_of(&channel.topic);
        let of_depth = |depth: &&Channel| {
            let is_named = says_depth(&channel.topic) && has_all(&words, &camera_of(&depth.topic));
            is_named || frame_of(depth) == Some(layout.frame_id())
        };
        layout.is_of_camera() || depths.iter().any(of_depth)
    };
    let clouds = channels.of_kind(Kind::is_cloud).filter(|_| !depths.is_empty()).filter(is_cameras);
    clouds.map(|channel| channel.topic.clone()).collect()
}

/// `camera_info` in the namespace of an image topic (`/ns/image_raw`, `/ns/image_raw/compressed`), or
/// `info/camera_info` there, as the RealSense SDK has it (`/ns/image/data`).
pub(super) fn sibling_info(channels: &Channels, image: &str) -> Option<String> {
    let mut namespace = image;
    for _ in 0..2 {
        namespace = namespace.rsplit_once('/')?.0;
        for name in ["camera_info", "info/camera_info"] {
            let wanted = format!("{namespace}/{name}");
            if channels.of_kind(Kind::is_calibration).any(|channel| channel.topic == wanted) {
                return Some(wanted);
            }
        }
    }
    None
}
