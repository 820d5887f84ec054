//! Why no floor is seen: what a sensor measured, looked at as if it were mounted otherwise (spec 6 §2).

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat3, DQuat, DVec2, DVec3};

use crate::sensor::{DepthSamples, Observation, RgbdFrame, SensorData};

/// Points that are looked at, at most.
const MOST_POINTS: usize = 1500;

/// Depths that are taken as measured, metres.
const DEPTHS_M: std::ops::Range<f64> = 0.1..10.0;

/// Planes that are drawn for each mount.
const DRAWS: u64 = 150;

/// How near a plane a point is on it: so much, and a share of its distance.
const TOLERANCE_M: f64 = 0.03;
const TOLERANCE_PER_M: f64 = 0.01;

/// What makes a floor: its slope, how far it lies below the sensor, the share of all points on it and below it, squares of a quarter
/// of a metre that show it.
const MOST_SLOPE: f64 = 0.21;
const BELOW_M: std::ops::Range<f64> = 0.05..2.2;
const LEAST_SHARE: f64 = 0.15;
const MOST_SHARE_BELOW: f64 = 0.05;
const SQUARES_PER_M: f64 = 4.0;
const LEAST_SQUARES: usize = 16;

/// A mistake in a mount.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mistake {
    /// The sensor hangs upside down, and its transform does not say so, or the other way round.
    UpsideDown,
    /// A camera's transform is that of its body, not of its optical frame (REP 103), or it is turned to that twice.
    Optical,
    /// A camera stands on its side, and its transform does not say so.
    Sideways,
}

/// A mistake that explains why no floor is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountHint {
    /// Which.
    pub mistake: Mistake,
    /// How far below the sensor the floor would lie without it, metres.
    pub below_m: f64,
}

impl MountHint {
    /// What to look at, in words; `frame`: the sensor's.
    pub fn text(&self, frame: &str) -> String {
        let looks = match self.mistake {
            Mistake::UpsideDown => "the sensor hangs upside down and its transform does not say so",
            Mistake::Optical => {
                "the rotation from its body to its optical frame (z ahead, x right, y down) is forgotten in its transform, or made twice"
            }
            Mistake::Sideways => "the camera stands on its side and its transform does not say so",
        };
        let below_m = self.below_m;
        format!(
            "no floor is seen, but there would be one {below_m:.2} m below the sensor if {looks}: see the transform to `{frame}` (tf, or static_transforms)"
        )
    }
}

/// The mistake under which an observation that shows no ground shows a floor, and more of it than anything level as it is placed.
pub(super) fn mistake(observation: &Observation) -> Option<MountHint> {
    let rotation = observation.pose?.map_from_sensor().rotation;
    let points = points(observation);
    let floor = |turn: DQuat| floor_below_m(points.iter().map(|point| rotation * (turn * *point)).collect());
    let as_placed = floor(DQuat::IDENTITY).map_or(0, |(_, squares)| squares);
    let seen = turns(observation).into_iter().filter_map(|(mistake, turn)| {
        let (below_m, squares) = floor(turn)?;
        Some((squares, MountHint { mistake, below_m }))
    });
    let most = seen.max_by_key(|(squares, _)| *squares);
    most.filter(|(squares, _)| *squares > as_placed).map(|(_, hint)| hint)
}

/// How what was measured must be turned in the sensor's own frame to undo a mistake.
fn turns(observation: &Observation) -> Vec<(Mistake, DQuat)> {
    match &observation.data {
        SensorData::Scan(_) => vec![(Mistake::UpsideDown, DQuat::from_rotation_x(PI))],
        SensorData::Frame(_) => {
            let body_from_optical = DQuat::from_mat3(&DMat3::from_cols(-DVec3::Y, -DVec3::Z, DVec3::X));
            vec![
                (Mistake::UpsideDown, DQuat::from_rotation_z(PI)),
                (Mistake::Optical, body_from_optical),
                (Mistake::Optical, body_from_optical.conjugate()),
                (Mistake::Sideways, DQuat::from_rotation_z(FRAC_PI_2)),
                (Mistake::Sideways, DQuat::from_rotation_z(-FRAC_PI_2)),
            ]
        }
    }
}

