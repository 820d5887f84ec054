// Follows the sub-rays of a lidar's beams through the scene: what each sends back, from which range.
// spec 6 §1 (a beam is a cone; power of a sub-ray; glass: a narrow lobe, two passes for what lies behind).
//
// Power is in the unit of a white wall at 1 m that fills the beam. A mirror and a pane are passed on the way out and on
// the way back, so that their shares count twice.
struct SimBeamParams {
    rows: u32,                  // beams of a column
    first_beam: u32,            // of this dispatch: column by column
    beams: u32,
    subrays: u32,               // of a beam
    turn: f32,                  // of the pattern of sub-rays, radians
    largest_range_m: f32,
    spread_level_rad: f32,      // half the beam's divergence across and along the vertical
    spread_upright_rad: f32,
    faintest: f32,              // power below which no echo is seen, share of a white wall's at 1 m
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> beam_params: SimBeamParams;
@group(0) @binding(1) var<uniform> scene: SimScene;
// Elevation, azimuth ahead of the column's, height at which the beam crosses the sensor's axis.
@group(0) @binding(2) var<storage, read> rings: array<vec4<f32>>;
// Four a column: rows of the map's axes and the sensor's place in them, then its azimuth.
@group(0) @binding(3) var<storage, read> column_poses: array<vec4<f32>>;
// Four a sub-ray: range, power, what it was and the true place (see packed_place).
@group(0) @binding(4) var<storage, read_write> sent_back: array<vec4<u32>>;

const ECHOES = 4u;              // of a sub-ray that are kept
const SEGMENTS = 10u;           // rays that a sub-ray may spend
// The lobe around head on in which glass and other smooth surfaces send light straight back (dust, scratches and the
// receiver's width make it wider than a mirror's own): a core and a skirt, deviations and heights by its share of
// mirror light, such that a QT64 sees a pane 5 m off as 3DRef's scans have it.
const CORE_RAD = 0.07;
const CORE_GAIN = 16.0;
const SKIRT_RAD = 0.21;
const SKIRT_GAIN = 1.6;
// Slopes of a surface above which its mirror image of a beam is lost.
const SHARP = 0.01;
const MIRROR_KIND = 5.0;

// What an echo was: bits of `info` above the material.
const OF_GLASS = 0x100u;        // the pane or mirror itself
const REFLECTED = 0x200u;       // met by way of a mirror image
const BEHIND = 0x400u;          // met through a pane
const PASSABLE = 0x800u;        // a robot can pass it

// A sub-ray: the ray under way, and a mirror image that has yet to be followed.
struct Shot {
    origin: vec3<f32>,
    direction: vec3<f32>,
    share: f32,                 // of the power that passes both ways; 0: nothing is left
    travelled_m: f32,
    info: u32,
    kept_origin: vec3<f32>,
    kept_direction: vec3<f32>,
    kept_share: f32,
    kept_travelled_m: f32,
    kept_info: u32,
}

// A surface's echo of a ray, and where it goes on.
struct Met {
    power: f32,
    info: u32,
    at: vec3<f32>,
}

// The place from the sensor in map axes, in 1/256 m up to 128 m: x above info, y and z in a word of their own.
fn packed_place(offset: vec3<f32>) -> vec2<u32> {
    let fixed = vec3<u32>(vec3<i32>(clamp(offset, vec3(-127.9), vec3(127.9)) * 256.0)) & vec3(0xffffu);
    return vec2(fixed.x << 16u, fixed.y | (fixed.z << 16u));
}

fn beam_direction(row: u32, column: u32, subray: u32) -> vec3<f32> {
    let angles = rings[row];
    // Even over the disc: a spiral by the golden angle.
    let radius = sqrt((f32(subray) + 0.5) / f32(beam_params.subrays));
    let swing = f32(subray) * 2.3999632 + beam_params.turn;
    let elevation = angles.x + radius * sin(swing) * beam_params.spread_upright_rad;
    let aside = radius * cos(swing) * beam_params.spread_level_rad / max(cos(angles.x), 0.05);
    let azimuth = column_poses[4u * column + 3u].x + angles.y + aside;
    let level = cos(elevation);
    return vec3(level * cos(azimuth), level * sin(azimuth), sin(elevation));
}

fn to_map(column: u32, v: vec3<f32>) -> vec3<f32> {
    let row = 4u * column;
    return vec3(
        dot(column_poses[row].xyz, v), dot(column_poses[row + 1u].xyz, v), dot(column_poses[row + 2u].xyz, v),
    );
}

// Height of the lobe that a smooth surface sends back, at an angle off head on, by its roughness.
fn straight_back(angle_rad: f32, roughness: f32) -> f32 {
    let core = angle_rad / max(CORE_RAD, 2.0 * roughness);
    let skirt = angle_rad / max(SKIRT_RAD, 2.0 * roughness);
    return CORE_GAIN * exp(-core * core) + SKIRT_GAIN * exp(-skirt * skirt);
}

// A share of power, 0 where even a white wall's echo here would be too faint.
fn visible_share(share: f32, travelled_m: f32) -> f32 {
    return select(0.0, share, share > beam_params.faintest * travelled_m * travelled_m);
}

// Follows the ray under way to where it ends: the echo there, and what goes on.
fn followed(shot: ptr<function, Shot>) -> Met {
    let origin = (*shot).origin;
    let direction = (*shot).direction;
    let hit = nearest_thin(nearest_hit(origin, direction), origin, direction);
    let travelled_m = (*shot).travelled_m + hit.t;
    let at = origin + hit.t * direction;
    let share = (*shot).share;
    (*shot).share = 0.0;
    if hit.id == NOTHING || travelled_m > beam_params.largest_range_m {
        return Met(0.0, 0u, at);
    }
    let surface = surface_of(hit, at, direction);
    let optics = scene.optics[surface.material];
    let cosine = max(-dot(direction, surface.normal), 0.0);
    let one_face = select(0.0, fresnel(optics.x, cosine), optics.x > 0.0);
    let pane = optics.z > 0.0;
    let mirrored = select(one_face, pane_reflectance(one_face), pane);
    let lobe = mirrored * straight_back(acos(min(cosine, 1.0)), optics.y);
    let footprint_m = travelled_m * beam_params.spread_level_rad;
    let matt = albedo_at(surface.material, at, surface.normal, footprint_m).w * cosine * (1.0 - mirrored);
    let power = share * (select(matt, 0.0, pane) + lobe) / (travelled_m * travelled_m);
    let is_smooth = pane || optics.w == MIRROR_KIND;
    let kind = select(0u, OF_GLASS, is_smooth) | select(0u, PASSABLE, is_passable(hit));
    let met = Met(power, (*shot).info | surface.material | kind, at);

    // On the way back the light passes the same surfaces again.
    let blur = optics.y / SHARP;
    let mirror_share = visible_share(share * mirrored * mirrored / (1.0 + blur * blur), travelled_m);
    let through = (1.0 - mirrored) * optics.z;
    let mirror_direction = reflect(direction, surface.normal);
    (*shot).origin = at;
    (*shot).travelled_m = travelled_m;
    if pane {
        if mirror_share > 0.0 && (*shot).kept_share == 0.0 {
            (*shot).kept_origin = at;
            (*shot).kept_direction = mirror_direction;
            (*shot).kept_share = mirror_share;
            (*shot).kept_travelled_m = travelled_m;
            (*shot).kept_info = (*shot).info | REFLECTED;
        }
        (*shot).share = visible_share(share * through * through, travelled_m);
        (*shot).info |= BEHIND;
    } else {
        (*shot).share = mirror_share;
        (*shot).direction = mirror_direction;
        (*shot).info |= REFLECTED;
    }
    return met;
}

@compute @workgroup_size(64)
fn beam(@builtin(global_invocation_id) id: vec3<u32>) {
    let subrays = beam_params.subrays;
    if id.x >= beam_params.beams * subrays {
        return;
    }
    let number = beam_params.first_beam + id.x / subrays;
    let row = number % beam_params.rows;
    let column = number / beam_params.rows;
    let sensor = vec3(column_poses[4u * column].w, column_poses[4u * column + 1u].w, column_poses[4u * column + 2u].w);
    var shot: Shot;
    shot.origin = sensor + to_map(column, vec3(0.0, 0.0, rings[row].z));
    shot.direction = to_map(column, beam_direction(row, column, id.x % subrays));
    shot.share = 1.0;
    var kept = 0u;
    for (var segment = 0u; segment < SEGMENTS; segment++) {
        let met = followed(&shot);
        if met.power > 0.0 {
            let place = packed_place(met.at - sensor);
            let word = vec4(bitcast<u32>(shot.travelled_m), bitcast<u32>(met.power), met.info | place.x, place.y);
            sent_back[ECHOES * id.x + kept] = word;
            kept++;
        }
        if kept == ECHOES {
            break;
        }
        if shot.share == 0.0 {
            if shot.kept_share <= 0.0 {
                break;
            }
            shot.origin = shot.kept_origin;
            shot.direction = shot.kept_direction;
            shot.share = shot.kept_share;
            shot.travelled_m = shot.kept_travelled_m;
            shot.info = shot.kept_info;
            // One mirror image a sub-ray.
            shot.kept_share = -1.0;
        }
    }
    for (var i = kept; i < ECHOES; i++) {
        sent_back[ECHOES * id.x + i] = vec4(0u);
    }
}
