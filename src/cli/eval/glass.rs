//! `limpid eval` of labelled lidar scans: a PLY file with a `label` column, or a folder of such.

use std::path::Path;
use std::time::{Duration, Instant};

use limpid::base::Rigid;
use limpid::input::points;
use limpid::input::points::Options;
use limpid::input::trajectory;
use limpid::offline::eval::glass_metrics::{ClassScore, GlassScores, GlassTally, drop_behind_planes};
use limpid::offline::labeller::Labeller;
use limpid::sensor::Scan;
use limpid::{Config, Error, Result};
use serde_json::json;

use super::{EvalArguments, Memory};
use crate::cli::save;

/// How far the stamps of a scan and of its pose may lie apart.
const POSE_TOLERANCE: Duration = Duration::from_millis(50);

/// Whether a path holds labelled scans: a PLY file, or a folder with one.
pub(super) fn is_scans(path: &Path) -> bool {
    let is_ply = |path: &Path| path.extension().is_some_and(|extension| extension == "ply");
    let holds_ply = |mut entries: std::fs::ReadDir| entries.any(|e| e.is_ok_and(|e| is_ply(&e.path())));
    is_ply(path) || std::fs::read_dir(path).is_ok_and(holds_ply)
}

/// What came of all scans.
#[derive(Default)]
struct Evaluation {
    tally: GlassTally,
    baseline: GlassTally,
    panes: u64,
    scans: u64,
    unlabelled_scans: u64,
    scans_without_pose: u64,
    pose_jumps: u64,
    times: Vec<Duration>,
}

pub(super) fn execute(arguments: &EvalArguments, path: &Path) -> Result<()> {
    let poses = arguments.poses.as_deref().map(trajectory).transpose()?;
    let memory = arguments.memory == Memory::On && poses.is_some();
    if arguments.memory == Memory::On && poses.is_none() {
        println!("no poses (--poses FILE): every scan is labelled by itself");
    }
    let config = Config { glass_memory: memory, ..arguments.base_config()? };
    let evaluation = evaluate(arguments, path, &config, poses.as_deref())?;
    if evaluation.scans == 0 {
        let reason = format!(
            "{} scans without labels, {} without a pose",
            evaluation.unlabelled_scans, evaluation.scans_without_pose
        );
        return Err(Error::Empty { reason });
    }
    report(arguments, &evaluation, memory)
}

fn evaluate(
    arguments: &EvalArguments,
    path: &Path,
    config: &Config,
    poses: Option<&[(u64, Rigid)]>,
) -> Result<Evaluation> {
    let mut scans = points::open(path, &Options { return_codes: config.return_codes, ..Options::default() })?;
    let mut labeller: Option<Labeller> = None;
    let mut evaluation = Evaluation::default();
    while let Some(scan) = scans.next_scan()? {
        if !scan.columns.label {
            evaluation.unlabelled_scans += 1;
            continue;
        }
        let Some(pose) = pose_of(&scan, poses.filter(|_| config.glass_memory)) else {
            evaluation.scans_without_pose += 1;
            continue;
        };
        let labeller = match &mut labeller {
            Some(labeller) => labeller,
            none => none.insert(Labeller::open(config, &scan, arguments.adapter.as_deref(), false)?),
        };
        let start = Instant::now();
        let labelled = labeller.label(&scan, pose)?;
        evaluation.times.push(start.elapsed());
        evaluation.tally.add(&scan, &labelled);
        evaluation.baseline.add(&scan, &drop_behind_planes(&scan, &labelled.panes));
        evaluation.pose_jumps += u64::from(labelled.counters.pose_jumps);
        evaluation.panes += labelled.panes.len() as u64;
        evaluation.scans += 1;
    }
    Ok(evaluation)
}

/// The pose nearest in time; the identity where none are given.
fn pose_of(scan: &Scan, poses: Option<&[(u64, Rigid)]>) -> Option<Rigid> {
    let Some(poses) = poses else { return Some(Rigid::IDENTITY) };
    let nearest = poses.iter().min_by_key(|(stamp_ns, _)| stamp_ns.abs_diff(scan.stamp_ns))?;
    let apart = Duration::from_nanos(nearest.0.abs_diff(scan.stamp_ns));
    (apart <= POSE_TOLERANCE).then_some(nearest.1)
}

fn report(arguments: &EvalArguments, evaluation: &Evaluation, memory: bool) -> Result<()> {
    let (scores, baseline) = (evaluation.tally.scores(), evaluation.baseline.scores());
    let mut times = evaluation.times.clone();
    times.sort();
    let ms_per_scan = times.get(times.len() / 2).map_or(0.0, |time| time.as_secs_f64() * 1e3);
    print_table(&scores);
    print_baseline(&baseline);
    #[expect(clippy::cast_precision_loss, reason = "counts of scans and panes are small")]
    let panes = evaluation.panes as f64 / evaluation.scans as f64;
    let memory_word = if memory { "with memory" } else { "every scan by itself" };
    println!(
        "{} scans, {memory_word}; {panes:.2} panes and {ms_per_scan:.1} ms a scan (median)",
        evaluation.scans
    );
    if evaluation.scans_without_pose + evaluation.unlabelled_scans > 0 {
        let (poses, labels) = (evaluation.scans_without_pose, evaluation.unlabelled_scans);
        println!("passed over: {poses} scans without a pose, {labels} without labels");
    }
    if evaluation.pose_jumps > 0 {
        println!(
            "{} times the pose jumped; panes kept from before stay where they were",
            evaluation.pose_jumps
        );
    }
    let Some(path) = &arguments.json else { return Ok(()) };
    let mut figures = json!(scores);
    figures["baseline"] = json!(baseline);
    figures["panes"] = json!(panes);
    figures["ms_per_scan"] = json!(ms_per_scan);
    figures["scans"] = json!(evaluation.scans);
    figures["pose_jumps"] = json!(evaluation.pose_jumps);
    figures["memory"] = json!(memory);
    save(path, &format!("{figures:#}\n"))
}

fn print_baseline(baseline: &GlassScores) {
    let GlassScores { classes, reflections_left, normal_lost, mirrored_within_0_2_m: mirrored } = baseline;
    let [inside, reflection, outside] = [classes.inside, classes.reflection, classes.outside].map(|c| c.iou);
    println!(
        "baseline, all more than 0.1 m behind a pane's endless plane dropped: IoU inside {inside:.3}, glass {:.3}, reflection \
         {reflection:.3}, outside {outside:.3}; reflections left {reflections_left:.4}, normal lost {normal_lost:.4}, mirrored \
         {mirrored:.3}",
        classes.glass.iou
    );
}

fn print_table(scores: &GlassScores) {
    let classes = scores.classes;
    println!("class        precision  recall  IoU");
    let rows = [
        ("inside", classes.inside),
        ("glass", classes.glass),
        ("reflection", classes.reflection),
        ("outside", classes.outside),
    ];
    for (name, ClassScore { precision, recall, iou }) in rows {
        println!("{name:<12} {precision:>9.3} {recall:>7.3} {iou:>5.3}");
    }
    println!("reflections left {:.4}", scores.reflections_left);
    println!("normal lost {:.4}", scores.normal_lost);
    println!("mirrored within 0.2 m of a normal point {:.3}", scores.mirrored_within_0_2_m);
}
