#!/usr/bin/env python3
"""Simulated scans as they truly are, what limpid says of them, and the true map beside limpid's: one row a recording.

    limpid sim --family glass --seed N --lidar hdl32e --no-camera --frames 60 -o glass.mcap
    limpid run glass.mcap --glass -o glass-map.mcap
    python3 bench/peers/lidar_scans.py -o scans.png glass.mcap=glass-map.mcap curtain.mcap=curtain-map.mcap

    python3 bench/peers/lidar_scans.py -o drive.png --drive glass.mcap=glass-map.mcap

The last scan is drawn from above; with `--drive` all scans of one drive in the map, as measured and as cleaned for SLAM. With `--glass` in the run its points are coloured by class, and reflections are drawn where the
cleaned cloud puts them; else by the class of their cell. Needs numpy, matplotlib, mcap and mcap-ros2-support.
"""

import argparse
import pathlib

import matplotlib
import numpy as np
from mcap_ros2.reader import read_ros2_messages

matplotlib.use("Agg")
import matplotlib.pyplot as plt

TYPES = {1: "i1", 2: "u1", 3: "<i2", 4: "<u2", 5: "<i4", 6: "<u4", 7: "<f4", 8: "<f8"}
# Flags of a true point: on glass, met by way of a mirror image, met through a pane, can be passed.
GLASS, REFLECTED, BEHIND, PASSABLE = 1, 2, 4, 8
# Values of cells in `/truth/all` and in `/limpid/classes`, and of classes of points.
TRUE_CELLS = {0: "free", 50: "passable", 99: "glass", 100: "solid"}
CELLS = {0: "free", 25: "passable", 50: "inflated", 75: "glass", 100: "solid"}
CLASSES = {0: "left open", 1: "solid", 2: "glass", 3: "reflection", 4: "behind"}
COLORS = {
    "unknown": "#dcdcdc",
    "free": "#ffffff",
    "inflated": "#f3e3c8",
    "solid": "#303030",
    "passable": "#3f9f46",
    "glass": "#00a5c8",
    "reflection": "#d63a2f",
    "behind": "#8e63c7",
    "left open": "#f0a020",
}


def cloud(message):
    """The points of a PointCloud2, by field."""
    fields = message.fields
    kind = np.dtype(
        {
            "names": [field.name for field in fields],
            "formats": [TYPES[field.datatype] for field in fields],
            "offsets": [field.offset for field in fields],
            "itemsize": message.point_step,
        }
    )
    return np.frombuffer(bytes(message.data), kind)


def messages(path, topics):
    """The last message of each topic."""
    return {message.channel.topic: message.ros_msg for message in read_ros2_messages(path, topics=topics)}


def kinds_of_truth(flags):
    """What each point is, by name."""
    kinds = np.full(len(flags), "solid", object)
    kinds[(flags & PASSABLE) != 0] = "passable"
    kinds[(flags & BEHIND) != 0] = "behind"
    kinds[(flags & GLASS) != 0] = "glass"
    kinds[(flags & REFLECTED) != 0] = "reflection"
    return kinds


def kinds_of_cells(points, pose, grid):
    """What the map says of the cell of each point."""
    info, cells = grid.info, np.array(grid.data, np.int16).reshape(grid.info.height, grid.info.width)
    place = np.column_stack([points["x"], points["y"], points["z"]]) @ pose[:3, :3].T + pose[:3, 3]
    at = np.floor((place[:, :2] - [info.origin.position.x, info.origin.position.y]) / info.resolution).astype(int)
    within = ((at >= 0) & (at < [info.width, info.height])).all(1)
    value = np.full(len(points), -1)
    value[within] = cells[at[within, 1], at[within, 0]]
    return np.array([CELLS.get(v, "unknown") for v in value], object)


def pose_of(transform):
    """4x4 of a transform about the vertical and its place."""
    turned, moved = transform.rotation, transform.translation
    yaw = np.arctan2(2 * (turned.w * turned.z + turned.x * turned.y), 1 - 2 * (turned.y**2 + turned.z**2))
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    pose[:3, 3] = moved.x, moved.y, moved.z
    return pose


def draw_points(axes, points, kinds, reach):
    for kind, color in COLORS.items():
        of = kinds == kind
        # The map knows no more of such cells than that they are free: the floor.
        color = "#b9a37a" if kind in ("free", "inflated") else color
        axes.scatter(points["x"][of], points["y"][of], s=0.5, color=color, linewidths=0, rasterized=True)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)


def draw_cells(axes, grid, names, centre, reach):
    info = grid.info
    cells = np.array(grid.data, np.int16).reshape(info.height, info.width)
    image = np.empty((info.height, info.width, 3))
    for value in np.unique(cells):
        image[cells == value] = matplotlib.colors.to_rgb(COLORS[names.get(value, "unknown")])
    low = np.array([info.origin.position.x, info.origin.position.y])
    high = low + info.resolution * np.array([info.width, info.height])
    axes.imshow(image, origin="lower", extent=(low[0], high[0], low[1], high[1]), interpolation="nearest")
    axes.set_facecolor(COLORS["unknown"])
    axes.set_xlim(centre[0] - reach, centre[0] + reach)
    axes.set_ylim(centre[1] - reach, centre[1] + reach)


