// The echoes of each beam: peaks of the power that came back, at least `pulse_m` apart, as the sensor reports them.
// spec 6 §1 (gathered power, detector's threshold, dual return).
struct SimEchoParams {
    beams: u32,
    subrays: u32,
    returns: u32,           // 0 strongest, 1 last and strongest (or second strongest), 2 first and last
    calibrated: u32,        // 1: intensity is reflectivity (power times range squared), 0: it is the signal
    seed: u32,              // of this scan and dispatch
    threshold: f32,         // least power, share of a white wall's at 1 m
    pulse_m: f32,
    range_noise_m: f32,
    power_noise: f32,       // deviation as a share
    scale: f32,             // intensity of 1
    largest: f32,           // intensity
    nearest_m: f32,
    focus_m: f32,           // ranges below which the signal grows no further, where it is not calibrated
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> echo_params: SimEchoParams;
@group(0) @binding(1) var<storage, read> sent_back: array<vec4<u32>>;
// Two a beam: range (0: none), intensity, info and true place as in sent_back.
@group(0) @binding(2) var<storage, read_write> echoes: array<vec4<u32>>;

const MOST = 128u;          // parts of a beam's echoes: 32 sub-rays of four
const PEAKS = 4u;

var<private> range_m: array<f32, 128>;
var<private> power: array<f32, 128>;
var<private> place: array<u32, 128>;    // in sent_back
var<private> count: u32;

// Takes up what the sub-rays sent back, by range.
fn sort_parts(beam: u32) {
    count = 0u;
    let parts = min(4u * echo_params.subrays, MOST);
    for (var i = 0u; i < parts; i++) {
        let at = 4u * echo_params.subrays * beam + i;
        let part = sent_back[at];
        let range = bitcast<f32>(part.x);
        if bitcast<f32>(part.y) > 0.0 && range >= echo_params.nearest_m {
            var slot = count;
            for (; slot > 0u; slot--) {
                if range_m[slot - 1u] <= range {
                    break;
                }
                range_m[slot] = range_m[slot - 1u];
                power[slot] = power[slot - 1u];
                place[slot] = place[slot - 1u];
            }
            range_m[slot] = range;
            power[slot] = bitcast<f32>(part.y) / f32(echo_params.subrays);
            place[slot] = at;
            count++;
        }
    }
}

struct Peak {
    range_m: f32,           // 0: none
    power: f32,
    place: u32,             // of its strongest part
}

// The strongest stretch of `pulse_m`; its parts, and those too near to it for an echo of their own, are used up.
fn next_peak() -> Peak {
    var best = 0.0;
    var first = 0u;
    var end = 0u;
    var j = 0u;
    var sum = 0.0;
    for (var i = 0u; i < count; i++) {
        for (; j < count; j++) {
            if range_m[j] > range_m[i] + echo_params.pulse_m {
                break;
            }
            sum += power[j];
        }
        if sum > best {
            best = sum;
            first = i;
            end = j;
        }
        sum -= power[i];
    }
    if best < echo_params.threshold {
        return Peak(0.0, 0.0, 0u);
    }
    var peak = Peak(0.0, best, place[first]);
    var strongest = 0.0;
    for (var i = first; i < end; i++) {
        peak.range_m += range_m[i] * power[i] / best;
        peak.place = select(peak.place, place[i], power[i] > strongest);
        strongest = max(strongest, power[i]);
    }
    for (var i = 0u; i < count; i++) {
        if abs(range_m[i] - peak.range_m) < echo_params.pulse_m {
            power[i] = 0.0;
        }
    }
    return peak;
}

fn reported(peak: Peak, beam: u32, slot: u32) -> vec4<u32> {
    if peak.range_m == 0.0 {
        return vec4(0u);
    }
    let bits = hash3(i32(beam), i32(slot), echo_params.seed);
    let range = peak.range_m + echo_params.range_noise_m * normal(bits);
    let noisy = max(peak.power * (1.0 + echo_params.power_noise * normal(hash(bits))), 0.0);
    let squared = peak.range_m * peak.range_m;
    let focus = squared / (squared + echo_params.focus_m * echo_params.focus_m);
    let value = noisy * select(focus, squared, echo_params.calibrated == 1u);
    let intensity = min(value * echo_params.scale, echo_params.largest);
    let part = sent_back[peak.place];
    return vec4(bitcast<u32>(max(range, 0.001)), bitcast<u32>(intensity), part.z, part.w);
}

@compute @workgroup_size(64)
fn echo(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= echo_params.beams {
        return;
    }
    sort_parts(id.x);
    let strongest = next_peak();
    var second = Peak(0.0, 0.0, 0u);
    var first = strongest;
    var last = strongest;
    for (var i = 1u; i < PEAKS; i++) {
        let peak = next_peak();
        if peak.range_m == 0.0 {
            break;
        }
        if i == 1u {
            second = peak;
        }
        if peak.range_m < first.range_m {
            first = peak;
        }
        if peak.range_m > last.range_m {
            last = peak;
        }
    }
    // One echo fills one slot.
    var one = strongest;
    var other = Peak(0.0, 0.0, 0u);
    if echo_params.returns == 1u && second.range_m > 0.0 {
        one = last;
        other = strongest;
        if last.range_m == strongest.range_m {
            other = second;
        }
    }
    if echo_params.returns == 2u && second.range_m > 0.0 {
        one = last;
        other = first;
    }
    echoes[2u * id.x] = reported(one, id.x, 0u);
    echoes[2u * id.x + 1u] = reported(other, id.x, 1u);
}
