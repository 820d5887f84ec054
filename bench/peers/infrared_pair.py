"""How near does the matcher of `limpid sim` come to a real camera's, on the same infrared pair?

    pip install numpy pillow wgpu
    python bench/peers/infrared_pair.py DATA/rgbd/d3roma-d415-ir [--sweep]

Runs limpid's own shaders (shaders/sim: census, cost, winner, depth) on the rectified infrared pair of a D415 and holds the depth against the
camera's own of the same frame, right of the border that has no partner in the other image. `--sweep` tries settings around the default.
Printed: the share of pixels with both depths that agree within 1 and 2 %, more than 10 % off, the median difference, and within 1 % once that is taken
away; the share of holes of both; and how well holes lie in the same places (precision, recall, F1).
"""

import argparse
import itertools
import pathlib
import struct

import numpy as np
import wgpu
from PIL import Image

SHADERS = pathlib.Path(__file__).resolve().parents[2] / "shaders" / "sim"
FOCAL_PX, BASELINE_MM = 443.914642, 54.7803528606892
DISPARITIES = 80            # at 443.9 px and 54.8 mm: 0.31 m and farther
BORDER_PX = 75
WINDOW_BITS = 62 * 25
DEFAULT = dict(uniqueness=0.03, left_right_px=1.0, texture=0.8, largest_cost=0.36, step_px=1 / 32)


def grey(path):
    """The image as bytes, and its size."""
    image = np.asarray(Image.open(path))
    return np.ascontiguousarray(image[..., 0] if image.ndim == 3 else image, np.uint8)


class Matcher:
    """The four passes on one pair; costs are computed once."""

    def __init__(self, left, right):
        self.height, self.width = left.shape
        adapter = wgpu.gpu.request_adapter_sync()
        most = adapter.limits["max-storage-buffer-binding-size"]
        self.device = adapter.request_device_sync(required_limits={"max-storage-buffer-binding-size": most})
        signatures = [self.census(image, side) for image, side in ((left, True), (right, False))]
        self.texture = signatures[0][1]
        words = DISPARITIES // 2
        size = self.width * self.height * words * 4
        params = struct.pack("<3I", self.width, self.height, words)
        groups = (-(-self.width // 64), -(-self.height // 8), -(-words // 4))
        [self.volume] = self.run("cost", params, [signatures[0][0], signatures[1][0]], [size], groups)

    def run(self, name, params, inputs, outputs, groups, constants=None):
        """Runs a pass: parameters, then what it reads, then what it writes, as they are bound."""
        device = self.device
        module = device.create_shader_module(code=(SHADERS / f"{name}.wgsl").read_text())
        compute = {"module": module, "entry_point": name, "constants": constants or {}}
        pipeline = device.create_compute_pipeline(layout="auto", compute=compute)
        padded = params + bytes(-len(params) % 16)
        uniform = device.create_buffer_with_data(data=padded, usage=wgpu.BufferUsage.UNIFORM)
        usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC | wgpu.BufferUsage.COPY_DST
        written = [device.create_buffer(size=size, usage=usage) for size in outputs]
        entries = [{"binding": i, "resource": {"buffer": b, "offset": 0, "size": b.size}} for i, b in enumerate([uniform, *inputs, *written])]
        group = device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
        encoder = device.create_command_encoder()
        run = encoder.begin_compute_pass()
        run.set_pipeline(pipeline)
        run.set_bind_group(0, group)
        run.dispatch_workgroups(*groups)
        run.end()
        device.queue.submit([encoder.finish()])
        return written

    def census(self, image, left):
        """Signatures and texture of an image."""
        source = self.device.create_buffer_with_data(data=image, usage=wgpu.BufferUsage.STORAGE)
        pixels, words = self.width * self.height, self.width // 4
        groups = (-(-words // 16), -(-self.height // 4), 1)
        return self.run("census", struct.pack("<2I", words, self.height), [source], [pixels * 8, pixels * 4], groups, {"left": True})

    def depth(self, uniqueness, left_right_px, texture, largest_cost, step_px):
        """Depth in millimetres; 0: none."""
        pixels = self.width * self.height
        params = struct.pack("<3I2f", self.width, self.height, DISPARITIES // 2, uniqueness, largest_cost * WINDOW_BITS)
        groups = (-(-self.width // 64), -(-self.height // 4), 1)
        found = [self.run("winner", params, [self.volume], [pixels * 4], groups, {"left": left})[0] for left in (True, False)]
        params = struct.pack("<2I5fI", self.width, self.height, FOCAL_PX * BASELINE_MM, left_right_px, texture, step_px, DISPARITIES - 1, 0)
        [depth] = self.run("depth", params, [*found, self.texture], [pixels * 4], (-(-pixels // 64), 1, 1))
        return np.frombuffer(self.device.queue.read_buffer(depth), np.uint32).reshape(self.height, self.width)


def compare(ours, theirs):
    """The figures of the module's description."""
    ours, theirs = ours[:, BORDER_PX:].astype(float), theirs[:, BORDER_PX:].astype(float)
    both = (ours > 0) & (theirs > 0)
    off = ours[both] / theirs[both] - 1
    shift = np.median(ours[both] - theirs[both])
    shifted = (ours[both] - shift) / theirs[both] - 1
    holes, real = ours == 0, theirs == 0
    same = (holes & real).sum()
    precision, recall = same / max(holes.sum(), 1), same / max(real.sum(), 1)
    return {
        "1 %": (abs(off) <= 0.01).mean(), "2 %": (abs(off) <= 0.02).mean(), "> 10 %": (abs(off) > 0.1).mean(),
        "median mm": shift, "1 % without it": (abs(shifted) <= 0.01).mean(), "holes": holes.mean(), "real holes": real.mean(),
        "precision": precision, "recall": recall, "F1": 2 * precision * recall / max(precision + recall, 1e-9),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--sweep", action="store_true")
    arguments = parser.parse_args()
    left, right = (grey(arguments.folder / f"0000_ir_{side}.png") for side in "lr")
    theirs = np.asarray(Image.open(arguments.folder / "0000_depth.png"))
    matcher = Matcher(left, right)
    tried = [DEFAULT]
    if arguments.sweep:
        grid = itertools.product((0.0, 0.01, 0.03, 0.06), (1.0, 2.0), (0.8, 3.0), (0.2, 0.28, 0.36))
        tried += [dict(DEFAULT, uniqueness=u, left_right_px=l, texture=t, largest_cost=c) for u, l, t, c in grid]
    names = None
    for settings in tried:
        figures = compare(matcher.depth(**settings), theirs)
        if names is None:
            names = list(figures)
            print("| settings | " + " | ".join(names) + " |")
            print("|---" * (len(names) + 1) + "|")
        label = ", ".join(f"{key} {value:g}" for key, value in settings.items() if key != "step_px")
        print(f"| {label} | " + " | ".join(f"{figures[name]:.3f}" for name in names) + " |", flush=True)


if __name__ == "__main__":
    main()