/// Points in the sensor's frame, metres.
fn points(observation: &Observation) -> Vec<DVec3> {
    match &observation.data {
        SensorData::Scan(scan) => {
            let stride = scan.points.len().div_ceil(MOST_POINTS).max(1);
            // Rings take turns in the order of points: a stride that is a multiple of their number would meet one of them.
            let taken = scan.points.chunks(stride).enumerate().map(|(at, chunk)| chunk[at * 7 % chunk.len()]);
            taken.map(|point| DVec3::from_array(point.position_m().map(f64::from))).collect()
        }
        SensorData::Frame(frame) => pixels(frame),
    }
}

fn pixels(frame: &RgbdFrame) -> Vec<DVec3> {
    let camera = &frame.depth.camera;
    let samples = |stride: &u32| (camera.width / stride * (camera.height / stride)) as usize;
    let stride = (1..=camera.width.max(1)).find(|stride| samples(stride) <= MOST_POINTS).unwrap_or(1);
    let depth_m = |u: u32, v: u32| {
        let at = v as usize * camera.width as usize + u as usize;
        match &frame.depth.samples {
            DepthSamples::Integer { raw, unit_m } => raw.get(at).map_or(0.0, |&raw| f64::from(raw) * unit_m),
            DepthSamples::Metres(samples) => samples.get(at).copied().map_or(0.0, f64::from),
        }
    };
    let step = |length: u32| (stride / 2..length).step_by(stride as usize);
    let all = step(camera.height).flat_map(|v| step(camera.width).map(move |u| (u, v)));
    all.filter_map(|(u, v)| {
        let depth_m = depth_m(u, v);
        let [x, y] = camera.ray(f64::from(u), f64::from(v)).filter(|_| DEPTHS_M.contains(&depth_m))?;
        Some(DVec3::new(x, y, 1.0) * depth_m)
    })
    .collect()
}

/// How far below the sensor there is a floor among `points` in level axes, metres, and how many squares show it.
fn floor_below_m(points: Vec<DVec3>) -> Option<(f64, usize)> {
    let below: Vec<DVec3> = points.iter().copied().filter(|point| point.z < -BELOW_M.start).collect();
    let on = |plane: DVec3, point: &DVec3| off(plane, *point).abs() < tolerance_m(*point);
    let count = |plane: &DVec3| below.iter().filter(|point| on(*plane, point)).count();
    let drawn = (0..DRAWS).filter_map(|number| plane_of(&below, number));
    let plane = drawn.filter(|plane| BELOW_M.contains(&-plane.z)).max_by_key(count)?;
    let under = below.iter().filter(|point| off(plane, **point) < -3.0 * tolerance_m(**point)).count();
    #[expect(clippy::cast_precision_loss, reason = "at most MOST_POINTS")]
    let share = |count: usize| count as f64 / points.len() as f64;
    #[expect(clippy::cast_possible_truncation, reason = "metres of what a sensor sees")]
    let square = |point: &DVec3| [point.x, point.y].map(|at| (at * SQUARES_PER_M).floor() as i64);
    let squares: std::collections::BTreeSet<_> =
        below.iter().filter(|point| on(plane, point)).map(square).collect();
    let is_floor = share(count(&plane)) >= LEAST_SHARE
        && share(under) <= MOST_SHARE_BELOW
        && squares.len() >= LEAST_SQUARES;
    is_floor.then_some((-plane.z, squares.len()))
}

/// The plane (a, b, c) of z = a x + b y + c through three of the points, the same for the same `number`; `None` where it is steep.
fn plane_of(points: &[DVec3], number: u64) -> Option<DVec3> {
    // SplitMix64 of G. Steele and others, "Fast splittable pseudorandom number generators", 2014.
    let mix = |value: u64| {
        let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        value ^ (value >> 31)
    };
    let at = |turn: u64| {
        let drawn = mix((3 * number + turn + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let index = usize::try_from(drawn % points.len().max(1) as u64).ok()?;
        points.get(index).copied()
    };
    let (a, b, c) = (at(0)?, at(1)?, at(2)?);
    let normal = (b - a).cross(c - a);
    let slopes = -normal.truncate() / normal.z;
    let is_level = slopes.is_finite() && slopes.length() <= MOST_SLOPE;
    is_level.then(|| slopes.extend(a.z - slopes.dot(a.truncate())))
}

fn off(plane: DVec3, point: DVec3) -> f64 {
    point.z - plane.truncate().dot(DVec2::new(point.x, point.y)) - plane.z
}

fn tolerance_m(point: DVec3) -> f64 {
    TOLERANCE_M + TOLERANCE_PER_M * point.length()
}
