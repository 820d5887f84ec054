"""How do other programs fare on the same frames? python bench/peers/costmap.py RECORDING_DIR [--frames N] [--limpid BINARY]

RECORDING_DIR is a TUM folder (depth.txt, groundtruth.txt, camera.yaml). Each peer takes metric depth and a pose and
puts one frame into a map; decoding is not counted. Peers and limpid (method range: no network, as in the peers) run in
rounds, one process each for limpid.

  numpy   back-projection and counts per cell, no clearing, no costs (numpy, scipy)
  numpy+edt   the same with Nav2's costs by scipy's exact distance transform
  octomap   insertPointCloud of every pixel, 0.05 m, 5 m range (the package pyoctomap, where it is installed)
"""
import argparse, json, os, pathlib, re, statistics, subprocess, tempfile, time

import numpy as np
from PIL import Image
from scipy.ndimage import distance_transform_edt
from scipy.spatial.transform import Rotation

CELL, SIDE, BAND, RANGE = 0.05, 240, (0.1, 2.0), 5.0


def frames(folder, count):
    text = (folder / "camera.yaml").read_text()
    fx, _, cx, _, fy, cy = [float(x) for x in re.search(r"data: \[(.*?)\]", text).group(1).split(",")[:6]]
    poses = {line.split()[0]: [float(x) for x in line.split()[1:]] for line in (folder / "groundtruth.txt").read_text().splitlines() if line[0] != "#"}
    for line in [l for l in (folder / "depth.txt").read_text().splitlines() if l[0] != "#"][:count]:
        stamp, name = line.split()
        raw = np.asarray(Image.open(folder / name)).astype(np.float32)
        depth = np.where((raw > 0) & (raw < 65535), raw * 0.001, 0)
        pose = poses[stamp]
        yield depth, (fx, fy, cx, cy), Rotation.from_quat(pose[3:]).as_matrix(), np.array(pose[:3])


def points(frame):
    depth, (fx, fy, cx, cy), rotation, origin = frame
    v, u = np.nonzero((depth >= 0.17) & (depth <= RANGE))
    d = depth[v, u]
    return np.stack([(u - cx) / fx * d, (v - cy) / fy * d, d], 1) @ rotation.T + origin


RAYS = {}


def rays(shape, camera):
    if (shape, camera) not in RAYS:
        fx, fy, cx, cy = camera
        v, u = np.mgrid[: shape[0], : shape[1]].astype(np.float32)
        RAYS[shape, camera] = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones_like(u)]).reshape(3, -1)
    return RAYS[shape, camera]


def counts(frame):
    depth, camera, rotation, origin = frame
    d = depth.ravel()
    x, y, z = rotation.astype(np.float32) @ rays(depth.shape, camera) * d
    z += np.float32(origin[2])
    hit = (d >= 0.17) & (d <= RANGE) & (z >= BAND[0]) & (z <= BAND[1])
    x, y = x[hit], y[hit]
    near = x * x + y * y <= RANGE * RANGE
    corner = origin[:2] - (np.floor(origin[:2] / CELL) - SIDE // 2) * CELL
    column = ((x[near] + np.float32(corner[0])) / CELL).astype(np.int32)
    row = ((y[near] + np.float32(corner[1])) / CELL).astype(np.int32)
    return np.bincount(row * SIDE + column, minlength=SIDE * SIDE)


def costs(frame):
    distance = distance_transform_edt((counts(frame) == 0).reshape(SIDE, SIDE)) * CELL
    cost = np.where(distance <= 0.1, 253, (252 * np.exp(-10 * (distance - 0.1))).astype(np.uint8))
    return np.where(distance == 0, 254, np.where(distance <= 0.55, cost, 0))


def octomap_peer():
    import pyoctomap
    tree = pyoctomap.OcTree(CELL)
    return lambda frame: tree.insertPointCloud(points(frame).astype(np.float64), frame[3].astype(np.float64), RANGE)


def timed(run, data):
    wall, cpu = [], []
    for frame in data:
        w, c = time.perf_counter(), time.process_time()
        run(frame)
        wall.append((time.perf_counter() - w) * 1e3)
        cpu.append((time.process_time() - c) * 1e3)
    return wall, cpu


def limpid(binary, folder, count):
    with tempfile.TemporaryDirectory() as scratch:
        out = os.path.join(scratch, "bench.json")
        subprocess.run([binary, "bench", str(folder), "--method", "range", "--samples", str(count), "--json", out], check=True, capture_output=True)
        report = json.load(open(out))
    return report["wall"]["median_ms"], report["cpu"]["median_ms"], report["adapter"], report["method"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--frames", type=int, default=50)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--limpid", default="target/release/limpid")
    options = parser.parse_args()
    data = list(frames(options.folder, options.frames))
    peers = {"numpy": counts, "numpy+edt": costs}
    try:
        peers["octomap"] = octomap_peer()
    except ImportError as error:
        print(f"octomap: not run ({error})")
    results = {name: ([], []) for name in peers}
    ours = []
    for _ in range(options.rounds):
        ours.append(limpid(options.limpid, options.folder, options.frames))
        for name, run in peers.items():
            for into, samples in zip(results[name], timed(run, data)):
                into.extend(samples)
    print(f"{len(data)} frames, {options.rounds} rounds, load {os.getloadavg()[0]:.1f}, {ours[0][2]}\n")
    print("| | wall median ms | CPU median ms |\n|---|---|---|")
    print(f"| limpid ({ours[0][3]}, clearing, costs) | {statistics.median(o[0] for o in ours):.1f} | {statistics.median(o[1] for o in ours):.1f} |")
    for name, (wall, cpu) in results.items():
        print(f"| {name} | {statistics.median(wall):.1f} | {statistics.median(cpu):.1f} |")


main()
