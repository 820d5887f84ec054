//! Every WGSL file is reached and parses; every parameter struct matches.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use limpid::Error;
use limpid::config::{Config, InflationLaw, Method};
use limpid::gpu::{Plan, Shader, ShaderSource, ShaderText};
use limpid::mapper;
use limpid::network::weights::Network;
use limpid::network::{Backend, all_kernels};
use limpid::sensor::CameraModel;
use limpid::sim::lidar::Lidar;
use limpid::stage::camera::drm::Drm;
use limpid::stage::camera::map_reliability::{self, MapReliability};
use limpid::stage::camera::{align_color, back_project, ingest, pane_clip, register_color};
use limpid::stage::camera::{see_through, spatial_median, tally, update, weigh};
use limpid::stage::glass::pane_cells;
use limpid::stage::lidar::{intensity_classes, intensity_layers};
use limpid::stage::map::layers::Layers;
use limpid::stage::map::{goal_costs, goal_inflation, inflate, scan_values, trajectory_cost};
use limpid::stage::targets;
use limpid::stage::{CameraJob, LidarJob, MapJob};

use crate::sim::small_room;
use crate::support::camera_job::{job, small_map, tiny_camera};
use crate::support::glass_room::GlassRoom;

const TARGETS: [ShaderSource; 4] = [targets::REMEMBER, targets::REPROJECT, targets::AGREE, targets::JUDGE];

/// The passes of cameras, of lidars and of the map, in every text that plans use.
const PIPELINE: &[ShaderSource] = &[
    align_color::ALIGN_COLOR,
    back_project::BACK_PROJECT,
    back_project::BACK_PROJECT_ALONE,
    goal_costs::GOAL_COSTS,
    goal_inflation::GOAL_INFLATION_OF_CAMERAS,
    goal_inflation::GOAL_INFLATION_OF_LIDARS,
    inflate::PACK,
    inflate::ROWS,
    inflate::COLUMNS,
    inflate::COLUMNS_AND_CLASSES,
    ingest::INGEST,
    intensity_classes::INTENSITY_CLASSES,
    intensity_classes::INTENSITY_CLASSES_AND_BEAMS,
    intensity_classes::INTENSITY_CLASSES_LEARNED,
    intensity_classes::INTENSITY_CLASSES_LEARNED_AND_BEAMS,
    intensity_layers::INTENSITY_LAYERS,
    intensity_layers::INTENSITY_LAYERS_OF_BUFFER,
    intensity_layers::INTENSITY_LAYERS_AND_BEAMS,
    intensity_layers::INTENSITY_LAYERS_AND_BEAMS_OF_BUFFER,
    map_reliability::MAP_RELIABILITY,
    pane_cells::PANE_CELLS,
    pane_cells::SHARE_PANES,
    pane_clip::PANE_CLIP,
    register_color::REGISTER_COLOR,
    scan_values::SCAN_VALUES,
    scan_values::SCAN_VALUES_AND_PANES,
    see_through::TILES,
    see_through::AROUND,
    see_through::GATHER,
    see_through::GATHER_SHARES,
    spatial_median::SPATIAL_MEDIAN,
    tally::TALLY,
    trajectory_cost::ROLL_OUT,
    trajectory_cost::SUM,
    update::UPDATE,
    update::UPDATE_BY_EVIDENCE,
    weigh::WEIGH,
];

/// Passes whose texts are put together for a plan.
const COMPOSED: [&str; 4] = ["move_window", "rule", "bridge/occupied", "bridge/gaps"];

/// The passes of the pipeline, of training targets and of simulated sensors.
fn all() -> impl Iterator<Item = ShaderSource> {
    PIPELINE
        .iter()
        .copied()
        .chain(TARGETS)
        .chain(limpid::sim::passes::ALL)
        .chain(limpid::stage::glass::LABELLING)
        .chain([limpid::stage::glass::CLEAN])
        .chain(limpid::stage::ground::ALL)
        .chain(limpid::stage::drops::ALL)
        .chain(limpid::stage::lidar::solidity::ALL)
}

fn wgsl_files(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            wgsl_files(&entry, found);
        } else {
            found.insert(std::fs::read_to_string(&entry).unwrap());
        }
    }
}

fn drm() -> Drm {
    let weights = include_bytes!("../testdata/reference/network.safetensors");
    let network = Arc::new(Network::from_bytes(weights).unwrap());
    Drm { network, backend: Backend { textures: true, subgroups: false } }
}

