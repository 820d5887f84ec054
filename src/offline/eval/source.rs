//! Frames with their ground truth: out of the simulator as they are made, or from a recording.

use std::path::{Path, PathBuf};

use crate::base::Rigid;
use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::{Recording, open};
use crate::sensor::CameraModel;
use crate::sensor::{ColorImage, DepthImage, DepthSamples, FramePose, RgbdFrame};
use crate::sim::frame::SimFrame;
use crate::sim::generate::Level;
use crate::sim::truth::{TrueMap, TruthFrame, TruthReader};
use crate::sim::{Scene, Simulator};

/// A frame as a pipeline takes it, and what is true of it.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueFrame {
    /// What the sensor gave.
    pub frame: RgbdFrame,
    /// What there was.
    pub truth: TruthFrame,
}

/// A stream of frames with truth.
pub trait Source {
    /// The next frame, `None` at the end.
    ///
    /// # Errors
    /// Whatever the simulator or the readers meet; [`Error::Format`] for a frame without truth.
    fn next_frame(&mut self) -> Result<Option<TrueFrame>>;
}

/// A scene driven through by the simulated camera.
pub struct Generated {
    simulator: Simulator,
    map: TrueMap,
    poses: std::iter::Zip<std::ops::RangeFrom<u64>, std::vec::IntoIter<FramePose>>,
}

impl Generated {
    /// Builds the simulator on the adapter of that name; height band, range and cells of the true map are the configuration's.
    ///
    /// # Errors
    /// Those of [`Simulator::open`].
    pub fn open(scene: &Scene, config: &Config, adapter: Option<&str>) -> Result<Self> {
        let simulator = Simulator::open(scene, adapter, false)?;
        let poses = (0..).zip(simulator.poses());
        Ok(Self { simulator, map: TrueMap::new(scene, config), poses })
    }
}

impl Source for Generated {
    fn next_frame(&mut self) -> Result<Option<TrueFrame>> {
        let Some((index, pose)) = self.poses.next() else { return Ok(None) };
        let frame = self.simulator.frame(index, pose)?;
        let camera = self.simulator.scene().camera.model();
        self.map.observe(&frame, &camera);
        let truth = TruthFrame {
            stamp_ns: frame.stamp_ns,
            width: frame.width,
            height: frame.height,
            depth_m: frame.true_depth_m.clone(),
            material: frame.material.clone(),
            grid: self.map.grid(),
            cells: self.map.cells(),
        };
        Ok(Some(TrueFrame { frame: recorded(frame, camera), truth }))
    }
}

/// A simulated frame as a reader would give it.
pub fn recorded(frame: SimFrame, camera: CameraModel) -> RgbdFrame {
    let SimFrame { index, stamp_ns, pose, depth_mm, rgb, .. } = frame;
    let samples = DepthSamples::Integer { raw: depth_mm, unit_m: 0.001 };
    RgbdFrame {
        index,
        depth: DepthImage { stamp_ns, frame_id: "camera".into(), camera, samples },
        color: Some(ColorImage { stamp_ns, camera, rgb }),
        color_from_depth: Some(Rigid::IDENTITY),
        color_missing: None,
        confidence: None,
        pose: Some(pose),
    }
}

/// A recording that carries its truth, as `limpid sim` writes it.
pub struct Recorded {
    path: PathBuf,
    frames: Box<dyn Recording>,
    truth: TruthReader,
    scene: Option<Scene>,
}

impl Recorded {
    /// Opens both streams.
    ///
    /// # Errors
    /// Those of [`open`]; [`Error::Format`] where the recording holds no truth.
    pub fn open(path: &Path, config: &Config) -> Result<Self> {
        let frames = open(path, config)?;
        if path.is_dir() && !path.join("truth.txt").exists() {
            return Err(without_truth(path));
        }
        let mut first = TruthReader::open(path)?;
        if first.next_frame()?.is_none() {
            return Err(without_truth(path));
        }
        Ok(Self { path: path.into(), frames, truth: TruthReader::open(path)?, scene: first.scene()? })
    }

    /// The glare level of a scene that [`generate`](crate::sim::generate::generate) made; `None` for any other.
    pub fn level(&self) -> Option<Level> {
        Level::of_scene(self.scene.as_ref()?)
    }
}

fn without_truth(path: &Path) -> Error {
    let reason = "holds no ground truth (/truth/depth/image_raw, /truth/map; in a folder truth.txt); \
                  `limpid sim` writes recordings that do"
        .into();
    Error::Format { path: path.into(), reason }
}

impl Source for Recorded {
    fn next_frame(&mut self) -> Result<Option<TrueFrame>> {
        // Frames without a pose go into no map; the reader's report counts them.
        let frame = loop {
            match self.frames.next_frame()? {
                None => return Ok(None),
                Some(frame) if frame.pose.is_some() => break frame,
                Some(_) => {}
            }
        };
        let stamp_ns = frame.depth.stamp_ns;
        while let Some(truth) = self.truth.next_frame()? {
            if truth.stamp_ns == stamp_ns {
                return Ok(Some(TrueFrame { frame, truth }));
            }
            if truth.stamp_ns > stamp_ns {
                break;
            }
        }
        let reason = format!("frame {} (stamp {stamp_ns} ns) has no ground truth", frame.index);
        Err(Error::Format { path: self.path.clone(), reason })
    }
}
