//! The first pane that a ray crosses before it ends (spec 4 §1).

use glam::DVec3;

use super::pane_cells::Corners;

/// Share of the way from `eye` to `end` at which the pane is crossed, and how far inside of its border, metres; `None`: nowhere.
fn crossing(pane: &Corners, eye: DVec3, end: DVec3) -> Option<(f64, f64)> {
    let (along, up) = (pane.low_right - pane.low_left, pane.high_left - pane.low_left);
    let normal = along.cross(up).normalize();
    let [from, to] = [eye, end].map(|at| normal.dot(at - pane.low_left));
    if from * to >= 0.0 {
        return None;
    }
    let share = from / (from - to);
    let at = eye + share * (end - eye) - pane.low_left;
    let [u, v] = [at.dot(along.normalize()), at.dot(up.normalize())];
    let inside = u.min(along.length() - u).min(v.min(up.length() - v));
    Some((share, inside))
}

/// Depth at which a ray to a point that is `depth_m` deep ends, below 0 at a pane; `None` where it passes within `slack_m` of a
/// pane's border or of its plane, so that rounding decides.
pub(crate) fn clipped_m(
    panes: &[Corners],
    eye: DVec3,
    end: DVec3,
    depth_m: f64,
    slack_m: f64,
) -> Option<f64> {
    let mut share = 1.0_f64;
    for pane in panes {
        let Some((at, inside)) = crossing(pane, eye, end) else { continue };
        if inside.abs() < slack_m || (1.0 - at) * depth_m < slack_m {
            return None;
        }
        if inside > 0.0 {
            share = share.min(at);
        }
    }
    Some(if share < 1.0 { -share * depth_m } else { depth_m })
}
