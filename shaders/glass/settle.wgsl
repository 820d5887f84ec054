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

var<workgroup> counts: array<atomic<u32>, CLASSES>;

@compute @workgroup_size(64)
fn settle(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    if lane < CLASSES {
        atomicStore(&counts[lane], 0u);
    }
    workgroupBarrier();
    if id.x < glass_params.points {
        var kind = labels[id.x] & 0xffu;
        let pane_id = labels[id.x] >> 8u;
        if kind == UNLABELLED && pane_id != 0u {
            kind = settled(id.x, pane_id);
        }
        classes[id.x] = label_of(kind, pane_id);
        atomicAdd(&counts[kind], 1u);
    }
    workgroupBarrier();
    if lane < CLASSES {
        atomicAdd(&glass_counters[COUNT_CLASSES + lane], atomicLoad(&counts[lane]));
    }
}
