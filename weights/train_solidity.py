"""Trains learned solidity (spec 6 §3) on cells that `limpid targets --solidity` wrote, and exports it as limpid loads it.

    pip install numpy safetensors
    python weights/train_solidity.py cells/*.safetensors --validate validation/*.safetensors -o weights/lidar-solidity.safetensors

Eight units of tanh on the inputs, and a weight for each; the same seed and cells give the same file on the same machine.
Solid and passable cells weigh as much as each other, with and without intensities. Cells of mirror images are left out, and so are
those that hold both kinds of thing; glass counts as solid. Two thresholds are chosen on the validation cells, for clouds with
intensities and without: the one at which `--solid` of the solid cells are found. They go into the biases.

    python weights/train_solidity.py --score TEST... [--beside NAME=TEST...] --weights weights/lidar-solidity.safetensors

prints what is found of the cells of a file by kind, range and sensor; `--beside` the same of the class that the map gave them."""

import argparse
import pathlib

import numpy as np
from safetensors import safe_open
from safetensors.numpy import load_file

from perceptron import fit, write

SOLID, PASSABLE, GLASS, IMAGE, EDGE = range(5)
PASSABLE_CLASS, FREE_CLASS, UNKNOWN_CLASS = 3, 1, 0


class Cells:
    """The columns of cell files, one after the other, materials by name."""

    def __init__(self, paths):
        files = [(load_file(path), metadata(path)) for path in paths]
        self.meta = files[0][1]
        for name in ("inputs", "label", "class", "family", "sensor", "bright", "seed", "scan", "points", "range_m", "resolution_m"):
            setattr(self, "kind" if name == "class" else name, np.concatenate([columns[name] for columns, _ in files]))
        names = [np.array(meta["materials"].split(","))[columns["material"]] for columns, meta in files]
        self.material = np.concatenate(names)
        self.x = self.inputs.astype(np.float64)
        self.names = self.meta["inputs"].split(",")

    def input(self, name):
        return self.x[:, self.names.index(name)]

    def judged(self):
        """Cells that count: solid or passable, with at least two returns."""
        return (self.label != IMAGE) & (self.label != GLASS) & (self.points >= 2)


def metadata(path):
    with safe_open(path, "np") as file:
        return file.metadata()


def weigh(cells, chosen):
    """Solid and passable alike in each of: with intensities, without."""
    weight = np.zeros(len(cells.label))
    solid = cells.label != PASSABLE
    for part in (solid & (cells.bright == 0), solid & (cells.bright == 1), ~solid & (cells.bright == 0), ~solid & (cells.bright == 1)):
        part &= chosen
        weight[part] = 0.25 / max(part.sum(), 1)
    # Of what is solid rare materials count for more: posts and legs of furniture beside walls and leaves.
    names, number, count = np.unique(cells.material, return_inverse=True, return_counts=True)
    rare = np.where(solid, np.sqrt(count.max() / count[number]), 1.0)
    for bright in (0, 1):
        part = chosen & solid & (cells.bright == bright)
        weight[part] *= rare[part] / rare[part].mean()
    return weight * chosen.sum()


def logit(model, cells):
    """What a model makes of cells: solid from 0 on."""
    inner = model["inner"].astype(np.float64)
    units = np.tanh(cells.x @ inner[:, :-1].T + inner[:, -1])
    known = (cells.input("contrast_known") > 0.5).astype(int)
    return units @ model["outer"].astype(np.float64) + model["bias"].astype(np.float64)[known]


def enough(cells, least):
    return 2.0 ** cells.input("returns_around") - 1 >= least - 0.5


def is_sheet(cells):
    """As in shaders/solidity/judge.wgsl."""
    thin = (cells.input("least_spread_around") < 0.3) & (cells.input("span_around") > 0.5)
    return thin & (cells.input("went_on_around") < 0.6)


def lay_thresholds(cells, model, least, solid_found):
    """The model with the biases at which so many solid cells are found with intensities and without."""
    value, solid = logit(model, cells), (cells.label == SOLID) | (cells.label == EDGE)
    known = cells.input("contrast_known") > 0.5
    bias = model["bias"].copy()
    for number, found in ((0, solid_found[1]), (1, solid_found[0])):
        of = (known == bool(number)) & solid & cells.judged()
        # Cells with too little around them are solid anyway.
        values = np.sort(np.where(enough(cells, least), value, np.inf)[of])
        bias[number] -= values[int((1 - found) * len(values))]
    return model | {"bias": bias}


def auc(value, solid):
    ranks = np.empty(len(value))
    ranks[np.argsort(value, kind="stable")] = np.arange(1, len(value) + 1)
    s, p = solid.sum(), (~solid).sum()
    return (ranks[solid].sum() - s * (s + 1) / 2) / max(s * p, 1)


