"""Trains DRM-Net (spec 1 §1, §2) on samples that `limpid targets` wrote, and exports it as limpid loads it.

    pip install numpy torch safetensors scikit-learn
    python weights/train.py SAMPLES... -o weights/drm-net.safetensors [--validate SAMPLES...] [--reference true|measured]

The loss is the mean of |R - target| over pixels with a reference (`--loss bce`: their cross entropy, for comparison). Batch norm
follows every convolution but the head's, and is folded into scale and bias at export. The same seed, samples and thread count give
the same file on the same CPU. What is exported is a running average of the weights; an interrupt (Ctrl-C) ends training early
and exports what there is.
"""

import argparse
import copy
import json
import math
import os
import pathlib
import signal
import time

import numpy as np
import torch
from safetensors import safe_open
from safetensors.numpy import save
from torch import nn
from torch.nn import functional as F

from export import in_order

DEPTH_SCALE_M = 10.0
ROWS, COLUMNS = 240, 320
INSERTED = 0.7  # evidence from which a cell counts as occupied (spec 1 §3)
FIRST_FRAMES = 0.15  # share of crops that are shown as a recording's first frame


def logit(probability):
    return math.log(probability / (1 - probability))


def down(name, inputs, outputs):
    return {"name": name, "op": "separable", "in": inputs, "out": outputs, "stride": 2}


def up(name, inputs, outputs, skip):
    return {"name": name, "op": "separable", "in": inputs, "out": outputs, "stride": 1, "upsample": 2, "skip": skip}


ARCHITECTURE = [
    {"name": "stem", "op": "conv3x3", "in": 5, "out": 16, "stride": 1},
    down("enc1", 16, 32),
    down("enc2", 32, 64),
    down("enc3", 64, 96),
    down("enc4", 96, 128),
    up("dec3", 128 + 96, 96, "enc3"),
    up("dec2", 96 + 64, 64, "enc2"),
    up("dec1", 64 + 32, 32, "enc1"),
    up("dec0", 32 + 16, 16, "stem"),
    {"name": "head", "op": "conv1x1", "in": 16, "out": 1, "stride": 1, "activation": "sigmoid"},
]


def doubled(image, dim):
    """Twice as long along `dim`: bilinear without aligned corners, of sums alone, whose gradient is the same in every run."""
    size = image.shape[dim]
    before = torch.cat([image.narrow(dim, 0, 1), image.narrow(dim, 0, size - 1)], dim)
    behind = torch.cat([image.narrow(dim, 1, size - 1), image.narrow(dim, size - 1, 1)], dim)
    pairs = torch.stack([0.75 * image + 0.25 * before, 0.75 * image + 0.25 * behind], dim + 1)
    return pairs.flatten(dim, dim + 1)


