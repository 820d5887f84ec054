// Places of the robot along the arc of every candidate velocity.
// spec 2 §5 (Eq. 12 of the paper).
struct RollOutParams {
    start: vec2<f32>,       // the robot in the window, metres
    heading: f32,           // radians from the window's x
    step_s: f32,            // time from one place to the next
    candidates: u32,
    places: u32,            // per candidate
}

@group(0) @binding(0) var<uniform> roll_out_params: RollOutParams;
@group(0) @binding(1) var<storage, read> velocities: array<vec2<f32>>;
@group(0) @binding(2) var<storage, read_write> trajectories: array<vec2<f32>>;

@compute @workgroup_size(64)
fn roll_out(@builtin(global_invocation_id) id: vec3<u32>) {
    let places = roll_out_params.places;
    if id.x >= roll_out_params.candidates * places {
        return;
    }
    let velocity = velocities[id.x / places];
    let time_s = f32(id.x % places) * roll_out_params.step_s;
    // The chord of the arc: 2 v / omega sin(omega t / 2), at half the turn.
    let half_turn = 0.5 * velocity.y * time_s;
    let bent = select(sin(half_turn) / half_turn, 1.0, abs(half_turn) < 1.0e-4);
    let along = roll_out_params.heading + half_turn;
    trajectories[id.x] = roll_out_params.start + velocity.x * time_s * bent * vec2(cos(along), sin(along));
}
