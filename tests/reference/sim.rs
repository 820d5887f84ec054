//! Where rays meet a scene's solids, in double precision and from the scene itself.

use glam::{DQuat, DVec2, DVec3};
use limpid::sim::scene::Scene;

/// Distance to the nearest surface along a unit ray, and its normal towards the ray's origin.
pub(crate) fn nearest_hit(scene: &Scene, origin: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
    let mut hits = vec![
        plane(origin, direction, DVec3::ZERO, DVec3::Z, |_| true),
        plane(origin, direction, DVec3::Z * scene.ceiling_m, DVec3::Z, |_| true),
    ];
    for room in &scene.rooms {
        let (low, high) = (DVec2::from(room.min_m), DVec2::from(room.max_m));
        for (corner, normal) in [(low, DVec3::X), (high, DVec3::X), (low, DVec3::Y), (high, DVec3::Y)] {
            let inside = move |p: DVec3| {
                let slack = DVec2::splat(1e-9);
                let at = p.truncate();
                at.cmpge(low - slack).all() && at.cmple(high + slack).all() && (0.0..=2.5).contains(&p.z)
            };
            hits.push(plane(origin, direction, corner.extend(0.0), normal, inside));
        }
    }
    for block in &scene.boxes {
        let turn = DQuat::from_rotation_z(-block.yaw_rad);
        let (o, d) = (turn * (origin - DVec3::from(block.center_m)), turn * direction);
        hits.push(slabs(o, d, DVec3::from(block.size_m) / 2.0).map(|(t, n)| (t, turn.inverse() * n)));
    }
    for c in &scene.cylinders {
        hits.push(cylinder(origin - DVec3::from(c.base_m), direction, c.radius_m, c.height_m));
    }
    for vessel in &scene.vessels {
        let local = origin - DVec3::from(vessel.base_m);
        let pieces = vessel.profile_m.windows(2);
        hits.extend(pieces.flat_map(|ends| frustum(local, direction, ends[0], ends[1])).map(Some));
    }
    for pane in &scene.panes {
        let normal = DVec2::from_angle(pane.yaw_rad).extend(0.0);
        let center = DVec3::from(pane.center_m);
        let inside = |p: DVec3| {
            let along = (p - center).dot(DVec3::Z.cross(normal)).abs();
            along <= pane.width_m / 2.0 && (p.z - center.z).abs() <= pane.height_m / 2.0
        };
        hits.push(plane(origin, direction, center, normal, inside));
    }
    let towards = |(t, n): (f64, DVec3)| (t, if n.dot(direction) > 0.0 { -n } else { n });
    hits.into_iter().flatten().filter(|(t, _)| *t > 1e-4).min_by(|a, b| a.0.total_cmp(&b.0)).map(towards)
}

fn plane(
    o: DVec3,
    d: DVec3,
    at: DVec3,
    normal: DVec3,
    inside: impl Fn(DVec3) -> bool,
) -> Option<(f64, DVec3)> {
    let t = (at - o).dot(normal) / d.dot(normal);
    (t.is_finite() && t > 0.0 && inside(o + t * d)).then_some((t, normal))
}

fn slabs(o: DVec3, d: DVec3, half: DVec3) -> Option<(f64, DVec3)> {
    let faces = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|n| [n, -n]);
    let hits = faces.filter_map(|n| {
        plane(o, d, n * half, n, |p| p.abs().cmple(half + 1e-9).all()).filter(|_| d.dot(n) < 0.0)
    });
    hits.min_by(|a, b| a.0.total_cmp(&b.0))
}

fn cylinder(o: DVec3, d: DVec3, radius: f64, height: f64) -> Option<(f64, DVec3)> {
    let caps = [DVec3::ZERO, DVec3::Z * height].into_iter().filter_map(|at| {
        let normal = if at.z > 0.0 { DVec3::Z } else { -DVec3::Z };
        plane(o, d, at, normal, |p| p.truncate().length() <= radius).filter(|_| d.dot(normal) < 0.0)
    });
    let (a, b) = (d.truncate().length_squared(), o.truncate().dot(d.truncate()));
    let root = b * b - a * (o.truncate().length_squared() - radius * radius);
    let t = (-b - root.max(0.0).sqrt()) / a;
    let p = o + t * d;
    let side = (root > 0.0 && t > 0.0 && (0.0..=height).contains(&p.z))
        .then(|| (t, (p.truncate() / radius).extend(0.0)));
    caps.chain(side).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Both places where a ray's line meets the surface of revolution of a straight piece of outline.
fn frustum(o: DVec3, d: DVec3, [r0, z0]: [f64; 2], [r1, z1]: [f64; 2]) -> Vec<(f64, DVec3)> {
    if z0 == z1 {
        let (least, most) = (r0.min(r1), r0.max(r1));
        let on = |p: DVec3| (least..=most).contains(&p.truncate().length());
        return plane(o, d, DVec3::Z * z0, DVec3::Z, on).into_iter().collect();
    }
    let k = (r1 - r0) / (z1 - z0);
    let radius = |z: f64| r0 + k * (z - z0);
    let a = d.truncate().length_squared() - k * k * d.z * d.z;
    let b = o.truncate().dot(d.truncate()) - k * radius(o.z) * d.z;
    let c = o.truncate().length_squared() - radius(o.z).powi(2);
    let root = (b * b - a * c).sqrt();
    let ts = [(-b - root) / a, (-b + root) / a];
    let on = |t: f64| (t > 1e-4).then(|| o + t * d).filter(|p| (z0.min(z1)..=z0.max(z1)).contains(&p.z));
    let hit = |t: f64| on(t).map(|p| (t, (p.truncate().normalize().extend(-k)).normalize()));
    ts.into_iter().filter_map(hit).collect()
}
