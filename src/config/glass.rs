//! Bounds of the parameters of glass.

use super::{Config, Error, Result};

/// Checks them.
pub(super) fn check(config: &Config) -> Result<()> {
    let bad = |key: &str, reason: String| Err(Error::Config { key: key.into(), reason });
    for (key, value, most) in [
        ("glass_return_gap_m", config.glass_return_gap_m, 10.0),
        ("glass_fit_tolerance_m", config.glass_fit_tolerance_m, 1.0),
        ("glass_plane_tolerance_m", config.glass_plane_tolerance_m, 1.0),
        ("glass_match_m", config.glass_match_m, 5.0),
        ("glass_slack_deg", config.glass_slack_deg, 45.0),
        ("glass_bright_ratio", config.glass_bright_ratio, 1e6),
        ("glass_lobe_deg", config.glass_lobe_deg, 90.0),
        ("glass_visible_deg", config.glass_visible_deg, 90.0),
    ] {
        if !(value > 0.0 && value <= most) {
            return bad(key, format!("{value} is not above 0 and up to {most}"));
        }
    }
    if !(0.0..=1.0).contains(&config.glass_match_per_m) {
        return bad("glass_match_per_m", format!("{} is not in [0, 1]", config.glass_match_per_m));
    }
    for (key, value, least, most) in [
        ("glass_hypotheses", config.glass_hypotheses, 32, 512),
        ("glass_min_inliers", config.glass_min_inliers, 3, 4096),
        ("glass_min_behind", config.glass_min_behind, 1, 1_000_000),
    ] {
        if !(least..=most).contains(&value) {
            return bad(key, format!("{value} is not in {least}..={most}"));
        }
    }
    Ok(())
}
