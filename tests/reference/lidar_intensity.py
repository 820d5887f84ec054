"""The lidar path in NumPy, written from the specification (spec 2), for tests/lidar/numpy.rs and bench/peers/lidar.py.

Run in the repository's root after `cargo build --release`, with the recordings at hand:
    python3 tests/reference/lidar_intensity.py ../shared/data/lidar
It writes testdata/reference/lidar_intensity.bin: little endian, per recording the number of cells a side (u32) and of layers (u32),
then per layer the runs of round(value * 65536), then the runs of the classes and of the costs. Runs are a u32 number of them, each a u32 value
and a u16 length. Points come from `limpid points`, whose decoding is checked against other programs elsewhere; geometry is in float32,
as on the GPU, so that points on the border of two cells fall into the same one."""

import math
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

STEPS, SECTORS = 4080, 720
UNKNOWN, FREE, SOLID, PASSABLE, TRANSPARENT, INFLATED = range(6)
F = np.float32
# As the configurations in testdata/config have them; the maps lie in the lidar's own frame.
DEFAULT = dict(size=20.0, cell=0.1, scale=255.0, heights=[-0.5, 0.0, 0.5], gamma=0.5, threshold=0.1, min_returns=1, rings=True,
               length=0.8, side=0.2, padding=1, inscribed=0.1, passable=50, percentile=99.0, measure="mean", kernel="adaptive")
CASES = {
    "vlp16-dual.mcap": dict(scale=100.0, heights=[-0.3, 0.0, 0.6], gamma=0.08, threshold=0.05),
    "3dref-hesai-qt64-dual": dict(heights=[-1.3, 0.0, 0.5], threshold=0.05),
    "rellis3d-os1-64-labelled/frame000104-1581624663_170.ply": dict(
        size=40.0, cell=0.2, scale=0.0, heights=[-1.0, 0.0, 1.0], gamma=0.3, length=1.0, side=0.4),
}


def read_ply(path):
    """Points of a PLY that `limpid points` wrote, as a structured array."""
    head, _, body = Path(path).read_bytes().partition(b"end_header\n")
    types = {"float": "<f4", "ushort": "<u2", "uchar": "u1", "uint": "<u4"}
    lines = [line.split() for line in head.decode().splitlines()]
    count = next(int(w[2]) for w in lines if w[:2] == ["element", "vertex"])
    return np.frombuffer(body, np.dtype([(w[2], types[w[1]]) for w in lines if w[0] == "property"]), count)


def first_scan(recording, limpid="target/release/limpid"):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([limpid, "points", str(recording), "-o", folder, "--limit", "1"], check=True, capture_output=True)
        return read_ply(Path(folder) / "000000.ply")


def plane_rings(points):
    """The ring nearest the horizontal (the upper of two as near) and the one below it."""
    known = points["ring"] != 65535
    elevation = np.arctan2(points["z"].astype(float), np.hypot(points["x"], points["y"]).astype(float))[known]
    rings, counts = np.unique(points["ring"][known], return_counts=True)
    means = [(elevation[points["ring"][known] == ring].mean(), ring) for ring, count in zip(rings, counts) if count >= 8]
    means.sort()
    nearest = min(abs(mean) for mean, _ in means)
    at = max(i for i, (mean, _) in enumerate(means) if abs(mean) <= nearest + 2e-3)
    return means[at][1], means[at - 1][1]


def sectors(x, y):
    length = np.abs(x) + np.abs(y)
    share = np.divide(np.abs(y), length, out=np.zeros_like(length), where=length > 0)
    turn = np.where(x < 0, F(2) - share, share)
    turn = np.where(y < 0, F(4) - turn, turn)
    return np.minimum((turn * F(SECTORS) / F(4)).astype(np.int64), SECTORS - 1)