/// Jobs that together use every pass.
fn jobs() -> Vec<CameraJob> {
    let plain = job(&small_map(), tiny_camera());
    let median = Config { method: Method::Median, ..small_map() };
    let color = CameraModel { width: 64, ..tiny_camera() };
    vec![
        plain.clone(),
        CameraJob { confidence: true, images: true, color: Some(color), ..job(&median, tiny_camera()) },
        CameraJob { drm: Some(drm()), color: Some(color), ..plain.clone() },
        CameraJob { color: Some(tiny_camera()), color_aligned: true, ..plain.clone() },
        CameraJob { layers: false, float_depth: false, ..plain },
    ]
}

fn camera_plan(job: &CameraJob) -> limpid::gpu::Plan {
    let job = Arc::new(job.clone());
    mapper::camera_plan(&job, &mapper::camera_stages(&job)).unwrap()
}

/// A job of the lidar path.
fn scan_job() -> LidarJob {
    LidarJob {
        config: Config::default(),
        capacity: 1000,
        full_scale: 255.0,
        plane_rings: None,
        deskew: true,
        layers: true,
        solidity: None,
        solidity_inputs: false,
        glass: None,
        map: Arc::new(MapJob::of_lidar(&Config { drop_m: 0.15, ..Config::default() }, 200, false)),
        sensor: 0,
        scope: String::new(),
        glass_number: 0,
    }
}

/// The same with glass.
fn glass_job() -> LidarJob {
    let (scan, _) = GlassRoom::default().scan();
    let grid = limpid::sensor::BeamGrid::of_scan(&scan).unwrap();
    let glass = limpid::stage::glass::Glass { grid, load: limpid::map::PaneSet::default() };
    let map = Arc::new(MapJob::of_lidar(&Config::default(), 200, true));
    LidarJob { glass: Some(glass), map, ..scan_job() }
}

/// With learned solidity.
fn learned(job: LidarJob) -> LidarJob {
    let model = limpid::stage::lidar::solidity::SolidityModel::shipped().unwrap();
    LidarJob { solidity: Some(Arc::new(model)), solidity_inputs: true, ..job }
}

const ALL_LAYERS: Layers = Layers { cameras: true, looks: true, lidars: true, panes: true, drops: true };

/// Plans of maps with several sensors, by both laws of inflation, with and without each layer.
fn one_map_plans() -> Vec<Plan> {
    let cameras = Layers { cameras: true, ..Layers::default() };
    let lidars = Layers { lidars: true, ..Layers::default() };
    let mut plans = Vec::new();
    let kinds =
        [ALL_LAYERS, Layers { looks: false, panes: false, drops: false, ..ALL_LAYERS }, cameras, lidars];
    for layers in kinds {
        for inflation_law in [InflationLaw::Nav2, InflationLaw::Goal] {
            let config = Config { inflation_law, ..small_map() };
            let side = config.cells_per_side().unwrap();
            let (cameras, glass_lidars) = (2 * u32::from(layers.cameras), u32::from(layers.panes));
            let (sensors, apart, verdicts) = (3, true, true);
            let evidence = layers.drops;
            let network = || Arc::new(MapReliability::shipped().unwrap());
            let reliability = layers.looks.then(network);
            let map = Arc::new(MapJob {
                config,
                side,
                layers,
                sensors,
                cameras,
                glass_lidars,
                evidence,
                reliability,
                apart,
                verdicts,
            });
            plans.push(mapper::map_plan(&map, &mapper::map_stages(&map)).unwrap());
            let scope = || "top".to_owned();
            if layers.cameras {
                plans.push(camera_plan(&CameraJob {
                    map: Arc::clone(&map),
                    scope: scope(),
                    ..job(&small_map(), tiny_camera())
                }));
            }
            let scans = if layers.panes { glass_job() } else { scan_job() };
            let scans = Arc::new(LidarJob { map, scope: scope(), ..scans });
            if layers.lidars {
                plans.push(mapper::lidar_plan(&scans, &mapper::lidar_stages(&scans)).unwrap());
                let scans = Arc::new(learned((*scans).clone()));
                plans.push(mapper::lidar_plan(&scans, &mapper::lidar_stages(&scans)).unwrap());
            }
        }
    }
    plans
}

