//! The plan and its memory, without a GPU.

use std::sync::Arc;

use limpid::config::Method;
use limpid::gpu::arena::{Kind, Layout};
use limpid::gpu::{Access, BufferId, Invocations, Plan, Requirements, ShaderSource};
use limpid::mapper;
use limpid::network::Backend;
use limpid::network::weights::Network;
use limpid::stage::camera::drm::Drm;
use limpid::stage::camera::map_reliability::MapReliability;
use limpid::stage::map::layers::Layers;
use limpid::stage::{CameraJob, MapJob};
use proptest::prelude::*;

use crate::support::camera_job::{job, small_map, tiny_camera};
use crate::support::readme_part;

limpid::params! {
    /// Parameters of the test passes.
    pub struct PassParams {
        /// Elements.
        pub count: u32,
        /// Factor.
        pub factor: f32,
    }
}

/// A pass over `source` (read) and `sink` with the given statement.
macro_rules! pass {
    ($name:literal, $to:literal, $body:literal) => {
        ShaderSource {
            name: $name,
            parts: &[
                "@group(0) @binding(0) var<storage, read> source: array<u32>;\n@group(0) @binding(1) var<storage, read_write> sink: ",
                $to,
                ";\n@compute @workgroup_size(64) fn ",
                $name,
                "(@builtin(global_invocation_id) id: vec3<u32>) {",
                $body,
                "}",
            ],
        }
    };
}

const COPY: ShaderSource = pass!("copy", "array<u32>", "sink[id.x] = source[id.x];");
const ADD: ShaderSource = pass!("add", "array<u32>", "sink[id.x] += source[id.x];");
const COUNT: ShaderSource = pass!("count", "array<atomic<u32>>", "atomicAdd(&sink[0], source[id.x]);");

/// With a parameter struct of that text.
macro_rules! with_params {
    ($fields:literal) => {
        ShaderSource {
            name: "scale",
            parts: &[
                "struct PassParams {",
                $fields,
                "}\n@group(0) @binding(0) var<uniform> pass_params: PassParams;\n@group(0) @binding(1) var<storage, read_write> sink: array<u32>;\n@compute @workgroup_size(64) fn scale(@builtin(global_invocation_id) id: vec3<u32>) { sink[id.x] = pass_params.count; }",
            ],
        }
    };
}

const LINE: Invocations = Invocations([64, 1, 1]);

/// Buffers `a` (upload), `b` and `c` (scratch), `kept` (state), 64 words each.
fn buffers() -> Plan {
    let mut plan = Plan::default();
    plan.upload("a", 256).unwrap();
    plan.scratch("b", 256).unwrap();
    plan.scratch("c", 256).unwrap();
    plan.state("kept", 256).unwrap();
    plan
}

fn step(plan: &mut Plan, pass: ShaderSource, from: &str, to: &str) -> limpid::Result<()> {
    plan.step(pass, LINE, &[("source", from), ("sink", to)])
}

#[track_caller]
fn refused<T>(result: limpid::Result<T>, parts: &[&str]) {
    let reason = result.err().expect("refused").to_string();
    assert!(parts.iter().all(|part| reason.contains(part)), "`{reason}` should say {parts:?}");
}

/// a -> b -> c -> kept, and c read back: right in every way.
fn chain() -> Plan {
    let mut plan = buffers();
    step(&mut plan, COPY, "a", "b").unwrap();
    step(&mut plan, COPY, "b", "c").unwrap();
    step(&mut plan, ADD, "c", "kept").unwrap();
    plan.read_back("c").unwrap();
    plan
}

#[test]
fn a_right_plan_passes_and_knows_its_accesses() {
    let plan = chain();
    plan.check().unwrap();
    let access =
        |step: usize| plan.steps()[step].shader.bindings.iter().map(|b| b.access).collect::<Vec<_>>();
    assert_eq!(
        (access(0), access(2)),
        (vec![Access::Read, Access::Write], vec![Access::Read, Access::ReadWrite])
    );
    let lifetime = |name: &str| plan.lifetime(plan.find(name).unwrap()).unwrap();
    assert_eq!([lifetime("a"), lifetime("b"), lifetime("c")], [(0, 0), (0, 1), (1, 3)]);
}

