// Auto exposure: the gain at which the mean of the image, cut at 1, is the wanted one.
// spec 1 §8 (auto-exposure mean 0.30).
struct SimMeterParams {
    width: u32,
    height: u32,
    step: u32,          // pixels from one sample to the next, along rows and columns
    wanted_mean: f32,
    largest_gain: f32,
    bias: f32,          // factor on the gain that is found
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> meter_params: SimMeterParams;
@group(0) @binding(1) var<storage, read> image: array<f32>;
@group(0) @binding(2) var<storage, read_write> gain: array<f32>;

const LANES = 64u;
const ROUNDS = 12u;

var<workgroup> sums: array<f32, 64>;

@compute @workgroup_size(64)
fn meter(@builtin(local_invocation_index) lane: u32) {
    let columns = meter_params.width / meter_params.step;
    let samples = columns * (meter_params.height / meter_params.step);
    var low = 0.0;
    var high = meter_params.largest_gain;
    // The mean grows with the gain: halve the interval, on a logarithmic scale after the first round.
    for (var round = 0u; round < ROUNDS; round++) {
        let trial = select(sqrt(max(low, high * 1.0e-4) * high), high, round == 0u);
        var sum = 0.0;
        for (var i = lane; i < samples; i += LANES) {
            let at = (i / columns) * meter_params.step * meter_params.width + (i % columns) * meter_params.step;
            sum += min(image[at] * trial, 1.0);
        }
        sums[lane] = sum;
        workgroupBarrier();
        var total = 0.0;
        for (var i = 0u; i < LANES; i++) {
            total += sums[i];
        }
        workgroupBarrier();
        let dark = total < meter_params.wanted_mean * f32(samples);
        low = select(low, trial, dark);
        high = select(trial, high, dark);
    }
    if lane == 0u {
        gain[0] = high * meter_params.bias;
    }
}
