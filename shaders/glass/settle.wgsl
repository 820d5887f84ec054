// Settles what the first steps left open, and counts. spec 3 §5 step 3; and, where a pane has been found before and is
// known to mirror, by what most points behind it are.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> places: array<u32>;
@group(0) @binding(3) var<storage, read> cells: array<u32>;
@group(0) @binding(4) var<storage, read> panes: Panes;
@group(0) @binding(5) var<storage, read> pane_counts: array<u32>;
@group(0) @binding(6) var<storage, read> labels: array<u32>;
@group(0) @binding(7) var<storage, read_write> classes: array<u32>;
@group(0) @binding(8) var<storage, read_write> glass_counters: array<atomic<u32>>;

// Scans that must have found a pane.
const ESTABLISHED = 2u;
// Of the points behind it that are decided, reflections must be this many times as many as others.
const MIRRORS_MORE = 2u;

fn settled(index: u32, pane_id: u32) -> u32 {
    let place = places[index];
    let word = cells[2u * place + 1u];
    if word != NONE && index_in(word) != index && (labels[index_in(word)] & 0xffu) == OUTSIDE {
        let farther = f32(steps_in(word)) / RANGE_STEPS_PER_M - length(points[2u * index].xyz);
        if farther > glass_params.match_m {
            return REFLECTION;
        }
    }
    for (var k = 0u; k < min(panes.slots, KEPT_PANES); k++) {
        let reflections = pane_counts[k * PANE_COUNTS + REFLECTIONS];
        let outsides = pane_counts[k * PANE_COUNTS + OUTSIDES];
        let known = panes.list[k].hits >= ESTABLISHED && glass_params.remembers != 0u;
        if panes.list[k].id == pane_id && known && reflections > MIRRORS_MORE * outsides {
            return REFLECTION;
        }
    }
    return UNLABELLED;
}

// Points that an invocation settles; it counts their classes before it shares the counts.
const EACH = 8u;

var<workgroup> counts: array<atomic<u32>, CLASSES>;

fn settle_points(begin: u32) {
    var mine = array<u32, CLASSES>();
    for (var index = begin; index < min(begin + EACH, glass_params.points); index++) {
        var kind = labels[index] & 0xffu;
        let pane_id = labels[index] >> 8u;
        for (var turn = 0u; turn < turns_if(kind == UNLABELLED && pane_id != 0u); turn++) {
            kind = settled(index, pane_id);
        }
        classes[index] = label_of(kind, pane_id);
        mine[0] += select(0u, 1u, kind == 0u);
        mine[1] += select(0u, 1u, kind == 1u);
        mine[2] += select(0u, 1u, kind == 2u);
        mine[3] += select(0u, 1u, kind == 3u);
        mine[4] += select(0u, 1u, kind == 4u);
    }
    for (var kind = 0u; kind < CLASSES; kind++) {
        if mine[kind] > 0u {
            atomicAdd(&counts[kind], mine[kind]);
        }
    }
}

@compute @workgroup_size(64)
fn settle(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    if lane < CLASSES {
        atomicStore(&counts[lane], 0u);
    }
    workgroupBarrier();
    for (var turn = 0u; turn < turns_if(EACH * id.x < glass_params.points); turn++) {
        settle_points(EACH * id.x);
    }
    workgroupBarrier();
    if lane < CLASSES {
        let count = atomicLoad(&counts[lane]);
        if count > 0u {
            atomicAdd(&glass_counters[COUNT_CLASSES + lane], count);
        }
    }
}
