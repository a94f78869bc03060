"""Tests that pseudo-3-D networks rewritten as 2-D ones compute the same, and run in the embedded runtime.

    python pseudo3d.py EDGEGAIT FOLDER

EDGEGAIT is the command; FOLDER is empty. ONNX Runtime, which has 3-D windows, is the reference.
"""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

RECIPE = Path(__file__).resolve().parents[2] / "models" / "recipe"
sys.path.insert(0, str(RECIPE))
sys.dont_write_bytecode = True

import pseudo3d  # noqa: E402

# The largest allowed difference, relative to the largest value.
TOLERANCE = 1e-5
CONTRACT = """template = "silhouettes"
layout = "NTHW"
rows = 64
columns = 44
framing = "height"
[outputs]
embedding = "embedding"
"""


def checked(nodes, constants, inputs, outputs, opset=17):
    ports = [[helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in part] for part in (inputs, outputs)]
    graph = helper.make_graph(nodes, "random", *ports, constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", opset)], ir_version=8)
    onnx.checker.check_model(model, full_check=True)
    return model


def outputs(model, feed):
    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
    return session.run(None, feed)


def difference(one, other):
    assert one.shape == other.shape, (one.shape, other.shape)
    assert np.isfinite(one).all() and np.isfinite(other).all()
    return float(np.abs(one - other).max() / np.abs(one).max())


def has_windows_over_three_axes(model):
    """Checks weights and attributes, independently of the rewriting."""
    weights = {tensor.name: len(tensor.dims) for tensor in model.graph.initializer}
    for node in model.graph.node:
        lengths = [len(item.ints) for item in node.attribute if item.name in ("kernel_shape", "strides", "dilations")]
        lengths += [len(item.ints) // 2 for item in node.attribute if item.name == "pads"]
        if 3 in lengths or node.op_type == "Conv" and weights.get(node.input[1]) == 5:
            return True
    return False


def refusal(model):
    try:
        pseudo3d.rewrite(model)
    except pseudo3d.Refused as error:
        return str(error)
    raise AssertionError("expected a refusal")


def random_window(random):
    """Returns a random window over three axes with a 1 in its kernel: operator, attributes, groups and channels."""
    kernel = [int(size) for size in random.integers(1, 4, 3)]
    kernel[random.integers(3)] = 1
    if random.random() < 0.5:
        kernel = [[3, 1, 1], [1, 3, 3], [1, 1, 1], [1, 2, 3]][random.integers(4)]
    operator = ["Conv", "Conv", "MaxPool", "AveragePool"][random.integers(4)]
    attributes = {"kernel_shape": kernel, "strides": [int(size) for size in random.integers(1, 4, 3)]}
    if operator != "AveragePool" and random.random() < 0.4:
        attributes["dilations"] = [int(size) for size in random.integers(1, 3, 3)]
    padding = random.integers(4)
    if padding == 0:
        attributes["auto_pad"] = ["SAME_UPPER", "SAME_LOWER", "VALID"][random.integers(3)]
        # Runtimes disagree on SAME with dilations, and with windows that leave gaps.
        attributes.pop("dilations", None)
        attributes["strides"] = [min(pair) for pair in zip(attributes["strides"], kernel)]
    elif padding < 3:
        most = kernel if operator != "Conv" else [3, 3, 3]
        attributes["pads"] = [int(random.integers(0, size)) for size in (*most, *most)]
    groups = int(random.integers(1, 3)) if operator == "Conv" else 1
    if operator == "Conv":
        attributes["group"] = groups
    if operator == "AveragePool":
        attributes["count_include_pad"] = int(random.integers(2))
    return operator, attributes, groups, 2 * groups


def random_case(random):
    operator, attributes, groups, channels = random_window(random)
    clip = [int(random.integers(1, 4)), channels, *(int(size) for size in random.integers(6, 10, 3))]
    constants = []
    inputs = ["clip"]
    if operator == "Conv":
        weights = random.normal(size=(2 * channels, channels // groups, *attributes["kernel_shape"]))
        constants.append(numpy_helper.from_array(weights.astype(np.float32), "weights"))
        inputs.append("weights")
        if random.random() < 0.5:
            constants.append(numpy_helper.from_array(random.normal(size=2 * channels).astype(np.float32), "bias"))
            inputs.append("bias")
    # Either no size is known, or all except the batch's and one more.
    known = random.random() < 0.5
    stated = [f"d{axis}" if axis == 0 or not known or axis == int(random.integers(5)) else size for axis, size in enumerate(clip)]
    node = helper.make_node(operator, inputs, ["out"], name="window", **attributes)
    model = checked([node], constants, [("clip", stated)], [("out", [None] * 5)])
    return model, {"clip": random.normal(size=clip).astype(np.float32)}


def windows_of_each_kind_compute_the_same():
    random = np.random.default_rng(3)
    worst, operators = 0.0, []
    for _ in range(600):
        model, feed = random_case(random)
        node = model.graph.node[0]
        says = f"{node.op_type} " + ", ".join(f"{item.name} {helper.get_attribute_value(item)}" for item in node.attribute)
        (expected,) = outputs(model, feed)
        rewritten, count = pseudo3d.rewrite(model)
        assert count == 1 and not has_windows_over_three_axes(rewritten), says
        (found,) = outputs(rewritten, feed)
        far = difference(expected, found)
        assert far < TOLERANCE, (says, far)
        worst = max(worst, far)
        operators.append(node.op_type)
    counts = {name: operators.count(name) for name in sorted(set(operators))}
    assert min(counts.values()) > 100, counts
    print(f"random windows {counts}: differ by {worst:.1e} at most")


def network(random):
    """Returns a small residual network, `[N, T, 64, 44]` to `[N, 8, 16]`, similar to DeepGaitV2, with unusual windows."""
    constants, nodes = [], []

    def constant(name, numbers, kind=np.float32):
        constants.append(numpy_helper.from_array(np.asarray(numbers, kind), name))
        return name

    def add(operator, *inputs, to, **attributes):
        nodes.append(helper.make_node(operator, inputs, [to], name=f"the {to}", **attributes))
        return to

    def conv(given, to, channels, kernel, groups=1, **attributes):
        shape = (channels[1], channels[0] // groups, *kernel)
        weights = random.normal(size=shape) / np.sqrt(np.prod(shape[1:]))
        inputs = [given, constant(f"{to}.weight", weights)]
        return add("Conv", *inputs, to=to, kernel_shape=kernel, group=groups, **attributes)

    def norm(given, to, channels):
        numbers = [random.uniform(0.5, 1.5, channels), random.normal(size=channels) / 5]
        numbers += [random.normal(size=channels) / 5, random.uniform(0.5, 2, channels)]
        names = [constant(f"{to}.{at}", part) for at, part in enumerate(numbers)]
        return add("BatchNormalization", given, *names, to=to)

    clip = add("Unsqueeze", "sils", constant("axis", [1], np.int64), to="clip")
    x = conv(clip, "stem", (1, 4), [1, 3, 3], pads=[0, 1, 1, 0, 1, 1], strides=[1, 2, 2])
    x = add("Relu", norm(x, "stem norm", 4), to="stem relu")
    # A window over frames, next to a residual path.
    over = norm(conv(x, "frames", (4, 4), [3, 1, 1], pads=[1, 0, 0, 1, 0, 0]), "frames norm", 4)
    x = add("Relu", add("Add", x, over, to="sum"), to="sum relu")
    # Both paths of a block have strides, with groups and uneven padding.
    down = conv(x, "down", (4, 8), [1, 1, 1], strides=[1, 2, 2])
    block = conv(x, "block", (4, 8), [1, 3, 2], groups=2, strides=[1, 2, 2], pads=[0, 1, 0, 0, 1, 1])
    x = add("Relu", add("Add", norm(block, "block norm", 8), down, to="block sum"), to="block relu")
    x = conv(x, "far", (8, 8), [3, 1, 1], groups=4, pads=[2, 0, 0, 2, 0, 0], dilations=[2, 1, 1])
    x = add("MaxPool", x, to="pooled", kernel_shape=[1, 1, 3], strides=[1, 1, 2], pads=[0, 0, 1, 0, 0, 1])
    x = add("ReduceMax", x, to="most", axes=[2], keepdims=0)
    x = add("Reshape", x, constant("parts", [0, 0, 16, -1], np.int64), to="places")
    add("ReduceMean", x, to="embedding", axes=[3], keepdims=0)
    return checked(nodes, constants, [("sils", ["N", "T", 64, 44])], [("embedding", ["N", 8, 16])])


def a_network_computes_the_same(model):
    before = model.SerializeToString()
    rewritten, count = pseudo3d.rewrite(model)
    assert model.SerializeToString() == before, "the given network has changed"
    assert count == 6 and not has_windows_over_three_axes(rewritten), count
    assert all(len(tensor.dims) < 5 for tensor in rewritten.graph.initializer), "weights occur twice"
    assert has_windows_over_three_axes(model)
    worst = 0.0
    for people, frames in ((1, 1), (1, 30), (3, 7), (2, 4)):
        feed = {"sils": np.random.default_rng(frames).random((people, frames, 64, 44), np.float32)}
        (expected,), (found,) = outputs(model, feed), outputs(rewritten, feed)
        worst = max(worst, difference(expected, found))
    assert worst < TOLERANCE, worst
    # The order of frames matters to the network, so the comparison covers it.
    (turned,) = outputs(model, {"sils": feed["sils"][:, ::-1].copy()})
    assert difference(expected, turned) > 1e-3
    again, count = pseudo3d.rewrite(rewritten)
    assert count == 0 and len(again.graph.node) == len(rewritten.graph.node)
    print(f"a network: differs by {worst:.1e} at most")
    return rewritten


def what_cannot_be_rewritten_is_refused():
    random = np.random.default_rng(5)
    clip = ("clip", ["n", 2, 5, 6, 7])

    def conv(kernel, name="the cube", **others):
        weights = numpy_helper.from_array(random.normal(size=(2, 2, *kernel)).astype(np.float32), "weights")
        node = helper.make_node("Conv", ["clip", "weights"], ["out"], name=name, **others)
        return checked([node], [weights], [clip], [("out", [None] * 5)])

    cube = conv([3, 3, 3])
    found = refusal(cube)
    assert "Conv the cube" in found and "3x3x3" in found, found
    # A node without a name is named after its output.
    assert "Conv out" in refusal(conv([2, 3, 2], name=""))
    pool = helper.make_node("MaxPool", ["clip"], ["out", "places"], name="the maxima", kernel_shape=[1, 2, 2])
    two = [("out", [None] * 5)]
    assert "MaxPool the maxima" in refusal(checked([pool], [], [clip], two))
    # Pooling excludes its padding from means and maxima, which Pad cannot express.
    pool = helper.make_node("AveragePool", ["clip"], ["out"], kernel_shape=[1, 2, 2], pads=[1, 0, 0, 1, 0, 0])
    assert "no padding where the kernel is 1" in refusal(checked([pool], [], [clip], two))
    weights = numpy_helper.from_array(np.ones((2, 2, 1, 2, 2), np.float32), "weights")
    turned = helper.make_node("ConvTranspose", ["clip", "weights"], ["out"], name="upwards")
    assert "ConvTranspose upwards" in refusal(checked([turned], [weights], [clip], two))
    assert "found 11" in refusal(checked([helper.make_node("Relu", ["clip"], ["out"])], [], [clip], two, opset=11))
    return cube


def weights_that_are_shared_or_computed_are_kept_apart():
    """Tests two windows and another node with the same weights, and a window with computed weights."""
    weights = np.random.default_rng(8).normal(size=(2, 2, 3, 1, 1)).astype(np.float32)
    constants = [numpy_helper.from_array(weights, "weights"), numpy_helper.from_array(np.float32(2), "two")]
    pads = [1, 0, 0, 1, 0, 0]
    nodes = [
        helper.make_node("Conv", ["clip", "weights"], ["one"], pads=pads),
        helper.make_node("Conv", ["one", "weights"], ["two of them"], pads=pads),
        helper.make_node("Mul", ["weights", "two"], ["doubled"]),
        helper.make_node("Conv", ["two of them", "doubled"], ["out"], pads=pads),
    ]
    model = checked(nodes, constants, [("clip", ["n", 2, "s", "h", "w"])], [("out", [None] * 5)])
    rewritten, count = pseudo3d.rewrite(model)
    assert count == 3
    feed = {"clip": np.random.default_rng(9).normal(size=(2, 2, 5, 4, 3)).astype(np.float32)}
    assert difference(outputs(model, feed)[0], outputs(rewritten, feed)[0]) < TOLERANCE


def command(*arguments):
    done = subprocess.run([sys.executable, RECIPE / "pseudo3d.py", *arguments], capture_output=True, text=True)
    assert "Traceback" not in done.stderr, done.stderr
    return done.returncode, done.stdout, done.stderr


def the_command_writes_whole_files_or_none(model, cube):
    onnx.save(model, "net.onnx")
    onnx.save(cube, "cube.onnx")
    Path("text.onnx").write_text("no model")
    for arguments, status, said in (
        (("cube.onnx", "out.onnx"), 1, "cube.onnx: Conv the cube"),
        (("text.onnx", "out.onnx"), 1, "text.onnx: expected an ONNX model"),
        (("none.onnx", "out.onnx"), 1, "none.onnx: No such file"),
        (("net.onnx", "none/out.onnx"), 1, "none/out.onnx: expected the folder none"),
        (("net.onnx", "net.onnx"), 1, "net.onnx: already exists (--overwrite"),
        (("net.onnx",), 2, "usage"),
    ):
        files = sorted(os.listdir("."))
        found, _, errors = command(*arguments)
        assert found == status and said in errors, (arguments, found, errors)
        assert status == 2 or errors.startswith("error: ") and errors.count("\n") == 1, errors
        assert sorted(os.listdir(".")) == files, arguments
    assert command("net.onnx", "flat.onnx")[0] == 0
    assert command("net.onnx", "flat.onnx", "--overwrite")[0] == 0
    assert not has_windows_over_three_axes(onnx.load("flat.onnx"))


def the_exporter_says_which_packages_it_lacks():
    # -S leaves out the folders of installed packages.
    done = subprocess.run(
        [sys.executable, "-S", "-E", RECIPE / "export_opengait.py", "--out", "x.onnx"], capture_output=True, text=True
    )
    assert done.returncode == 1 and done.stderr.count("\n") == 1, done.stderr
    assert "packages torch, torchvision, einops" in done.stderr and "requirements-opengait.txt" in done.stderr, done.stderr


def score(program, model, *arguments):
    """Returns standard error, rank-1 and the rows of probes."""
    cohort = ["--subjects", "F01,M01,F02,M02", "--azimuth-deg", "90,45", "--elevation-deg", "0", "--no-baselines"]
    files = ["--json", f"{model}.json", "--probes-csv", f"{model}.csv", "--cache", "none", "--overwrite"]
    done = subprocess.run(
        [program, "score", model, "--raster", "rows", *cohort, *files, *arguments], capture_output=True, text=True
    )
    if done.returncode:
        return done.stderr, None, None
    with open(f"{model}.csv", encoding="utf-8") as file:
        probes = list(csv.DictReader(file))
    return done.stderr, json.loads(Path(f"{model}.json").read_text())["recognizers"][0]["rank1"], probes


def the_embedded_runtime_runs_what_was_rewritten(program):
    for name in ("net", "flat"):
        Path(f"{name}.toml").write_text(CONTRACT)
    errors, rank1, _ = score(program, "net.onnx")
    assert rank1 is None and "slides over 3 axes" in errors, errors
    _, embedded, taken = score(program, "flat.onnx")
    assert embedded is not None and len(taken) == 8, taken
    if os.environ.get("EDGEGAIT_ORT_LIB"):
        _, original, others = score(program, "net.onnx", "--runtime", "ort")
        assert embedded == original and len(taken) == len(others)
        far = 0.0
        for one, other in zip(taken, others):
            for key, value in one.items():
                if key == "recognizer":
                    continue
                try:
                    far = max(far, abs(float(value) - float(other[key])) / max(abs(float(value)), 1e-3))
                except ValueError:
                    assert value == other[key], (one, other)
        assert far < 1e-3, far
        print(f"embedded runtime, rewritten, and ONNX Runtime, original: distances differ by {far:.1e} at most")
    print(f"embedded runtime: {len(taken)} probes, rank-1 {embedded}")


if __name__ == "__main__":
    program = str(Path(sys.argv[1]).resolve())
    os.chdir(sys.argv[2])
    windows_of_each_kind_compute_the_same()
    model = network(np.random.default_rng(4))
    a_network_computes_the_same(model)
    cube = what_cannot_be_rewritten_is_refused()
    weights_that_are_shared_or_computed_are_kept_apart()
    the_command_writes_whole_files_or_none(model, cube)
    the_exporter_says_which_packages_it_lacks()
    the_embedded_runtime_runs_what_was_rewritten(program)