def layers(points, p, n):
    """Eq. 1-2: fixed-point sums and counts, layer by cell (row = y), and the farthest reach of each sector."""
    cell, heights = F(p["cell"]), [F(h) for h in p["heights"]]
    half = F((n // 2) * p["cell"])
    x, y, z = points["x"] + half, points["y"] + half, points["z"]
    scale = p["scale"] or float(np.sort(points["intensity"])[round(p["percentile"] / 100 * (len(points) - 1))])
    steps = (np.clip(points["intensity"] * F(1 / scale), F(0), F(1)) * F(STEPS) + F(0.5)).astype(np.int64)
    column, row = x / cell, y / cell
    inside = (column >= 0) & (row >= 0) & (column < n) & (row < n)
    index = np.where(inside, row, 0).astype(np.int64) * n + np.where(inside, column, 0).astype(np.int64)
    tall = len(heights) - 1
    masks = [(z >= heights[k]) & ((z < heights[k + 1]) | (z == heights[k + 1]) & (k + 1 == tall)) for k in range(tall)]
    masks += [points["ring"] == ring for ring in plane_rings(points)]
    sums = np.array([np.bincount(index[m & inside], steps[m & inside], n * n) for m in masks]).astype(np.int64)
    counts = np.array([np.bincount(index[m & inside], minlength=n * n) for m in masks])
    seen_x, seen_y = x - half, y - half
    distance = np.sqrt(seen_x * seen_x + seen_y * seen_y)
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.where(z > heights[-1], distance * heights[-1] / z, np.where(z < heights[0], distance * heights[0] / z, distance))
    farthest = np.zeros(SECTORS, np.int64)
    np.maximum.at(farthest, sectors(seen_x, seen_y), (reach * F(1024)).astype(np.int64))
    return sums, counts, farthest


def classify(sums, counts, farthest, p, n):
    """Eq. 3-7 for one scan: values of the layers, class, strength in steps, value."""
    tall = len(p["heights"]) - 1
    if p["measure"] == "sum":
        values, full = sums / STEPS / p["cell"] ** 2, p["cell"] ** -2
    else:
        values, full = sums / STEPS / np.maximum(counts, 1), 1.0
    steps = lambda value: (np.clip(value / full, 0, 1) * STEPS + 0.5).astype(np.int64)
    tallest, plane, below = values[:tall].max(0), values[tall], values[tall + 1]
    returns = np.maximum(counts[:tall].sum(0), counts[tall])
    value = np.maximum(tallest, plane)
    decided = returns >= p["min_returns"]
    solid = decided & (value > p["gamma"])
    excess = np.maximum(plane - below, 0)
    glass = decided & (excess > p["threshold"]) & ~(tallest > p["gamma"])
    centres = (np.arange(n, dtype=F) + F(0.5)) * F(p["cell"]) - F((n // 2) * p["cell"])
    y, x = (grid.ravel() for grid in np.meshgrid(centres, centres, indexing="ij"))
    crossed = farthest[sectors(x, y)] > ((np.sqrt(x * x + y * y) + F(p["cell"])) * F(1024)).astype(np.int64)
    kinds = np.where((returns == 0) & crossed, FREE, UNKNOWN)
    for mask, kind in ((decided, PASSABLE), (glass, TRANSPARENT), (solid, SOLID)):
        kinds[mask] = kind
    strength = np.where(glass, np.maximum(steps(excess), 1), 0)
    strength = np.maximum(strength, np.where(solid, np.maximum(steps(value), 1), 0))
    return values, kinds, strength, np.where(decided, value, 0)


def kernel(p, theta):
    """Eq. 8-9: K over (y, x), one-sided, symmetric or uniform, with the disc; and the part within the inscribed radius."""
    reach = math.ceil(max(p["length"], p["side"], p["inscribed"]) / p["cell"] - 1e-6)
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].astype(float)
    near = 1e-9
    along, across = x * math.cos(theta) + y * math.sin(theta), np.abs(x * math.sin(theta) - y * math.cos(theta))
    box = np.maximum(np.abs(x), np.abs(y)) <= p["length"] / p["cell"] + near
    side = (along <= near) | (p["kernel"] == "symmetric")
    line = box if p["kernel"] == "uniform" else box & side & (across <= p["padding"] + 0.5 + near)
    inscribed = np.hypot(x, y) <= p["inscribed"] / p["cell"] + near
    return line | inscribed | (np.hypot(x, y) <= p["side"] / p["cell"] + near), inscribed


def convolve(image, k):
    """Eq. 10: sum over the kernel, by shifts."""
    n, reach = image.shape[0], k.shape[0] // 2
    padded = np.zeros((n + 2 * reach,) * 2, np.int64)
    for dy, dx in np.argwhere(k) - reach:
        padded[reach + dy : reach + dy + n, reach + dx : reach + dx + n] += image
    return padded[reach : reach + n, reach : reach + n]


def plan(kinds, strength, p, n, theta=0.0):
    """Eq. 11: classes and Nav2 costs."""
    k, inscribed = kernel(p, theta)
    image = strength.reshape(n, n)
    spread = np.minimum(convolve(image, k), STEPS).ravel()
    close = convolve((image > 0).astype(np.int64), inscribed).ravel() > 0
    costs = np.array([255, 0, 254, p["passable"], 254, 0])[kinds]
    cost = np.where(close, 253, 1 + 251 * spread // STEPS)
    near = (spread > 0) & ~np.isin(kinds, (SOLID, TRANSPARENT)) & ((kinds != PASSABLE) | (cost >= p["passable"]))
    near &= (kinds != UNKNOWN) | close
    return np.where(near, INFLATED, kinds), np.where(near, cost, costs)


def scan_to_plan(points, p):
    n = round(p["size"] / p["cell"])
    values, kinds, strength, _ = classify(*layers(points, p, n), p, n)
    return (n, values, *plan(kinds, strength, p, n))


def runs(values):
    flat = np.asarray(values).ravel()
    ends = np.append(np.flatnonzero(np.diff(flat)) + 1, flat.size)
    out, start = [], 0
    for end in ends:
        while start < end:
            length = min(end - start, 65535)
            out.append(struct.pack("<IH", int(flat[start]), length))
            start += length
    return struct.pack("<I", len(out)) + b"".join(out)


def main():
    data = Path(sys.argv[1])
    with open("testdata/reference/lidar_intensity.bin", "wb") as out:
        for name, changes in CASES.items():
            n, values, kinds, costs = scan_to_plan(first_scan(data / name), DEFAULT | changes)
            out.write(struct.pack("<II", n, len(values)))
            for layer in values:
                out.write(runs(np.round(layer * 65536).astype(np.int64)))
            out.write(runs(kinds) + runs(costs))
            print(name, n, np.bincount(kinds, minlength=6))


if __name__ == "__main__":
    main()