class DrmNet(nn.Module):
    """The network as the layer list says; `convs` holds (convolution, batch norm) by the prefix of their tensors."""

    def __init__(self, architecture):
        super().__init__()
        self.architecture = architecture
        self.convs = nn.ModuleDict()
        for block in architecture:
            name, inputs, outputs, stride = (block[key] for key in ("name", "in", "out", "stride"))
            if block["op"] == "separable":
                self.add(f"{name}.dw", inputs, inputs, 3, stride, inputs)
                self.add(f"{name}.pw", inputs, outputs, 1, 1, 1)
            elif block["op"] == "conv3x3":
                self.add(name, inputs, outputs, 3, stride, 1)
            else:
                self.convs[name] = nn.Conv2d(inputs, outputs, 1)

    def add(self, prefix, inputs, outputs, kernel, stride, groups):
        conv = nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, groups=groups, bias=False)
        nn.init.kaiming_normal_(conv.weight, mode="fan_in", nonlinearity="relu")
        self.convs[prefix.replace(".", "_")] = nn.Sequential(conv, nn.BatchNorm2d(outputs), nn.ReLU(inplace=True))

    def forward(self, now):
        """1 x 5 x rows x columns to logits of 1 x 1 x rows x columns."""
        kept = {}
        for block in self.architecture:
            name = block["name"]
            if block.get("upsample", 1) == 2:
                now = doubled(doubled(now, 2), 3)
            if "skip" in block:
                now = torch.cat([now, kept[block["skip"]]], 1)
            if block["op"] == "separable":
                now = self.convs[f"{name}_pw"](self.convs[f"{name}_dw"](now))
            else:
                now = self.convs[name](now)
            kept[name] = now
        return now

    def folded(self, sharpen, at):
        """Weights and biases by name, batch norm folded in; the head's logit is scaled by `sharpen`, and R is INSERTED where it was `at`."""
        tensors = {}
        for key, module in self.convs.items():
            prefix = key.replace("_", ".")
            if isinstance(module, nn.Conv2d):
                weight, bias = module.weight, module.bias
            else:
                conv, norm = module[0], module[1]
                scale = norm.weight.double() / torch.sqrt(norm.running_var.double() + norm.eps)
                weight = conv.weight.double() * scale[:, None, None, None]
                bias = norm.bias.double() - norm.running_mean.double() * scale
            tensors[f"{prefix}.weight"] = weight.detach().float().cpu().numpy().copy()
            tensors[f"{prefix}.bias"] = bias.detach().float().cpu().numpy().copy()
        tensors["head.weight"] *= np.float32(sharpen)
        tensors["head.bias"] *= np.float32(sharpen)
        tensors["head.bias"] += np.float32(logit(INSERTED) - sharpen * logit(at))
        return tensors


    def unfold(self, path, batches):
        """Takes on the weights of a file, as they were before it was sharpened; batch norm gets the statistics of `batches` and the scale
        that undoes them."""
        with safe_open(path, "pt", str(self.convs["head"].weight.device)) as file:
            tensors = {name: file.get_tensor(name) for name in file.keys()}
            before = json.loads(file.metadata().get("training", "{}"))
        sharpen, at = before.get("sharpen", 1.0), before.get("at", INSERTED)
        tensors["head.bias"] = (tensors["head.bias"] - (logit(INSERTED) - sharpen * logit(at))) / sharpen
        tensors["head.weight"] = tensors["head.weight"] / sharpen
        hooks = []
        for key, module in self.convs.items():
            prefix = key.replace("_", ".")
            conv = module if isinstance(module, nn.Conv2d) else module[0]
            wanted = tensors[f"{prefix}.weight"]
            if conv.weight.shape != wanted.shape:
                raise SystemExit(f"{path}: `{prefix}.weight` is {list(wanted.shape)}, the network's {list(conv.weight.shape)}")
            conv.weight.data.copy_(wanted)
            if conv is module:
                conv.bias.data.copy_(tensors[f"{prefix}.bias"])
            else:
                hooks.append(conv.register_forward_hook(restoring(module[1], tensors[f"{prefix}.bias"])))
        self.eval()
        with torch.no_grad():
            self(batches.contiguous(memory_format=torch.channels_last))
        for hook in hooks:
            hook.remove()
        self.train()


def restoring(norm, bias):
    """A hook behind a convolution: sets its batch norm so that it adds `bias` to what now comes and no more."""

    def hook(_module, _inputs, output):
        variance, mean = torch.var_mean(output, (0, 2, 3))
        norm.running_mean.copy_(mean)
        norm.running_var.copy_(variance)
        norm.weight.data.copy_(torch.sqrt(variance + norm.eps))
        norm.bias.data.copy_(bias + mean)

    return hook


class Samples:
    """Inputs (half precision), targets (counts of 255 or 1) and masks of all frames in some files, on a device."""

    def __init__(self, paths, reference, target, device):
        prefix = "true_" if reference == "true" else ""
        depth = "true_depth_m" if reference == "true" else "reference_m"
        inputs, targets, known, self.names = [], [], [], []
        for path in sorted(paths):
            with safe_open(path, "np") as file:
                if depth not in file.keys():
                    raise SystemExit(f"{path}: has no tensor `{depth}`; the recording has no ground truth")
                inputs.append(file.get_tensor("input").astype(np.float16))
                wanted = file.get_tensor(prefix + target)
                targets.append(np.round(wanted * (255 if target == "soft" else 1)).astype(np.uint8))
                known.append(file.get_tensor(depth) > 0)
                self.names += [pathlib.Path(path).stem] * len(wanted)
        self.scale = 255.0 if target == "soft" else 1.0
        self.inputs, self.targets, self.known = (
            torch.from_numpy(np.concatenate(part)).to(device) for part in (inputs, targets, known))

    def __len__(self):
        return len(self.inputs)

    def batch(self, which):
        """Whole frames: N x 5 x rows x columns, N x 1 x rows x columns, the same."""
        return self.cut(which, (ROWS, COLUMNS), None)

    def cut(self, which, crop, random):
        """Crops at places that `random` draws, every other one mirrored; whole frames where there is none."""
        image = torch.as_tensor(which, device=self.inputs.device)[:, None, None]
        (rows, columns), count = crop, len(image)
        at = lambda length: torch.arange(length, device=self.inputs.device).expand(count, length)
        y, x = at(rows), at(columns)
        if random is not None:
            y = y + random.whole(ROWS - rows + 1, (count, 1))
            x = torch.where(random.within(0, 1, (count, 1)) < 0.5, x.flip(1), x) + random.whole(COLUMNS - columns + 1, (count, 1))
        y, x = y[:, :, None], x[:, None, :]
        inputs = self.inputs[image, :, y, x].permute(0, 3, 1, 2).float()
        return inputs, self.targets[image, y, x].float()[:, None] / self.scale, self.known[image, y, x][:, None]


