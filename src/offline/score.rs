//! Scores of trajectories and of velocities of the dynamic window approach on a plan map, on the GPU (spec 2 §5, Eq. 12).

use bytemuck::{cast_slice, pod_read_unaligned};
use glam::{DVec2, DVec3, Vec2};

use crate::base::Rigid;
use crate::base::{Error, Result};
use crate::gpu::{Context, Executor, Invocations, Plan};
use crate::map::MapUpdate;
use crate::stage::map::trajectory_cost::{ROLL_OUT, RollOutParams, SUM, SumParams};
use crate::stage::single;

/// Cost of a cell that is unknown or outside of the map, as Nav2 counts it.
pub const UNKNOWN_COST: u32 = 255;

/// Most places of all candidates together.
const MAX_PLACES: u32 = 1 << 20;

/// Places lie this many cells apart at most, so that no cell is stepped over but at its corners.
const STEP_CELLS: f64 = 0.5;

/// What a trajectory costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Score {
    /// Sum of the costs of the cells that it crosses.
    pub cost: u32,
    /// The highest cost of a known cell among them; from 253 up the robot would touch something.
    pub worst: u32,
    /// How many cells it crosses.
    pub cells: u32,
    /// How many of them are unknown or outside of the map.
    pub unknown: u32,
}

/// Scores batches of candidates on plan maps of one size.
pub struct Scorer {
    rolled: Executor,
    given: Executor,
    side: u32,
    candidates: u32,
    places: u32,
}

/// The passes for so many candidates of so many places: places computed from velocities, or given.
fn plan(side: u32, candidates: u32, places: u32, rolled: bool) -> Result<Plan> {
    let mut plan = Plan::default();
    let trajectory_bytes = u64::from(candidates) * u64::from(places) * 8;
    plan.upload("plan_costs", u64::from(side * side.div_ceil(4)) * 4)?;
    if rolled {
        plan.uniform::<RollOutParams>("roll_out_params")?;
        plan.upload("velocities", u64::from(candidates) * 8)?;
        plan.scratch("trajectories", trajectory_bytes)?;
        plan.step(ROLL_OUT, Invocations::line(candidates * places), &[])?;
    } else {
        plan.upload("trajectories", trajectory_bytes)?;
    }
    plan.uniform::<SumParams>("sum_params")?;
    plan.scratch("scores", u64::from(candidates) * 16)?;
    plan.step(SUM, Invocations::line(candidates), &[])?;
    plan.read_back("scores")?;
    plan.check()?;
    Ok(plan)
}

/// The plan with both passes, for the checks of shaders.
///
/// # Errors
/// [`Error::Plan`], [`Error::Shader`].
pub fn velocity_plan(side: u32, candidates: u32, places: u32) -> Result<Plan> {
    plan(side, candidates, places, true)
}

fn check_size(side: u32, candidates: u32, places: u32) -> Result<()> {
    let all = candidates.checked_mul(places).filter(|all| (1..=MAX_PLACES).contains(all));
    if all.is_none() || side == 0 {
        let reason = format!("{candidates} of {places} places; 1 to {MAX_PLACES} places are supported");
        return Err(bad(reason));
    }
    Ok(())
}

impl Scorer {
    /// For maps of `side` cells and up to `candidates` trajectories of up to `places` places, half a cell apart.
    ///
    /// # Errors
    /// [`Error::Input`] where that is nothing or too much; [`Error::NoAdapter`], [`Error::Limit`], [`Error::Gpu`].
    pub fn open(adapter: Option<&str>, side: u32, candidates: u32, places: u32) -> Result<Self> {
        check_size(side, candidates, places)?;
        Self::on(&Context::open(adapter, false)?, side, candidates, places)
    }

    /// As [`Scorer::open`], on a device that is open already.
    ///
    /// # Errors
    /// As there.
    pub fn on(context: &Context, side: u32, candidates: u32, places: u32) -> Result<Self> {
        check_size(side, candidates, places)?;
        let (rolled, given) = (plan(side, candidates, places, true)?, plan(side, candidates, places, false)?);
        let (rolled, given) = (Executor::build(context, rolled)?, Executor::build(context, given)?);
        Ok(Self { rolled, given, side, candidates, places })
    }

    /// Scores velocities (v in m/s, omega in rad/s) held for `horizon_s` from the robot's pose `map_from_base`.
    ///
    /// # Errors
    /// [`Error::Input`] where map, candidates or way are larger than the scorer was opened for, or no numbers.
    pub fn score_velocities(
        &mut self,
        map: &MapUpdate,
        map_from_base: Rigid,
        velocities: &[[f64; 2]],
        horizon_s: f64,
    ) -> Result<Vec<Score>> {
        let candidates = self.check(map, velocities.len())?;
        let numbers = velocities.iter().flatten().chain([&horizon_s]);
        if numbers.into_iter().any(|number| !number.is_finite()) || horizon_s < 0.0 {
            return Err(bad("velocities or horizon are no numbers".into()));
        }
        let fastest = velocities.iter().map(|[v, _]| v.abs()).fold(0.0, f64::max);
        let steps = fastest * horizon_s / (STEP_CELLS * map.grid.resolution_m);
        let places = self.check_places(steps)?;
        let heading = map_from_base.rotation * DVec3::X;
        let params = RollOutParams {
            start: in_window(map, map_from_base.translation_m.truncate()),
            heading: single(heading.y.atan2(heading.x)),
            step_s: single(horizon_s / f64::from(places - 1).max(1.0)),
            candidates,
            places,
        };
        let velocities: Vec<[f32; 2]> = velocities.iter().map(|v| v.map(single)).collect();
        let sum = self.sum_params(map, candidates, places);
        let costs = packed(map);
        let mut input = self.rolled.begin()?;
        input.write("plan_costs", &costs)?;
        input.write("velocities", cast_slice(&velocities))?;
        input.set("roll_out_params", &params)?;
        input.set("sum_params", &sum)?;
        input.limit(ROLL_OUT.name, Invocations::line(candidates * places))?;
        input.limit(SUM.name, Invocations::line(candidates))?;
        input.submit()?;
        scores(&mut self.rolled, candidates)
    }

