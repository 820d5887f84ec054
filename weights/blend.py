"""Blends two weight files of DRM-Net that were trained from the same start: weights (1 - share) of the first, share of the second.

    pip install numpy safetensors
    python weights/blend.py OLD NEW --share 0.4 -o weights/drm-net.safetensors

What `train.py --init` goes on from and what it comes to lie in one valley: between them the network keeps more of what it
could before than at the end, and has most of what it learned. The metadata is the second's, with the share."""

import argparse
import json
import pathlib

import numpy as np
from safetensors import safe_open
from safetensors.numpy import save

from export import in_order


def read(path):
    """Tensors and metadata."""
    with safe_open(path, "np") as file:
        return {name: file.get_tensor(name) for name in file.keys()}, file.metadata()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("old", type=pathlib.Path)
    parser.add_argument("new", type=pathlib.Path)
    parser.add_argument("--share", type=float, required=True)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    (old, before), (new, metadata) = read(arguments.old), read(arguments.new)
    if before["architecture"] != metadata["architecture"]:
        raise SystemExit(f"{arguments.old} and {arguments.new} are not of one layer list")
    trained = [json.loads(part["training"]) for part in (before, metadata)]
    if any(trained[0][key] != trained[1][key] for key in ("sharpen", "at")):
        raise SystemExit("the heads are not scaled alike (--sharpen, --at)")
    blend = {name: ((1 - arguments.share) * old[name].astype(float) + arguments.share * new[name]).astype(np.float32) for name in old}
    metadata["training"] = json.dumps(trained[1] | {"share": arguments.share}, sort_keys=True)
    metadata["origin"] += f", by a share of {arguments.share} from where it began"
    arguments.output.write_bytes(in_order(save(blend, metadata)))


if __name__ == "__main__":
    main()
