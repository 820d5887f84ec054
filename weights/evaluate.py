"""Scores weights of DRM-Net pixel by pixel, beside predictors that need no network.

    pip install numpy scipy torch safetensors scikit-learn OpenEXR pillow
    python weights/evaluate.py weights/drm-net.safetensors --samples VALIDATION... [--cleargrasp ../shared/data/rgbd/cleargrasp-d435]
    python weights/evaluate.py weights/drm-net.safetensors --compare INPUT.safetensors OUTPUT.safetensors

A pixel with depth is bad where the depth is off: in samples by more than delta of the true depth (at the network's size), in ClearGrasp
by more than 1 cm of the opaque reference (at the native size). AUPRC is for finding bad pixels; F1 is the best of all thresholds for
every predictor, and for the network also that of R <= 0.3. `--compare` says how far the output of
`limpid net --weights W --input INPUT -o OUTPUT` is from PyTorch's.
"""

import argparse
import json
import pathlib

import numpy as np
import torch
from safetensors import safe_open
from scipy import ndimage
from sklearn.metrics import average_precision_score, precision_recall_curve
from torch.nn import functional as F

TAU = 0.3
NAMES = ["R of the network", "depth", "local variance", "depth gradient", "nearness of a hole"]


class Network:
    """A weight file run by PyTorch, layer by layer as its metadata says."""

    def __init__(self, path):
        with safe_open(path, "pt") as file:
            self.blocks = json.loads(file.metadata()["architecture"])
            self.tensors = {name: file.get_tensor(name) for name in file.keys()}

    def conv(self, now, prefix, stride=1, groups=1):
        weight, bias = self.tensors[f"{prefix}.weight"], self.tensors[f"{prefix}.bias"]
        return F.conv2d(now, weight, bias, stride, weight.shape[-1] // 2, groups=groups)

    def __call__(self, now):
        kept = {}
        for block in self.blocks:
            name = block["name"]
            if block.get("upsample", 1) == 2:
                now = F.interpolate(now, scale_factor=2, mode="bilinear", align_corners=False)
            if "skip" in block:
                now = torch.cat([now, kept[block["skip"]]], 1)
            if block["op"] == "separable":
                now = F.relu(self.conv(now, f"{name}.dw", block["stride"], block["in"]))
                now = F.relu(self.conv(now, f"{name}.pw"))
            elif block["op"] == "conv3x3":
                now = F.relu(self.conv(now, name, block["stride"]))
            else:
                now = torch.sigmoid(self.conv(now, name))
            kept[name] = now
        return now


def cheap(depth):
    """Depth, variance in 5x5 and greatest step to a neighbour over valid pixels, nearness of a hole."""
    valid = depth > 0
    count = ndimage.uniform_filter(valid.astype(np.float64), 5, mode="constant") * 25
    sums = [ndimage.uniform_filter(depth.astype(np.float64) ** k, 5, mode="constant") * 25 for k in (1, 2)]
    mean, square = (part / np.maximum(count, 1) for part in sums)
    variance = np.maximum(square - mean**2, 0)
    step = np.zeros_like(depth)
    for axis in (0, 1):
        for shift in (-1, 1):
            beside = np.roll(depth, shift, axis)
            edge = [slice(None)] * 2
            edge[axis] = 0 if shift == 1 else -1
            beside[tuple(edge)] = 0
            step = np.maximum(step, np.where((beside > 0) & valid, np.abs(depth - beside), 0))
    hole = np.pad(valid, 1, constant_values=True)
    distance = ndimage.distance_transform_edt(hole)[1:-1, 1:-1] if not valid.all() else np.full(depth.shape, 1e3)
    return [depth, variance, step, -distance]


def table(title, pairs):
    """Prints AUPRC and F1 of each predictor; `pairs` are (scores of each predictor, bad) of the pixels of every image."""
    bad = np.concatenate([bad for _, bad in pairs])
    print(f"\n{title}: {len(bad)} pixels with depth, {100 * bad.mean():.1f} % bad")
    if not bad.any() or bad.all():
        print("nothing to tell apart")
        return
    print("| predictor | AUPRC | best F1 |\n|---|---|---|")
    for index, name in enumerate(NAMES):
        score = np.concatenate([scores[index] for scores, _ in pairs])
        precision, recall, _ = precision_recall_curve(bad, score)
        best = (2 * precision * recall / np.maximum(precision + recall, 1e-9)).max()
        print(f"| {name} | {average_precision_score(bad, score):.3f} | {best:.3f} |")
    reliability = 1 - np.concatenate([scores[0] for scores, _ in pairs])
    called = reliability <= TAU
    hit = (called & bad).sum()
    print(f"R <= {TAU}: F1 {2 * hit / max(called.sum() + bad.sum(), 1):.3f}, "
          f"{100 * hit / bad.sum():.1f} % of the bad refused, {100 * (called & ~bad).sum() / (~bad).sum():.1f} % of the good")
    print(f"mean R: good {reliability[~bad].mean():.3f}, bad {reliability[bad].mean():.3f}; "
          f"R > 0.9 on {100 * (reliability[~bad] > 0.9).mean():.1f} % of the good")


def of_samples(net, paths):
    levels = {}
    for path in sorted(paths):
        with safe_open(path, "np") as file:
            inputs, true_depth, good = (file.get_tensor(name) for name in ("input", "true_depth_m", "true_binary"))
        for image, truth, fine in zip(inputs, true_depth, good):
            with torch.no_grad():
                reliability = net(torch.from_numpy(image[None]))[0, 0].numpy()
            depth = image[3] * 10
            scored = (depth > 0) & (truth > 0)
            scores = [plane[scored] for plane in [1 - reliability] + cheap(depth)]
            levels.setdefault(pathlib.Path(path).stem.split("-")[0], []).append((scores, fine[scored] == 0))
    for level, pairs in sorted(levels.items()):
        table(f"{level}, {len(pairs)} frames", pairs)


def exr(path):
    import Imath
    import OpenEXR

    file = OpenEXR.InputFile(str(path))
    window = file.header()["dataWindow"]
    shape = (window.max.y - window.min.y + 1, window.max.x - window.min.x + 1)
    plane = np.frombuffer(file.channel("R", Imath.PixelType(Imath.PixelType.FLOAT)), np.float32).reshape(shape)
    return np.where(np.isfinite(plane) & (plane >= 0.17) & (plane <= 10), plane, 0)


def resize(color, depth):
    """The network's input from 1280x720: colour by mean, depth by the nearest valid sample of 4x3, no frame before."""
    rows, columns = 240, 320
    mean = color.reshape(rows, 3, columns, 4, 3).mean((1, 3)).transpose(2, 0, 1)
    cells = depth.reshape(rows, 3, columns, 4).transpose(0, 2, 1, 3).reshape(rows, columns, 12)
    order = np.argsort([(y - 1) ** 2 + (x - 1.5) ** 2 for y in range(3) for x in range(4)], kind="stable")
    sorted_cells = cells[..., order]
    nearest = np.take_along_axis(sorted_cells, (sorted_cells > 0).argmax(-1)[..., None], -1)[..., 0]
    return np.concatenate([mean, nearest[None] / 10, np.zeros((1, rows, columns))]).astype(np.float32)


def of_cleargrasp(net, folder):
    from PIL import Image

    pairs = []
    for path in sorted(pathlib.Path(folder).glob("*-transparent-depth-img.exr")):
        name = path.name.split("-")[0]
        depth, reference = exr(path), exr(path.with_name(f"{name}-opaque-depth-img.exr"))
        color = np.asarray(Image.open(path.with_name(f"{name}-transparent-rgb-img.jpg")), np.float32) / 255
        with torch.no_grad():
            low = net(torch.from_numpy(resize(color, depth)[None]))
            reliability = F.interpolate(low, depth.shape, mode="bilinear", align_corners=False)[0, 0].numpy()
        scored = (depth > 0) & (reference > 0)
        scores = [plane[scored] for plane in [1 - reliability] + cheap(depth)]
        pairs.append((scores, np.abs(depth - reference)[scored] > 0.01))
        table(f"ClearGrasp {name}", pairs[-1:])
    table("ClearGrasp, all", pairs)


def compare(net, input_path, output_path):
    with safe_open(input_path, "pt") as file, safe_open(output_path, "pt") as given:
        with torch.no_grad():
            difference = (net(file.get_tensor("input")) - given.get_tensor("output")).abs()
    print(f"largest difference {difference.max():.2e}, mean {difference.mean():.2e}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("weights")
    parser.add_argument("--samples", nargs="*", default=[])
    parser.add_argument("--cleargrasp")
    parser.add_argument("--compare", nargs=2, metavar=("INPUT", "OUTPUT"))
    arguments = parser.parse_args()
    net = Network(arguments.weights)
    if arguments.compare:
        compare(net, *arguments.compare)
    of_samples(net, arguments.samples)
    if arguments.cleargrasp:
        of_cleargrasp(net, arguments.cleargrasp)


if __name__ == "__main__":
    main()
