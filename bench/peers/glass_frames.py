#!/usr/bin/env python3
"""Scores of `limpid eval` on labelled scans and on the same scans turned, mirrored and cut: do the rules hold elsewhere?

    python bench/peers/glass_frames.py LIMPID FOLDER [POSES]

FOLDER holds ASCII PLY files with the columns x, y, z, ring, return and label, as the 3DRef frames; POSES lines of
`t x y z qx qy qz qw`. With POSES panes are kept from scan to scan, else every scan is labelled by itself. Needs NumPy.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

# Labels of what holds a pane: normal and other reflective surfaces.
HOLDERS = (1, 4)


def read_ply(path):
    lines = path.read_text().splitlines()
    end = lines.index("end_header")
    names = [line.split()[-1] for line in lines[:end] if line.startswith("property")]
    rows = np.array([line.split() for line in lines[end + 1 :] if line.strip()], dtype=float)
    return lines[:end], names, rows


def write_ply(path, head, names, rows):
    head = [f"element vertex {len(rows)}" if line.startswith("element vertex") else line for line in head]
    whole = ("ring", "return", "label", "intensity")
    kinds = [("%d" if name in whole and (rows[:, k] % 1 == 0).all() else "%.6f") for k, name in enumerate(names)]
    with path.open("w") as file:
        file.write("\n".join([*head, "end_header"]) + "\n")
        np.savetxt(file, rows, fmt=kinds)


def plane_of_glass(points):
    """Least-squares plane of the points labelled glass, twice, the second time of those within 0.2 m."""
    for _ in range(2):
        centre = points.mean(0)
        normal = np.linalg.svd(points - centre, full_matrices=False)[2][2]
        points = points[abs((points - centre) @ normal) < 0.2]
    return normal, normal @ centre


def turn(angle_deg):
    cos, sin = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def changed(names, rows, change):
    places = [names.index(axis) for axis in "xyz"]
    label = rows[:, names.index("label")]
    points = rows[:, places]
    if change == "cut":
        normal, distance = plane_of_glass(points[label == 2])
        rows = rows[~((abs(points @ normal - distance) < 1.0) & np.isin(label, HOLDERS))]
        return rows
    if change == "sector":
        centre = points[label == 2].mean(0)
        apart = np.arctan2(points[:, 1], points[:, 0]) - np.arctan2(centre[1], centre[0])
        return rows[abs((apart + np.pi) % (2 * np.pi) - np.pi) < np.radians(100)]
    rows = rows.copy()
    if change == "mirrored":
        points = points * [1.0, -1.0, 1.0]
    elif change != "as is":
        points = points @ turn(float(change)).T
    rows[:, places] = points
    return rows


def product(a, b):
    """Of quaternions x, y, z, w."""
    v = a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])
    return np.array([*v, a[3] * b[3] - a[:3] @ b[:3]])


def changed_pose(pose, change):
    pose = pose.copy()
    if change == "mirrored":
        pose[[2, 4, 6]] *= -1.0  # y, and the turns about x and z
    elif change not in ("as is", "cut", "sector"):
        half = np.radians(-float(change)) / 2
        pose[4:] = product(pose[4:], np.array([0.0, 0.0, np.sin(half), np.cos(half)]))
    return pose


def scores(limpid, folder, change, poses, work):
    for path in sorted(Path(folder).glob("*.ply")):
        head, names, rows = read_ply(path)
        write_ply(work / path.name, head, names, changed(names, rows, change))
    out = work / "scores.json"
    command = [limpid, "eval", str(work), "--json", str(out)]
    if poses is None:
        command += ["--memory", "off"]
    else:
        np.savetxt(work / "poses.txt", [changed_pose(pose, change) for pose in poses], fmt="%.9f")
        command += ["--poses", str(work / "poses.txt")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return json.loads(out.read_text())


def row(name, figures):
    ious = [figures["classes"][kind]["iou"] for kind in ("inside", "glass", "reflection", "outside")]
    rest = [figures[key] for key in ("reflections_left", "normal_lost", "mirrored_within_0_2_m")]
    cells = [f"{value:.3f}" for value in ious] + [f"{value:.4f}" for value in rest[:2]] + [f"{rest[2]:.3f}"]
    panes = f" {figures['panes']:.2f} |" if "panes" in figures else " |"
    print(f"| {name} | " + " | ".join(cells) + f" |{panes}", flush=True)


def main():
    limpid, folder = sys.argv[1:3]
    poses = np.loadtxt(sys.argv[3]) if len(sys.argv) > 3 else None
    print("| | inside | glass | reflection | outside | left | lost | mirrored | panes |\n|---|---|---|---|---|---|---|---|---|")
    names = {
        "as is": "as is",
        "37": "turned by 37 degrees",
        "180.2": "turned by 180.2 degrees",
        "mirrored": "mirrored",
        "cut": "walls and frames within 1 m of the plane cut away",
        "sector": "only the 200 degrees towards the pane",
    }
    for change, name in names.items():
        with tempfile.TemporaryDirectory() as work:
            figures = scores(limpid, folder, change, poses, Path(work))
        row(name, figures)
        if change == "as is":
            baseline = figures["baseline"]
    row("baseline, as is", baseline)


if __name__ == "__main__":
    main()
