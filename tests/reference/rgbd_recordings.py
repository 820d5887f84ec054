"""Figures of the real recordings, read with the reference Python readers (mcap, mcap-ros2-support,
mcap-protobuf-support, numpy, scipy, pillow): `python3 rgbd_recordings.py DATA > ../../testdata/reference/rgbd_recordings.json`.

Per depth image: stamp, hole rate (0 or 65535), sum, and the sum of samples times their number from 1;
per recording: intrinsics and, where tf has them, poses by hand-made composition.
"""

import io
import json
import pathlib
import sys

import numpy as np
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory as Protobuf
from mcap_ros2.decoder import DecoderFactory as Ros2
from PIL import Image
from scipy.spatial.transform import Rotation


def depth_row(stamp_ns, depth):
    """Figures of one depth image, uint16 [height, width]."""
    return {
        "stamp_ns": stamp_ns,
        "size": [int(depth.shape[1]), int(depth.shape[0])],
        "holes": float(np.mean((depth == 0) | (depth == 65535))),
        "sum": int(depth.astype(np.uint64).sum()),
        "checksum": int((np.arange(1, depth.size + 1, dtype=np.uint64) * depth.ravel().astype(np.uint64)).sum()),
    }


def color_row(stamp_ns, rgb):
    """Figures of one colour image, uint8 [height, width, 3]."""
    return {"stamp_ns": stamp_ns, "mean_rgb": [float(x) for x in rgb.reshape(-1, 3).mean(axis=0)]}


def matrix(translation, rotation):
    """4x4 of a translation and a quaternion message."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_quat([rotation.x, rotation.y, rotation.z, rotation.w]).as_matrix()
    out[:3, 3] = [translation.x, translation.y, translation.z]
    return out


def ns(stamp):
    """Nanoseconds of a ROS or protobuf stamp."""
    return stamp.sec * 10**9 + stamp.nanosec if hasattr(stamp, "sec") else stamp.seconds * 10**9 + stamp.nanos


def pixels(message):
    """Decoded pixels of an image message."""
    if hasattr(message, "format"):
        return np.asarray(Image.open(io.BytesIO(bytes(message.data))).convert("RGB"))
    if message.encoding == "rgb8":
        return np.frombuffer(bytes(message.data), np.uint8).reshape(message.height, message.width, 3)
    return np.frombuffer(bytes(message.data), "<u2").reshape(message.height, message.width)


def recording(path, depth_topic, color_topic, info_topic):
    """Figures of one MCAP file."""
    out = {"depth": [], "color": [], "transforms": []}
    with open(path, "rb") as stream:
        for _, channel, _, m in make_reader(stream, decoder_factories=[Ros2(), Protobuf()]).iter_decoded_messages():
            stamp = ns(m.header.stamp) if hasattr(m, "header") else ns(m.timestamp) if hasattr(m, "timestamp") else 0
            if channel.topic == depth_topic:
                out["depth"].append(depth_row(stamp, pixels(m)))
            elif channel.topic == color_topic:
                out["color"].append(color_row(stamp, pixels(m)))
            elif channel.topic == info_topic:
                k = list(m.k) if hasattr(m, "k") else list(m.K)
                out["intrinsics"] = [k[0], k[4], k[2], k[5]]
            elif hasattr(m, "transforms"):
                chain = np.eye(4)
                for t in m.transforms:
                    chain = chain @ matrix(t.transform.translation, t.transform.rotation)
                out["transforms"].append({"stamp_ns": ns(m.transforms[0].header.stamp), "first_from_last": chain.tolist()})
            elif hasattr(m, "parent_frame_id"):
                out["transforms"].append({"stamp_ns": stamp, "first_from_last": matrix(m.translation, m.rotation).tolist()})
    return out


def tum(root):
    """Figures of a TUM folder: depth and camera poses."""
    def lines(name):
        return [line.split() for line in (root / name).read_text().splitlines() if line and line[0] != "#"]

    def nanoseconds(stamp):
        seconds, microseconds = stamp.split(".")
        return int(seconds) * 10**9 + int(microseconds) * 1000

    out = {"depth": [], "transforms": []}
    for stamp, name in lines("depth.txt"):
        out["depth"].append(depth_row(nanoseconds(stamp), np.asarray(Image.open(root / name)).astype(np.uint16)))
    for stamp, *numbers in lines("groundtruth.txt"):
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_quat([float(n) for n in numbers[3:]]).as_matrix()
        pose[:3, 3] = [float(n) for n in numbers[:3]]
        out["transforms"].append({"stamp_ns": nanoseconds(stamp), "first_from_last": pose.tolist()})
    return out


def main(data):
    """All recordings, as JSON on stdout."""
    rgbd = pathlib.Path(data) / "rgbd"
    camera = "/camera/camera"
    json.dump(
        {
            "kitchen": recording(rgbd / "kitchen.mcap", f"{camera}/aligned_depth_to_color/image_raw",
                                 f"{camera}/color/image_raw/compressed", f"{camera}/aligned_depth_to_color/camera_info"),
            "redkitchen": recording(rgbd / "mcap-derived/redkitchen_foxglove_protobuf_lz4.mcap", "/camera/depth/raw",
                                    "/camera/color/compressed", "/camera/calibration"),
            "realsense": recording(rgbd / "mcap-derived/librealsense_d435_unaligned_ros2_cdr.mcap",
                                   f"{camera}/depth/image_rect_raw", f"{camera}/color/image_raw", f"{camera}/depth/camera_info"),
            "kitchen_tum": tum(rgbd / "kitchen-tum"),
        },
        sys.stdout,
        separators=(",", ":"),
    )


if __name__ == "__main__":
    main(sys.argv[1])
