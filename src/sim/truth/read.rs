//! Reads ground truth back, from MCAP or from a folder, a frame at a time.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::base::{Error, Result};
use crate::input::image_decode::{color_from_file, read_file};
use crate::input::{McapRecords, Record, Records, depth_from_exr};
use crate::map::Grid;
use crate::message::ros2::{Header, Image, Pose, Time, decode_cdr};
use crate::sensor::DepthSamples;
use crate::sim::scene::Scene;

/// Ground truth of one frame; see [`crate::sim::truth`].
#[derive(Debug, Clone, PartialEq)]
pub struct TruthFrame {
    /// Stamp of the depth image that it belongs to, nanoseconds since the Unix epoch.
    pub stamp_ns: u64,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Depth of the first surface, metres, row-major; 0: none.
    pub depth_m: Vec<f32>,
    /// Codes of [`crate::sim::material::Kind`]; 0: none.
    pub material: Vec<u8>,
    /// Where the cells lie in the map frame.
    pub grid: Grid,
    /// [`super::UNKNOWN`], [`super::FREE`], [`super::OCCUPIED`] or [`super::GLASS`], row 0 = smallest y.
    pub cells: Vec<i8>,
}

/// A stream of [`TruthFrame`]s in the recording's order.
pub struct TruthReader {
    path: PathBuf,
    source: Source,
    scene: Option<String>,
}

enum Source {
    Mcap(Box<McapTruth>),
    Folder(std::vec::IntoIter<Entry>, Grid),
}

impl TruthReader {
    /// Opens a recording that `limpid sim` wrote.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] where it is no MCAP file and holds no readable `truth.txt`.
    pub fn open(path: &Path) -> Result<Self> {
        let (source, scene) = if path.is_dir() {
            let entries = entries(&path.join("truth.txt"))?;
            let scene = std::fs::read_to_string(path.join("truth/scene.yaml")).ok();
            (Source::Folder(entries.into_iter(), grid_file(&path.join("truth/map.yaml"))?), scene)
        } else {
            let records = McapRecords::open(path)?;
            let truth = McapTruth { records, topics: HashMap::new(), images: [None, None], scene: None };
            (Source::Mcap(Box::new(truth)), None)
        };
        Ok(Self { path: path.into(), source, scene })
    }

    /// The scene that was recorded, from the first frame on; `None` where the recording holds none.
    ///
    /// # Errors
    /// Those of [`Scene::from_yaml`].
    pub fn scene(&self) -> Result<Option<Scene>> {
        let yaml = match &self.source {
            Source::Mcap(mcap) => mcap.scene.as_deref(),
            Source::Folder(..) => self.scene.as_deref(),
        };
        yaml.map(Scene::from_yaml).transpose()
    }

    /// The truth of the next frame, `None` at the end.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] and [`Error::Decode`] for damaged content, and for a frame with parts missing.
    pub fn next_frame(&mut self) -> Result<Option<TruthFrame>> {
        let frame = match &mut self.source {
            Source::Mcap(mcap) => mcap.next_frame(&self.path)?,
            Source::Folder(entries, grid) => match entries.next() {
                Some(entry) => Some(entry.load(&self.path, *grid)?),
                None => None,
            },
        };
        frame.map(|frame| checked(&self.path, frame)).transpose()
    }
}

fn checked(path: &Path, frame: TruthFrame) -> Result<TruthFrame> {
    let pixels = frame.width as usize * frame.height as usize;
    let cells = frame.grid.width as usize * frame.grid.height as usize;
    let sizes = [frame.depth_m.len(), frame.material.len(), frame.cells.len()];
    if sizes == [pixels, pixels, cells] && pixels > 0 && cells > 0 {
        return Ok(frame);
    }
    let reason = format!(
        "the truth of stamp {} has {} depths, {} materials and {} cells where {pixels} pixels and {cells} cells are wanted",
        frame.stamp_ns, sizes[0], sizes[1], sizes[2]
    );
    Err(bad(path, reason))
}

fn bad(path: &Path, reason: impl Into<String>) -> Error {
    Error::Format { path: path.into(), reason: reason.into() }
}

const DEPTH: &str = "/truth/depth/image_raw";
const MATERIAL: &str = "/truth/material/image_raw";
const MAP: &str = "/truth/map";
const SCENE: &str = "/truth/scene";

/// `std_msgs/String` as it is read.
#[derive(Deserialize)]
struct RosString {
    data: String,
}

/// `nav_msgs/OccupancyGrid` as it is read.
#[derive(Deserialize)]
struct OccupancyGrid {
    header: Header,
    info: MapMetaData,
    #[serde(with = "serde_bytes")]
    data: Vec<u8>,
}

#[derive(Deserialize)]
struct MapMetaData {
    #[expect(dead_code, reason = "part of the message")]
    map_load_time: Time,
    resolution: f32,
    width: u32,
    height: u32,
    origin: Pose,
}

/// Messages of a frame come as depth, material, map; the map completes it.
struct McapTruth {
    records: McapRecords,
    topics: HashMap<u32, String>,
    images: [Option<Image>; 2],
    scene: Option<String>,
}