#[test]
fn reading_before_writing_is_refused() {
    for pass in [COPY, ADD, COUNT] {
        let mut plan = buffers();
        step(&mut plan, pass, "b", "kept").unwrap();
        refused(plan.check(), &[pass.name, "reads `b` before any pass has written it"]);
    }
    for pass in [ADD, COUNT] {
        let mut plan = buffers();
        step(&mut plan, pass, "a", "b").unwrap();
        refused(plan.check(), &[pass.name, "reads `b` before"]);
        let mut cleared = chain();
        step(&mut cleared, pass, "a", "b").unwrap();
        cleared.check().unwrap();
    }
}

#[test]
fn writing_what_is_bound_twice_is_refused() {
    for pass in [COPY, ADD, COUNT] {
        let mut plan = chain();
        step(&mut plan, pass, "c", "c").unwrap();
        refused(plan.check(), &[pass.name, "binds `c` as `source` and as `sink`"]);
    }
}

#[test]
fn writing_what_the_host_fills_is_refused() {
    let mut plan = buffers();
    plan.fixed("table", vec![0; 256]).unwrap();
    refused(step(&mut plan, COPY, "kept", "a"), &["copy", "`sink` writes buffer `a`"]);
    refused(step(&mut plan, COUNT, "a", "table"), &["count", "writes buffer `table`"]);
}

