//! The recordings, each with the configuration that goes with it and how much of it is run.

use std::path::{Path, PathBuf};

use crate::support::data_path;

use super::products::{Product, camera_case, lidar_case};

/// Where no example configuration goes with a recording.
const DEFAULTS: &str = "limpid:\n  ros__parameters:\n    map_frame: map\n";

/// Makes a case's products: recording, configuration in YAML, how many frames.
type Make = fn(&Path, &str, u64) -> Vec<Product>;

/// A recording with an example configuration, and what of it is run.
struct Source {
    name: &'static str,
    recording: &'static str,
    /// A file of testdata/config or of the data; empty: the defaults.
    config: &'static str,
    /// Texts of the configuration, each with what stands there instead.
    edits: &'static [(&'static str, &'static str)],
    /// Name of a variant, its line in the configuration, frames.
    variants: &'static [(&'static str, &'static str, u64)],
}

const fn source(
    name: &'static str,
    [recording, config]: [&'static str; 2],
    variants: &'static [(&'static str, &'static str, u64)],
) -> Source {
    Source { name, recording, config, edits: &[], variants }
}

const RANGE: (&str, &str, u64) = ("range", "method: range", 10);
const DRM: (&str, &str, u64) = ("drm", "method: drm", 3);
const BOTH: &[(&str, &str, u64)] = &[RANGE, DRM];
const SCANS: (&str, &str, u64) = ("plain", "glass: false", 6);
const GLASS: &[(&str, &str, u64)] = &[SCANS, ("glass", "glass: true", 6)];

const ALL_METHODS: &[(&str, &str, u64)] = &[
    RANGE,
    DRM,
    ("naive", "method: naive", 10),
    ("median", "method: median", 10),
    ("temporal", "method: temporal", 10),
];

/// The still of a D415: depth alone, as its colour lies elsewhere.
const D415: &[(&str, &str)] = &[
    ("raw_depth.png", "0000_depth.png"),
    ("color_file: rgb.jpg", "color_file: \"\""),
    (
        "[461.2757, 0.0, 324.985, 0.0, 461.5195, 241.524,",
        "[443.914642, 0.0, 315.938354, 0.0, 443.914642, 186.570435,",
    ),
];

const PROTOBUF: [&str; 2] =
    ["rgbd/mcap-derived/redkitchen_foxglove_protobuf_lz4.mcap", "redkitchen-foxglove.yaml"];
const UNALIGNED: [&str; 2] =
    ["rgbd/mcap-derived/librealsense_d435_unaligned_ros2_cdr.mcap", "realsense-unaligned.yaml"];
const BAG: [&str; 2] = ["rgbd/librealsense-d435-bag/single_depth_color_640x480.bag", "realsense-bag.yaml"];
const CLEARGRASP: [&str; 2] = ["rgbd/cleargrasp-d435", "cleargrasp.yaml"];

static CAMERAS: [Source; 15] = [
    source("room", ["testdata/room.mcap", ""], ALL_METHODS),
    source("field reference", ["field/reference/in.mcap", ""], BOTH),
    source("kitchen", ["rgbd/kitchen.mcap", "kitchen.yaml"], &[("range", "method: range", 30), DRM]),
    source("kitchen-tum", ["rgbd/kitchen-tum", "kitchen.yaml"], BOTH),
    source("redkitchen-foxglove", PROTOBUF, BOTH),
    source("realsense-unaligned", UNALIGNED, BOTH),
    source("realsense-bag", BAG, BOTH),
    source("cleargrasp 080", CLEARGRASP, BOTH),
    Source { edits: &[("000000080", "000000123")], ..source("cleargrasp 123", CLEARGRASP, BOTH) },
    Source { edits: &[("000000080", "000000153")], ..source("cleargrasp 153", CLEARGRASP, BOTH) },
    source("lingbot 0", ["rgbd/lingbot-depth-raw/0", "still-pair.yaml"], BOTH),
    source("lingbot 1", ["rgbd/lingbot-depth-raw/1", "still-pair-photo.yaml"], BOTH),
    source("lingbot 3", ["rgbd/lingbot-depth-raw/3", "still-pair-photo.yaml"], BOTH),
    source("lingbot 6", ["rgbd/lingbot-depth-raw/6", "still-pair-photo.yaml"], BOTH),
    Source {
        edits: D415,
        ..source("d3roma-d415", ["rgbd/d3roma-d415-ir", "still-pair-photo.yaml"], &[RANGE])
    },
];

const FIELD: [&str; 2] = ["field/lidar-reference/in.mcap", "field/lidar-reference/config.yaml"];
const MONTEREY: [&str; 2] =
    ["lidar/veloview-hdl32e-vlp16-strongest/monterey-first-100-packets.pcap", "monterey.yaml"];
const VLP16: [&str; 2] =
    ["lidar/veloview-hdl32e-vlp16-strongest/vlp-16-test-90deg-1-50-frames.pcap", "vlp16-pcap.yaml"];
const VLP16_GPS: [&str; 2] =
    ["lidar/mrpt-velodyne-strongest/sample_velodyne_vlp16_gps.pcap", "vlp16-pcap.yaml"];
const HDL32: [&str; 2] = ["lidar/mrpt-velodyne-strongest/sample_velodyne_hdl32.pcap", "mrpt-hdl32.yaml"];
const RELLIS: [&str; 2] = ["lidar/rellis3d-os1-64-labelled/frame000104-1581624663_170.ply", "rellis.yaml"];

static LIDARS: [Source; 9] = [
    source("field lidar-reference", FIELD, &[SCANS]),
    source("3dref", ["lidar/3dref.mcap", "3dref.yaml"], GLASS),
    source("3dref-ply", ["lidar/3dref-hesai-qt64-dual", "3dref.yaml"], GLASS),
    source("vlp16-dual", ["lidar/vlp16-dual.mcap", "vlp16-dual.yaml"], &[SCANS]),
    source("monterey", MONTEREY, &[SCANS]),
    source("vlp16-test", VLP16, &[SCANS]),
    source("mrpt-vlp16-gps", VLP16_GPS, &[SCANS]),
    source("mrpt-hdl32", HDL32, &[SCANS]),
    source("rellis", RELLIS, &[SCANS]),
];

/// A recording with a configuration, to be run.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) recording: PathBuf,
    source: &'static Source,
    line: &'static str,
    frames: u64,
    make: Make,
}