impl McapTruth {
    fn next_frame(&mut self, path: &Path) -> Result<Option<TruthFrame>> {
        loop {
            let topics = &self.topics;
            let wanted = |id: u32| topics.contains_key(&id);
            match self.records.next(&wanted)? {
                None => return Ok(None),
                Some(Record::Channel { id, topic, .. }) => {
                    if [DEPTH, MATERIAL, MAP, SCENE].contains(&topic.as_str()) {
                        self.topics.insert(id, topic);
                    }
                }
                Some(Record::Message { channel_id, data, .. }) => {
                    let topic = self.topics.get(&channel_id).map(String::as_str);
                    match topic {
                        Some(DEPTH) => self.images[0] = Some(decode_cdr(DEPTH, &data)?),
                        Some(MATERIAL) => self.images[1] = Some(decode_cdr(MATERIAL, &data)?),
                        Some(SCENE) => self.scene = Some(decode_cdr::<RosString>(SCENE, &data)?.data),
                        Some(MAP) => return self.complete(path, decode_cdr(MAP, &data)?).map(Some),
                        _ => {}
                    }
                }
                Some(_) => {}
            }
        }
    }

    fn complete(&mut self, path: &Path, map: OccupancyGrid) -> Result<TruthFrame> {
        let stamp_ns = map.header.stamp.stamp_ns()?;
        let missing = |topic: &str| bad(path, format!("the map of stamp {stamp_ns} has no {topic}"));
        let [depth, material] = self.images.each_mut().map(Option::take);
        let (depth, material) =
            (depth.ok_or_else(|| missing(DEPTH))?, material.ok_or_else(|| missing(MATERIAL))?);
        if depth.header.stamp != map.header.stamp || material.header.stamp != map.header.stamp {
            return Err(missing("images of its own stamp"));
        }
        Ok(TruthFrame {
            stamp_ns,
            width: depth.width,
            height: depth.height,
            depth_m: depth.data.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect(),
            material: material.data,
            grid: Grid {
                origin_x_m: map.info.origin.position.x,
                origin_y_m: map.info.origin.position.y,
                resolution_m: widened(map.info.resolution),
                width: map.info.width,
                height: map.info.height,
            },
            cells: map.data.into_iter().map(u8::cast_signed).collect(),
        })
    }
}

/// The decimal number that a 32-bit resolution stands for: 0.05, not 0.0500000007.
fn widened(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| value.into())
}

/// A line of `truth.txt`.
struct Entry {
    stamp_ns: u64,
    files: [String; 3],
}

fn entries(list: &Path) -> Result<Vec<Entry>> {
    let text = std::fs::read_to_string(list).map_err(Error::file(list))?;
    let parse = |line: &str| {
        let mut fields = line.split_whitespace();
        let (seconds, nanoseconds) = fields.next()?.split_once('.')?;
        let stamp_ns = seconds.parse::<u64>().ok()?.checked_mul(1_000_000_000)?;
        let files = [fields.next()?, fields.next()?, fields.next()?].map(str::to_owned);
        Some(Entry { stamp_ns: stamp_ns.checked_add(nanoseconds.parse().ok()?)?, files })
    };
    let lines = text.lines().filter(|line| !line.trim().is_empty());
    let entries = lines.map(|line| parse(line).ok_or_else(|| bad(list, format!("`{line}` is no entry"))));
    entries.collect()
}

/// `truth/map.yaml`.
#[derive(Deserialize)]
struct GridFile {
    origin_x_m: f64,
    origin_y_m: f64,
    resolution_m: f64,
}

fn grid_file(path: &Path) -> Result<Grid> {
    let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
    let file: GridFile = serde_saphyr::from_str(&text).map_err(|error| bad(path, error.to_string()))?;
    let GridFile { origin_x_m, origin_y_m, resolution_m } = file;
    Ok(Grid { origin_x_m, origin_y_m, resolution_m, width: 0, height: 0 })
}

impl Entry {
    fn load(self, folder: &Path, grid: Grid) -> Result<TruthFrame> {
        let file = |name: &String| read_file(&folder.join(name));
        let depth = depth_from_exr(&file(&self.files[0])?)?;
        let DepthSamples::Metres(depth_m) = depth.samples else {
            return Err(bad(&folder.join(&self.files[0]), "does not hold metres"));
        };
        let grey = |name: &String| {
            let picture = color_from_file(&file(name)?)?;
            let values: Vec<u8> = picture.samples.chunks_exact(3).map(|pixel| pixel[0]).collect();
            Ok::<_, Error>((picture.width, picture.height, values))
        };
        let (_, _, material) = grey(&self.files[1])?;
        let (width, height, codes) = grey(&self.files[2])?;
        let cells = codes.into_iter().map(|code| code.wrapping_sub(1).cast_signed()).collect();
        let grid = Grid { width, height, ..grid };
        let (stamp_ns, width, height) = (self.stamp_ns, depth.width, depth.height);
        Ok(TruthFrame { stamp_ns, width, height, depth_m, material, grid, cells })
    }
}
