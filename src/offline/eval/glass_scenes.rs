//! Scores of labels on simulated drives past glass (spec 6 section 4): points against what their beams truly met, the map
//! of panes against the scene's.

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::glass_metrics::{GlassScores, GlassTally};
use crate::base::{Error, Result, Rigid};
use crate::config::Config;
use crate::gpu::Context;
use crate::map::Pane;
use crate::map::glass::{LabelledScan, PointClass};
use crate::offline::labeller::Labeller;
use crate::sensor::Scan;
use crate::sim::Way;
use crate::sim::generate::Random;
use crate::sim::lidar::{LidarSimulator, PointTruth, SimScan};
use crate::sim::material::Kind;
use crate::sim::scene::{self, Scene};

/// A mirrored point this near to where its beam was sent back is in place, metres.
const IN_PLACE_M: f64 = 0.1;
/// A pane that was found is a true one within this distance and angle.
const ON_PANE_M: f64 = 0.15;
const ON_PANE_COSINE: f64 = 0.985;
/// Ends of panes may be this far off, metres.
const BEYOND_END_M: f64 = 0.1;
/// Lengths of panes are counted in steps, metres.
const STEP_M: f64 = 0.05;
/// Points that a pane must have sent back to count as seen.
const SEEN_POINTS: usize = 30;

/// 3DRef's labels.
const NORMAL: u32 = 1;
const GLASS: u32 = 2;
const MIRROR: u32 = 3;
const REFLECTION: u32 = 5;
const BEHIND: u32 = 6;

/// Scores of drives, as shares.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct DriveScores {
    /// Points, by 3DRef's labels.
    pub points: GlassScores,
    /// Of the true reflections that were mirrored those within 0.1 m of where their beam was sent back.
    pub mirrored_in_place: f64,
    /// Of the length of the glass that was seen that which the map of panes has.
    pub pane_recall: f64,
    /// Of the length of the panes in the map that which is glass or a mirror.
    pub pane_precision: f64,
    /// Mean distance of panes in the map from the true ones, metres.
    pub pane_off_m: f64,
    /// Of the scans those that were labelled by a pane.
    pub scans_with_panes: f64,
}

/// Sums over drives.
#[derive(Debug, Clone, Default)]
pub struct DriveTally {
    points: GlassTally,
    mirrored: u64,
    in_place: u64,
    seen_steps: u64,
    found_steps: u64,
    pane_steps: u64,
    true_steps: u64,
    off_m: f64,
    /// Scans that were labelled by a pane.
    pub with_panes: u64,
    /// Scans so far.
    pub scans: u64,
}

impl DriveTally {
    /// Takes the counts of other drives in.
    pub fn join(&mut self, other: &Self) {
        self.points.join(&other.points);
        for (own, other) in [
            (&mut self.mirrored, other.mirrored),
            (&mut self.in_place, other.in_place),
            (&mut self.seen_steps, other.seen_steps),
            (&mut self.found_steps, other.found_steps),
            (&mut self.pane_steps, other.pane_steps),
            (&mut self.true_steps, other.true_steps),
            (&mut self.with_panes, other.with_panes),
            (&mut self.scans, other.scans),
        ] {
            *own += other;
        }
        self.off_m += other.off_m;
    }

    /// The shares; 0 of nothing is 0.
    pub fn scores(&self) -> DriveScores {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let share = |part: u64, whole: u64| if whole == 0 { 0.0 } else { part as f64 / whole as f64 };
        DriveScores {
            points: self.points.scores(),
            mirrored_in_place: share(self.in_place, self.mirrored),
            pane_recall: share(self.found_steps, self.seen_steps),
            pane_precision: share(self.true_steps, self.pane_steps),
            pane_off_m: self.off_m * share(1, self.found_steps),
            scans_with_panes: share(self.with_panes, self.scans),
        }
    }
}

/// How poses are given to the labeller: as they are, or off by this much (deviations of each axis).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PoseNoise {
    /// Metres.
    pub place_m: f64,
    /// About the vertical, radians.
    pub yaw_rad: f64,
}

