//! Where base and camera were: from the transform tree, from what the user stated, or, where a
//! recording knows only its camera, a base derived from it.

use glam::{DQuat, DVec3};

use crate::base::Rigid;
use crate::base::{Error, Result, duration_ns};
use crate::config::Config;
use crate::input::ReadReport;
use crate::input::event::TransformEvent;
use crate::input::frames::{Asked, FrameTree, Posing};
use crate::input::transforms::{TransformBuffer, TransformError};
use crate::message::bare_name;
use crate::sensor::{FramePose, SensorKind};

/// The transforms of a recording and the frames that are asked for.
pub(crate) struct PoseResolver {
    /// Everything known, the stated transforms included.
    pub(crate) tree: TransformBuffer,
    /// `static_transforms` alone.
    stated: TransformBuffer,
    /// All that was seen, whatever became of it.
    pub(crate) frames: FrameTree,
    map_frame: String,
    base_frame: String,
    ground_z_m: f64,
    /// `transform_tolerance_s`, for what is no sensor's own.
    pub(crate) tolerance_ns: u64,
}

/// A pose and whether its base was derived from the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ResolvedPose {
    pub(crate) pose: FramePose,
    pub(crate) base_derived: bool,
}

impl PoseResolver {
    /// # Errors
    /// [`Error::Config`] for a stated transform that is not a transform.
    pub(crate) fn new(config: &Config) -> Result<Self> {
        let (mut tree, mut stated) = (TransformBuffer::new(), TransformBuffer::new());
        let mut frames = FrameTree::default();
        for (number, transform) in config.static_transforms.iter().enumerate() {
            let rigid = Rigid::new(transform.translation_m, transform.rotation_xyzw).ok_or_else(|| {
                let reason =
                    format!("entry {number} (`{}`) has no rotation or is not finite", transform.child);
                Error::Config { key: "static_transforms".into(), reason }
            })?;
            let [parent, child] = [&transform.parent, &transform.child].map(|name| bare_name(name));
            tree.insert_stated(parent, child, rigid);
            stated.insert_fixed(parent, child, rigid);
            frames.state(parent, child);
        }
        Ok(Self {
            tree,
            stated,
            frames,
            map_frame: bare_name(&config.map_frame).into(),
            base_frame: bare_name(&config.base_frame).into(),
            ground_z_m: config.ground_z_m,
            tolerance_ns: duration_ns(config.transform_tolerance_s),
        })
    }

    /// Whether a transform's stamp lies more than a second before the newest of its frame.
    pub(crate) fn jumps_back(&self, transform: &TransformEvent) -> bool {
        let TransformEvent { child, stamp_ns, fixed, parent_from_child, .. } = transform;
        parent_from_child.is_some() && !fixed && self.tree.jumps_back(child, *stamp_ns)
    }

    /// Takes in a transform of a recording's `topic`. One that is not finite is counted; one in the place of a stated
    /// transform is noted.
    pub(crate) fn take(&mut self, topic: &str, transform: &TransformEvent, report: &mut ReadReport) {
        let TransformEvent { parent, child, stamp_ns, fixed, parent_from_child } = transform;
        let Some(parent_from_child) = *parent_from_child else {
            let reason = format!("the transform of `{child}` is not finite or has no rotation");
            report.skip(topic, reason, *stamp_ns);
            return;
        };
        if self.tree.is_stated(child) {
            report.note(format!(
                "the recording has its own transform of `{child}`, which takes the place of that in static_transforms"
            ));
        }
        self.frames.see(transform);
        if *fixed {
            self.tree.insert_fixed(parent, child, parent_from_child);
        } else {
            self.tree.insert(parent, child, *stamp_ns, parent_from_child);
        }
    }

    /// Newest stamp of the transforms between a frame and the map, where any has one.
    pub(crate) fn newest_ns(&self, frame: &str) -> Option<u64> {
        self.tree.newest_ns(frame).max(self.tree.newest_ns(&self.map_frame))
    }

    /// `target_from_source` at a stamp; one past the newest transform takes it within the tolerance.
    pub(crate) fn lookup(
        &self,
        target: &str,
        source: &str,
        stamp_ns: u64,
        tolerance_ns: u64,
    ) -> Result<Rigid, TransformError> {
        self.tree.lookup(target, source, stamp_ns, tolerance_ns)
    }

    /// Whether the pose at a stamp is known without holding the newest transform past its stamp.
    pub(crate) fn settled(&self, camera_frame: &str, stamp_ns: u64) -> bool {
        self.pose(camera_frame, stamp_ns, 0).is_ok()
    }

