"""A layer of tanh units and a weight for each: what map reliability and solidity are judged by. Training and file."""

import pathlib

import numpy as np
from safetensors.numpy import save

from export import in_order


def fit(x, solid, weight, hidden, steps, seed, batch, rate, decay=1e-4):
    """inner (hidden x inputs + 1), outer (hidden) and bias of units of tanh: Adam on weighted cross entropy, half a cosine."""
    random = np.random.default_rng(seed)
    mean, deviation = x.mean(0), np.maximum(x.std(0), 1e-6)
    design, weight = (x - mean) / deviation, weight / weight.mean()
    inputs = design.shape[1]
    state = [random.normal(0, inputs**-0.5, (inputs, hidden)), np.zeros(hidden), random.normal(0, 0.1, hidden), np.zeros(1)]
    first, second = [0 * part for part in state], [0 * part for part in state]
    for step in range(1, steps + 1):
        picked = random.integers(0, len(design), batch)
        units = np.tanh(design[picked] @ state[0] + state[1])
        error = (1 / (1 + np.exp(-units @ state[2] - state[3])) - solid[picked]) * weight[picked] / batch
        back = np.outer(error, state[2]) * (1 - units**2)
        slopes = [design[picked].T @ back, back.sum(0), units.T @ error, error.sum(keepdims=True)]
        for part, slope in enumerate(slopes):
            first[part] = 0.9 * first[part] + 0.1 * slope
            second[part] = 0.999 * second[part] + 0.001 * slope**2
            along = first[part] / (1 - 0.9**step) / (np.sqrt(second[part] / (1 - 0.999**step)) + 1e-8)
            state[part] = state[part] - 0.5 * rate * (1 + np.cos(np.pi * step / steps)) * (along + decay * state[part])
    inner = state[0] / deviation[:, None]
    inner = np.vstack([inner, state[1] - mean @ inner]).T
    return {"inner": inner, "outer": state[2], "bias": state[3]}


def write(model, path, metadata):
    """The weights in 32-bit floats, and the metadata that limpid reads beside them."""
    tensors = {name: np.ascontiguousarray(part, np.float32) for name, part in model.items()}
    pathlib.Path(path).write_bytes(in_order(save(tensors, metadata)))
