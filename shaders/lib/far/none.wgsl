// Where looks through are counted, no pass asks how far the pixels around look.
fn keep_far(word: u32, far_m: f32) {}
