// Looks at what beams show that go on behind a wall: images of the room before it, which a mirror shows, or another room, which a door
// does. What lies along the wall's normal, as floors and side walls do, has its image wherever the mirror stands, so it proves nothing;
// proof is a surface that would lie elsewhere if the wall stood before or behind where it stands. Glass shows both its image and what
// stands behind it, so a beam with two returns proves nothing either. spec 6 §4.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(2) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(3) var row_texels: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(4) var<storage, read> scan_walls: Walls;
@group(0) @binding(5) var<storage, read> passed_beams: array<u32>;
@group(0) @binding(6) var<storage, read_write> wall_strips: array<atomic<u32>>;

// How far before and behind the wall others are imagined, metres: a beam's image moves by twice that.
const ELSEWHERE_M = 0.4;
// Of the range tolerance of panes, whose images need not stand alone.
const STRICTER = 0.5;

fn has_surface(at: vec3<f32>) -> Shown {
    return shown_at(at, STRICTER * tolerance(length(at)));
}

fn count_in(at: u32, what: u32, counts: bool) {
    if counts {
        atomicAdd(&wall_strips[at + what], 1u);
    }
}

fn look_behind(place: u32, wall: u32) {
    let plane = scan_walls.planes[wall];
    let level = scan_walls.levels[wall].xyz;
    let first = beam_cells[2u * place];
    let p = point_at(index_in(first)).xyz;
    let reach = dot(plane.xyz, p);
    let met = p * (plane.w / reach);
    let strip = u32(clamp(dot(met, level) / STRIP_M + 0.5 * f32(STRIPS), 0.0, f32(STRIPS - 1u)));
    let at = strip_at(wall, strip);
    // Where most beams have two returns there is glass.
    let glass = 2u * atomicLoad(&wall_strips[at + TWICE]) > atomicLoad(&wall_strips[at + GO_ON]);
    for (var once = 0u; once < turns_if(!glass); once++) {
        let over = reach - plane.w;
        let shown = has_surface(p - 2.0 * over * plane.xyz);
        var proves = shown.matches && !two_returns(first, beam_cells[2u * place + 1u]);
        for (var turn = 0u; turn < turns_if(proves); turn++) {
            proves = !has_surface(p - 2.0 * (over + ELSEWHERE_M) * plane.xyz).matches
                && !has_surface(p - 2.0 * (over - ELSEWHERE_M) * plane.xyz).matches;
        }
        let refuted = shown.beyond && !shown.matches;
        count_in(at, IMAGES, shown.matches);
        count_in(at, MISSING, shown.known && !shown.matches);
        count_in(at, REFUTED, refuted);
        count_in(at, PROOFS, proves);
        if !refuted {
            let v = dot(met, cross(plane.xyz, level));
            let v_mm = u32(clamp(1000.0 * v + V_ZERO_MM, 0.0, 2.0 * V_ZERO_MM));
            atomicMin(&wall_strips[at + LOWEST], v_mm);
            atomicMax(&wall_strips[at + HIGHEST], v_mm);
        }
    }
}

@compute @workgroup_size(64)
fn images(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let turns = turns_from(id.x, passed_beams[PASSED_COUNT], 64u * groups.x);
    for (var turn = 0u; turn < turns; turn++) {
        let word = passed_beams[1u + id.x + 64u * groups.x * turn];
        look_behind(word & ((1u << PLACE_BITS) - 1u), word >> PLACE_BITS);
    }
}
