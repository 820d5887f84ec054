//! The stages of a camera frame, of a scan and of a published map, in the order of the papers, on one page; and their plans.

use std::sync::Arc;

use crate::base::Result;
use crate::config::{InflationLaw, Method};
use crate::gpu::Plan;
use crate::stage::camera::{
    back_project, drm, ingest, map_reliability, pane_clip, see_through, spatial_median, tally, update, weigh,
};
use crate::stage::drops::Drops;
use crate::stage::glass::{LabelGlass, pane_cells};
use crate::stage::ground::Ground;
use crate::stage::lidar::solidity::Solidity;
use crate::stage::lidar::{intensity_classes, intensity_layers};
use crate::stage::map::{bridge, goal_costs, goal_inflation, inflate, move_window, rule, scan_values};
use crate::stage::{CameraJob, LidarJob, MapJob, Stage, color_stage};

/// The stages of a camera's frame, in order (spec 1 §1 to §3, spec 6 §2: reliability, ground, move window, update, hysteresis, inflate).
pub fn camera_stages(job: &Arc<CameraJob>) -> Vec<Box<dyn Stage>> {
    let of = || Arc::clone(job);
    let mut stages: Vec<Box<dyn Stage>> = vec![Box::new(ingest::Ingest { job: of() })];
    if job.config.method == Method::Median {
        stages.push(Box::new(spatial_median::SpatialMedian { job: of() }));
    }
    let color = color_stage(job);
    let (color, shown_color) = if job.drm.is_some() { (color, None) } else { (None, color) };
    stages.extend(color);
    if let Some(drm) = &job.drm {
        stages.push(Box::new(drm::DrmNet { job: of(), drm: drm.clone() }));
    }
    if job.confidence {
        stages.push(Box::new(weigh::Weigh { job: of() }));
    }
    stages.push(Box::new(Ground::of_camera(job)));
    stages.push(Box::new(move_window::MoveWindow { map: Arc::clone(&job.map), frame: true }));
    if job.map.layers.panes {
        stages.push(Box::new(pane_clip::PaneClip { job: of() }));
    }
    stages.push(Box::new(back_project::BackProject { job: of() }));
    if job.map.layers.drops {
        stages.push(Box::new(Drops::of_camera(job)));
    }
    stages.push(Box::new(see_through::SeeThrough::new(job)));
    stages.push(Box::new(update::Update { job: of() }));
    if let Some(network) = &job.map.reliability {
        stages.push(Box::new(map_reliability::JudgeCells { job: of(), network: Arc::clone(network) }));
    }
    if !job.map.apart {
        stages.extend(map_stages(&job.map));
    }
    stages.push(Box::new(tally::Tally { job: of() }));
    stages.extend(shown_color);
    stages
}

/// The stages of a lidar's scan, in order (spec 6 §2; spec 3; spec 6 §3; spec 2 §2 to §4).
pub fn lidar_stages(job: &Arc<LidarJob>) -> Vec<Box<dyn Stage>> {
    let of = || Arc::clone(job);
    let mut stages: Vec<Box<dyn Stage>> = vec![Box::new(Ground::of_lidar(job))];
    if let Some(glass) = &job.glass {
        stages.push(Box::new(LabelGlass { job: of(), glass: glass.clone() }));
    }
    stages.push(Box::new(move_window::MoveWindow { map: Arc::clone(&job.map), frame: false }));
    stages.push(Box::new(intensity_layers::IntensityLayers { job: of() }));
    if let Some(model) = &job.solidity {
        stages.push(Box::new(Solidity { job: of(), model: Arc::clone(model) }));
    }
    stages.push(Box::new(intensity_classes::IntensityClasses { job: of() }));
    if job.map.layers.drops {
        stages.push(Box::new(Drops::of_lidar(job)));
    }
    if job.glass.is_some() {
        stages.push(Box::new(pane_cells::PaneCells { job: of() }));
    }
    if !job.map.apart {
        stages.extend(map_stages(&job.map));
    }
    if job.layers {
        stages.push(Box::new(scan_values::ScanValues { job: of() }));
    }
    stages
}