/// Drives through a scene with its lidar for at most `scans` revolutions, and scores what the labels say with each kind
/// of poses; `tallies` are as many as `noises`.
///
/// # Errors
/// [`Error::Config`] for a scene without a lidar, those of the simulator and the labeller.
pub fn drive(
    scene: &Scene,
    config: &Config,
    scans: u64,
    context: &Context,
    (noises, tallies): (&[PoseNoise], &mut [DriveTally]),
) -> Result<()> {
    let lidar = scene
        .lidar
        .as_ref()
        .ok_or_else(|| Error::Config { key: "lidar".into(), reason: "the scene has none".into() })?;
    let (mount, way) = (lidar.base_from_lidar(), Way::of(scene));
    let mut simulator = LidarSimulator::with_context(scene, context)?;
    let mut random = Random::new(scene.seed ^ 0x706f_7365);
    let mut labellers: Vec<Labeller> = Vec::new();
    let mut seen = vec![0; scene.panes.len()];
    let mut last: Vec<(Rigid, Vec<Pane>)> = Vec::new();
    for _ in 0..scans {
        let Some((simulated, _)) = simulator.next_on(&way, u64::MAX)? else { break };
        count_seen(scene, &simulated.truth, &mut seen);
        let at = |stamp_ns: u64| way.at(stamp_ns).then(mount);
        let (scan, pose) = (deskewed(scene, &simulated, at), at(simulated.scan.stamp_ns));
        last.clear();
        for (index, (noise, tally)) in noises.iter().zip(tallies.iter_mut()).enumerate() {
            if labellers.len() <= index {
                labellers.push(Labeller::on(context, config, &scan)?);
            }
            let given = noisy(pose, *noise, &mut random);
            let labelled = labellers[index].label(&scan, given)?;
            tally.add(&scan, &simulated.truth, &labelled, pose);
            last.push((given, labelled.panes));
        }
    }
    for ((given, panes), tally) in last.iter().zip(tallies) {
        tally.add_panes(scene, &seen, &panes.iter().map(|pane| pane.moved(*given)).collect::<Vec<_>>());
    }
    Ok(())
}

/// The points in the lidar's frame at the scan's stamp, with 3DRef's labels.
fn deskewed(scene: &Scene, simulated: &SimScan, at: impl Fn(u64) -> Rigid) -> Scan {
    let kinds: Vec<Kind> = scene.materials.values().map(|material| material.kind).collect();
    let start = at(simulated.scan.stamp_ns).inverse();
    let mut scan = simulated.scan.clone();
    scan.columns.label = true;
    for (point, truth) in scan.points.iter_mut().zip(&simulated.truth) {
        let after = std::time::Duration::from_secs_f64(f64::from(point.time_s.max(0.0)));
        let later = simulated.scan.stamp_ns + u64::try_from(after.as_nanos()).unwrap_or(0);
        let place_m = DVec3::from(point.position_m().map(f64::from));
        let [x, y, z] = start.then(at(later)).transform_point(place_m).as_vec3().to_array();
        (point.x_m, point.y_m, point.z_m) = (x, y, z);
        point.label = label_of(truth, &kinds);
    }
    scan
}

fn label_of(truth: &PointTruth, kinds: &[Kind]) -> u32 {
    let is_mirror = kinds.get(usize::from(truth.material)) == Some(&Kind::Mirror);
    match (truth.is_reflection(), truth.is_glass(), truth.is_behind()) {
        (true, ..) => REFLECTION,
        (_, true, _) if is_mirror => MIRROR,
        (_, true, _) => GLASS,
        (_, _, true) => BEHIND,
        _ => NORMAL,
    }
}

fn noisy(pose: Rigid, noise: PoseNoise, random: &mut Random) -> Rigid {
    // Near normal: the sum of twelve even numbers.
    let mut normal = || (0..12).map(|_| random.unit()).sum::<f64>() - 6.0;
    let shift = DVec3::new(normal(), normal(), 0.0) * noise.place_m;
    let turn = glam::DQuat::from_rotation_z(normal() * noise.yaw_rad);
    Rigid { rotation: (turn * pose.rotation).normalize(), translation_m: pose.translation_m + shift }
}

/// Counts the points that each pane of the scene sent back itself.
fn count_seen(scene: &Scene, truth: &[PointTruth], seen: &mut [usize]) {
    let itself = truth.iter().filter(|truth| truth.is_glass() && !truth.is_reflection());
    for place in itself.map(|truth| truth.place_m.truncate()) {
        let on = |pane: &scene::Pane| off_pane(pane, place).is_some_and(|off| off.abs() < 0.02);
        if let Some(index) = scene.panes.iter().position(on) {
            seen[index] += 1;
        }
    }
}

/// Direction along a pane of the scene, and the one that it faces.
fn axes(pane: &scene::Pane) -> (DVec2, DVec2) {
    let facing = DVec2::from_angle(pane.yaw_rad);
    (facing.perp(), facing)
}