    /// Base and camera at a stamp; one past the newest transform takes it within the tolerance.
    pub(crate) fn pose(
        &self,
        camera_frame: &str,
        stamp_ns: u64,
        tolerance_ns: u64,
    ) -> Result<ResolvedPose, TransformError> {
        let map_from_camera = self.tree.lookup(&self.map_frame, camera_frame, stamp_ns, tolerance_ns)?;
        let in_tree = self.tree.lookup(&self.base_frame, camera_frame, stamp_ns, tolerance_ns);
        let known = in_tree
            .or_else(|error| self.stated.lookup(&self.base_frame, camera_frame, 0, 0).map_err(|_| error));
        match known {
            Ok(base_from_camera) => {
                let map_from_base = map_from_camera.then(base_from_camera.inverse());
                Ok(ResolvedPose { pose: FramePose { map_from_base, base_from_camera }, base_derived: false })
            }
            Err(error) if self.tree.knows(&self.base_frame) => Err(error),
            Err(_) => {
                let map_from_base = base_under_camera(map_from_camera, self.ground_z_m);
                let base_from_camera = map_from_base.inverse().then(map_from_camera);
                Ok(ResolvedPose { pose: FramePose { map_from_base, base_from_camera }, base_derived: true })
            }
        }
    }

    /// Whether the configuration states transforms.
    pub(crate) fn has_stated(&self) -> bool {
        !self.stated.is_empty()
    }

    /// A frame in the map at a stamp.
    pub(crate) fn map_from(
        &self,
        frame: &str,
        stamp_ns: u64,
        tolerance_ns: u64,
    ) -> Result<Rigid, TransformError> {
        self.lookup(&self.map_frame, frame, stamp_ns, tolerance_ns)
    }

    /// Base in the map and lidar in the base at a stamp. Where nothing says where the base is, it is the lidar, which is
    /// noted.
    pub(crate) fn lidar_pose(
        &self,
        lidar_frame: &str,
        stamp_ns: u64,
        tolerance_ns: u64,
        report: &mut ReadReport,
    ) -> Result<(Rigid, Rigid), TransformError> {
        let map_from_lidar = self.map_from(lidar_frame, stamp_ns, tolerance_ns)?;
        let in_tree = self.lookup(&self.base_frame, lidar_frame, stamp_ns, tolerance_ns);
        let known = in_tree
            .or_else(|error| self.stated.lookup(&self.base_frame, lidar_frame, 0, 0).map_err(|_| error));
        match known {
            Ok(base_from_lidar) => Ok((map_from_lidar.then(base_from_lidar.inverse()), base_from_lidar)),
            Err(error) if self.tree.knows(&self.base_frame) => Err(error),
            Err(_) => {
                report.note(format!(
                    "no transform of `{}`: the base is taken to be the lidar",
                    self.base_frame
                ));
                Ok((map_from_lidar, Rigid::IDENTITY))
            }
        }
    }

    /// Why a sensor of that kind has no poses, and which keys to set; `without_transforms`: what to say where the recording
    /// has no transforms; `odometry`: what to say of odometry that is not used.
    pub(crate) fn explain(
        &self,
        posing: &Posing,
        kind: SensorKind,
        without_transforms: &str,
        odometry: &str,
    ) -> Option<String> {
        let (map_frame, base_frame) = (self.map_frame.as_str(), self.base_frame.as_str());
        self.frames.explain(posing, &Asked { kind, map_frame, base_frame, without_transforms, odometry })
    }

    /// Why a frame has no pose.
    pub(crate) fn missing_reason(&self, camera_frame: &str, error: &TransformError) -> String {
        format!("no transform from `{}` to `{camera_frame}`: {error}", self.map_frame)
    }

    /// What a user should know where the base is derived.
    pub(crate) fn derived_note(&self) -> String {
        format!(
            "no transform of `{}`: the base is taken to stand under the camera at z = {} m, upright, facing along the optical axis",
            self.base_frame, self.ground_z_m
        )
    }
}

/// `map_from_base` of a base that stands on the ground under the camera, z up, x along the optical
/// axis; where that points straight up or down, x is up in the image.
fn base_under_camera(map_from_camera: Rigid, ground_z_m: f64) -> Rigid {
    let axis = map_from_camera.rotation * DVec3::Z;
    let facing = if axis.truncate().length() > 1e-6 { axis } else { map_from_camera.rotation * DVec3::NEG_Y };
    let yaw_rad = facing.y.atan2(facing.x);
    let at = map_from_camera.translation_m;
    Rigid { rotation: DQuat::from_rotation_z(yaw_rad), translation_m: DVec3::new(at.x, at.y, ground_z_m) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_that_looks_down_gives_a_base_that_faces_the_image_top() {
        // Optical z down (-z map), image top (-y) towards map +y: x right = map x.
        let rotation = DQuat::from_rotation_x(std::f64::consts::PI);
        let camera = Rigid { rotation, translation_m: DVec3::new(1.0, 2.0, 3.0) };
        let base = base_under_camera(camera, 0.5);
        assert!(base.translation_m.abs_diff_eq(DVec3::new(1.0, 2.0, 0.5), 1e-12));
        assert!((base.rotation * DVec3::X).abs_diff_eq(DVec3::Y, 1e-12), "{base:?}");
    }
}
