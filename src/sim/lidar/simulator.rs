//! The simulated lidar on the GPU: sub-rays, then echoes, some ten thousand beams a submission.

use std::f64::consts::TAU;
use std::time::Duration;

use glam::DVec3;

use super::model::{Optics, Ring};
use super::scan::{Echo, SimScan};
use super::settings::{Lidar, Returns};
use crate::base::{Error, Result, Rigid};
use crate::gpu::{Context, Executor, Invocations, Plan, Readback};
use crate::sensor::{Columns, Dropped, Point, ReturnType, Scan, Strength};
use crate::sim::generate::Random;
use crate::sim::passes::{BEAM, ECHO, SimBeamParams, SimEchoParams};
use crate::sim::scene::Scene;
use crate::sim::trajectory::seconds_at;
use crate::sim::written;
use crate::sim::{SimScene, Way};
use crate::stage::single;

/// Beams of one submission.
const BEAMS_AT_ONCE: u32 = 16_384;

/// Echoes of a sub-ray that are kept (`ECHOES` of `sim/beam`).
const ECHOES: u64 = 4;

/// The frame of the simulated lidar's clouds.
pub const LIDAR_FRAME: &str = "lidar";

/// A scene with its lidar, ready to scan from any pose.
pub struct LidarSimulator {
    lidar: Lidar,
    optics: Optics,
    columns: u32,
    seed: u64,
    /// Kept where people walk.
    moving: Option<Scene>,
    packed: SimScene,
    next: u64,
    executor: Executor,
    pass_ms: Vec<(String, f64)>,
}

/// The plan of a part of a scan.
///
/// # Errors
/// [`Error::Plan`] or [`Error::Shader`] where a pass contradicts its shader.
pub fn plan(lidar: &Lidar) -> Result<Plan> {
    plan_with(lidar, None)
}

/// As [`plan`], with the solids of `written` in the code.
fn plan_with(lidar: &Lidar, written: Option<&SimScene>) -> Result<Plan> {
    let mut plan = Plan::default();
    let (beams, rows) = (u64::from(BEAMS_AT_ONCE), lidar.model.optics().rings.len() as u64);
    plan.uniform::<SimScene>("scene")?;
    plan.uniform::<SimBeamParams>("beam_params")?;
    plan.uniform::<SimEchoParams>("echo_params")?;
    plan.upload("rings", rows * 16)?;
    plan.upload("column_poses", u64::from(lidar.columns()) * 64)?;
    plan.scratch("sent_back", beams * u64::from(lidar.subrays) * ECHOES * 16)?;
    plan.scratch("echoes", beams * 32)?;
    plan.step(written::text(BEAM, written), Invocations::line(BEAMS_AT_ONCE * lidar.subrays), &[])?;
    plan.step(ECHO, Invocations::line(BEAMS_AT_ONCE), &[])?;
    plan.read_back("echoes")?;
    plan.check()?;
    Ok(plan)
}

