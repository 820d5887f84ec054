"""Draws what `limpid eval --frontier --json` found: obstacles kept against free cells called occupied, a panel a level.

    pip install matplotlib
    python bench/peers/frontier.py train=train.json held-out=held-out.json -o testdata/frontier.png
"""

import argparse
import json
import pathlib

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot

# Markers and names of the methods that stand beside the frontier.
BESIDE = {"naive": ("x", "naive"), "drm_weight": ("s", "drm, the paper's fusion"), "drm_evidence": ("^", "drm, fusion: evidence")}
COLORS = ("tab:blue", "tab:orange")


def frontier(methods):
    """Points by learned_bias, the default at 0."""
    points = {0.0: methods["drm"]}
    points |= {float(key.split(":")[1]): method for key, method in methods.items() if key.startswith("learned_bias")}
    return [(bias, points[bias]["for"], points[bias]["or"]) for bias in sorted(points)]


def draw(panel, name, methods, color):
    points = frontier(methods)
    panel.plot([p[1] for p in points], [p[2] for p in points], "-", color=color, label=f"{name}: learned_bias -2 to 2")
    default = next(p for p in points if p[0] == 0)
    panel.plot(default[1], default[2], "o", color=color, markersize=9, label=f"{name}: drm, the default")
    for key, (marker, label) in BESIDE.items():
        panel.plot(methods[key]["for"], methods[key]["or"], marker, color=color, label=f"{name}: {label}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("evals", nargs="+", metavar="NAME=JSON")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    files = dict(argument.split("=", 1) for argument in arguments.evals)
    levels = {name: json.loads(pathlib.Path(path).read_text())["levels"] for name, path in files.items()}
    names = sorted(set().union(*levels.values()))
    figure, panels = pyplot.subplots(1, len(names), figsize=(2.6 + 4.0 * len(names), 3.6), layout="constrained", squeeze=False)
    for panel, level in zip(panels[0], names):
        for color, (name, of) in zip(COLORS, levels.items()):
            draw(panel, name, of[level], color)
        panel.set(title=level, xlabel="FOR: free cells called occupied", ylim=(None, 1))
        panel.set_xscale("symlog", linthresh=0.02)
        panel.set_xlim(0, 1)
        panel.grid(alpha=0.3)
    panels[0][0].set_ylabel("OR: obstacle cells that are lethal")
    handles, labels = panels[0][-1].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, loc="outside right center")
    figure.savefig(arguments.output, dpi=110)


if __name__ == "__main__":
    main()
