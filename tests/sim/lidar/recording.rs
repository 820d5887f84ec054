//! Recordings with a lidar: limpid's own readers take them, and a map comes of them.

use limpid::config::Config;
use limpid::sim::lidar::LidarSimulator;
use limpid::sim::truth::TrueMap;
use limpid::sim::write::recorder;
use limpid::sim::{Simulator, Way, poses, stamp_ns};

use super::room_with_lidar;
use crate::support::gpu::{context, skipped};

#[test]
fn scans_of_a_drive_are_read_back_in_their_order_beside_the_camera_s_frames() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive.mcap");
    let mut scene = room_with_lidar();
    scene.trajectory.waypoints_m = vec![[-1.0, 0.0], [0.5, 0.3]];
    scene.trajectory.frames = 7;
    let (mut camera, mut lidar) = (
        Simulator::with_context(&scene, &context()).unwrap(),
        LidarSimulator::with_context(&scene, &context()).unwrap(),
    );
    let (way, mut map) = (Way::of(&scene), TrueMap::new(&scene, &Config::default()));
    let mut file = recorder(&path, &scene, false).unwrap();
    let mut written = Vec::new();
    for (index, pose) in (0_u64..).zip(poses(&scene)) {
        while let Some((scan, end_ns)) = lidar.next_on(&way, stamp_ns(&scene, index)).unwrap() {
            file.write_scan(&scan, end_ns).unwrap();
            written.push(scan.scan);
        }
        let frame = camera.frame(index, pose).unwrap();
        map.observe(&frame, &scene.camera.model());
        file.write(&frame, &map.grid(), &map.cells()).unwrap();
    }
    file.finish().unwrap();
    // 6 periods of 1/30 s, rounded to nanoseconds, end just before the eighth revolution of 1/40 s.
    assert_eq!(written.len(), 7);
    let mut reader = limpid::input::points::open(&path, &limpid::input::points::Options::default()).unwrap();
    for scan in &written {
        let read = reader.next_scan().unwrap().unwrap();
        assert_eq!((read.stamp_ns, &read.frame_id), (scan.stamp_ns, &scan.frame_id));
        assert_eq!(read.points.len(), scan.points.len());
        for (got, want) in read.points.iter().zip(&scan.points) {
            assert_eq!((got.position_m(), got.intensity), (want.position_m(), want.intensity));
            assert_eq!((got.ring, got.time_s, got.return_type), (want.ring, want.time_s, want.return_type));
        }
    }
    assert!(reader.next_scan().unwrap().is_none());
}
