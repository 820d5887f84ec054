//! How far apart stamps are, in words that are the same for distances that are alike, so that they can be counted.

/// Steps in which distances are told, milliseconds.
const STEPS_MS: [u64; 9] = [5, 10, 20, 30, 50, 100, 200, 500, 1000];

/// Why the nearest colour image, `apart_ns` from a depth image, does not belong to it; `None`: none is near at all.
pub(crate) fn apart_text(apart_ns: Option<u64>, tolerance_ns: u64) -> String {
    #[expect(clippy::cast_precision_loss, reason = "told in milliseconds")]
    let tolerance_s = tolerance_ns as f64 * 1e-9;
    let step = |ns: u64| STEPS_MS.into_iter().find(|&step_ms| ns <= step_ms * 1_000_000);
    let within = match apart_ns.map(step) {
        None => "no colour image came near".into(),
        Some(None) => "the nearest colour image is more than 1000 ms off".into(),
        Some(Some(step_ms)) => format!("the nearest colour image is up to {step_ms} ms off"),
    };
    format!("{within} (`pair_tolerance_s` is {tolerance_s})")
}