/// The stages of a published map, in order (spec 4 §2 and §3; spec 1 §3 or spec 2 §4). A map of one sensor is published with
/// each of its observations.
pub fn map_stages(map: &Arc<MapJob>) -> Vec<Box<dyn Stage>> {
    let of = || Arc::clone(map);
    let mut stages: Vec<Box<dyn Stage>> = vec![Box::new(rule::Rule { map: of() })];
    if map.evidence {
        stages.push(Box::new(bridge::Bridge { map: of() }));
    }
    if map.law() == InflationLaw::Goal {
        stages.push(Box::new(goal_inflation::GoalInflation { map: of() }));
        stages.push(Box::new(goal_costs::GoalCosts { map: of() }));
    } else {
        stages.push(Box::new(inflate::Inflate { map: of() }));
    }
    stages
}

/// The plan of a camera's frame, with what is to be read back.
///
/// # Errors
/// [`crate::Error::Plan`] or [`crate::Error::Shader`] where a stage contradicts its shader or its neighbours.
pub fn camera_plan(job: &CameraJob, stages: &[Box<dyn Stage>]) -> Result<Plan> {
    let mut plan = Plan::default();
    plan.enter(&job.scope);
    plan.fixed("rays", back_project::rays(&job.depth))?;
    for stage in stages {
        stage.append(&mut plan)?;
    }
    let layers = ["evidence", "occupancy", "state"];
    for name in image_buffers(job).chain(layers.into_iter().filter(|_| job.layers)) {
        plan.read_back(name)?;
    }
    if job.map.reliability.is_some() && job.cell_inputs {
        plan.read_back("map_reliability_inputs")?;
    }
    if !job.map.apart {
        read_back_map(&mut plan, &job.map)?;
    }
    plan.check()?;
    Ok(plan)
}

/// The images that are read back with a camera's frame.
pub(super) fn image_buffers(job: &CameraJob) -> impl Iterator<Item = &'static str> {
    let images = [job.depth_buffer(), "reliability"].into_iter().chain(job.color.map(|_| "color"));
    images.filter(|_| job.images)
}

/// Reads the map back: costs, classes where a lidar takes part, and verdicts where they are wanted.
fn read_back_map(plan: &mut Plan, map: &MapJob) -> Result<()> {
    let classes = map.layers.lidars.then_some("cell_classes");
    let verdicts = map.verdicts.then_some("verdicts");
    for name in ["costmap"].into_iter().chain(classes).chain(verdicts) {
        plan.read_back(name)?;
    }
    Ok(())
}

/// The plan of a published map, with what is to be read back.
///
/// # Errors
/// As [`camera_plan`].
pub fn map_plan(map: &MapJob, stages: &[Box<dyn Stage>]) -> Result<Plan> {
    let mut plan = Plan::default();
    for stage in stages {
        stage.append(&mut plan)?;
    }
    read_back_map(&mut plan, map)?;
    plan.check()?;
    Ok(plan)
}

/// The plan of a lidar's scan, with what is to be read back.
///
/// # Errors
/// As [`camera_plan`].
pub fn lidar_plan(job: &LidarJob, stages: &[Box<dyn Stage>]) -> Result<Plan> {
    let mut plan = Plan::default();
    plan.enter(&job.scope);
    intensity_layers::upload_points(&mut plan, job.capacity)?;
    for stage in stages {
        stage.append(&mut plan)?;
    }
    let products = ["layer_values", "cell_values"];
    for name in products.into_iter().filter(|_| job.layers) {
        plan.read_back(name)?;
    }
    if job.solidity.is_some() && job.solidity_inputs {
        plan.read_back("solidity_inputs")?;
    }
    if !job.map.apart {
        read_back_map(&mut plan, &job.map)?;
    }
    for name in ["classes", "panes", "glass_counters"].into_iter().filter(|_| job.glass.is_some()) {
        plan.read_back(name)?;
    }
    plan.check()?;
    Ok(plan)
}
