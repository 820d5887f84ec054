"""Cells hit by three frames of the kitchen recording, in f64, for tests/real.rs.

Run in the repository's root: python3 tests/reference/back_projection.py (needs NumPy only; PNG is read
here). LIMPID_DATA names the folder that holds rgbd/kitchen-tum. Writes testdata/reference/kitchen_hits.json: per frame its stamp,
`sure` (cells with a hit at least 1e-4 m from every edge) and `doubtful` (cells that only points nearer to an edge can hit)."""

import json
import os
import struct
import zlib
from pathlib import Path

import numpy as np

EDGE_M = 1e-4
RESOLUTION_M = 0.05
SIDE = 240
FRAMES = [0, 40, 80]


def read_png16(path):
    data = path.read_bytes()
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack(">IIBB", body[:10])
            assert (depth, colour) == (16, 0) and body[12] == 0
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    lines = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 2 * width)
    out = np.zeros((height, 2 * width), np.uint8)
    above = np.zeros(2 * width, np.int32)
    for row, line in enumerate(lines):
        out[row] = above = unfilter(line[0], line[1:].astype(np.int32), above)
    return out.reshape(height, width, 2).astype(np.uint16) @ np.array([256, 1], np.uint16)


def unfilter(kind, line, above):
    line, above = list(map(int, line)), list(map(int, above))
    for i in range(len(line)):
        left = line[i - 2] if i >= 2 else 0
        corner = above[i - 2] if i >= 2 else 0
        if kind == 1:
            line[i] += left
        elif kind == 2:
            line[i] += above[i]
        elif kind == 3:
            line[i] += (left + above[i]) // 2
        elif kind == 4:
            guess = left + above[i] - corner
            line[i] += min((left, above[i], corner), key=lambda v: abs(guess - v))
        line[i] &= 255
    return np.array(line, np.int32)


def rotation(x, y, z, w):
    x, y, z, w = np.array([x, y, z, w]) / np.linalg.norm([x, y, z, w])
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])


def hits(raw, translation, quaternion):
    """Sure and doubtful cells of the window centred on the camera."""
    v, u = np.nonzero((raw >= 170) & (raw <= 5000))
    depth = raw[v, u] * 0.001
    rays = np.stack([(u - 320.0) / 585.0, (v - 240.0) / 585.0, np.ones_like(depth)])
    corner = (np.floor(translation[:2] / RESOLUTION_M) - SIDE // 2) * RESOLUTION_M
    points = (rotation(*quaternion) @ (rays * depth)).T + translation
    ground = points[:, :2] - corner
    distance = np.hypot(*(points[:, :2] - translation[:2]).T)

    def cells(slack, shift):
        inside = (points[:, 2] >= 0.1 - slack) & (points[:, 2] <= 2.0 + slack) & (distance <= 5.0 + slack)
        cell = np.floor((ground[inside] + shift) / RESOLUTION_M).astype(int)
        cell = cell[((cell >= 0) & (cell < SIDE)).all(axis=1)]
        return set((cell[:, 1] * SIDE + cell[:, 0]).tolist()), inside

    to_edge = np.abs(ground / RESOLUTION_M - np.round(ground / RESOLUTION_M)).min(axis=1) * RESOLUTION_M
    _, inside = cells(-EDGE_M, 0.0)
    cell = np.floor(ground / RESOLUTION_M).astype(int)
    certain = inside & (to_edge > EDGE_M) & ((cell >= 0) & (cell < SIDE)).all(axis=1)
    sure = set((cell[certain, 1] * SIDE + cell[certain, 0]).tolist())
    shifts = [np.array([dx, dy]) for dx in (-EDGE_M, EDGE_M) for dy in (-EDGE_M, EDGE_M)]
    possible = set().union(*(cells(EDGE_M, shift)[0] for shift in shifts))
    return sorted(sure), sorted(possible - sure)


def main():
    folder = Path(os.environ.get("LIMPID_DATA", "../shared/data")) / "rgbd/kitchen-tum"
    poses = [line.split() for line in (folder / "groundtruth.txt").read_text().splitlines() if line[0] != "#"]
    frames = []
    for index in FRAMES:
        stamp, numbers = poses[index][0], np.array(poses[index][1:], float)
        sure, doubtful = hits(read_png16(folder / f"depth/{stamp}.png"), numbers[:3], numbers[3:])
        frames.append({"stamp": stamp, "sure": sure, "doubtful": doubtful})
        print(stamp, len(sure), "sure", len(doubtful), "doubtful")
    Path("testdata/reference/kitchen_hits.json").write_text(json.dumps(frames, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
