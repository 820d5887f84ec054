// Settles what the first steps left open, and counts. spec 3 §5 step 3; and, where a pane has been found before and is
// known to mirror, by what most points behind it are.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(2) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(3) var pane_texels: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(4) var<storage, read> pane_counts: array<u32>;
@group(0) @binding(5) var<storage, read> met_points: array<u32>;
@group(0) @binding(6) var<storage, read_write> classes: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> glass_counters: array<atomic<u32>>;

// Scans that must have found a pane.
const ESTABLISHED = 2u;
// Of the points behind it that are decided, reflections must be this many times as many as others.
const MIRRORS_MORE = 2u;

// Points that are outside stay so, and none becomes it: it does not matter whether another invocation was here before.
fn settled(index: u32, place: u32, pane_id: u32) -> u32 {
    let word = beam_cells[2u * place + 1u];
    let other = index_in(word);
    if word != NONE && other != index && (atomicLoad(&classes[other]) & 0xffu) == OUTSIDE {
        let farther = f32(steps_in(word)) / RANGE_STEPS_PER_M - length(point_at(index).xyz);
        if farther > glass_params.match_m {
            return REFLECTION;
        }
    }
    let slots = pane_slots();
    for (var k = 0u; k < slots; k++) {
        let pane = pane_at(k);
        let reflections = pane_counts[k * PANE_COUNTS + REFLECTIONS];
        let outsides = pane_counts[k * PANE_COUNTS + OUTSIDES];
        let known = pane.hits >= ESTABLISHED && glass_params.remembers != 0u;
        if pane.id == pane_id && known && reflections > MIRRORS_MORE * outsides {
            return REFLECTION;
        }
    }
    return UNLABELLED;
}

fn settle_point(index: u32, place: u32) {
    let label = atomicLoad(&classes[index]);
    var kind = label & 0xffu;
    let pane_id = label >> 8u;
    for (var turn = 0u; turn < turns_if(kind == UNLABELLED && pane_id != 0u); turn++) {
        kind = settled(index, place, pane_id);
        atomicStore(&classes[index], label_of(kind, pane_id));
    }
    atomicAdd(&glass_counters[COUNT_CLASSES + min(kind, CLASSES - 1u)], 1u);
}

// Those that meet no pane are inside, or were not placed.
fn count_unmet(met: u32) {
    let unplaced = atomicLoad(&glass_counters[COUNT_UNUSABLE]) + atomicLoad(&glass_counters[COUNT_NO_ROW]);
    atomicAdd(&glass_counters[COUNT_CLASSES + UNLABELLED], unplaced);
    atomicAdd(&glass_counters[COUNT_CLASSES + INSIDE], glass_params.points - unplaced - met);
}

@compute @workgroup_size(64)
fn settle(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let met = met_points[MET_COUNT];
    let turns = turns_from(id.x, met, 64u * groups.x);
    for (var turn = 0u; turn < turns; turn++) {
        let number = id.x + 64u * groups.x * turn;
        settle_point(met_points[met_at(number)], met_points[met_at(number) + 1u]);
    }
    for (var once = 0u; once < turns_if(id.x == 0u); once++) {
        count_unmet(met);
    }
}