/// Plans that together run every pass in every text.
fn plans() -> Vec<Plan> {
    let mut plans: Vec<_> = jobs().iter().map(camera_plan).collect();
    plans.push(limpid::sim::simulator::plan(&small_room()).unwrap());
    plans.push(limpid::sim::lidar::plan(&Lidar::default()).unwrap());
    for scans in [scan_job(), glass_job(), learned(scan_job()), learned(glass_job())] {
        let job = Arc::new(scans);
        plans.push(mapper::lidar_plan(&job, &mapper::lidar_stages(&job)).unwrap());
    }
    plans.extend(one_map_plans());
    plans.push(limpid::offline::score::velocity_plan(20, 5, 30).unwrap());
    let colored = CameraJob { color: Some(tiny_camera()), ..job(&small_map(), tiny_camera()) };
    plans.push(limpid::offline::targets::plan(&Arc::new(colored), &targets::Rule::default(), true).unwrap());
    plans
}

/// Name and text of every step of `plans` but the network's.
fn texts(plans: &[Plan]) -> BTreeSet<(&str, &str)> {
    let shaders = plans.iter().flat_map(|plan| plan.steps()).map(|step| &step.shader);
    let of_maps = shaders.filter(|shader| !shader.name.starts_with("net/"));
    of_maps.map(|shader| (shader.name.as_str(), shader.source.as_str())).collect()
}

/// The first lines of all parts of those texts that no plan runs.
fn unused(sources: impl IntoIterator<Item = ShaderSource>, plans: &[Plan]) -> Vec<String> {
    let run = texts(plans);
    let begins = |source: &ShaderSource| -> String {
        source.parts.iter().flat_map(|part| part.lines().next()).collect::<Vec<_>>().join(" ")
    };
    let unused = sources.into_iter().filter(|source| {
        let ShaderText { label, text, .. } = (*source).into();
        !run.contains(&(label.as_str(), text.as_str()))
    });
    unused.map(|source| format!("{}: {}", source.name, begins(&source))).collect()
}

/// The text of every file in `shaders/`.
fn files() -> BTreeSet<String> {
    let mut files = BTreeSet::new();
    wgsl_files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders"), &mut files);
    files
}

#[test]
fn every_shader_parses_and_is_made_of_files() {
    let files = files();
    for source in all() {
        let shader = Shader::parse(source).unwrap();
        assert!(!shader.bindings.is_empty() && shader.workgroup_size.iter().product::<u32>() > 1);
        assert!(source.parts.iter().all(|part| files.contains(*part)), "{}", source.name);
    }
}

#[test]
fn every_file_is_in_a_text_that_a_plan_runs_and_says_what_it_is() {
    let (plans, kernels) = (plans(), all_kernels());
    let texts = texts(&plans);
    let network: BTreeSet<&str> = kernels.iter().flatten().copied().collect();
    let files = files();
    assert!(files.len() > 100, "{} files", files.len());
    for file in &files {
        let first = file.lines().next().unwrap();
        assert!(first.starts_with("// "), "a file begins with {first:?}");
        let reached = network.contains(file.as_str()) || texts.iter().any(|(_, text)| text.contains(file));
        assert!(reached, "no plan runs the file that begins with {first:?}");
    }
}

#[test]
fn every_text_of_a_pass_is_in_a_plan_that_fits() {
    let plans = plans();
    assert_eq!(unused(all(), &plans), [""; 0], "no plan runs these");
    let listed: BTreeSet<_> = all().map(|source| (source.name, ShaderText::from(source).text)).collect();
    for (name, text) in texts(&plans) {
        assert!(COMPOSED.contains(&name) || listed.contains(&(name, text.into())), "{name} is not listed");
    }
    // The network's passes have constants in place of parameters.
    let steps = plans.iter().flat_map(|plan| plan.steps());
    for step in steps.filter(|step| !step.shader.name.starts_with("net/")) {
        let name = &step.shader.name;
        let first = step.shader.bindings.iter().find(|b| b.name.ends_with("_params")).expect(name);
        assert!(first.slot == 0 && !first.fields.is_empty(), "{name}: parameters come first");
    }
}

#[test]
fn control_a_text_left_over_under_a_used_name_is_found() {
    let leftover = ShaderSource { name: tally::TALLY.name, parts: &["// What was.", "// Tallies."] };
    let found = unused([tally::TALLY, leftover], &[camera_plan(&jobs()[0])]);
    assert_eq!(found, ["tally: // What was. // Tallies."]);
}

