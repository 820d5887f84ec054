"""What does intensity say of labelled points? `python bench/peers/lidar_labels.py ../shared/data/lidar` (numpy, scipy, mcap-ros2-support; after cargo build --release)

RELLIS: intensity per cell and class, and how well a threshold parts solid (tree, bush, fence, person) from passable (grass), by
measure. 3DRef: what the map holds where glass is labelled. The maps are those of tests/reference/lidar_intensity.py, which the test
suite holds equal to limpid's cell by cell; thresholds are those of testdata/config. Last, RELLIS as limpid itself maps it by each kind of
solidity: `... ../shared/data/lidar solidity` prints that alone."""

import sys
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "reference"))
import lidar_intensity as li

RELLIS = {3: "grass", 4: "tree", 17: "person", 18: "fence", 19: "bush", 23: "concrete", 31: "puddle", 33: "mud"}
SOLID, PASSABLE = [4, 17, 18, 19], [3]
BAND_M, CELL_M, HALF_M = (-1.0, 1.0), 0.2, 20.0


def cosines(xyz):
    """Cosine of incidence by planes fitted to 12 neighbours, at least 0.1."""
    _, near = cKDTree(xyz).query(xyz, 12)
    around = xyz[near] - xyz[near].mean(1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
    beams = xyz / np.linalg.norm(xyz, axis=1, keepdims=True)
    return np.maximum(np.abs((vectors[:, :, 0] * beams).sum(1)), 0.1)


def cells(xyz, labels, band):
    """Cell of each point, and the commonest label of each cell."""
    inside = (np.abs(xyz[:, :2]) < HALF_M).all(1) & (xyz[:, 2] >= band[0]) & (xyz[:, 2] <= band[1])
    index = np.floor((xyz[:, :2] + HALF_M) / CELL_M).astype(int) @ [1, round(2 * HALF_M / CELL_M)]
    _, cell = np.unique(index[inside], return_inverse=True)
    votes = np.zeros((cell.max() + 1, 40), int)
    np.add.at(votes, (cell, labels[inside]), 1)
    return inside, cell, votes.argmax(1)


def best_threshold(value, solid):
    """Threshold with the best balanced accuracy, solid above it or below it, and the ranks' AUC."""
    order = np.argsort(value)
    s, p = solid[order].cumsum() / solid.sum(), (~solid[order]).cumsum() / (~solid).sum()
    above, below = 0.5 * ((1 - s) + p), 0.5 * (s + (1 - p))
    at, up = (above.argmax(), True) if above.max() >= below.max() else (below.argmax(), False)
    ranks = np.empty(len(value))
    ranks[order] = np.arange(1, len(value) + 1)
    auc = (ranks[solid].sum() - solid.sum() * (solid.sum() + 1) / 2) / (solid.sum() * (~solid).sum())
    return value[order][at], up, max(above.max(), below.max()), auc


def rellis(data):
    folder = data / "rellis3d-os1-64-labelled"
    raw = np.fromfile(folder / "000104.bin", "<f4").reshape(-1, 4)
    labels = np.fromfile(folder / "000104.label", "<u4") & 0xFFFF
    hit = np.linalg.norm(raw[:, :3], axis=1) > 0.3
    xyz, intensity, labels = raw[hit, :3].astype(float), raw[hit, 3].astype(float), labels[hit]
    intensity = intensity / np.percentile(intensity, 99)
    distance = np.linalg.norm(xyz, axis=1)
    for band in (BAND_M, (-2.0, 2.0)):
        inside, cell, label = cells(xyz, labels, band)
        count = np.bincount(cell)
        mean = lambda v: np.bincount(cell, np.minimum(v[inside], 20.0)) / count
        measures = {
            "sum / area": np.bincount(cell, np.minimum(intensity[inside], 1.0)) / CELL_M**2,
            "mean": mean(intensity),
            "mean, range^2": mean(intensity * (distance / 5) ** 2),
            "mean, 1/cos": mean(intensity / cosines(xyz)),
            "mean, range^2 and 1/cos": mean(intensity * (distance / 5) ** 2 / cosines(xyz)),
            "returns": count.astype(float),
        }
        print(f"\n### RELLIS, {band[0]} to {band[1]} m about the lidar, cells of {CELL_M} m\n")
        print("| class | cells | returns a cell | range m | " + " | ".join(m for m in list(measures)[:3]) + " |\n" + "|---" * 7 + "|")
        ranges = np.bincount(cell, distance[inside]) / count
        for number, name in RELLIS.items():
            of = label == number
            if of.sum() >= 10:
                medians = [f"{np.median(v[of]):.3f}" for v in list(measures.values())[:3]]
                print(f"| {name} | {of.sum()} | {np.median(count[of]):.0f} | {np.median(ranges[of]):.1f} | " + " | ".join(medians) + " |")
        solid, passable = np.isin(label, SOLID), np.isin(label, PASSABLE)
        if passable.sum() < 10:
            print("\nno grass in this band")
            continue
        print("\n| measure | AUC | best threshold | balanced accuracy | solid found | passable found |\n|---|---|---|---|---|---|")
        both = solid | passable
        for name, value in measures.items():
            limit, up, accuracy, auc = best_threshold(value[both], solid[both])
            called = (value > limit) if up else (value <= limit)
            found = called[solid].mean(), (~called)[passable].mean()
            print(f"| {name} | {auc:.3f} | {'>' if up else '<='} {limit:.3g} | {accuracy:.3f} | {found[0]:.3f} | {found[1]:.3f} |")


def rellis_map(data):
    """Shares of the map's own classes among the cells of each label, by the thresholds of testdata/config/rellis.yaml."""
    recording = next(name for name in li.CASES if name.startswith("rellis"))
    p = li.DEFAULT | li.CASES[recording]
    n = round(p["size"] / p["cell"])
    points = li.first_scan(data / recording)
    folder = data / "rellis3d-os1-64-labelled"
    raw = np.fromfile(folder / "000104.bin", "<f4").reshape(-1, 4)
    hit = np.linalg.norm(raw[:, :3], axis=1) > 0.3
    labels = (np.fromfile(folder / "000104.label", "<u4") & 0xFFFF)[hit].astype(int)
    assert np.allclose(raw[hit, :3], np.stack([points[axis] for axis in "xyz"], 1), atol=1e-5), "the labels are not of these points"
    kinds = li.classify(*li.layers(points, p, n), p, n)[1]
    at = [np.floor(points[axis] / p["cell"]).astype(int) + n // 2 for axis in ("x", "y")]
    inside = (points["z"] >= p["heights"][0]) & (points["z"] <= p["heights"][-1]) & (np.minimum(*at) >= 0) & (np.maximum(*at) < n)
    votes = np.zeros((n * n, 40), int)
    np.add.at(votes, ((at[1] * n + at[0])[inside], labels[inside]), 1)
    label = np.where(votes.sum(1) > 0, votes.argmax(1), -1)
    print(f"\n### RELLIS, the map's classes: Gamma {p['gamma']}, transparent from {p['threshold']}, {p['heights'][0]} to {p['heights'][-1]} m\n")
    print("| class | cells | solid | passable | transparent |\n|---|---|---|---|---|")
    for number, name in RELLIS.items():
        of = label == number
        if of.sum() >= 10:
            shares = [f"{(kinds[of] == kind).mean():.3f}" for kind in (li.SOLID, li.PASSABLE, li.TRANSPARENT)]
            print(f"| {name} | {of.sum()} | " + " | ".join(shares) + " |")


def local_ground(xyz):
    """Height of the ground at each point: the lowest return within 0.5 m, and of these the median within 1.5 m."""
    tree = cKDTree(xyz[:, :2])
    lowest = np.array([xyz[near, 2].min() for near in tree.query_ball_point(xyz[:, :2], 0.5)])
    return np.array([np.median(lowest[near]) for near in tree.query_ball_point(xyz[:, :2], 1.5)])


def mapped(recording, keys, limpid="target/release/limpid"):
    """Classes of the map of a recording's first scan, by rows, and the place of its corner; nothing is inflated."""
    import subprocess, tempfile
    from mcap_ros2.reader import read_ros2_messages
    none = dict(inflation_length_m=0, inflation_padding_cells=0, inflation_side_m=0, inscribed_radius_m=0)
    with tempfile.TemporaryDirectory() as folder:
        config, out = Path(folder) / "config.yaml", Path(folder) / "out.mcap"
        config.write_text("".join(f"{key}: {value}\n" for key, value in (none | keys).items()))
        subprocess.run([limpid, "run", str(recording), "-c", str(config), "-o", str(out)], check=True, capture_output=True)
        grid = next(read_ros2_messages(out, topics=["/limpid/classes"])).ros_msg
        shape = (grid.info.height, grid.info.width)
        return np.array(grid.data, int).reshape(shape), (grid.info.origin.position.x, grid.info.origin.position.y)


def rellis_solidity(data):
    """What is found of labelled cells with at least two returns 0.15 to 2 m above the local ground, by each kind of solidity."""
    folder = data / "rellis3d-os1-64-labelled"
    raw = np.fromfile(folder / "000104.bin", "<f4").reshape(-1, 4)
    hit = np.linalg.norm(raw[:, :3], axis=1) > 0.3
    xyz, labels = raw[hit, :3].astype(float), (np.fromfile(folder / "000104.label", "<u4") & 0xFFFF)[hit].astype(int)
    near = (np.abs(xyz[:, :2]) < HALF_M).all(1)
    xyz, labels = xyz[near], labels[near]
    above = xyz[:, 2] - local_ground(xyz)
    band = (above >= 0.15) & (above <= 2.0)
    side = round(2 * HALF_M / CELL_M)
    cell = np.floor((xyz[:, :2] + HALF_M) / CELL_M).astype(int) @ [1, side]
    votes = np.zeros((side * side, 40), int)
    np.add.at(votes, (cell[band], labels[band]), 1)
    distance = np.bincount(cell[band], np.hypot(xyz[band, 0], xyz[band, 1]), side * side) / np.maximum(votes.sum(1), 1)
    recording = next(folder.glob("*.ply"))
    base = dict(scan_map_size_m=2 * HALF_M, scan_resolution_m=CELL_M, layer_heights_m=[-1.3, 0.0, 0.8], intensity_full_scale=0)
    rules = {"learned": {}, "intensity, gamma 0.3": dict(solidity="intensity", gamma=0.3), "standing": dict(solidity="standing")}
    maps = {name: mapped(recording, base | keys) for name, keys in rules.items()}
    # The other cells have all their returns outside of the map's layers, or on what the map takes for the floor.
    stands = maps["standing"][0].ravel() == 100
    for least in (2, 1):
        label = np.where(votes.sum(1) >= least, votes.argmax(1), -1)
        solid, passable = np.isin(label, SOLID), np.isin(label, PASSABLE)
        print(f"\n### RELLIS as limpid maps it: {(solid | passable).sum()} cells with at least {least} returns 0.15 to 2 m above the local ground\n")
        names = [RELLIS[number] for number in SOLID]
        print("| solidity | solid found | passable found | solid, passable found where `standing` says solid | " + " | ".join(f"{name} solid" for name in names) + " | by range: solid, passable found |")
        print("|---" * (5 + len(names)) + "|")
        for name, (kinds, (x, y)) in maps.items():
            # Unknown and free cells count as not found.
            assert kinds.shape == (side, side) and abs(x + HALF_M) < 0.01 and abs(y + HALF_M) < 0.01
            kinds = kinds.ravel()
            called = np.isin(kinds, (100, 75))
            there = f"{called[solid & stands].mean():.3f} of {(solid & stands).sum()}, {(kinds == 25)[passable & stands].mean():.3f} of {(passable & stands).sum()}"
            of = [f"{called[label == number].mean():.3f} of {(label == number).sum()}" for number in SOLID]
            ranges = [(0, 5), (5, 10), (10, 15), (15, 30)]
            parts = [(distance >= low) & (distance < high) for low, high in ranges]
            far = [f"{low}-{high} m: {called[part & solid].mean():.2f}, {(kinds == 25)[part & passable].mean():.2f}" for (low, high), part in zip(ranges, parts) if (part & solid).any() and (part & passable).any()]
            print(f"| {name} | {called[solid].mean():.3f} | {(kinds[passable] == 25).mean():.3f} | {there} | " + " | ".join(of) + " | " + "; ".join(far) + " |")


def three_d_ref(data, limpid="target/release/limpid"):
    import subprocess, tempfile
    p = li.DEFAULT | li.CASES["3dref-hesai-qt64-dual"]
    n = round(p["size"] / p["cell"])
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([limpid, "points", str(data / "3dref-hesai-qt64-dual"), "-o", folder], check=True, capture_output=True)
        for path in sorted(Path(folder).glob("*.ply")):
            points = li.read_ply(path)
            kinds = li.classify(*li.layers(points, p, n), p, n)[1]
            band = (points["z"] >= p["heights"][0]) & (points["z"] <= p["heights"][-1])
            at = [np.floor(points[axis] / p["cell"]).astype(int) + n // 2 for axis in ("x", "y")]
            inside = band & (np.minimum(*at) >= 0) & (np.maximum(*at) < n)
            cell = (at[1] * n + at[0])[inside]
            glass = np.bincount(cell[points["label"][inside] == 2], minlength=n * n) > 0
            other = (np.bincount(cell[np.isin(points["label"][inside], (1, 3, 4))], minlength=n * n) > 0) & ~glass
            rows.append([glass.sum()] + [(kinds[glass] == k).mean() for k in (li.TRANSPARENT, li.SOLID, li.PASSABLE)]
                        + [other.sum(), (kinds[other] == li.TRANSPARENT).mean(), (kinds[other] == li.SOLID).mean()])
    print(f"\n### 3DRef, Gamma {p['gamma']}, transparent from {p['threshold']}, {p['heights'][0]} to {p['heights'][-1]} m, single scans\n")
    print("| scan | glass cells | transparent | solid | passable | other cells | transparent | solid |\n" + "|---" * 8 + "|")
    for number, row in enumerate([*rows, np.mean(rows, axis=0)]):
        name = number if number < len(rows) else "mean"
        print(f"| {name} | {row[0]:.0f} | {row[1]:.3f} | {row[2]:.3f} | {row[3]:.3f} | {row[4]:.0f} | {row[5]:.3f} | {row[6]:.3f} |")


if __name__ == "__main__":
    if "solidity" not in sys.argv[2:]:
        rellis(Path(sys.argv[1]))
        rellis_map(Path(sys.argv[1]))
        three_d_ref(Path(sys.argv[1]))
    rellis_solidity(Path(sys.argv[1]))
