//! `limpid eval --glass-scenes`: labels of simulated drives past glass.

use limpid::gpu::Context;
use limpid::offline::eval::glass_scenes::{DriveScores, DriveTally, PoseNoise, drive};
use limpid::sim::Scene;
use limpid::sim::generate::{Family, Level, generate};
use limpid::sim::lidar::{Lidar, LidarModel};
use limpid::{Config, Result};
use serde_json::json;

use super::EvalArguments;
use crate::cli::save;

/// Revolutions a second, each of them a step of the way.
const RATE_HZ: f64 = 10.0;

/// The kinds of poses, by name.
const POSES: [(&str, PoseNoise); 2] = [
    ("true poses", PoseNoise { place_m: 0.0, yaw_rad: 0.0 }),
    ("noisy poses", PoseNoise { place_m: 0.02, yaw_rad: 0.005 }),
];

/// A scene of the family `glass` with an HDL-32E in dual mode and a floor that mirrors as at this level; without its panes it keeps
/// their posts, sills and openings.
fn scene(level: Level, seed: u64, scans: u32, without_glass: bool) -> Result<Scene> {
    // A drive that is found is as long as the scans take; the last one ends a step later.
    let mut scene = generate(Family::Glass, level, seed, scans + 1)?;
    scene.trajectory.rate_hz = RATE_HZ;
    if without_glass {
        scene.panes.clear();
    }
    scene.lidar = Some(Lidar { model: LidarModel::Hdl32e, rate_hz: RATE_HZ, ..Lidar::default() });
    Ok(scene)
}

pub(super) fn execute(arguments: &EvalArguments, scenes: u32) -> Result<()> {
    let config = Config { glass_memory: true, ..arguments.base_config()? };
    let context = Context::open(arguments.adapter.as_deref(), false)?;
    println!("adapter: {}", context.describe());
    let noises = POSES.map(|(_, noise)| noise);
    let mut pooled = [DriveTally::default(), DriveTally::default()];
    let mut rows = Vec::new();
    let head = "glass IoU  reflection IoU  left  normal lost  in place  pane recall  precision  off m";
    println!("seed      scans  {head}");
    let first = arguments.scenes.first_seed;
    for seed in (first..).take(scenes as usize) {
        let mut own = [DriveTally::default(), DriveTally::default()];
        let scene = scene(arguments.floor, seed, arguments.scans, arguments.without_glass)?;
        drive(&scene, &config, arguments.scans.into(), &context, (&noises, &mut own))?;
        print_row(&format!("{seed:<8}"), own[0].scans, &own[0].scores());
        rows.push(json!({ "seed": seed, "true_poses": own[0].scores(), "noisy_poses": own[1].scores() }));
        pooled.iter_mut().zip(&own).for_each(|(pooled, own)| pooled.join(own));
    }
    println!("\nall                {head}");
    for ((name, _), tally) in POSES.iter().zip(&pooled) {
        print_row(&format!("{name:<12}"), tally.scans, &tally.scores());
    }
    for ((name, _), tally) in POSES.iter().zip(&pooled).filter(|_| arguments.without_glass) {
        println!(
            "{name}: {} of {} scans were labelled by a pane that is none",
            tally.with_panes, tally.scans
        );
    }
    let Some(path) = &arguments.json else { return Ok(()) };
    let all = pooled.map(|tally| tally.scores());
    let figures = json!({ "scenes": rows, "true_poses": all[0], "noisy_poses": all[1] });
    save(path, &format!("{figures:#}\n"))
}

fn print_row(name: &str, scans: u64, scores: &DriveScores) {
    let points = &scores.points;
    println!(
        "{name} {scans:>6}  {:>9.3} {:>15.3} {:>5.3} {:>12.4} {:>9.3} {:>12.3} {:>10.3} {:>6.3}",
        points.classes.glass.iou,
        points.classes.reflection.iou,
        points.reflections_left,
        points.normal_lost,
        scores.mirrored_in_place,
        scores.pane_recall,
        scores.pane_precision,
        scores.pane_off_m
    );
}