#[test]
fn control_broken_shaders_are_refused_by_name() {
    let refused = |name: &'static str, text: &'static str, part: &str| {
        let parts: &'static [&'static str] = Box::leak(Box::new([text]));
        let error = Shader::parse(ShaderSource { name, parts }).unwrap_err();
        assert!(
            matches!(&error, Error::Shader { pass, reason } if pass == name && reason.contains(part)),
            "{error}"
        );
    };
    refused("broken", "fn", "expected");
    refused("none", "fn helper() {}", "0 entry points");
    refused("other", "@compute @workgroup_size(1) fn main() {}", "not named as its file");
    let unused = "@group(0) @binding(0) var<storage, read> data: array<u32>; @compute @workgroup_size(1) fn unused() {}";
    refused("unused", unused, "`data` is declared but not used");
    let group = "@group(1) @binding(0) var<storage, read_write> data: array<u32>; @compute @workgroup_size(1) fn group() { data[0] = 1u; }";
    refused("group", group, "group 1");
}

/// The head of a pass with one loop, and the loop.
fn with_loop(lines: &str) -> ShaderText {
    let text = format!(
        "const STEP = 4u;\n@group(0) @binding(0) var<storage, read_write> sums: array<u32>;\n\
         @compute @workgroup_size(1)\nfn run(@builtin(global_invocation_id) id: vec3<u32>) {{\n\
         let count = sums[0];\n{lines}\n}}"
    );
    ShaderText { label: "pass".into(), entry_point: "run", text }
}

#[test]
fn loops_run_without_a_guard_only_where_they_are_sure_to_end() {
    for (ends, lines) in [
        (true, "for (var i = 0u; i < 9u; i += 2u) { sums[i] = 1u; }"),
        (true, "for (var i = id.x; i < count; i++) { sums[i] = 1u; }"),
        (true, "for (var i = id.x; i < min(count, 4096u); i += STEP) { sums[i] = 1u; }"),
        (
            true,
            "for (var i = 0u; i < count; i++) { for (var k = 0u; k < i; k++) { if k == 3u { break; } sums[k] = i; } }",
        ),
        (
            true,
            "for (var i = 0u; i < select(0u, 1u, id.x < count && sums[id.x] == 2u); i++) { sums[i] = 1u; }",
        ),
        (true, "for (var i = 0u; i < firstTrailingBit(sums[i]); i++) { sums[i] = 1u; }"),
        (true, "for (var i = id.x; i > 0u; i--) { sums[i] = 1u; }"),
        (false, "for (var i = id.x; i > 0u; i -= 2u) { sums[i] = 1u; }"),
        (false, "for (var i = id.x; i > 0u; i++) { sums[i] = 1u; }"),
        (false, "for (var i = id.x; i > count; i--) { sums[i] = 1u; }"),
        (false, "for (var i = 0u; ; i++) { if sums[0] == 1u { continue; } if !(i < count) { break; } }"),
        // From the largest number but one it would go on with 0.
        (false, "for (var i = id.x; i < count; i += 2u) { sums[i] = 1u; }"),
        (false, "for (var i = id.x; i < max(count, 4096u); i += STEP) { sums[i] = 1u; }"),
        (false, "for (var i = id.x; i <= count; i++) { sums[i] = 1u; }"),
        (false, "for (var i = 0u; i < count; i += id.x) { sums[i] = 1u; }"),
        (false, "for (var i = 0u; i < count; i++) { i = 0u; sums[i] = 1u; }"),
        (false, "for (var i = 0u; i < count; i++) { for (var k = 0u; k <= i; k++) { sums[k] = i; } }"),
        (false, "var i = 0u; while i < count { sums[i] = 1u; i++; }"),
        (false, "loop { if sums[1] == 7u { break; } sums[2] = 1u; }"),
    ] {
        let shader = Shader::parse(with_loop(lines)).unwrap();
        assert_eq!(shader.counted_loops, ends, "{lines}");
    }
}

#[test]
fn passes_that_run_with_guards_in_their_loops_are_these() {
    let guarded = all().filter(|source| !Shader::parse(*source).unwrap().counted_loops);
    let guarded: BTreeSet<_> = guarded.map(|source| source.name).collect();
    let known = [
        "back_project",
        "inflate/rows",
        "inflate/columns",
        "see_through/gather",
        "tally",
        "sim/meter",
        "glass/gather",
    ];
    assert_eq!(guarded, BTreeSet::from(known));
}
