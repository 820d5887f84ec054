#!/usr/bin/env python3
"""Odometry on the cleaned clouds that `limpid run --glass -o OUT.mcap` writes: kiss-icp in, a TUM trajectory out.

    limpid run RECORDING --glass -o glass.mcap
    python3 bench/peers/odometry.py glass.mcap poses.txt [--topic /limpid/glass/cleaned]
    limpid eval FOLDER --poses poses.txt

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


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mcap")
    parser.add_argument("poses")
    parser.add_argument("--topic", default="/limpid/glass/cleaned")
    arguments = parser.parse_args()
    config = KISSConfig()
    config.data.deskew = False
    config.mapping.voxel_size = 0.25
    odometry = KissICP(config)
    count = 0
    with open(arguments.poses, "w") as out:
        for message in read_ros2_messages(arguments.mcap, topics=[arguments.topic]):
            cloud = message.ros_msg
            odometry.register_frame(points_of(cloud), np.array([]))
            pose = odometry.last_pose
            stamp = f"{cloud.header.stamp.sec}.{cloud.header.stamp.nanosec:09d}"
            numbers = " ".join(f"{value:.9f}" for value in (*pose[:3, 3], *quaternion(pose)))
            out.write(f"{stamp} {numbers}\n")
            count += 1
    print(f"{count} clouds, {arguments.poses} written")


if __name__ == "__main__":
    main()
