//! Panes and mirrors: the patch met head on, what lies behind, mirrored rooms.

use std::f64::consts::PI;

use limpid::sim::Scene;
use limpid::sim::scene::Pane;

use super::{in_map, pairs, robot, room_with_lidar, scan_of};
use crate::support::gpu::skipped;

/// The small room with an upright sheet across it at x = 1.5, facing the robot.
fn with_sheet(material: &str) -> Scene {
    let mut scene = room_with_lidar();
    scene.panes.push(Pane {
        center_m: [1.5, 0.0, 1.25],
        width_m: 4.0,
        height_m: 2.5,
        yaw_rad: PI,
        material: material.into(),
    });
    scene
}

#[test]
fn truth_glass_is_seen_head_on_alone_and_what_lies_behind_everywhere() {
    if skipped() {
        return;
    }
    let scene = with_sheet("glass");
    let scan = scan_of(&scene);
    let (mut widest_deg, mut behind): (f64, u32) = (0.0, 0);
    for (point, truth) in pairs(&scan) {
        let at = in_map(&scene, robot(0.0, 0.0, 0.0), point);
        if truth.is_glass() {
            assert!((at.x - 1.5).abs() < 0.1, "{at}");
            let direction = glam::Vec3::from_array(point.position_m()).as_dvec3().normalize();
            widest_deg = widest_deg.max(direction.x.acos().to_degrees());
        }
        if truth.is_behind() && !truth.is_reflection() {
            behind += 1;
            // Range noise of 15 mm.
            assert!(at.x > 1.44, "{at}");
        }
    }
    assert!((16.0..36.0).contains(&widest_deg), "{widest_deg}");
    assert!(behind > 1000, "{behind}");
}

#[test]
fn truth_reflections_lie_as_far_behind_the_pane_as_what_they_show_before_it() {
    if skipped() {
        return;
    }
    for (material, least) in [("glass", 100), ("mirror", 1000)] {
        let scene = with_sheet(material);
        let scan = scan_of(&scene);
        let mut mirrored = 0;
        // Nearer to the pane than a pulse, their echo and the pane's own are one.
        let apart = |truth: &limpid::sim::lidar::PointTruth| truth.is_reflection() && truth.place_m.x < 0.3;
        for (point, truth) in pairs(&scan).filter(|(_, truth)| apart(truth)) {
            let at = in_map(&scene, robot(0.0, 0.0, 0.0), point);
            mirrored += 1;
            let back = glam::DVec3::new(3.0 - at.x, at.y, at.z);
            assert!(back.distance(truth.place_m) < 0.3, "{material}: {at} {truth:?}");
        }
        assert!(mirrored > least, "{material}: {mirrored}");
        let behind = pairs(&scan).filter(|(_, truth)| truth.is_behind()).count();
        assert_eq!(behind > 0, material == "glass", "nothing shines through a mirror");
    }
}
