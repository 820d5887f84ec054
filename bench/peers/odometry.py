#!/usr/bin/env python3
"""Odometry on the cleaned clouds that `limpid run --glass -o OUT.mcap` writes: kiss-icp in, a TUM trajectory out.

    limpid run RECORDING --glass -o glass.mcap
    python3 bench/peers/odometry.py glass.mcap poses.txt [--topic /limpid/glass/cleaned]
    limpid eval FOLDER --poses poses.txt

With `--truth RECORDING`, one of `limpid sim`, the errors of place against its transforms are printed, from the first cloud on.

Needs the packages kiss-icp, mcap and mcap-ros2-support.
"""

import argparse

import numpy as np
from kiss_icp.config import KISSConfig
from kiss_icp.kiss_icp import KissICP
from mcap_ros2.reader import read_ros2_messages


def points_of(cloud):
    """x, y, z of a PointCloud2 whose first fields are these, as float32."""
    raw = np.frombuffer(bytes(cloud.data), np.uint8).reshape(cloud.width * cloud.height, cloud.point_step)
    return raw[:, :12].copy().view("<f4").astype(np.float64)


def quaternion(m):
    """x, y, z, w of a rotation matrix."""
    w = np.sqrt(max(0.0, 1.0 + m[0, 0] + m[1, 1] + m[2, 2])) / 2
    x, y, z = (
        np.copysign(np.sqrt(max(0.0, 1.0 + s)) / 2, d)
        for s, d in (
            (m[0, 0] - m[1, 1] - m[2, 2], m[2, 1] - m[1, 2]),
            (m[1, 1] - m[0, 0] - m[2, 2], m[0, 2] - m[2, 0]),
            (m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]),
        )
    )
    return x, y, z, w


def true_places(recording, frame):
    """Stamps in seconds and rigid 4x4 poses of a sensor's frame in the map, by the transforms of a simulated recording."""
    static, moving = {}, []
    for message in read_ros2_messages(recording, topics=["/tf", "/tf_static"]):
        for transform in message.ros_msg.transforms:
            moved, turned = transform.transform.translation, transform.transform.rotation
            pose = rigid((moved.x, moved.y, moved.z), (turned.x, turned.y, turned.z, turned.w))
            if message.channel.topic == "/tf_static":
                static[transform.child_frame_id] = pose
            else:
                moving.append((seconds(transform.header.stamp), pose))
    return [(stamp, pose @ static[frame]) for stamp, pose in moving]


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


def rigid(place, turned):
    x, y, z, w = turned
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = place
    return pose


def errors(poses, truth):
    """Distances of places, each from the first cloud on, and how far the sensor went; metres."""
    stamps = np.array([stamp for stamp, _ in truth])
    true = [truth[np.abs(stamps - stamp).argmin()][1] for stamp, _ in poses]
    off = [
        (np.linalg.inv(poses[0][1]) @ pose)[:3, 3] - (np.linalg.inv(true[0]) @ at)[:3, 3] for (_, pose), at in zip(poses, true)
    ]
    went = sum(np.linalg.norm(b[:3, 3] - a[:3, 3]) for a, b in zip(true, true[1:]))
    return np.linalg.norm(off, axis=1), went


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mcap")
    parser.add_argument("poses")
    parser.add_argument("--topic", default="/limpid/glass/cleaned")
    parser.add_argument("--truth")
    arguments = parser.parse_args()
    config = KISSConfig()
    config.data.deskew = False
    config.mapping.voxel_size = 0.25
    odometry = KissICP(config)
    poses = []
    with open(arguments.poses, "w") as out:
        for message in read_ros2_messages(arguments.mcap, topics=[arguments.topic]):
            cloud = message.ros_msg
            odometry.register_frame(points_of(cloud), np.array([]))
            pose = odometry.last_pose
            stamp = f"{cloud.header.stamp.sec}.{cloud.header.stamp.nanosec:09d}"
            numbers = " ".join(f"{value:.9f}" for value in (*pose[:3, 3], *quaternion(pose)))
            out.write(f"{stamp} {numbers}\n")
            poses.append((seconds(cloud.header.stamp), pose.copy()))
            frame = cloud.header.frame_id
    print(f"{len(poses)} clouds, {arguments.poses} written")
    if arguments.truth:
        off, went = errors(poses, true_places(arguments.truth, frame))
        print(f"{went:.2f} m of way; off by {np.sqrt((off**2).mean()):.3f} m (root mean square), {off[-1]:.3f} m at the end")


if __name__ == "__main__":
    main()