impl LidarSimulator {
    /// Checks the scene and builds the passes of its lidar on a device.
    ///
    /// # Errors
    /// [`Error::Config`] with the key of the scene, `lidar` where it has none; [`Error::Limit`], [`Error::Gpu`].
    pub fn with_context(scene: &Scene, context: &Context) -> Result<Self> {
        let way = &scene.trajectory;
        let lidar_hz = scene.lidar.as_ref().map_or(0.0, |lidar| lidar.rate_hz);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few; 0 where it is odd"
        )]
        let scans = (f64::from(way.frames) / way.rate_hz * lidar_hz) as u64;
        Self::for_scans(scene, context, scans)
    }

    /// As [`Self::with_context`], for so many revolutions: what is compiled for many takes longer and runs faster. The scans
    /// are the same.
    ///
    /// # Errors
    /// As there.
    pub fn for_scans(scene: &Scene, context: &Context, scans: u64) -> Result<Self> {
        scene.validate()?;
        let lidar = scene
            .lidar
            .clone()
            .ok_or_else(|| Error::Config { key: "lidar".into(), reason: "the scene has none".into() })?;
        let (optics, columns, seed) = (lidar.model.optics(), lidar.columns(), scene.seed);
        let packed = SimScene::pack(&scene.at(0.0));
        let rays = scans * u64::from(columns * lidar.subrays) * optics.rings.len() as u64;
        let written = written::is_worth_it(scene, context, rays).then_some(&packed);
        let executor = Executor::build(context, plan_with(&lidar, written)?)?;
        let moving = (!scene.walkers.is_empty()).then(|| scene.clone());
        Ok(Self { lidar, optics, columns, seed, moving, packed, next: 0, executor, pass_ms: Vec::new() })
    }

    /// Milliseconds of each pass of the last scan, where passes are timed.
    pub fn pass_ms(&self) -> &[(String, f64)] {
        &self.pass_ms
    }

    /// Nanoseconds of a revolution.
    pub fn period_ns(&self) -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a checked, positive rate"
        )]
        let period_ns = (1e9 / self.lidar.rate_hz).round() as u64;
        period_ns
    }

    /// The next revolution of a robot on its way, where it ends by `until_ns`; with the time of its end.
    ///
    /// # Errors
    /// As [`Self::scan`].
    pub fn next_on(&mut self, way: &Way, until_ns: u64) -> Result<Option<(SimScan, u64)>> {
        let period_ns = self.period_ns();
        let (index, start_ns) = (self.next, way.start_ns() + self.next * period_ns);
        if start_ns + period_ns > until_ns {
            return Ok(None);
        }
        self.next += 1;
        let period_s = 1.0 / self.lidar.rate_hz;
        let after = |share: f64| u64::try_from(Duration::from_secs_f64(share * period_s).as_nanos());
        let pose = |share: f64| way.at(start_ns + after(share).unwrap_or(period_ns));
        Ok(Some((self.scan(index, start_ns, pose)?, start_ns + period_ns)))
    }

    /// Revolution `index`, whose first firing is at `stamp_ns`; `map_from_base` gives the robot's pose at a share of it.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn scan(
        &mut self,
        index: u64,
        stamp_ns: u64,
        map_from_base: impl Fn(f64) -> Rigid,
    ) -> Result<SimScan> {
        let mount = self.lidar.base_from_lidar();
        let poses: Vec<Rigid> = (0..self.columns)
            .map(|column| map_from_base(f64::from(column) / f64::from(self.columns)).then(mount))
            .collect();
        let words: Vec<[f32; 16]> =
            (0_u32..).zip(&poses).map(|(column, pose)| self.column(column, *pose)).collect();
        let beams = self.columns * self.rows();
        let mut collected = self.empty(index, stamp_ns, beams);
        self.pass_ms.clear();
        for first in (0..beams).step_by(BEAMS_AT_ONCE as usize) {
            let count = BEAMS_AT_ONCE.min(beams - first);
            if let Some(scene) = &self.moving {
                let share = f64::from(first) / f64::from(beams);
                self.packed = SimScene::pack(&scene.at(seconds_at(stamp_ns) + share / self.lidar.rate_hz));
            }
            let readback = self.part(index, first, count, &words)?;
            let slots = readback.bytes(self.executor.find("echoes")?)?.chunks_exact(32);
            for (beam, slots) in (first..first + count).zip(slots) {
                let [one, other]: [[u32; 4]; 2] = bytemuck::pod_read_unaligned(slots);
                self.take(&mut collected, beam, [Echo::of(one), Echo::of(other)], &poses);
            }
        }
        Ok(collected)
    }

    fn rows(&self) -> u32 {
        u32::try_from(self.optics.rings.len()).unwrap_or(0)
    }

    /// Sends `count` beams and waits for their echoes.
    fn part(&mut self, index: u64, first: u32, count: u32, columns: &[[f32; 16]]) -> Result<Readback> {
        let ring = |ring: &Ring| [ring.elevation_rad, self.ahead_rad(ring), ring.offset_m, 0.0].map(single);
        let rings: Vec<[f32; 4]> = self.optics.rings.iter().map(ring).collect();
        let (beam, echo) = (self.beam_params(index, first, count), self.echo_params(index, first, count));
        let mut input = self.executor.begin()?;
        input.set("scene", &self.packed)?;
        input.write("rings", bytemuck::cast_slice(&rings))?;
        input.write("column_poses", bytemuck::cast_slice(columns))?;
        input.set("beam_params", &beam)?;
        input.set("echo_params", &echo)?;
        input.submit()?;
        let readback = self.executor.receive()?.ok_or_else(|| Error::Gpu {
            what: "simulated scan".into(),
            reason: "nothing came back".into(),
        })?;
        for (name, span) in &readback.spans {
            let ms = span.length_ns * 1e-6;
            match self.pass_ms.iter_mut().find(|(known, _)| known.as_str() == &**name) {
                Some((_, sum)) => *sum += ms,
                None => self.pass_ms.push((name.to_string(), ms)),
            }
        }
        Ok(readback)
    }

    /// Least power of an echo, as a share of a white wall's at 1 m.
    fn threshold(&self) -> f32 {
        single(0.1 / (self.optics.tenth_seen_m * self.optics.tenth_seen_m))
    }

    fn beam_params(&self, index: u64, first_beam: u32, beams: u32) -> SimBeamParams {
        let [level, upright] = self.optics.divergence_rad.map(|full| single(full / 2.0));
        SimBeamParams {
            rows: self.rows(),
            first_beam,
            beams,
            subrays: self.lidar.subrays,
            turn: single(TAU * f64::from(self.bits(index, 7)) / f64::from(u32::MAX)),
            largest_range_m: single(self.optics.range_m[1]),
            spread_level_rad: level,
            spread_upright_rad: upright,
            // Several faint parts may add up.
            faintest: 0.5 * self.threshold(),
            pad0: 0,
            pad1: 0,
            pad2: 0,
        }
    }

    fn echo_params(&self, index: u64, first: u32, beams: u32) -> SimEchoParams {
        let optics = &self.optics;
        SimEchoParams {
            beams,
            subrays: self.lidar.subrays,
            returns: self.lidar.returns.code(),
            calibrated: u32::from(optics.calibrated),
            seed: self.bits(index, 8).wrapping_add(first),
            threshold: self.threshold(),
            pulse_m: single(optics.pulse_m),
            range_noise_m: single(optics.range_noise_m),
            power_noise: single(optics.power_noise),
            scale: single(optics.scale * self.lidar.intensity_gain),
            largest: single(optics.largest * self.lidar.intensity_gain),
            nearest_m: single(optics.range_m[0]),
            focus_m: single(optics.focus_m),
            pad0: 0,
            pad1: 0,
            pad2: 0,
        }
    }

    /// Rows of the map's axes with the sensor's place, and the azimuth.
    fn column(&self, column: u32, pose: Rigid) -> [f32; 16] {
        let (axes, at) = (pose.rotation_matrix().transpose(), pose.translation_m);
        let mut words = [0.0; 16];
        for (row, place) in [(axes.x_axis, at.x), (axes.y_axis, at.y), (axes.z_axis, at.z)].iter().enumerate()
        {
            words[4 * row..4 * row + 4].copy_from_slice(&[
                single(place.0.x),
                single(place.0.y),
                single(place.0.z),
                single(place.1),
            ]);
        }
        words[12] = single(self.azimuth_rad(column));
        words
    }

    /// Sensors turn clockwise, seen from above, from forward on.
    fn azimuth_rad(&self, column: u32) -> f64 {
        -TAU * f64::from(column) / f64::from(self.columns)
    }

    /// How far a ring points ahead of its column: where it fires later, the sensor has turned on.
    fn ahead_rad(&self, ring: &Ring) -> f64 {
        ring.ahead_rad - TAU * self.lidar.rate_hz * ring.firing_s
    }

    fn bits(&self, index: u64, purpose: u64) -> u32 {
        Random::new(self.seed ^ (index << 20) ^ (purpose << 56)).bits()
    }

    fn empty(&self, index: u64, stamp_ns: u64, beams: u32) -> SimScan {
        let columns =
            Columns { ring: true, column: true, time: true, return_type: true, ..Columns::default() };
        let scan = Scan {
            index,
            stamp_ns,
            frame_id: LIDAR_FRAME.into(),
            points: Vec::with_capacity(beams as usize),
            columns,
            dropped: Dropped::default(),
        };
        SimScan { scan, truth: Vec::with_capacity(beams as usize), beams }
    }

    /// Appends the points of a beam's slots.
    fn take(&self, to: &mut SimScan, beam: u32, slots: [Option<Echo>; 2], poses: &[Rigid]) {
        let (column, row) = (beam / self.rows(), beam % self.rows());
        let ring = self.optics.rings[row as usize];
        let azimuth = self.azimuth_rad(column) + self.ahead_rad(&ring);
        let (up, level) = ring.elevation_rad.sin_cos();
        let direction = DVec3::new(level * azimuth.cos(), level * azimuth.sin(), up);
        let offset = DVec3::Z * ring.offset_m;
        let time_s = f64::from(column) / (f64::from(self.columns) * self.lidar.rate_hz) + ring.firing_s;
        let intensities = slots.each_ref().map(|slot| slot.as_ref().map(Echo::intensity));
        for (slot, echo) in slots.into_iter().enumerate() {
            let Some(echo) = echo else { continue };
            let [x_m, y_m, z_m] = (offset + direction * f64::from(echo.range_m())).as_vec3().to_array();
            let other = intensities[1 - slot];
            to.scan.points.push(Point {
                x_m,
                y_m,
                z_m,
                intensity: echo.intensity(),
                time_s: single(time_s),
                ring: u16::try_from(row).unwrap_or(Point::UNKNOWN),
                column: u16::try_from(column).unwrap_or(Point::UNKNOWN),
                return_type: self.return_type(slot, other.is_some()),
                strength: other.map_or(Strength::Unknown, |other| strength(echo.intensity(), other)),
                reserved: 0,
                label: Point::UNLABELLED,
            });
            to.truth.push(echo.truth(poses[column as usize].translation_m));
        }
    }

    /// The first slot holds the last return where there are two.
    fn return_type(&self, slot: usize, two: bool) -> ReturnType {
        match (self.lidar.returns, two, slot) {
            (Returns::Strongest, ..) => ReturnType::Single,
            (_, false, _) => ReturnType::Both,
            (_, true, 0) => ReturnType::Last,
            (Returns::FirstLast, true, _) => ReturnType::First,
            (Returns::StrongestLast, true, _) => ReturnType::StrongestOrSecond,
        }
    }
}

fn strength(own: f32, other: f32) -> Strength {
    match own.total_cmp(&other) {
        std::cmp::Ordering::Greater => Strength::Stronger,
        std::cmp::Ordering::Less => Strength::Weaker,
        std::cmp::Ordering::Equal => Strength::Equal,
    }
}