def share(called, of):
    return f"{called[of].mean():.3f} of {of.sum()}" if of.sum() else "none"


def rows(cells):
    """Names and cells of the rows of a table."""
    yield "all", np.ones(len(cells.label), bool)
    yield "with intensities", cells.bright == 1
    yield "without intensities", cells.bright == 0
    for number, name in enumerate(cells.meta["sensors"].split(",")):
        yield name, cells.sensor == number
    for low, high in ((0, 3), (3, 6), (6, 10), (10, 40)):
        yield f"{low} to {high} m", (cells.range_m >= low) & (cells.range_m < high)
    for size in (0.1, 0.15, 0.2):
        yield f"cells of {size} m", np.abs(cells.resolution_m - size) < 1e-3
    for number, name in enumerate(cells.meta["families"].split(",")):
        yield name, cells.family == number


def table(title, cells, passable):
    """What is found, and of what."""
    print(f"\n### {title}\n\n| | solid found | passable found |\n|---|---|---|")
    judged, solid, grass = cells.judged(), np.isin(cells.label, (SOLID, EDGE)), cells.label == PASSABLE
    for name, part in rows(cells):
        if (part & judged).sum() >= 50:
            print(f"| {name} | {share(~passable, part & judged & solid)} | {share(passable, part & judged & grass)} |")
    print(f"| solid alone in its cell | {share(~passable, judged & (cells.label == SOLID))} | |")
    print(f"| with what is passable before it | {share(~passable, judged & (cells.label == EDGE))} | |")
    print(f"| cells of one return too | {share(~passable, solid)} | {share(passable, grass)} |")
    print(f"| glass | {share(~passable, cells.label == GLASS)} | |")
    print("\n| material | solid called solid | passable called passable |\n|---|---|---|")
    for name in sorted(set(cells.material)):
        of = judged & (cells.material == name)
        if (of & (solid | grass)).sum() >= 50:
            print(f"| {name} | {share(~passable, of & solid)} | {share(passable, of & grass)} |")


def by_model(cells, path):
    """Whether the model of a weight file calls each cell passable."""
    return (logit(load_file(path), cells) < 0) & ~is_sheet(cells) & enough(cells, int(metadata(path)["least_returns"]))


def train(arguments):
    cells = Cells(arguments.cells)
    chosen = cells.judged() & (cells.label != EDGE)
    chosen |= (cells.label == GLASS) & (cells.points >= 2)
    weight = weigh(cells, chosen)[chosen]
    solid = (cells.label != PASSABLE)[chosen].astype(float)
    model = fit(cells.x[chosen], solid, weight, arguments.hidden, arguments.steps, arguments.seed, batch=2048, rate=3e-3)
    model["bias"] = np.repeat(model["bias"], 2)
    print(f"{chosen.sum()} cells of {len(set(cells.seed))} scenes, {int(solid.sum())} solid")
    check = Cells(arguments.validate)
    of = check.judged()
    print(f"validation: AUC {auc(logit(model, check)[of], (check.label != PASSABLE)[of]):.4f}")
    model = lay_thresholds(check, model, arguments.least_returns, arguments.solid)
    origin = f"trained by weights/train_solidity.py on {chosen.sum()} cells of {len(set(cells.seed))} simulated scenes"
    metadata = {"format": "lidar-solidity", "inputs": cells.meta["inputs"], "least_returns": str(arguments.least_returns), "origin": origin}
    write(model, arguments.output, metadata)
    table("validation", check, by_model(check, arguments.output))


def score(arguments):
    cells = Cells(arguments.score)
    table("learned", cells, by_model(cells, arguments.weights))
    table("learned, as the map calls them", cells, cells.kind == PASSABLE_CLASS)
    for beside in arguments.beside:
        name, _, path = beside.partition("=")
        other = Cells([path])
        table(name, other, other.kind == PASSABLE_CLASS)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("cells", nargs="*", type=pathlib.Path)
    parser.add_argument("--validate", nargs="+", type=pathlib.Path, default=[])
    parser.add_argument("-o", "--output", type=pathlib.Path)
    parser.add_argument("--hidden", type=int, default=8)
    parser.add_argument("--steps", type=int, default=20000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--least-returns", type=int, default=4)
    parser.add_argument("--solid", type=float, nargs=2, default=(0.977, 0.98), help="of the solid cells, with intensities and without")
    parser.add_argument("--score", nargs="+", type=pathlib.Path)
    parser.add_argument("--beside", nargs="+", default=[], metavar="NAME=FILE")
    parser.add_argument("--weights", type=pathlib.Path)
    arguments = parser.parse_args()
    score(arguments) if arguments.score else train(arguments)


if __name__ == "__main__":
    main()