    /// Scores trajectories: corners in the map frame, metres, joined by straight lines; one without corners costs nothing.
    ///
    /// # Errors
    /// As [`Self::score_velocities`].
    pub fn score_trajectories(
        &mut self,
        map: &MapUpdate,
        trajectories: &[Vec<[f64; 2]>],
    ) -> Result<Vec<Score>> {
        let candidates = self.check(map, trajectories.len())?;
        if trajectories.iter().flatten().flatten().any(|number| !number.is_finite()) {
            return Err(bad("a place is no number".into()));
        }
        let step_m = STEP_CELLS * map.grid.resolution_m;
        let dense: Vec<Vec<Vec2>> = trajectories
            .iter()
            .map(|corners| resample(corners, step_m).into_iter().map(|at| in_window(map, at)).collect())
            .collect();
        let most = dense.iter().map(Vec::len).max().unwrap_or(0);
        #[expect(clippy::cast_precision_loss, reason = "compared with at most a million")]
        let places = self.check_places(most as f64 - 1.0)?;
        let mut all = Vec::new();
        for places_of_one in &dense {
            // Standing still at the end crosses no further cell.
            let last = places_of_one.last().copied().unwrap_or_default();
            all.extend(places_of_one.iter().copied().chain(std::iter::repeat(last)).take(places as usize));
        }
        let sum = self.sum_params(map, candidates, places);
        let costs = packed(map);
        let mut input = self.given.begin()?;
        input.write("plan_costs", &costs)?;
        input.write("trajectories", cast_slice(&all))?;
        input.set("sum_params", &sum)?;
        input.limit(SUM.name, Invocations::line(candidates))?;
        input.submit()?;
        let mut scores = scores(&mut self.given, candidates)?;
        for (score, _) in scores.iter_mut().zip(trajectories).filter(|(_, corners)| corners.is_empty()) {
            *score = Score { cost: 0, worst: 0, cells: 0, unknown: 0 };
        }
        Ok(scores)
    }

    fn check(&self, map: &MapUpdate, candidates: usize) -> Result<u32> {
        let side = self.side as usize;
        if map.grid.width != self.side || map.grid.height != self.side || map.costmap.len() != side * side {
            return Err(bad(format!("the map is not of {side}x{side} cells")));
        }
        let fits = u32::try_from(candidates).ok().filter(|&count| count <= self.candidates);
        fits.ok_or_else(|| bad(format!("{candidates} candidates; opened for {}", self.candidates)))
    }

    /// Places for that many steps.
    fn check_places(&self, steps: f64) -> Result<u32> {
        if steps + 1.0 > f64::from(self.places) {
            return Err(bad(format!("a way of {steps:.0} half cells; opened for {}", self.places - 1)));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 1 to self.places")]
        let places = steps.max(0.0).ceil() as u32 + 1;
        Ok(places.min(self.places))
    }

    fn sum_params(&self, map: &MapUpdate, candidates: u32, places: u32) -> SumParams {
        SumParams {
            side: self.side,
            quads: self.side.div_ceil(4),
            resolution_m: single(map.grid.resolution_m),
            candidates,
            places,
            unknown_cost: UNKNOWN_COST,
        }
    }
}

fn in_window(map: &MapUpdate, place: DVec2) -> Vec2 {
    (place - DVec2::new(map.grid.origin_x_m, map.grid.origin_y_m)).as_vec2()
}

/// Costs four to a word, rows padded.
fn packed(map: &MapUpdate) -> Vec<u8> {
    let side = map.grid.width as usize;
    let mut bytes = Vec::with_capacity(side.next_multiple_of(4) * side);
    for row in map.costmap.chunks_exact(side) {
        bytes.extend_from_slice(row);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

/// Places along the line through the corners, at most `step_m` apart, the corners included.
fn resample(corners: &[[f64; 2]], step_m: f64) -> Vec<DVec2> {
    let corners: Vec<DVec2> = corners.iter().map(|&corner| DVec2::from_array(corner)).collect();
    let mut places: Vec<DVec2> = corners.first().copied().into_iter().collect();
    for pair in corners.windows(2) {
        // More steps than a scorer has places are refused after this; a bound against endless ways.
        let steps = (pair[0].distance(pair[1]) / step_m).ceil().clamp(1.0, f64::from(MAX_PLACES));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 1..=MAX_PLACES")]
        let count = steps as u32;
        places.extend((1..=count).map(|step| pair[0].lerp(pair[1], f64::from(step) / steps)));
        if places.len() > MAX_PLACES as usize {
            break;
        }
    }
    places
}

fn scores(executor: &mut Executor, candidates: u32) -> Result<Vec<Score>> {
    let none = || Error::Gpu { what: "scores".into(), reason: "nothing under way".into() };
    let readback = executor.receive()?.ok_or_else(none)?;
    let words = readback.bytes(executor.find("scores")?)?.chunks_exact(16).take(candidates as usize);
    let score = |bytes: &[u8]| {
        let [cost, worst, cells, unknown] = pod_read_unaligned::<[u32; 4]>(bytes);
        Score { cost, worst, cells, unknown }
    };
    Ok(words.map(score).collect())
}

fn bad(reason: String) -> Error {
    Error::Input { what: "trajectories".into(), reason }
}
