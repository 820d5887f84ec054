"""Nav2's inflation by SciPy's exact distance transform, for tests/stage/inflate.rs.

Run in the repository's root: python3 tests/reference/inflation.py (NumPy and SciPy). Writes testdata/reference/inflation.bin,
little endian: the 240x240 grid (0 free, 1 occupied, 2 unknown), a u32 number of cases, and per case four f64 (resolution, radius,
inscribed radius, cost scaling factor) and the costs. Grids are runs: a u32 number of them, each a u8 value and a u16 length."""

import struct

import numpy as np
from scipy.ndimage import distance_transform_edt

SIDE = 240
CASES = [
    # resolution, radius, inscribed radius, cost scaling factor
    (0.05, 0.55, 0.10, 10.0),
    (0.05, 0.55, 0.22, 3.0),
    (0.10, 0.55, 0.10, 1.0),
    (0.05, 1.20, 0.0, 2.5),
    (0.03, 0.07, 0.07, 10.0),
    (0.05, 0.0, 0.0, 10.0),
]


def costs(grid, resolution, radius, inscribed, factor):
    distance = distance_transform_edt(grid != 1)
    metres = distance * resolution
    cost = (252.0 * np.exp(-factor * (metres - inscribed))).astype(np.int64)
    cost = np.where(metres <= inscribed, 253, cost)
    cost = np.where(distance == 0, 254, cost)
    cost = np.where(distance <= np.ceil(radius / resolution - 1e-6), cost, 0)
    return np.where((grid == 2) & (cost < 253), 255, cost).astype(np.uint8)


def runs(values):
    flat = values.ravel()
    ends = np.flatnonzero(np.diff(flat)) + 1
    starts = np.concatenate([[0], ends])
    lengths = np.diff(np.concatenate([starts, [flat.size]]))
    pairs = []
    for start, length in zip(starts, lengths):
        while length > 0:
            pairs.append(struct.pack("<BH", flat[start], min(length, 65535)))
            length -= min(length, 65535)
    return struct.pack("<I", len(pairs)) + b"".join(pairs)


def main():
    random = np.random.default_rng(7)
    grid = np.zeros((SIDE, SIDE), np.uint8)
    grid[60:140, 90:200] = 2
    grid[random.random((SIDE, SIDE)) < 0.002] = 1
    grid[20, 30:90] = 1
    grid[200:220, 0] = 1
    grid[239, 239] = 1
    grid[100, 150] = 1
    with open("testdata/reference/inflation.bin", "wb") as out:
        out.write(runs(grid))
        out.write(struct.pack("<I", len(CASES)))
        for case in CASES:
            out.write(struct.pack("<4d", *case))
            out.write(runs(costs(grid, *case)))


if __name__ == "__main__":
    main()