class Random:
    """Draws on the device that holds the samples."""

    def __init__(self, seed, device):
        self.of = {"generator": torch.Generator(device).manual_seed(seed), "device": device}

    def within(self, low, high, shape):
        return low + (high - low) * torch.rand(shape, **self.of)

    def normal(self, shape):
        return torch.randn(shape, **self.of)

    def whole(self, end, shape):
        return torch.randint(0, end, shape, **self.of)


def augment(inputs, random):
    """Exposure, gain, gamma and noise of colour; noise of depth far below delta; some frames without one before them."""
    count, _, rows, columns = inputs.shape
    draw = lambda low, high, channels=1: random.within(low, high, (count, channels, 1, 1))
    exposure, balance, gamma = torch.exp2(draw(-1.0, 0.7)), draw(0.85, 1.15, 3), draw(0.75, 1.35)
    noise = draw(0.0, 0.03) * random.normal((count, 3, rows, columns))
    color = (inputs[:, :3].clamp(min=1e-4) ** gamma * exposure * balance + noise).clamp(0, 1)
    depth, change = inputs[:, 3:4], inputs[:, 4:5]
    change = change * (draw(0, 1) > FIRST_FRAMES).float()
    jitter = 1 + 0.002 * random.normal((count, 1, rows, columns))
    return torch.cat([color, depth * jitter, change], 1)


def loss_of(logits, targets, known, inputs, settings):
    """Mean of |R - target|, or of the cross entropy, over pixels with a reference; those without depth count less."""
    weight = known.float() * torch.where(inputs[:, 3:4] > 0, 1.0, settings.hole_weight)
    if settings.loss == "bce":
        off = F.binary_cross_entropy_with_logits(logits, targets, reduction="none")
    else:
        off = (torch.sigmoid(logits) - targets).abs()
    return (off * weight).sum() / weight.sum().clamp(min=1)


def scores(net, samples, every):
    """By level: AUPRC for "bad" among pixels with depth and reference, and mean R of good and bad ones."""
    from sklearn.metrics import average_precision_score

    found = {}
    with torch.no_grad():
        for index in range(0, len(samples), every):
            inputs, targets, known = samples.batch([index])
            reliability = torch.sigmoid(net(inputs))
            valid = (known & (inputs[:, 3:4] > 0)).flatten()
            level = samples.names[index].split("-")[0]
            pair = (reliability.flatten()[valid].cpu().numpy(), targets.flatten()[valid].cpu().numpy() > 0.5)
            found.setdefault(level, []).append(pair)
    lines = []
    for level, pairs in sorted(found.items()):
        reliability, good = (np.concatenate([pair[k] for pair in pairs]) for k in range(2))
        auprc = average_precision_score(~good, -reliability) if (~good).any() else float("nan")
        kept = (reliability[good] > 0.3).mean()
        missed = (reliability[~good] > 0.3).mean() if (~good).any() else float("nan")
        lines.append(f"{level} AUPRC {auprc:.3f} bad {(~good).mean():.3f} R good {reliability[good].mean():.3f} "
                     f"kept {kept:.3f} bad kept {missed:.3f}")
    return "; ".join(lines)


