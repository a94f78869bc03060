"""Tests that a network's answers are cached: a second run needs no inference, and a killed run continues.

    python answers.py EDGEGAIT FOLDER

EDGEGAIT is the command; FOLDER is empty.
"""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper


def write_network(path):
    """Writes a network of two convolutions with random weights and 32 outputs: 14 million multiply-accumulates."""
    random = np.random.default_rng(7)

    def weights(name, *shape):
        scale = 1 / np.sqrt(np.prod(shape[1:]))
        return numpy_helper.from_array((random.normal(size=shape) * scale).astype(np.float32), name)

    nodes = [
        helper.make_node("Conv", ["geis", "w1"], ["c1"], pads=[1] * 4, kernel_shape=[3, 3], strides=[1, 1]),
        helper.make_node("Relu", ["c1"], ["r1"]),
        helper.make_node("Conv", ["r1", "w2"], ["c2"], pads=[1] * 4, kernel_shape=[3, 3], strides=[1, 1]),
        helper.make_node("Relu", ["c2"], ["r2"]),
        helper.make_node("MaxPool", ["r2"], ["p2"], kernel_shape=[5, 5], strides=[5, 5]),
        helper.make_node("Flatten", ["p2"], ["flat"]),
        helper.make_node("Gemm", ["flat", "w3"], ["embedding"], transB=1),
    ]
    constants = [weights("w1", 16, 1, 3, 3), weights("w2", 64, 16, 3, 3), weights("w3", 32, 3840)]
    graph = helper.make_graph(
        nodes,
        "random",
        [helper.make_tensor_value_info("geis", TensorProto.FLOAT, ["n", 1, 50, 30])],
        [helper.make_tensor_value_info("embedding", TensorProto.FLOAT, ["n", 32])],
        constants,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(model, full_check=True)
    onnx.save(model, path)


def command(program, cache, views):
    azimuths = ",".join(str(180 * at // views) for at in range(views))
    arguments = ["score", "net.onnx", "--raster", "rows", "--azimuth-deg", azimuths, "--json", "-"]
    return [program, *arguments, "--cache", cache]


def processor_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def results(program, cache, views):
    """Runs the command: the processor time that it took, which other programs hardly change, and its results."""
    started = processor_seconds()
    done = subprocess.run(command(program, cache, views), check=True, capture_output=True)
    seconds = processor_seconds() - started
    found = json.loads(done.stdout)
    recognizer = found["recognizers"][0]
    assert recognizer["name"] == "net" and recognizer["p50_us"] > 100, recognizer["p50_us"]
    return seconds, {key: recognizer[key] for key in ("rank1", "probes", "by_viewpoint", "probe_sets")}


if __name__ == "__main__":
    program = str(Path(sys.argv[1]).resolve())
    os.chdir(sys.argv[2])
    write_network("net.onnx")
    views = 60
    alone = results(program, "none", views)
    first = results(program, "kept", views)
    again = results(program, "kept", views)
    assert not Path("none").exists()
    assert first[1] == again[1] == alone[1]
    # Other viewpoints, all of which are cached.
    kept = next(Path("kept/answers").iterdir())
    length = kept.stat().st_size
    results(program, "kept", 20)
    assert kept.stat().st_size == length
    # After a kill, the answers so far are kept, and the results are the same.
    process = subprocess.Popen(
        command(program, "killed", views), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    time.sleep(first[0] / 2 / os.cpu_count())
    process.send_signal(signal.SIGKILL)
    process.wait()
    files = list(Path("killed/answers").glob("*"))
    part = files[0].stat().st_size if files else 0
    rest = results(program, "killed", views)
    assert rest[1] == first[1]
    assert next(Path("killed/answers").iterdir()).stat().st_size == length
    print(
        f"{alone[1]['probes']} probes: {alone[0]:.1f} s of processor time without, {first[0]:.1f} s first, {again[0]:.1f} s again;"
        f" killed at {100 * part // length} % of the answers, {rest[0]:.1f} s for the rest"
    )
    assert 2 * again[0] < first[0], (first[0], again[0])