def row(axes, simulated, mapped, reach):
    truth = messages(simulated, ["/truth/points", "/truth/all", "/velodyne_points", "/points"])
    said = messages(mapped, ["/limpid/classes", "/limpid/glass/points"])
    raw = truth.get("/velodyne_points") or truth["/points"]
    poses = [
        (transform.header.stamp, pose_of(transform.transform))
        for message in read_ros2_messages(simulated, topics=["/tf"])
        for transform in message.ros_msg.transforms
    ]
    stamp = raw.header.stamp
    pose = min(poses, key=lambda pose: abs((pose[0].sec - stamp.sec) * 10**9 + pose[0].nanosec - stamp.nanosec))[1]
    points = cloud(raw)
    draw_points(axes[0], points, kinds_of_truth(cloud(truth["/truth/points"])["flags"]), reach)
    if "/limpid/glass/points" in said:
        labelled = cloud(said["/limpid/glass/points"])
        draw_points(axes[1], labelled, np.array([CLASSES[kind] for kind in labelled["class"]], object), reach)
    else:
        draw_points(axes[1], points, kinds_of_cells(points, pose, said["/limpid/classes"]), reach)
    draw_cells(axes[2], truth["/truth/all"], TRUE_CELLS, pose[:2, 3], reach)
    draw_cells(axes[3], said["/limpid/classes"], CELLS, pose[:2, 3], reach)
    for one in axes:
        one.set_aspect("equal")
        one.set_xticks([])
        one.set_yticks([])
    axes[0].set_ylabel(pathlib.Path(simulated).stem)


def draw_drive(simulated, mapped, output):
    """All scans in the map by true poses: what was measured, by what it is, and what the cleaned cloud keeps of it."""
    poses = {}
    for message in read_ros2_messages(simulated, topics=["/tf"]):
        for transform in message.ros_msg.transforms:
            poses[transform.header.stamp.sec * 10**9 + transform.header.stamp.nanosec] = pose_of(transform.transform)
    stamps = np.array(list(poses))
    figure, axes = plt.subplots(1, 2, figsize=(10, 5))
    flags = {}
    for message in read_ros2_messages(simulated, topics=["/truth/points"]):
        flags[message.ros_msg.header.stamp.sec * 10**9 + message.ros_msg.header.stamp.nanosec] = cloud(message.ros_msg)["flags"]
    for one, path, topic in ((axes[0], simulated, "/velodyne_points"), (axes[1], mapped, "/limpid/glass/cleaned")):
        for number, message in enumerate(read_ros2_messages(path, topics=[topic])):
            stamp = message.ros_msg.header.stamp.sec * 10**9 + message.ros_msg.header.stamp.nanosec
            pose, points = poses[stamps[np.abs(stamps - stamp).argmin()]], cloud(message.ros_msg)
            place = np.column_stack([points["x"], points["y"], points["z"]]) @ pose[:3, :3].T + pose[:3, 3]
            if one is axes[0]:
                kinds = kinds_of_truth(flags[stamp])
            else:
                kinds = np.array([CLASSES[kind] for kind in points["class"]], object)
            for kind in ("solid", "behind", "reflection", "glass"):
                of = kinds == kind
                one.scatter(place[of, 0], place[of, 1], s=0.2, color=COLORS[kind], linewidths=0, rasterized=True)
            one.plot(*pose[:2, 3], "o", ms=2, color="#f0a020")
        one.set_aspect("equal")
        one.set_xticks([])
        one.set_yticks([])
    axes[1].set_xlim(axes[0].get_xlim())
    axes[1].set_ylim(axes[0].get_ylim())
    axes[0].set_title("as measured; red: seen in glass", fontsize=9)
    axes[1].set_title("cleaned; red: mirrored back", fontsize=9)
    figure.tight_layout()
    figure.savefig(output, dpi=90)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="*", metavar="SIMULATED=MAPPED")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--drive", metavar="SIMULATED=MAPPED")
    parser.add_argument("--reach", type=float, default=6.0, help="metres about the lidar")
    arguments = parser.parse_args()
    if arguments.drive:
        draw_drive(*arguments.drive.split("=", 1), arguments.output)
        return
    pairs = [pair.split("=", 1) for pair in arguments.recordings]
    figure, axes = plt.subplots(len(pairs), 4, figsize=(10, 2.55 * len(pairs)), squeeze=False)
    for of, (simulated, mapped) in zip(axes, pairs):
        row(of, simulated, mapped, arguments.reach)
    for one, title in zip(axes[0], ("scan, what it is", "scan, what limpid says", "cells, what they are", "cells, what limpid says")):
        one.set_title(title, fontsize=9)
    legend = [plt.Line2D([], [], marker="s", ls="", color=color, label=name, mec="#999999") for name, color in COLORS.items()]
    figure.legend(handles=legend, loc="lower center", ncols=len(legend), fontsize=7, frameon=False)
    figure.tight_layout(rect=(0, 0.12 / len(pairs), 1, 1), pad=0.4)
    figure.savefig(arguments.output, dpi=90)


if __name__ == "__main__":
    main()
