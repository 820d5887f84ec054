//! A robot that drives a curve through the analytic living room, and the recording of it.

use std::io::Cursor;
use std::path::Path;

use glam::{DQuat, DVec3};
use image::codecs::jpeg::JpegEncoder;
use limpid::base::Rigid;
use limpid::message::ros2::{CameraInfo, CompressedImage, Header, Image, TFMessage, TransformStamped};
use limpid::output::RosFile;
use limpid::sensor::{CameraModel, Distortion};

use super::room::Room;

pub(crate) const FRAMES: u64 = 30;
/// Stamp of the first transform; the first image is 5 ms later.
pub(crate) const START_NS: u64 = 1_700_000_000_000_000_000;
const FRAME_PERIOD_NS: u64 = 100_000_000;
const TRANSFORM_PERIOD_NS: u64 = 33_333_333;
const IMAGE_DELAY_NS: u64 = 5_000_000;
const OPTICAL_FRAME: &str = "camera_color_optical_frame";
const SPEED_M_PER_S: f64 = 0.6;
const YAW_RATE_RAD_PER_S: f64 = 0.5;
const START_YAW_RAD: f64 = 0.3;
const PITCH_DOWN_RAD: f64 = 0.2;

/// 160x120, 57 degrees wide, no distortion.
pub(crate) fn camera() -> CameraModel {
    CameraModel {
        width: 160,
        height: 120,
        fx: 146.0,
        fy: 146.0,
        cx: 79.5,
        cy: 59.5,
        distortion: Distortion::None,
    }
}

/// Stamp of image `index`, nanoseconds.
pub(crate) fn image_stamp_ns(index: u64) -> u64 {
    START_NS + IMAGE_DELAY_NS + index * FRAME_PERIOD_NS
}

/// The robot's pose on its arc.
pub(crate) fn map_from_base(stamp_ns: u64) -> Rigid {
    #[expect(clippy::cast_precision_loss, reason = "a few seconds in nanoseconds")]
    let seconds = (stamp_ns - START_NS) as f64 * 1e-9;
    let radius_m = SPEED_M_PER_S / YAW_RATE_RAD_PER_S;
    let yaw = START_YAW_RAD + YAW_RATE_RAD_PER_S * seconds;
    Rigid {
        rotation: DQuat::from_rotation_z(yaw),
        translation_m: DVec3::new(
            -1.8 + radius_m * (yaw.sin() - START_YAW_RAD.sin()),
            -1.2 + radius_m * (START_YAW_RAD.cos() - yaw.cos()),
            0.0,
        ),
    }
}

/// 0.6 m above the ground, pitched down; axes of an optical frame (REP 103).
pub(crate) fn base_from_camera() -> Rigid {
    let optical = DQuat::from_xyzw(-0.5, 0.5, -0.5, 0.5);
    Rigid {
        rotation: DQuat::from_rotation_y(PITCH_DOWN_RAD) * optical,
        translation_m: DVec3::new(0.15, 0.0, 0.6),
    }
}

pub(crate) fn map_from_camera(stamp_ns: u64) -> Rigid {
    map_from_base(stamp_ns).then(base_from_camera())
}

/// Depth in whole millimetres.
pub(crate) fn millimetres(depth_m: &[f32]) -> Vec<u16> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the room is smaller than 65 m"
    )]
    depth_m.iter().map(|&d| (f64::from(d) * 1000.0).round() as u16).collect()
}

/// The bytes of `testdata/room.mcap`.
pub(crate) fn recording() -> Vec<u8> {
    let mut file = RosFile::new(Cursor::new(Vec::new()), Path::new("room.mcap")).unwrap();
    write_mount(&mut file);
    let mut transforms = (0..).map(|i| START_NS + i * TRANSFORM_PERIOD_NS).peekable();
    for index in 0..FRAMES {
        let stamp_ns = image_stamp_ns(index);
        // One transform past the image, so that its pose can be interpolated.
        while let Some(due) = transforms.next_if(|&stamp| stamp < stamp_ns + TRANSFORM_PERIOD_NS) {
            write_pose(&mut file, due);
        }
        write_images(&mut file, stamp_ns);
    }
    file.finish().unwrap().unwrap().into_inner()
}

type MemoryFile = RosFile<Cursor<Vec<u8>>>;

fn edge(stamp_ns: u64, parent: &str, child: &str, pose: Rigid) -> TFMessage {
    let header = Header::new(stamp_ns, parent);
    TFMessage {
        transforms: vec![TransformStamped { header, child_frame_id: child.into(), transform: pose.into() }],
    }
}

fn write_mount(file: &mut MemoryFile) {
    let message = edge(START_NS, "base_link", OPTICAL_FRAME, base_from_camera());
    file.write("/tf_static", START_NS, &message).unwrap();
}

fn write_pose(file: &mut MemoryFile, stamp_ns: u64) {
    file.write("/tf", stamp_ns, &edge(stamp_ns, "map", "base_link", map_from_base(stamp_ns))).unwrap();
}

fn write_images(file: &mut MemoryFile, stamp_ns: u64) {
    let (room, camera) = (Room::living_room(), camera());
    let header = Header::new(stamp_ns, OPTICAL_FRAME);
    let info = CameraInfo::new(header.clone(), &camera);

    let mut jpeg = Vec::new();
    let (depth_m, rgb) = room.view(&camera, map_from_camera(stamp_ns));
    JpegEncoder::new_with_quality(&mut jpeg, 90)
        .encode(&rgb, camera.width, camera.height, image::ExtendedColorType::Rgb8)
        .unwrap();
    let color =
        CompressedImage { header: header.clone(), format: "rgb8; jpeg compressed bgr8".into(), data: jpeg };
    file.write("/camera/camera/color/camera_info", stamp_ns, &info).unwrap();
    file.write("/camera/camera/color/image_raw/compressed", stamp_ns, &color).unwrap();

    let depth = Image {
        header,
        height: camera.height,
        width: camera.width,
        encoding: "16UC1".into(),
        is_bigendian: 0,
        step: 2 * camera.width,
        data: millimetres(&depth_m).into_iter().flat_map(u16::to_le_bytes).collect(),
    };
    file.write("/camera/camera/aligned_depth_to_color/camera_info", stamp_ns, &info).unwrap();
    file.write("/camera/camera/aligned_depth_to_color/image_raw", stamp_ns, &depth).unwrap();
}
