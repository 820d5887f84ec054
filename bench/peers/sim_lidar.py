"""Do simulated scans look like real ones? `python bench/peers/sim_lidar.py ../shared/data/lidar` (numpy, mcap, mcap-ros2-support; after cargo build --release)

3DRef's room with a glass wall (Hesai QT64, first and last return) beside a simulated room of its kind: points by class, second
returns among them, and how far from head on glass is seen. RELLIS (Ouster OS1-64) beside simulated meadows: intensity by class and
returns a cell by range. VLP-16 in dual mode: beams with two returns."""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "reference"))
import lidar_intensity as li

LIMPID = "target/release/limpid"
TYPES = {2: "u1", 4: "<u2", 6: "<u4", 7: "<f4"}
GLASS, REFLECTED, BEHIND, PASSABLE = 1, 2, 4, 8
RANGES_M = [(2, 5), (5, 10), (10, 15), (15, 20)]

# A room of 8 m by 8 m whose side at x = 5 is coated glass (a mirror share of .29) between posts, with a room behind; the sensor is held 1.4 m up.
OFFICE = """
name: office
seed: 1
materials:
  wall: {albedo_ir: 0.6}
  floor: {albedo_ir: 0.3}
  desk: {albedo_ir: 0.45}
  frame: {albedo_ir: 0.2}
  glass: {kind: glass, albedo: [0, 0, 0], albedo_ir: 0.0, reflectance: 0.17, transmission: 0.6}
floor: floor
ceiling: wall
ceiling_m: 2.7
rooms:
  - {min_m: [-3, -4], max_m: [5, 4], walls: wall}
  - {min_m: [5, -4], max_m: [8.5, 4], walls: wall}
boxes:
%s
panes:
%s
trajectory: {waypoints_m: [[0, 0]], frames: 8}
lidar: {model: qt64, returns: first-last, height_m: 1.4, tilt_rad: [0.0, 0.1, 0.0]}
"""


def office():
    posts = [f"  - {{center_m: [5, {y:.2f}, 1.35], size_m: [0.06, 0.06, 2.7], material: frame}}" for y in np.arange(-3.0, 3.1, 2.0)]
    desks = [f"  - {{center_m: [{x}, {y}, 0.37], size_m: [1.6, 0.8, 0.74], material: desk}}" for x, y in [(2, 2.5), (-1.5, -2.5), (-2, 2), (7, 1.5), (7, -2)]]
    panes = [f"  - {{center_m: [5, {y:.2f}, 1.35], width_m: 1.9, height_m: 2.7, yaw_rad: 3.14159, material: glass}}" for y in np.arange(-4.0, 4.1, 2.0)]
    return OFFICE % ("\n".join(posts + desks), "\n".join(panes))


def cloud(message):
    fields = message.fields
    kind = np.dtype(dict(names=[f.name for f in fields], formats=[TYPES[f.datatype] for f in fields], offsets=[f.offset for f in fields],
                         itemsize=message.point_step))
    return np.frombuffer(bytes(message.data), kind)


def simulate(arguments):
    """(points, truth) of every scan of a simulation, and the scene's text."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sim.mcap"
        subprocess.run([LIMPID, "sim", *arguments, "--no-camera", "-o", str(file)], check=True, capture_output=True)
        measured, true, scene = [], [], ""
        with open(file, "rb") as stream:
            for _, channel, _, message in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
                if channel.topic == "/truth/points":
                    true.append(cloud(message))
                elif channel.topic == "/truth/scene":
                    scene = message.data
                elif channel.topic.endswith("points"):
                    measured.append(cloud(message))
    return list(zip(measured, true)), scene


def real_scans(recording):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([LIMPID, "points", str(recording), "-o", folder], check=True, capture_output=True)
        return [li.read_ply(path).copy() for path in sorted(Path(folder).glob("*.ply"))]


def xyz_of(points):
    return np.stack([points[axis].astype(float) for axis in "xyz"], 1)


def glass_rows(classes, second, xyz, normal):
    """Per class its share of the points and the share of second returns in it; the angle within which 95 % of glass is seen."""
    rows = [(name, (classes == name).mean(), second[classes == name].mean() if (classes == name).any() else np.nan)
            for name in ("normal", "glass", "reflection", "behind")]
    at = xyz[classes == "glass"]
    cosine = np.abs(at @ normal) / np.linalg.norm(at, axis=1)
    return rows, np.degrees(np.arccos(np.clip(np.percentile(cosine, 5), 0, 1)))


def fitted_normal(at, rounds=200):
    """Of the plane that most of the points lie in."""
    random, best = np.random.default_rng(1), (0, None)
    for _ in range(rounds):
        a, b, c = at[random.choice(len(at), 3, replace=False)]
        n = np.cross(b - a, c - a)
        if np.linalg.norm(n) < 1e-6:
            continue
        n /= np.linalg.norm(n)
        count = (np.abs((at - a) @ n) < 0.05).sum()
        best = max(best, (count, tuple(n)), key=lambda entry: entry[0])
    return np.array(best[1])


def three_d_ref(data):
    names = {1: "normal", 2: "glass", 5: "reflection", 6: "behind"}
    real = np.concatenate(real_scans(data / "3dref-hesai-qt64-dual"))
    real = real[np.isin(real["label"], list(names))]
    classes = np.array([names[label] for label in real["label"]])
    rows, angle = glass_rows(classes, real["return_type"] == 2, xyz_of(real), fitted_normal(xyz_of(real)[classes == "glass"]))
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as scene:
        scene.write(office())
        scene.flush()
        pairs, _ = simulate([scene.name])
    points, truth = (np.concatenate(side) for side in zip(*pairs))
    flags = truth["flags"]
    kinds = np.select([flags & REFLECTED > 0, flags & GLASS > 0, flags & BEHIND > 0], ["reflection", "glass", "behind"], "normal")
    # 1 first, 2 last, 3 the only one: the second return is the last of two.
    normal = np.array([np.cos(0.1), 0.0, np.sin(0.1)])
    ours, our_angle = glass_rows(kinds, points["return_type"] == 2, xyz_of(points), normal)
    print("\n### 3DRef beside a simulated room with a glass wall, QT64, first and last return\n")
    print("| class | share of points | simulated | second returns | simulated |\n|---|---|---|---|---|")
    for (name, share, second), (_, our_share, our_second) in zip(rows, ours):
        print(f"| {name} | {share:.3f} | {our_share:.3f} | {second:.4f} | {our_second:.4f} |")
    print(f"\nGlass is seen within {angle:.0f} degrees of head on (95 % of its points), simulated {our_angle:.0f}.")


def cell_rows(xyz, intensity, classes):
    """Per class: intensity relative to the scan's 99th percentile (median), and returns a cell of 0.2 m by range (median)."""
    relative = intensity / np.percentile(intensity, 99)
    inside = (np.abs(xyz[:, :2]) < 20).all(1) & (xyz[:, 2] > -1.0) & (xyz[:, 2] < 1.0)
    xyz, relative, classes = xyz[inside], relative[inside], classes[inside]
    cells = np.floor(xyz[:, :2] / 0.2).astype(int)
    _, cell = np.unique(cells, axis=0, return_inverse=True)
    cell = cell.ravel()
    count = np.bincount(cell)
    distance = np.bincount(cell, np.hypot(xyz[:, 0], xyz[:, 1])) / count
    rows = {}
    for name in ("grass", "bush", "trunk or tree"):
        of = np.unique(cell[classes == name])
        if len(of) < 10:
            continue
        by_range = [of[(distance[of] >= low) & (distance[of] < high)] for low, high in RANGES_M]
        rows[name] = [np.median(relative[classes == name])] + [np.median(count[b]) if len(b) >= 5 else np.nan for b in by_range]
    return rows