/// Signed distance of a place from a pane of the scene, where it lies beside the pane.
fn off_pane(pane: &scene::Pane, place: DVec2) -> Option<f64> {
    let (along, facing) = axes(pane);
    let offset = place - DVec2::new(pane.center_m[0], pane.center_m[1]);
    (offset.dot(along).abs() <= pane.width_m / 2.0 + BEYOND_END_M).then(|| offset.dot(facing))
}

/// Places along a line, [`STEP_M`] apart.
fn steps(from: DVec2, to: DVec2) -> impl Iterator<Item = DVec2> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a length of some metres")]
    let count = (from.distance(to) / STEP_M).round().max(1.0) as u32;
    (0..count).map(move |k| from.lerp(to, (f64::from(k) + 0.5) / f64::from(count)))
}

/// A pane of the map as seen from above: its ends and unit normal.
struct Found {
    ends: [DVec2; 2],
    normal: DVec2,
}

impl Found {
    fn of(pane: &Pane) -> Self {
        let corners = pane.corners_m();
        let ends = [corners[0].midpoint(corners[3]), corners[1].midpoint(corners[2])].map(DVec3::truncate);
        Self { ends, normal: pane.unit_normal().as_dvec3().truncate().normalize_or_zero() }
    }

    /// Signed distance of a place, where it lies beside the pane.
    fn off(&self, place: DVec2) -> Option<f64> {
        let [from, to] = self.ends;
        let along = (to - from).normalize_or_zero();
        let at = (place - from).dot(along);
        let beside = (-BEYOND_END_M..=from.distance(to) + BEYOND_END_M).contains(&at);
        beside.then(|| (place - from).dot(self.normal))
    }
}

impl DriveTally {
    fn add(&mut self, scan: &Scan, truth: &[PointTruth], labelled: &LabelledScan, pose: Rigid) {
        self.scans += 1;
        self.with_panes += u64::from(!labelled.panes.is_empty());
        self.points.add(scan, labelled);
        for ((point, truth), &(class, pane_id)) in scan.points.iter().zip(truth).zip(&labelled.classes) {
            if class != PointClass::Reflection || !truth.is_reflection() {
                continue;
            }
            let Some(pane) = labelled.panes.iter().find(|pane| pane.id == pane_id) else { continue };
            let mirrored = pane.mirrored_m(DVec3::from(point.position_m().map(f64::from)));
            self.mirrored += 1;
            let off_m = pose.transform_point(mirrored).distance(truth.place_m);
            self.in_place += u64::from(off_m < IN_PLACE_M);
        }
    }

    /// Counts the map of panes at the end of a drive in; `seen`: points of each true one.
    fn add_panes(&mut self, scene: &Scene, seen: &[usize], panes: &[Pane]) {
        let found: Vec<Found> = panes.iter().map(Found::of).collect();
        let kind = |pane: &scene::Pane| scene.materials.get(&pane.material).map(|material| material.kind);
        let is_smooth = |pane: &scene::Pane| matches!(kind(pane), Some(Kind::Glass | Kind::Mirror));
        let is_seen = |(pane, points): &(&scene::Pane, &usize)| {
            kind(pane) == Some(Kind::Glass) && **points >= SEEN_POINTS
        };
        for (pane, _) in scene.panes.iter().zip(seen).filter(is_seen) {
            let (along, facing) = axes(pane);
            let middle = DVec2::new(pane.center_m[0], pane.center_m[1]);
            let half = along * pane.width_m / 2.0;
            for place in steps(middle - half, middle + half) {
                let offs = found.iter().filter(|f| f.normal.dot(facing).abs() > ON_PANE_COSINE);
                let off = offs.filter_map(|f| f.off(place)).map(f64::abs).fold(f64::INFINITY, f64::min);
                self.seen_steps += 1;
                if off < ON_PANE_M {
                    self.found_steps += 1;
                    self.off_m += off;
                }
            }
        }
        for found in &found {
            for place in steps(found.ends[0], found.ends[1]) {
                let is_true = scene.panes.iter().filter(|pane| is_smooth(pane)).any(|pane| {
                    found.normal.dot(axes(pane).1).abs() > ON_PANE_COSINE
                        && off_pane(pane, place).is_some_and(|off| off.abs() < ON_PANE_M)
                });
                self.pane_steps += 1;
                self.true_steps += u64::from(is_true);
            }
        }
    }
}
