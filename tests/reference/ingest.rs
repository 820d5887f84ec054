//! Which samples are measured depth (spec 1 §1, §3, §4).

use limpid::config::{Config, Method};
use limpid::sensor::DepthSamples;

/// Share of a count by which a limit may be missed: limits like 0.17 m are no exact multiples of 0.001 m in binary.
const COUNT_SLACK: f64 = 1e-6;

/// Depth in metres, 0 where there is none.
pub(crate) fn ingest(config: &Config, samples: &DepthSamples) -> Vec<f32> {
    let gate = |metres: f64, slack: f64| match config.method {
        Method::Drm => panic!("the twin knows no network"),
        Method::Range | Method::Auto => {
            metres >= config.depth_min_m - slack
                && metres <= config.range_gate_m.min(config.depth_max_m) + slack
        }
        Method::Naive | Method::Median | Method::Temporal => true,
    };
    match samples {
        DepthSamples::Integer { raw, unit_m } => raw
            .iter()
            .map(|&count| {
                let metres = f64::from(count) * unit_m;
                let measured = count != 0 && count != 65535 && gate(metres, COUNT_SLACK * unit_m);
                if measured { metres as f32 } else { 0.0 }
            })
            .collect(),
        // Limits are stated in f64 and samples come in f32: a sample equal to the rounded limit counts as on it.
        DepthSamples::Metres(metres) => metres
            .iter()
            .map(|&m| {
                let measured =
                    m.is_finite() && m > 0.0 && gate(f64::from(m), f64::from(m) * f64::from(f32::EPSILON));
                if measured { m } else { 0.0 }
            })
            .collect(),
    }
}