def rellis(data):
    folder = data / "rellis3d-os1-64-labelled"
    raw = np.fromfile(folder / "000104.bin", "<f4").reshape(-1, 4)
    labels = np.fromfile(folder / "000104.label", "<u4") & 0xFFFF
    hit = np.linalg.norm(raw[:, :3], axis=1) > 0.3
    classes = np.select([labels == 3, labels == 19, labels == 4], ["grass", "bush", "trunk or tree"], "other")[hit]
    real = cell_rows(raw[hit, :3].astype(float), raw[hit, 3].astype(float), classes)
    pooled = {}
    for family in ("vegetation", "thicket"):
        for seed in ("11", "12", "13"):
            pairs, scene = simulate(["--seed", seed, "--family", family, "--lidar", "os1-64", "--frames", "5", "--returns", "strongest"])
            names = sorted(set(materials(scene)))
            points, truth = pairs[0]
            material = np.array([names[m] if m < len(names) else "" for m in truth["material"]])
            kinds = np.select([truth["flags"] & PASSABLE > 0, material == "leaf", material == "bark"], ["grass", "bush", "trunk or tree"], "other")
            for name, row in cell_rows(xyz_of(points), points["intensity"].astype(float), kinds).items():
                pooled.setdefault(name, []).append(row)
    print("\n### RELLIS beside simulated meadows (six, families vegetation and thicket), OS1-64\n")
    head = " | ".join(f"{low}-{high} m" for low, high in RANGES_M)
    print(f"| class | intensity | simulated | returns a cell at {head} | simulated |\n|---|---|---|" + "---|" * len(RANGES_M) + "---|")
    for name, row in real.items():
        ours = np.nanmean(np.array(pooled.get(name, [[np.nan] * 5])), axis=0)
        counts = " | ".join(f"{value:.0f}" for value in row[1:])
        print(f"| {name} | {row[0]:.2f} | {ours[0]:.2f} | {counts} | " + ", ".join(f"{value:.0f}" for value in ours[1:]) + " |")


def materials(scene):
    """Names of the scene's materials: the keys of its first mapping."""
    inside, names = False, []
    for line in scene.splitlines():
        if line.startswith("materials:"):
            inside = True
        elif inside and line.startswith("  ") and not line.startswith("   ") and line.endswith(":"):
            names.append(line.strip()[:-1].strip("'\""))
        elif inside and not line.startswith(" "):
            break
    return names


def dual(data):
    real = np.concatenate(real_scans(data / "vlp16-dual.mcap"))
    shares = {}
    for name, family in (("a room", "train"), ("glass", "glass"), ("plants", "thicket")):
        pairs, _ = simulate(["--seed", "21", "--family", family, "--lidar", "vlp16", "--frames", "5"])
        types = pairs[0][0]["return_type"]
        shares[name] = (types == 2).sum() / (types != 4).sum()
    beams = (real["return_type"] != 4).sum()
    print("\n### VLP-16 in dual mode: beams with two returns\n")
    print("| recording | simulated: " + " | ".join(shares) + " |\n|---" + "|---" * len(shares) + "|")
    print(f"| {(real['return_type'] == 2).sum() / beams:.3f} | " + " | ".join(f"{share:.3f}" for share in shares.values()) + " |")


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    three_d_ref(folder)
    rellis(folder)
    dual(folder)
