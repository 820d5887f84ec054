//! What the robot carries: the simulated camera and lidar of a scene, as observations (spec 1 §8, spec 6).

use super::robot::Pose;
use super::setup::Setup;
use crate::base::{Result, Rigid};
use crate::config::SensorInfo;
use crate::gpu::Context;
use crate::offline::eval::source::recorded;
use crate::sensor::{
    CameraInfo, FramePose, Observation, Scan, SensorData, SensorPose, Sweep, ring_elevations,
};
use crate::sim::frame::SimFrame;
use crate::sim::lidar::LidarSimulator;
use crate::sim::trajectory::base_from_camera;
use crate::sim::{Scene, Simulator, stamp_ns};

/// A trial has about so many frames and scans.
const FRAMES: u64 = 300;

/// Where the robot was and where it took itself to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// In the world.
    pub truly: Pose,
    /// By its odometry.
    pub believed: Pose,
}

/// See the module. The camera is sensor 0; the lidar follows.
pub struct Sensors {
    scene: Scene,
    camera: Option<Simulator>,
    lidar: Option<LidarSimulator>,
    one_ring: bool,
    map_frame: String,
    infos: Vec<SensorInfo>,
}

/// What came of a tick.
pub struct Looked {
    /// In the order of the sensors.
    pub observations: Vec<Observation>,
    /// The camera's frame with its truth.
    pub frame: Option<SimFrame>,
}

impl Sensors {
    /// Of a scene, for what a set-up has; `start` is where the first scan is taken that tells what the lidar is like.
    ///
    /// # Errors
    /// Those of the simulators.
    pub fn open(context: &Context, scene: &Scene, setup: &Setup, start: Pose) -> Result<Self> {
        let camera = match &setup.camera {
            Some(_) => Some(Simulator::for_frames(scene, context, FRAMES)?),
            None => None,
        };
        let lidar = match &setup.lidar {
            Some(_) => Some(LidarSimulator::for_scans(scene, context, FRAMES)?),
            None => None,
        };
        let map_frame = setup.config.map_frame.clone();
        let (scene, one_ring) = (scene.clone(), setup.one_ring);
        let mut sensors = Self { scene, camera, lidar, one_ring, map_frame, infos: Vec::new() };
        if let Some(config) = &setup.camera {
            let model = sensors.scene.camera.model();
            let info = CameraInfo {
                depth: model,
                float_depth: false,
                color: Some(model),
                color_aligned: true,
                confidence: false,
            };
            sensors.infos.push(SensorInfo::camera(config, info));
        }
        if let Some(config) = &setup.lidar {
            let standing = Placed { truly: start, believed: start };
            let first = sensors.scan(0, [standing; 2])?;
            sensors.infos.extend(first.map(|(scan, _)| SensorInfo::lidar(config, scan)));
        }
        Ok(sensors)
    }

    /// What a mapper needs to know of them.
    pub fn infos(&self) -> &[SensorInfo] {
        &self.infos
    }

    /// What all see at a tick: the camera from where the robot is, the lidar on its way there from where it was.
    ///
    /// # Errors
    /// Those of the simulators.
    pub fn look(&mut self, tick: u64, places: [Placed; 2]) -> Result<Looked> {
        let mut observations = Vec::new();
        let frame = match &mut self.camera {
            Some(simulator) => {
                let base_from_camera = base_from_camera(&self.scene.camera);
                let pose = |at: Pose| FramePose { map_from_base: at.rigid(), base_from_camera };
                let frame = simulator.frame(tick, pose(places[1].truly))?;
                let mut seen = recorded(frame.clone(), self.scene.camera.model());
                seen.pose = Some(pose(places[1].believed));
                observations.push(Observation::of_frame(0, &self.map_frame, seen));
                Some(frame)
            }
            None => None,
        };
        if let Some((scan, pose)) = self.scan(tick, places)? {
            let (sensor, map_frame) = (observations.len(), self.map_frame.clone());
            let data = SensorData::Scan(scan);
            observations.push(Observation { sensor, pose: Some(pose), map_frame, goal_m: None, data });
        }
        Ok(Looked { observations, frame })
    }

    fn scan(&mut self, tick: u64, places: [Placed; 2]) -> Result<Option<(Scan, SensorPose)>> {
        let Some(lidar) = &mut self.lidar else { return Ok(None) };
        let [from, to] = places;
        let way = |from: Pose, to: Pose| {
            let (from, to) = (from.rigid(), to.rigid());
            move |share: f64| -> Rigid { from.interpolate(to, share) }
        };
        let stamp_ns = stamp_ns(&self.scene, tick) - lidar.period_ns();
        let mut scan = lidar.scan(tick, stamp_ns, way(from.truly, to.truly))?.scan;
        if self.one_ring {
            keep_level_ring(&mut scan);
        }
        let mount = self.scene.lidar.as_ref().map_or(Rigid::IDENTITY, |lidar| lidar.base_from_lidar());
        let believed = way(from.believed, to.believed);
        let times = || scan.points.iter().map(|point| point.time_s);
        let (first_s, last_s) = (times().fold(f32::INFINITY, f32::min), times().fold(0.0, f32::max));
        let period_s = std::time::Duration::from_nanos(lidar.period_ns()).as_secs_f64();
        let at = |time_s: f32| believed(f64::from(time_s) / period_s).then(mount);
        let moved = from.believed != to.believed && first_s < last_s;
        let sweep =
            moved.then(|| Sweep { first_s, last_s, map_from_first: at(first_s), map_from_last: at(last_s) });
        let pose = SensorPose { map_from_base: believed(0.0), base_from_sensor: mount, sweep };
        Ok(Some((scan, pose)))
    }
}

/// Leaves the ring nearest to the horizontal, and of each beam the strongest return: a laser scanner.
fn keep_level_ring(scan: &mut Scan) {
    let rings = ring_elevations(scan);
    let level = rings.iter().min_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map(|(ring, _)| *ring);
    scan.points
        .retain(|point| Some(point.ring) == level && point.strength != crate::sensor::Strength::Weaker);
}