def export(net, path, settings):
    metadata = {
        "format": "drm-net",
        "depth_scale_m": str(DEPTH_SCALE_M),
        "origin": f"trained by weights/train.py on {settings['frames']} frames of {len(settings['samples'])} recordings of `limpid sim`",
        "architecture": json.dumps(ARCHITECTURE),
        "training": json.dumps(settings, sort_keys=True),
    }
    pathlib.Path(path).write_bytes(in_order(save(net.folded(settings["sharpen"], settings["at"]), metadata)))


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("samples", nargs="+", help="safetensors files of `limpid targets`")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--validate", nargs="*", default=[], help="files that are scored, never trained on")
    parser.add_argument("--sharpen", type=float, default=1.0, help="scales the exported head: R goes faster from 0 to 1")
    parser.add_argument("--at", type=float, default=INSERTED, help="what R was where the exported R is 0.7")
    parser.add_argument("--init", metavar="WEIGHTS", help="go on from this weight file")
    parser.add_argument("--reference", choices=["true", "measured"], default="true")
    parser.add_argument("--target", choices=["binary", "soft"], default="binary")
    parser.add_argument("--loss", choices=["l1", "bce"], default="l1")
    parser.add_argument("--steps", type=int, default=2000)
    parser.add_argument("--end", type=int, metavar="STEP", help="end at this step, as an interrupt there would")
    parser.add_argument("--batch", type=int, default=8)
    parser.add_argument("--crop", type=int, nargs=2, default=[128, 160], help="rows and columns, multiples of 16")
    parser.add_argument("--rate", type=float, default=4e-3)
    parser.add_argument("--hole-weight", type=float, default=0.1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--device", default="cpu", help="cpu, or cuda for an NVIDIA GPU")
    parser.add_argument("--report", type=int, default=100, help="steps between lines of the log")
    return parser.parse_args()


class Average:
    """The network whose weights and batch statistics are running averages of another's."""

    def __init__(self, net):
        self.net, self.updates = copy.deepcopy(net).eval(), 0

    def update(self, net):
        self.updates += 1
        kept = min(0.99, self.updates / (self.updates + 9))
        with torch.no_grad():
            for mean, now in zip(self.net.state_dict().values(), net.state_dict().values()):
                if mean.is_floating_point():
                    mean.lerp_(now, 1 - kept)


def rate_at(step, steps, rate):
    """Rises over 50 steps and falls to nothing along half a cosine."""
    return rate * min((step + 1) / 50, 1.0) * 0.5 * (1 + math.cos(math.pi * step / steps))


def settings_of(arguments, samples, steps):
    names = ("reference", "target", "loss", "sharpen", "at", "batch", "crop", "rate", "hole_weight", "seed", "threads", "device")
    settings = {name: getattr(arguments, name) for name in names}
    if arguments.init:
        with safe_open(arguments.init, "np") as file:
            settings["init"] = json.loads(file.metadata().get("training", "{}"))
    recordings = sorted(pathlib.Path(path).stem for path in arguments.samples)
    return settings | {"steps": steps, "frames": len(samples), "samples": recordings, "torch": torch.__version__}


def begin(arguments, samples):
    """The network on its device, new or from a file."""
    net = DrmNet(ARCHITECTURE)
    nn.init.constant_(net.convs["head"].bias, 1.0)
    net = net.to(arguments.device, memory_format=torch.channels_last)
    if arguments.init:
        some = np.random.default_rng(arguments.seed).permutation(len(samples))[:16]
        net.unfold(arguments.init, samples.batch(some)[0])
    return net


def train(net, samples, validation, arguments):
    """Runs the steps, reporting and exporting between them; returns the averaged network and how many steps were made."""
    average, random = Average(net), Random(arguments.seed, arguments.device)
    order_of = np.random.default_rng(arguments.seed)
    optimizer = torch.optim.AdamW(net.parameters(), arguments.rate, weight_decay=1e-4)
    start, total, order, interrupted, step = time.time(), 0.0, [], [], 0
    signal.signal(signal.SIGINT, lambda *_: interrupted.append(True))
    while step < min(arguments.steps, arguments.end or arguments.steps) and not interrupted:
        for group in optimizer.param_groups:
            group["lr"] = rate_at(step, arguments.steps, arguments.rate)
        while len(order) < arguments.batch:
            order += list(order_of.permutation(len(samples)))
        which, order = order[: arguments.batch], order[arguments.batch :]
        inputs, targets, known = samples.cut(which, arguments.crop, random)
        inputs = augment(inputs, random)
        logits = net(inputs.contiguous(memory_format=torch.channels_last))
        loss = loss_of(logits, targets, known, inputs, arguments)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        average.update(net)
        step += 1
        total = total + loss.detach()
        if step % arguments.report == 0:
            seen = f"; {scores(average.net, validation, 7)}" if len(validation) else ""
            print(f"step {step} {time.time() - start:.0f} s loss {float(total) / arguments.report:.4f}{seen}", flush=True)
            total = 0.0
            export(average.net, arguments.output, settings_of(arguments, samples, step))
    print(f"{step} steps in {time.time() - start:.0f} s", flush=True)
    return average.net, step


def main():
    arguments = parse()
    os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")  # what CUDA asks for to give the same bits in every run
    torch.manual_seed(arguments.seed)
    torch.set_num_threads(arguments.threads)
    torch.use_deterministic_algorithms(True)
    samples = Samples(arguments.samples, arguments.reference, arguments.target, arguments.device)
    validation = Samples(arguments.validate, "true", "binary", arguments.device) if arguments.validate else []
    print(f"{len(samples)} frames for training, {len(validation)} for validation", flush=True)
    net, step = train(begin(arguments, samples), samples, validation, arguments)
    export(net, arguments.output, settings_of(arguments, samples, step))
    if len(validation):
        print(scores(net, validation, 1), flush=True)


if __name__ == "__main__":
    main()