#[test]
fn names_and_sizes() {
    let mut plan = buffers();
    refused(plan.scratch("a", 4), &["`a` is declared twice"]);
    refused(plan.upload("empty", 0), &["`empty` has no bytes"]);
    refused(plan.fixed("empty", Vec::new()), &["`empty` has no bytes"]);
    refused(step(&mut plan, COPY, "nowhere", "b"), &["copy", "`source` needs a buffer `nowhere`"]);
    refused(plan.read_back("nowhere"), &["`nowhere`", "not declared"]);
    refused(
        plan.step(COPY, Invocations::line(0), &[("source", "a"), ("sink", "b")]),
        &["copy", "an extent is 0"],
    );
    let small = ShaderSource {
        name: "small",
        parts: &["@group(0) @binding(0) var<storage, read_write> tiny: array<vec4<f32>, 2>;
            @compute @workgroup_size(1) fn small() { tiny[0] = vec4(1.0); }"],
    };
    plan.scratch("tiny", 28).unwrap();
    refused(plan.step(small, LINE, &[]), &["small", "needs 32 bytes, buffer `tiny` has 28"]);
}

#[test]
fn unused_and_unwritten_buffers_are_refused() {
    let mut plan = chain();
    plan.scratch("spare", 4).unwrap();
    refused(plan.check(), &["`spare` is never read"]);
    plan.read_back("spare").unwrap();
    refused(plan.check(), &["`spare` is read back but never written"]);
}

#[test]
fn what_is_zeroed_may_be_read_first_and_lives_from_the_start() {
    let mut plan = Plan::default();
    plan.zeroed("zeros", 64).unwrap();
    plan.scratch("copy", 64).unwrap();
    plan.scratch("again", 64).unwrap();
    step(&mut plan, COPY, "zeros", "copy").unwrap();
    step(&mut plan, COPY, "copy", "again").unwrap();
    plan.read_back("again").unwrap();
    plan.check().unwrap();
    assert_eq!(plan.lifetime(plan.find("zeros").unwrap()), Some((0, 0)));
    refused(plan.upload_texture("narrow", 24, 4), &["narrow", "no multiple of 16"]);
    refused(plan.upload_texture("flat", 16, 0), &["flat", "has no bytes"]);
}

#[test]
fn what_is_written_must_be_read_unless_it_is_a_product() {
    let mut wasteful = chain();
    wasteful.scratch("waste", 256).unwrap();
    step(&mut wasteful, COPY, "c", "waste").unwrap();
    refused(wasteful.check(), &["`waste` is never read"]);
    let mut plan = chain();
    plan.product("result", 256).unwrap();
    step(&mut plan, COPY, "c", "result").unwrap();
    plan.check().unwrap();
}

#[test]
fn override_constants_must_exist() {
    let mut plan = chain();
    refused(plan.with(&[("no_such_constant", true)]), &["no override `no_such_constant`"]);
}

#[test]
fn parameter_layouts_must_match() {
    let add = |source: ShaderSource| {
        let mut plan = Plan::default();
        plan.uniform::<PassParams>("pass_params").unwrap();
        plan.scratch("sink", 256).unwrap();
        plan.step(source, LINE, &[])
    };
    add(with_params!("count: u32, factor: f32")).unwrap();
    refused(add(with_params!("count: u32, weight: f32")), &["scale", "weight", "factor"]);
    refused(add(with_params!("factor: f32, count: u32")), &["(\"factor\", 0)", "(\"count\", 0)"]);
    refused(
        add(with_params!("count: u32, @align(16) factor: f32")),
        &["(\"factor\", 16)", "(\"factor\", 4)"],
    );
    refused(add(with_params!("count: u32")), &["scale", "`pass_params`"]);
    refused(add(with_params!("count: u32, @size(12) factor: f32")), &["spans 16 bytes in WGSL and 8"]);
    let mut plan = buffers();
    plan.upload("pass_params", 8).unwrap();
    let scale = with_params!("count: u32, factor: f32");
    refused(plan.step(scale, LINE, &[("sink", "b")]), &["scale", "disagree on being uniform"]);
}

#[test]
fn requirements_say_what_the_device_must_offer() {
    let mut plan = chain();
    plan.scratch("large", 4096).unwrap();
    plan.step(COPY, Invocations::line(64 * 7 + 1), &[("source", "kept"), ("sink", "large")]).unwrap();
    let needs = plan.requirements();
    assert_eq!((needs.largest_buffer_bytes, needs.upload_bytes), (4096, 256));
    assert_eq!((needs.storage_buffers, needs.invocations, needs.workgroups), (2, 64, 8));
}

#[test]
fn buffers_that_never_live_together_share_bytes() {
    let mut plan = Plan::default();
    plan.upload("first", 1024).unwrap();
    for name in ["b", "c", "d", "e"] {
        plan.scratch(name, 1024).unwrap();
    }
    for (from, to) in [("first", "b"), ("b", "c"), ("c", "d"), ("d", "e")] {
        step(&mut plan, COPY, from, to).unwrap();
    }
    plan.read_back("e").unwrap();
    let layout = Layout::pack(&plan, 256);
    let scratch: u64 = layout.arenas.iter().filter(|a| a.kind == Kind::Scratch).map(|a| a.bytes).sum();
    assert_eq!(scratch, 2048, "four buffers in the room of two");
    assert_packed(&plan, &layout, 256);
}

/// No two buffers alive at once overlap (textures have memory of their own), places are aligned and inside, and no step reads and writes one allocation.
fn assert_packed(plan: &Plan, layout: &Layout, alignment: u64) {
    let ids: Vec<BufferId> = plan.buffers().iter().map(|b| plan.find(&b.name).unwrap()).collect();
    let range = |i: usize| (layout.places[i].offset, layout.places[i].offset + plan.buffers()[i].bytes);
    let is_texture = |i: usize| plan.buffers()[i].texture.is_some();
    for i in (0..ids.len()).filter(|i| !is_texture(*i)) {
        let place = layout.places[i];
        assert!(place.offset.is_multiple_of(alignment) && range(i).1 <= layout.arenas[place.arena].bytes);
        for j in (0..i).filter(|j| !is_texture(*j)) {
            let apart = range(i).1 <= range(j).0 || range(j).1 <= range(i).0;
            let scratch = layout.arenas[place.arena].kind == Kind::Scratch;
            let together = match (plan.lifetime(ids[i]), plan.lifetime(ids[j])) {
                (Some(a), Some(b)) if scratch => a.0 <= b.1 && b.0 <= a.1,
                _ => !scratch,
            };
            let shared = layout.places[j].arena == place.arena;
            assert!(
                !shared || apart || !together,
                "{} and {}",
                plan.buffers()[i].name,
                plan.buffers()[j].name
            );
        }
    }
    for step in plan.steps() {
        let arena = |id: BufferId| layout.places[ids.iter().position(|i| *i == id).unwrap()].arena;
        let buffers = step.uses().filter(|(b, _)| !b.texture);
        let (writes, reads): (Vec<_>, Vec<_>) = buffers.partition(|(b, _)| b.access.writes());
        for (_, written) in &writes {
            assert!(reads.iter().all(|(_, read)| arena(*read) != arena(*written)), "{}", step.shader.name);
        }
    }
}

fn random_plan(sizes: &[u64], steps: &[(usize, usize, bool)], read_back: usize) -> Plan {
    let mut plan = Plan::default();
    let name = |i: usize| format!("buffer{}", i % sizes.len());
    for (i, &bytes) in sizes.iter().enumerate() {
        let declared = if i == 0 { plan.upload(&name(0), bytes) } else { plan.scratch(&name(i), bytes) };
        declared.unwrap();
    }
    for &(from, to, add) in steps {
        let to = 1 + to % (sizes.len() - 1);
        if from % sizes.len() != to {
            step(&mut plan, if add { ADD } else { COPY }, &name(from), &name(to)).unwrap();
        }
    }
    plan.read_back(&name(read_back)).unwrap();
    plan
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_two_live_buffers_overlap(
        sizes in prop::collection::vec(1_u64..3000, 2..9),
        steps in prop::collection::vec((0_usize..9, 0_usize..9, any::<bool>()), 1..14),
        read_back in 0_usize..9,
        alignment in prop::sample::select(vec![4_u64, 32, 256]),
    ) {
        let plan = random_plan(&sizes, &steps, read_back);
        assert_packed(&plan, &Layout::pack(&plan, alignment), alignment);
    }
}

#[test]
fn the_default_job_is_packed_right() {
    let job = job(&small_map(), tiny_camera());
    let plan = camera_plan(&job);
    assert_packed(&plan, &Layout::pack(&plan, 64), 64);
}

fn camera_plan(job: &CameraJob) -> Plan {
    let job = Arc::new(job.clone());
    mapper::camera_plan(&job, &mapper::camera_stages(&job)).unwrap()
}

/// The table of passes that the README shows between markers of that name.
#[track_caller]
fn assert_readme_shows(marker: &str, job: &CameraJob) {
    let table = camera_plan(job).table();
    let shown = readme_part(marker);
    assert_eq!(
        shown,
        table.trim(),
        "README.md should hold between its <!-- {marker} --> markers:\n\n{table}\n"
    );
}

#[test]
fn the_readme_shows_the_passes_of_the_default_job() {
    assert_readme_shows("passes", &job(&limpid::Config::default(), tiny_camera()));
}

#[test]
fn the_readme_shows_the_passes_of_method_drm_on_a_gpu() {
    let config = limpid::Config { method: Method::Drm, ..limpid::Config::default() };
    let network = Arc::new(Network::from_bytes(include_bytes!("../weights/drm-net.safetensors")).unwrap());
    let drm = Drm { network, backend: Backend { textures: false, subgroups: true } };
    let camera = tiny_camera();
    let plain = job(&config, camera);
    // As the mapper builds it: drm comes with map reliability.
    let reliability = Some(Arc::new(MapReliability::shipped().unwrap()));
    let layers = Layers { looks: true, ..plain.map.layers };
    let map = Arc::new(MapJob { evidence: true, reliability, layers, ..(*plain.map).clone() });
    let job = CameraJob { drm: Some(drm), color: Some(camera), color_aligned: true, map, ..plain };
    assert_readme_shows("drm passes", &job);
}

#[test]
fn a_plan_that_needs_more_than_is_offered_is_refused_by_the_limit_s_name() {
    let much = 1 << 32;
    let offered = wgpu::Limits {
        max_storage_buffer_binding_size: much,
        max_buffer_size: much,
        max_storage_buffers_per_shader_stage: 16,
        max_storage_textures_per_shader_stage: 16,
        max_texture_dimension_2d: 16384,
        max_texture_array_layers: 2048,
        max_compute_invocations_per_workgroup: 1024,
        max_compute_workgroups_per_dimension: 1 << 20,
        ..wgpu::Limits::downlevel_defaults()
    };
    let needs = Requirements {
        largest_buffer_bytes: much,
        upload_bytes: much - 1,
        storage_buffers: 9,
        storage_textures: 7,
        texture_side: 9000,
        texture_layers: 600,
        subgroups: false,
        invocations: 512,
        workgroups: 100_000,
    };
    needs.check("some", &offered).unwrap();
    let little = Requirements { storage_buffers: 3, ..Requirements::default() };
    let poor = wgpu::Limits { max_storage_buffers_per_shader_stage: 4, ..offered.clone() };
    little.check("poor", &poor).unwrap();
    let error = needs.check("poor", &poor).unwrap_err().to_string();
    assert!(error.contains("max_storage_buffers_per_shader_stage"), "{error}");
}
