// Lets the points of a scan vote for the cells of the ground that their beams meet, as drops/pixels does. spec 6 §2 (drop-offs).
@group(0) @binding(0) var<uniform> drop_params: DropParams;
@group(0) @binding(4) var<storage, read> drop_view: array<u32>;
@group(0) @binding(6) var<storage, read> ground_now: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> drop_marks: array<atomic<u32>>;

// How near the mirrored place something is the thing that is mirrored.
const MIRROR_M = 0.1;
const MIRROR_PER_M = 0.05;
// Directions around it, of nine, that must be seen, and past it.
const LEAST_PAST = 2u;

// What the lidar sees of the place as far above the ground as `place` lies below it.
fn seen_mirrored(place: vec3<f32>, height: f32) -> u32 {
    let off = mirrored(place, height);
    let away = length(off);
    let seen = view_of(off);
    var past = 0u;
    var in_the_way = false;
    for (var k = 0u; k < 9u; k++) {
        let sector = (seen.x + SECTORS + k % 3u - 1u) % SECTORS;
        let bin = seen.y + k / 3u;
        if bin > 0u && bin <= VIEW_BINS {
            let word = drop_view[sector * VIEW_BINS + bin - 1u];
            let nearest = f32(~word) / SECTOR_STEPS_PER_M;
            let is_there = nearest < away + MIRROR_M + MIRROR_PER_M * away;
            in_the_way = in_the_way || (word != 0u && is_there);
            past += select(0u, 1u, word != 0u && !is_there);
        }
    }
    return select(select(NOT_SEEN, LOOKED_PAST, past >= LEAST_PAST), IN_THE_WAY, in_the_way);
}

@compute @workgroup_size(64)
fn returns(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = point_of(id.x);
    if at.w == 0.0 || !is_ground_seen() {
        return;
    }
    let place = in_window(at.xyz);
    let crossing = crossing_of(place);
    var kind = crossing.does;
    let meets = kind != ROUGH;
    for (var ask = 0u; ask < turns_if(kind == OPEN); ask++) {
        kind = vote_by(seen_mirrored(place, crossing.height));
    }
    if meets {
        vote(crossing, kind);
    }
}
