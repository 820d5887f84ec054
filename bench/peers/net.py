"""How does limpid's DRM-Net compare with ONNX Runtime and ncnn on the same machine?

    pip install numpy safetensors onnx onnxruntime ncnn
    cargo bench --bench net --no-run      # prints the benchmark's path
    python bench/peers/net.py --limpid PATH --weights WEIGHTS [--rounds 6] [--count 8]

One process for each engine. They take turns: in every round each runs a few inferences (1x5x240x320 floats in, 240x320 out) while
the others wait, so that all meet the same load. Before anything is timed, each peer's output is compared with
limpid's (`limpid net`, given as --command) where that is given. Prints a table of wall and processor time.
"""

import argparse
import json
import os
import resource
import struct
import subprocess
import sys
import tempfile
import time

import numpy as np

ROWS, COLUMNS = 240, 320


def layers(path):
    """Blocks of a weight file with their arrays."""
    from safetensors import safe_open

    with safe_open(path, "np") as file:
        blocks = json.loads(file.metadata()["architecture"])
        tensors = {name: file.get_tensor(name) for name in file.keys()}
    return blocks, tensors


def to_onnx(path, rows=ROWS, columns=COLUMNS, more=()):
    """The network as an ONNX model; the blocks named in `more` are outputs too."""
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    blocks, tensors = layers(path)
    nodes, constants = [], [numpy_helper.from_array(np.array([1, 1, 2, 2], np.float32), "scales")]
    constants += [numpy_helper.from_array(value, name) for name, value in tensors.items()]

    def conv(source, sink, prefix, kernel, stride, groups, relu):
        raw = f"{sink}.raw" if relu else sink
        nodes.append(
            helper.make_node(
                "Conv", [source, f"{prefix}.weight", f"{prefix}.bias"], [raw], kernel_shape=[kernel] * 2,
                strides=[stride] * 2, pads=[kernel // 2] * 4, group=groups))
        if relu:
            nodes.append(helper.make_node("Relu", [raw], [sink]))

    now = "input"
    for block in blocks:
        name = block["name"]
        if block.get("upsample", 1) == 2:
            nodes.append(
                helper.make_node("Resize", [now, "", "scales"], [f"{name}.up"], mode="linear",
                                 coordinate_transformation_mode="half_pixel"))
            now = f"{name}.up"
        if block.get("skip"):
            nodes.append(helper.make_node("Concat", [now, block["skip"]], [f"{name}.in"], axis=1))
            now = f"{name}.in"
        if block["op"] == "separable":
            conv(now, f"{name}.mid", f"{name}.dw", 3, block["stride"], block["in"], True)
            conv(f"{name}.mid", name, f"{name}.pw", 1, 1, 1, True)
        elif block["op"] == "conv3x3":
            conv(now, name, name, 3, block["stride"], 1, True)
        else:
            conv(now, f"{name}.raw", name, 1, 1, 1, False)
            nodes.append(helper.make_node("Sigmoid", [f"{name}.raw"], ["output"]))
        now = name
    shape = lambda name, channels: helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, channels, rows, columns])
    sinks = [helper.make_empty_tensor_value_info(name) for name in more] + [shape("output", 1)]
    graph = helper.make_graph(nodes, "drm-net", [shape("input", 5)], sinks, constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    return model.SerializeToString()


def to_ncnn(path, folder):
    """Writes ncnn's text of layers and its weights; returns their paths."""
    blocks, tensors = layers(path)
    lines, weights, blobs = [], [], {"input"}
    uses = {}

    def layer(kind, name, sources, sink, parameters=""):
        taken = []
        for source in sources:
            uses[source] = uses.get(source, 0) + 1
            taken.append((source, uses[source]))
        lines.append((kind, name, taken, sink, parameters))
        blobs.add(sink)

    def conv(source, sink, prefix, kernel, stride, groups, activation):
        weight, bias = tensors[f"{prefix}.weight"], tensors[f"{prefix}.bias"]
        text = f"0={weight.shape[0]} 1={kernel} 3={stride} 4={kernel // 2} 5=1 6={weight.size} 9={activation}"
        kind = "ConvolutionDepthWise" if groups > 1 else "Convolution"
        layer(kind, sink, [source], sink, text + (f" 7={groups}" if groups > 1 else ""))
        weights.append(struct.pack("<I", 0) + weight.astype("<f4").tobytes() + bias.astype("<f4").tobytes())

    now = "input"
    for block in blocks:
        name = block["name"]
        if block.get("upsample", 1) == 2:
            layer("Interp", f"{name}.up", [now], f"{name}.up", "0=2 1=2.0 2=2.0")
            now = f"{name}.up"
        if block.get("skip"):
            layer("Concat", f"{name}.in", [now, block["skip"]], f"{name}.in", "0=0")
            now = f"{name}.in"
        if block["op"] == "separable":
            conv(now, f"{name}.mid", f"{name}.dw", 3, block["stride"], block["in"], 1)
            conv(f"{name}.mid", name, f"{name}.pw", 1, 1, 1, 1)
        elif block["op"] == "conv3x3":
            conv(now, name, name, 3, block["stride"], 1, 1)
        else:
            conv(now, "output", name, 1, 1, 1, 4)
        now = name
    # A blob that is read twice goes through a Split, as ncnn wants it.
    text, count = [("Input", "input", [], ["input"], "")], {}
    for kind, name, taken, sink, parameters in lines:
        sources = [f"{s}.{i}" if uses[s] > 1 else s for s, i in taken]
        text.append((kind, name, sources, [sink], parameters))
        if uses.get(sink, 0) > 1:
            text.append(("Split", f"{sink}.split", [sink], [f"{sink}.{i + 1}" for i in range(uses[sink])], ""))
    count = sum(len(sinks) for *_, sinks, _ in text)
    param, binary = os.path.join(folder, "net.param"), os.path.join(folder, "net.bin")
    with open(param, "w") as file:
        file.write(f"7767517\n{len(text)} {count}\n")
        for kind, name, sources, sinks, parameters in text:
            file.write(f"{kind} {name} {len(sources)} {len(sinks)} {' '.join(sources + sinks)} {parameters}\n")
    with open(binary, "wb") as file:
        file.write(b"".join(weights))
    return param, binary


def onnxruntime_engine(weights, threads):
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads, options.inter_op_num_threads = threads, 1
    session = onnxruntime.InferenceSession(to_onnx(weights), options, providers=["CPUExecutionProvider"])
    return lambda image: session.run(["output"], {"input": image})[0]


def ncnn_engine(weights, vulkan):
    import ncnn

    net = ncnn.Net()
    net.opt.use_vulkan_compute, net.opt.num_threads = vulkan, 2
    # float32 throughout, as the others.
    net.opt.use_fp16_packed = net.opt.use_fp16_storage = net.opt.use_fp16_arithmetic = False
    net.opt.use_bf16_storage = False
    if vulkan:
        net.set_vulkan_device(0)
    with tempfile.TemporaryDirectory() as folder:
        param, binary = to_ncnn(weights, folder)
        assert net.load_param(param) == 0 and net.load_model(binary) == 0, "ncnn refuses the network"

    def infer(image):
        with net.create_extractor() as extractor:
            extractor.input("input", ncnn.Mat(image[0]))
            code, out = extractor.extract("output")
            assert code == 0, f"ncnn: {code}"
            return np.array(out).reshape(1, 1, ROWS, COLUMNS)

    return infer


ENGINES = {
    "ONNX Runtime, 2 threads": lambda weights: onnxruntime_engine(weights, 2),
    "ONNX Runtime, 1 thread": lambda weights: onnxruntime_engine(weights, 1),
    "ncnn CPU, 2 threads": lambda weights: ncnn_engine(weights, False),
    "ncnn Vulkan": lambda weights: ncnn_engine(weights, True),
}


def test_input():
    """The numbers that the benchmark of limpid takes too."""
    index = np.arange(5 * ROWS * COLUMNS, dtype=np.int64)
    return ((index * 7919 % 1009).astype(np.float32) / np.float32(1009)).reshape(1, 5, ROWS, COLUMNS)


def processor_ms():
    used = resource.getrusage(resource.RUSAGE_SELF)
    return (used.ru_utime + used.ru_stime) * 1e3


def serve(engine, weights):
    """A peer's process: its output first, then times on request."""
    begin = time.perf_counter()
    infer, image = ENGINES[engine](weights), test_input()
    output = infer(image)
    answer = {"first_ms": (time.perf_counter() - begin) * 1e3, "output": output.ravel()[::997].tolist()}
    print(json.dumps(answer), flush=True)
    for line in sys.stdin:
        wall, processor = [], []
        for _ in range(int(line)):
            start, start_processor = time.perf_counter(), processor_ms()
            infer(image)
            wall.append((time.perf_counter() - start) * 1e3)
            processor.append(processor_ms() - start_processor)
        print(json.dumps({"wall_ms": wall, "cpu_ms": processor}), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--weights", required=True)
    parser.add_argument("--limpid", help="the built benchmark `net`")
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--count", type=int, default=8)
    parser.add_argument("--only", default="", help="engines whose name contains this, and limpid")
    parser.add_argument("--serve", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.serve:
        return serve(arguments.serve, arguments.weights)
    if not arguments.limpid:
        parser.error("--limpid is needed")

    own = [arguments.limpid, arguments.weights, "--serve"]
    commands = {
        "limpid": own,
        "limpid, no subgroups": own + ["--no-subgroups"],
        "limpid, tensors as buffers": own + ["--buffers"],
    }
    for name in ENGINES:
        if arguments.only in name:
            commands[name] = [sys.executable, __file__, "--weights", arguments.weights, "--serve", name]
    processes, first, outputs = {}, {}, {}
    for name, command in commands.items():
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        answer = None
        while answer is None:  # libraries print lines of their own
            line = process.stdout.readline()
            assert line, f"{name} ended before it was ready"
            answer = json.loads(line) if line.startswith("{") else None
        processes[name], first[name], outputs[name] = process, answer["first_ms"], answer["output"]
    for name, output in outputs.items():
        worst = np.abs(np.array(output) - np.array(outputs["limpid"])).max()
        assert len(output) > 50 and worst < 1e-4, f"{name} differs from limpid by {worst}"
    times = {name: {"wall_ms": [], "cpu_ms": []} for name in commands}
    for round_ in range(arguments.rounds + 1):
        for name, process in processes.items():
            process.stdin.write(f"{arguments.count}\n")
            process.stdin.flush()
            answer = json.loads(process.stdout.readline())
            if round_ > 0:  # the first warms up
                for key in ("wall_ms", "cpu_ms"):
                    times[name][key] += answer[key]
    for process in processes.values():
        process.stdin.close()
        process.wait()
    print(f"load average {os.getloadavg()[0]:.1f}, {arguments.rounds} rounds of {arguments.count}\n")
    base = np.median(times.get("ONNX Runtime, 2 threads", times["limpid"])["wall_ms"])
    print("| engine | first ms | min ms | median ms | p90 ms | cpu ms | of ONNX Runtime, 2 threads |")
    print("|---|---|---|---|---|---|---|")
    for name, now in times.items():
        wall, processor = np.array(now["wall_ms"]), np.median(now["cpu_ms"])
        print(f"| {name} | {first[name]:.0f} | {wall.min():.2f} | {np.median(wall):.2f} | {np.quantile(wall, .9):.2f} "
              f"| {processor:.1f} | {np.median(wall) / base:.2f} |")


if __name__ == "__main__":
    main()
