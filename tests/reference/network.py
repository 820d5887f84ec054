"""Makes testdata/reference/network.safetensors: a random network of odd widths, an input, and what every block gives.

    pip install numpy onnx onnxruntime safetensors
    python tests/reference/network.py testdata/reference/network.safetensors

The outputs are ONNX Runtime's (the graph comes from bench/peers/net.py). The widths cover what the shipped network does not:
quads that are no pair, pointwise outputs that fill no group, tiles that stand over the image.
"""

import json
import pathlib
import sys

import numpy as np
import onnxruntime
from safetensors.numpy import load_file, save_file

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "bench" / "peers"))
import net  # noqa: E402

ROWS, COLUMNS = 12, 20


def down(name, inputs, outputs):
    return {"name": name, "op": "separable", "in": inputs, "out": outputs, "stride": 2}


def up(name, inputs, outputs, skip):
    return {"name": name, "op": "separable", "in": inputs, "out": outputs, "stride": 1, "upsample": 2, "skip": skip}


ARCHITECTURE = [
    {"name": "stem", "op": "conv3x3", "in": 5, "out": 12, "stride": 1},
    down("enc1", 12, 68),
    down("enc2", 68, 36),
    {"name": "middle", "op": "separable", "in": 36, "out": 20, "stride": 1},
    up("dec1", 20 + 68, 72, "enc1"),
    up("dec0", 72 + 12, 8, "stem"),
    {"name": "head", "op": "conv1x1", "in": 8, "out": 1, "stride": 1, "activation": "sigmoid"},
]


def random_tensors(random):
    tensors = {}
    for block in ARCHITECTURE:
        name, inputs, outputs = block["name"], block["in"], block["out"]
        shapes = {
            "separable": {".dw": (inputs, 1, 3, 3), ".pw": (outputs, inputs, 1, 1)},
            "conv3x3": {"": (outputs, inputs, 3, 3)},
            "conv1x1": {"": (outputs, inputs, 1, 1)},
        }[block["op"]]
        for suffix, shape in shapes.items():
            spread = np.sqrt(2.0 / np.prod(shape[1:]))
            tensors[f"{name}{suffix}.weight"] = random.normal(0, spread, shape).astype(np.float32)
            tensors[f"{name}{suffix}.bias"] = random.normal(0, 0.1, shape[:1]).astype(np.float32)
    return tensors


def main():
    target = sys.argv[1]
    random = np.random.default_rng(11)
    metadata = {
        "format": "drm-net", "depth_scale_m": "10.0", "origin": "random, seed 11; for tests only",
        "architecture": json.dumps(ARCHITECTURE),
    }
    weights = random_tensors(random)
    save_file(weights, target, metadata)
    image = random.random((1, 5, ROWS, COLUMNS), np.float32)
    names = [block["name"] for block in ARCHITECTURE[:-1]]
    model = net.to_onnx(target, ROWS, COLUMNS, names)
    session = onnxruntime.InferenceSession(model, providers=["CPUExecutionProvider"])
    outputs = session.run(names + ["output"], {"input": image})
    save_file({"input": image} | dict(zip(names + ["output"], outputs)), str(pathlib.Path(target).with_suffix(".io.safetensors")))
    print({name: value.shape for name, value in load_file(pathlib.Path(target).with_suffix(".io.safetensors")).items()})


main()
