"""Trains map reliability (spec 1 §9) on cells that `limpid targets --map` wrote, and exports it as limpid loads it.

    pip install numpy safetensors
    python weights/train_map.py cells/*/*.safetensors --validate validation/*/*.safetensors -o weights/map-reliability.safetensors

Sixteen units of tanh on the inputs, and a weight for each; the same seed and cells give the same file on the same machine. A true
obstacle weighs 1 (under severe glare, where phantoms are many and false rates have room, `--glare`). A free cell weighs what it costs the map when it is called an obstacle: the truly free cells that inflation would
block around it (`blocks`), so that a cell right before a wall costs little and one in a passage much; cells that people come into or leave weigh CHANGING times as much. `--shift` moves the threshold
after training; `limpid eval --frontier` with `learned_weights: FILE` shows what the map makes of it."""

import argparse
import pathlib

import numpy as np
from safetensors import safe_open
from safetensors.numpy import load_file

from perceptron import fit, write

# Free cells that a false obstacle blocks for a weight of 1, and what one that blocks none weighs.
BLOCKED_FOR_ONE = 20.0
LEAST_WEIGHT = 0.05
# How much more cells weigh that people come into and leave: they are few.
CHANGING = 8.0


class Cells:
    """The columns of cell files, one after the other; recordings by name."""

    def __init__(self, paths):
        files = [(load_file(path), metadata(path)) for path in paths]
        self.names = files[0][1]["inputs"]
        self.x = np.concatenate([columns["inputs"] for columns, _ in files]).astype(np.float64)
        self.solid = np.concatenate([columns["solid"] for columns, _ in files]).astype(float)
        self.changes = np.concatenate([columns["changes"] for columns, _ in files]) > 0
        self.blocks = np.concatenate([columns["blocks"] for columns, _ in files]).astype(float)
        self.recording = np.concatenate([np.array(meta["recordings"].split(","))[columns["recording"]] for columns, meta in files])

    def level(self):
        """Glare level in the recording's name, where there is one."""
        return np.array([next((part for part in name.split("-") if part in ("L0", "L1", "L2")), "?") for name in self.recording])

    def weight(self, glare):
        solid = np.where(self.level() == "L2", glare, 1.0)
        return np.where(self.solid > 0, solid, LEAST_WEIGHT + self.blocks / BLOCKED_FOR_ONE) * np.where(self.changes, CHANGING, 1.0)


def metadata(path):
    with safe_open(path, "np") as file:
        return file.metadata()


def logit(model, cells):
    """What a model makes of cells: an obstacle from 0 on."""
    inner = model["inner"].astype(np.float64)
    return np.tanh(cells.x @ inner[:, :-1].T + inner[:, -1]) @ model["outer"].astype(np.float64) + float(model["bias"][0])


def table(cells, value, biases):
    """Of the judged cells, by level: obstacles found, and cells blocked by false obstacles a thousand judged cells."""
    level = cells.level()
    print("| bias | " + " | ".join(f"{name} found, blocked" for name in sorted(set(level))) + " |")
    print("|---" * (1 + len(set(level))) + "|")
    for bias in biases:
        called = value + bias >= 0
        of = [(called[level == name], cells.solid[level == name] > 0, cells.blocks[level == name]) for name in sorted(set(level))]
        row = [f"{c[s].mean():.3f}, {1000 * (b * c)[~s].sum() / len(s) / 100:.2f}" for c, s, b in of]
        print(f"| {bias:+.2f} | " + " | ".join(row) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cells", nargs="+", type=pathlib.Path)
    parser.add_argument("--validate", nargs="+", type=pathlib.Path, default=[])
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--hidden", type=int, default=16)
    parser.add_argument("--steps", type=int, default=8000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--glare", type=float, default=1.0, help="weight of obstacles under severe glare (L2)")
    parser.add_argument("--shift", type=float, default=0.0, help="added to the bias that training came to")
    parser.add_argument("--release", type=float, default=0.5, help="how far under 0 an obstacle is given up")
    arguments = parser.parse_args()
    cells = Cells(arguments.cells)
    model = fit(cells.x, cells.solid, cells.weight(arguments.glare), arguments.hidden, arguments.steps, arguments.seed, batch=4096, rate=4e-3)
    model["bias"] = model["bias"] + arguments.shift
    recordings = len(set(cells.recording))
    print(f"{len(cells.solid)} cells of {recordings} recordings, {int(cells.solid.sum())} solid")
    if arguments.validate:
        check = Cells(arguments.validate)
        table(check, logit(model, check), (-2, -1, -0.5, 0, 0.5, 1, 2))
    metadata = {
        "format": "map-reliability",
        "inputs": cells.names,
        "release": str(arguments.release),
        "origin": f"trained by weights/train_map.py on {len(cells.solid)} cells of {recordings} simulated recordings",
    }
    write(model, arguments.output, metadata)


if __name__ == "__main__":
    main()