/// All cases, in the order in which they run.
pub(super) fn all() -> Vec<Case> {
    let cameras = CAMERAS.iter().flat_map(|source| source.cases(camera_case));
    cameras.chain(LIDARS.iter().flat_map(|source| source.cases(lidar_case))).collect()
}

impl Case {
    /// Runs it.
    pub(super) fn products(&self) -> Vec<Product> {
        (self.make)(&self.recording, &self.source.yaml(self.line), self.frames)
    }

    /// Runs it with a further line in the configuration.
    pub(super) fn products_with(&self, line: &str) -> Vec<Product> {
        (self.make)(&self.recording, &format!("{}    {line}\n", self.source.yaml(self.line)), self.frames)
    }
}

impl Source {
    fn cases(&'static self, make: Make) -> impl Iterator<Item = Case> {
        self.variants.iter().map(move |&(variant, line, frames)| Case {
            name: format!("{} {variant}", self.name),
            recording: self.path(),
            source: self,
            line,
            frames,
            make,
        })
    }

    fn path(&self) -> PathBuf {
        if self.recording.starts_with("testdata/") {
            self.recording.into()
        } else {
            data_path(self.recording)
        }
    }

    /// The configuration with `line` at its end.
    fn yaml(&self, line: &str) -> String {
        let read = |path: PathBuf| std::fs::read_to_string(path).unwrap();
        let mut yaml = match self.config {
            "" => DEFAULTS.into(),
            config if config.contains('/') => read(data_path(config)),
            config => read(Path::new("testdata/config").join(config)),
        };
        for (from, to) in self.edits {
            assert!(yaml.contains(from), "{}: `{from}` is not in {}", self.name, self.config);
            yaml = yaml.replace(from, to);
        }
        // The bits of what stands on a stated ground; the estimate has tests of its own.
        format!("{}\n    ground: stated\n    {line}\n", yaml.trim_end())
    }
}
