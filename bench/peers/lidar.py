"""The lidar path in NumPy on one scan: `python bench/peers/lidar.py SCAN.ply` (as `limpid points` writes; numpy). Prints table rows.

The sums are those of tests/reference/lidar_intensity.py, which the tests hold equal to limpid's; the convolution is also timed as FFT
where SciPy is there."""

import os
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "reference"))
import lidar_intensity as li

SAMPLES = 30


def timed(name, work):
    wall, cpu = [], []
    for sample in range(SAMPLES + 3):
        start, busy = time.perf_counter(), time.process_time()
        work()
        if sample >= 3:
            wall.append((time.perf_counter() - start) * 1e3)
            cpu.append((time.process_time() - busy) * 1e3)
    print(f"| {name} | {np.median(wall):.3f} | {np.percentile(wall, 95):.3f} | {min(wall):.3f} |")
    print(f"| {name}, CPU time | {np.median(cpu):.3f} | {np.percentile(cpu, 95):.3f} | {min(cpu):.3f} |")


def main():
    points = li.read_ply(sys.argv[1])
    p = li.DEFAULT
    n = round(p["size"] / p["cell"])
    layers = li.layers(points, p, n)
    _, kinds, strength, _ = li.classify(*layers, p, n)
    timed("NumPy: whole scan", lambda: li.plan(*li.classify(*li.layers(points, p, n), p, n)[1:3], p, n))
    timed("NumPy: layers", lambda: li.layers(points, p, n))
    timed("NumPy: inflation and plan", lambda: li.plan(kinds, strength, p, n))
    try:
        from scipy.signal import fftconvolve
    except ImportError:
        return
    k = li.kernel(p, 0.0)[0].astype(float)
    timed("SciPy: the convolution by FFT", lambda: fftconvolve(strength.reshape(n, n).astype(float), k, mode="same"))


if __name__ == "__main__":
    main()
