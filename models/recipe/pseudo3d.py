"""Rewrites the pseudo-3-D windows of an ONNX file as 2-D windows.

    python pseudo3d.py IN.onnx OUT.onnx [--overwrite]

A network of sequences `[n, c, s, h, w]` is pseudo-3-D if each of its convolutions slides over the
rows and columns of a frame (1x3x3), over the frames at a place (3x1x1) or over neither (1x1x1).
Runtimes for small machines, such as the one in EdgeGait, have convolutions over one or two axes only.
2-D windows can compute the same:

- `[k,1,1]` on `[n, c, s, h, w]` is `[k,1]` on `[n, c, s, h*w]`;
- a kernel that is 1 along another axis is the kernel without that axis on `[n*s, c, h, w]` (if the
  axis is the frames; likewise for rows or columns).

The same holds for MaxPool and AveragePool. Along an axis where the kernel is 1, a stride selects
elements and padding adds zeros; both are done before the window. Everything else is unchanged. A
kernel without a 1 is an error. Needs onnx and NumPy.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path

import numpy as np
import onnx
from onnx import GraphProto, ModelProto, NodeProto, TensorProto, helper, numpy_helper

WINDOWS = ("Conv", "MaxPool", "AveragePool")
# Their windows slide over all axes of their input after the first two; they are not rewritten.
OTHER_WINDOWS = ("ConvTranspose", "ConvInteger", "QLinearConv", "DeformConv", "LpPool", "MaxUnpool")
# From this operator set on, Slice, Pad and Unsqueeze take their numbers as inputs, as written here.
OLDEST_OPSET = 13
# The axes over which windows slide in `[n, c, s, h, w]`.
SLID = (2, 3, 4)


class Refused(Exception):
    """An error message of one line."""


def rewrite(model: ModelProto) -> tuple[ModelProto, int]:
    """Returns the network with 2-D windows in place of pseudo-3-D ones, and their number.

    Raises `Refused`, with the node's name, for a window that slides over three axes.
    """
    opset = max((entry.version for entry in model.opset_import if entry.domain in ("", "ai.onnx")), default=0)
    if opset < OLDEST_OPSET:
        raise Refused(f"expected operator set {OLDEST_OPSET} or newer, found {opset} (onnx.version_converter raises it)")
    onnx.checker.check_model(model)
    refuse_hidden(model)
    rewriting = Rewriting(model)
    rewriting.run()
    result = ModelProto()
    result.CopyFrom(model)
    graph = result.graph
    del graph.node[:], graph.value_info[:]
    graph.node.extend(rewriting.nodes)
    graph.initializer.extend(rewriting.constants)
    drop_unused(graph, rewriting.replaced)
    result = onnx.shape_inference.infer_shapes(result)
    onnx.checker.check_model(result, full_check=True)
    return result, rewriting.count


class Rewriting:
    """A pass over a graph's nodes, in order."""

    def __init__(self, model: ModelProto):
        graph = model.graph
        self.source = graph.node
        self.initializers = {tensor.name: tensor for tensor in graph.initializer}
        self.shapes = stated_shapes(onnx.shape_inference.infer_shapes(model, data_prop=True).graph)
        self.names = {name for node in graph.node for name in (node.name, *node.input, *node.output)}
        self.names.update(value.name for value in (*graph.input, *graph.output, *graph.initializer))
        self.nodes: list[NodeProto] = []
        self.constants: list[TensorProto] = []
        # Weights that have a 2-D copy.
        self.replaced: set[str] = set()
        self.count = 0

    def run(self) -> None:
        for node in self.source:
            if window_rank(node, self.shapes) == 3:
                self.window(node)
                self.count += 1
            else:
                self.nodes.append(node)

    def window(self, node: NodeProto) -> None:
        """Replaces a 3-D window with nodes around a 2-D window."""
        attributes = {item.name: helper.get_attribute_value(item) for item in node.attribute}
        kernel = self.kernel(node, attributes)
        title = f"{node.op_type} {label(node)}"
        if all(size > 1 for size in kernel):
            found = "x".join(str(size) for size in kernel)
            raise Refused(f"{title}: expected a kernel that is 1 along frames, rows or columns, found {found} (true 3-D)")
        if len([name for name in node.output if name]) > 1:
            raise Refused(f"{title}: expected one output, found also the indices of the maxima")
        strides = list(attributes.get("strides") or [1, 1, 1])
        dilations = list(attributes.get("dilations") or [1, 1, 1])
        pads = list(attributes.get("pads") or [0] * 6)
        merged = kernel[1] == kernel[2] == 1 < kernel[0]
        # The axes that the 2-D window does not cover, counted from the first axis of the window.
        free = [1, 2] if merged else [kernel.index(1)]
        kept = [axis for axis in range(3) if axis not in free]
        # Along axes where the kernel is 1, SAME adds no padding.
        value = self.padded(node, title, free, pads)
        value = self.strided(node, value, free, strides)
        before = self.shapes.get(value)
        # A merged window is (k, 1) over frames and places; others keep their two axes.
        axes = [0, None] if merged else kept
        along = lambda numbers, other: [other if axis is None else numbers[axis] for axis in axes]  # noqa: E731
        flat = dict(attributes)
        flat["kernel_shape"] = along(kernel, 1)
        flat["strides"] = along(strides, 1)
        flat.pop("dilations", None)
        if any(size != 1 for size in along(dilations, 1)):
            flat["dilations"] = along(dilations, 1)
        flat.pop("pads", None)
        if flat.get("auto_pad", b"NOTSET") == b"NOTSET":
            flat["pads"] = along(pads[:3], 0) + along(pads[3:], 0)
        window_inputs = list(node.input[1:])
        if node.op_type == "Conv":
            window_inputs[0] = self.weights(node.input[1], along(kernel, 1))

        def slid(given: str) -> str:
            return self.add(node, node.op_type, [given, *window_inputs], "window", **flat)

        if merged:
            given = self.reshaped(node, value, [0, 0, 0, -1])
            last = self.sizes(node, value, before, [3, 4])
            self.reshaped(node, slid(given), [0, 0, 0, *last], node.output[0])
            return
        # The free axis first: [n, free, c, a, b], then [n * free, c, a, b].
        order = [0, SLID[free[0]], 1, *(SLID[axis] for axis in kept)]
        turned = self.add(node, "Transpose", [value], "turned", perm=order)
        given = self.reshaped(node, turned, [-1, *self.sizes(node, value, before, order[2:])])
        result = slid(given)
        # The sizes of the merged axes come first, then those of the result.
        whole = [*self.sizes(node, value, before, order[:2]), *self.sizes(node, result, self.after(node, order), [1, 2, 3])]
        parted = self.reshaped(node, result, whole)
        back = [order.index(axis) for axis in range(5)]
        self.add(node, "Transpose", [parted], None, node.output[0], perm=back)

    def kernel(self, node: NodeProto, attributes: dict) -> list[int]:
        """Returns the sizes of the window along frames, rows and columns."""
        if node.op_type != "Conv":
            return list(attributes["kernel_shape"])
        return [int(size) for size in self.shapes[node.input[1]][2:]]

    def after(self, node: NodeProto, order: list[int]) -> list[int | None] | None:
        """Returns the known sizes of `[n * free, c, a, b]` after the window, from the shape that the file states."""
        shape = self.shapes.get(node.output[0])
        return shape and [None, *(shape[axis] for axis in order[2:])]

    def padded(self, node: NodeProto, title: str, free: list[int], pads: list[int]) -> str:
        """Returns the input, padded with zeros along the axes where the kernel is 1."""
        if not any(pads[axis] or pads[3 + axis] for axis in free):
            return node.input[0]
        if node.op_type != "Conv":
            raise Refused(f"{title}: expected no padding where the kernel is 1, found pads {pads}")
        around = [0] * 10
        for axis in free:
            around[2 + axis], around[7 + axis] = pads[axis], pads[3 + axis]
        inputs = [node.input[0], self.constant(node, around)]
        result = self.add(node, "Pad", inputs, "padded")
        shape = self.shapes.get(node.input[0])
        self.shapes[result] = shape and [size and size + around[axis] + around[5 + axis] for axis, size in enumerate(shape)]
        return result

    def strided(self, node: NodeProto, value: str, free: list[int], strides: list[int]) -> str:
        """Applies strides along the axes where the kernel is 1."""
        steps = {SLID[axis]: strides[axis] for axis in free if strides[axis] != 1}
        if not steps:
            return value
        numbers = ([0] * len(steps), [np.iinfo(np.int64).max] * len(steps), list(steps), list(steps.values()))
        inputs = [value, *(self.constant(node, list(part)) for part in numbers)]
        result = self.add(node, "Slice", inputs, "strided")
        shape = self.shapes.get(value)
        self.shapes[result] = shape and [size and -(-size // steps.get(axis, 1)) for axis, size in enumerate(shape)]
        return result

    def weights(self, name: str, kernel: list[int]) -> str:
        """Returns the name of these weights with a kernel over two axes."""
        shape = [int(size) for size in (*self.shapes[name][:2], *kernel)]
        flat = self.unused(f"{name}/2d")
        if name in self.initializers:
            numbers = numpy_helper.to_array(self.initializers[name]).reshape(shape)
            self.constants.append(numpy_helper.from_array(numbers, flat))
            self.replaced.add(name)
        else:
            asked = self.unused(f"{flat}/shape")
            self.constants.append(numpy_helper.from_array(np.array(shape, np.int64), asked))
            self.nodes.append(helper.make_node("Reshape", [name, asked], [flat], name=flat))
        return flat

    def sizes(self, node: NodeProto, value: str, shape: list[int | None] | None, axes: list[int]) -> list[int | str]:
        """Returns the sizes of a value along axes: numbers if they are fixed, else names of computed values."""
        sizes = [shape[axis] if shape else None for axis in axes]
        if None not in sizes:
            return sizes
        whole = self.add(node, "Shape", [value], "shape")
        return [
            self.add(node, "Gather", [whole, self.constant(node, [axis])], "size") if size is None else size
            for axis, size in zip(axes, sizes)
        ]

    def reshaped(self, node: NodeProto, value: str, sizes: list[int | str], to: str | None = None) -> str:
        """Reshapes a value; a single computed size is left to the runtime (-1)."""
        computed = [at for at, size in enumerate(sizes) if isinstance(size, str)]
        if len(computed) == 1 and -1 not in sizes:
            sizes = [-1 if at in computed else size for at, size in enumerate(sizes)]
        if any(isinstance(size, str) for size in sizes):
            parts = [size if isinstance(size, str) else self.constant(node, [size]) for size in sizes]
            shape = self.add(node, "Concat", parts, "sizes", axis=0)
        else:
            shape = self.constant(node, sizes)
        return self.add(node, "Reshape", [value, shape], "reshaped", to)

    def constant(self, node: NodeProto, numbers: list[int]) -> str:
        name = self.unused(f"{label(node)}/numbers")
        self.constants.append(numpy_helper.from_array(np.array(numbers, np.int64), name))
        return name

    def add(self, node: NodeProto, operator: str, inputs: list[str], what: str | None, to: str | None = None, **attributes) -> str:
        """Adds a node that replaces part of another, and returns the name of its output."""
        result = to or self.unused(f"{label(node)}/{what}")
        name = self.unused(f"{label(node)}/{operator}")
        self.nodes.append(helper.make_node(operator, inputs, [result], name=name, **attributes))
        return result

    def unused(self, name: str) -> str:
        free, number = name, 1
        while free in self.names:
            number += 1
            free = f"{name}.{number}"
        self.names.add(free)
        return free


def label(node: NodeProto) -> str:
    """Returns a node's name, or else that of its output."""
    return node.name or node.output[0]


def stated_shapes(graph: GraphProto) -> dict[str, list[int | None] | None]:
    """Returns shapes by name, with `None` for sizes, or shapes, that are not fixed."""
    shapes: dict[str, list[int | None] | None] = {}
    for value in (*graph.value_info, *graph.input, *graph.output):
        kind = value.type.tensor_type
        if kind.HasField("shape"):
            shapes[value.name] = [size.dim_value if size.HasField("dim_value") else None for size in kind.shape.dim]
    for tensor in graph.initializer:
        shapes[tensor.name] = list(tensor.dims)
    return shapes


def window_rank(node: NodeProto, shapes: dict) -> int | None:
    """Returns the number of axes that a node's window slides over; `None` without a window."""
    if node.domain not in ("", "ai.onnx"):
        return None
    if node.op_type in ("MaxPool", "AveragePool"):
        return len(next(item.ints for item in node.attribute if item.name == "kernel_shape"))
    if node.op_type not in WINDOWS + OTHER_WINDOWS:
        return None
    known = [len(shape) - 2 for shape in map(shapes.get, node.input[:2]) if shape]
    weights = shapes.get(node.input[1]) if node.op_type == "Conv" else None
    if node.op_type == "Conv" and (3 in known or not known) and (weights is None or None in weights):
        raise Refused(f"Conv {label(node)}: expected weights of a fixed shape, found no stated shape")
    if node.op_type in OTHER_WINDOWS and 3 in known:
        raise Refused(f"{node.op_type} {label(node)}: expected windows over three axes only of {', '.join(WINDOWS)}")
    return len(weights) - 2 if weights else None


def refuse_hidden(model: ModelProto) -> None:
    """Rejects windows over three axes in nested graphs and functions, where no exporter writes them."""
    def look(nodes, where: str | None) -> None:
        for node in nodes:
            kernels = [item.ints for item in node.attribute if item.name == "kernel_shape"]
            if where and node.op_type in WINDOWS + OTHER_WINDOWS and (not kernels or len(kernels[0]) == 3):
                raise Refused(f"{node.op_type} {label(node)}: expected windows in the outermost graph, found one in {where}")
            for item in node.attribute:
                for graph in (*item.graphs, *([item.g] if item.HasField("g") else [])):
                    look(graph.node, f"a branch of {node.op_type} {label(node)}")

    look(model.graph.node, None)
    for function in model.functions:
        look(function.node, f"the function {function.name}")


def drop_unused(graph: GraphProto, names: set[str]) -> None:
    """Removes these weights if no node uses them any more."""
    def read(nodes) -> set[str]:
        names = {name for node in nodes for name in node.input}
        for node in nodes:
            for item in node.attribute:
                for inner in (*item.graphs, *([item.g] if item.HasField("g") else [])):
                    names |= read(inner.node)
        return names

    gone = names - read(graph.node) - {value.name for value in graph.output}
    for values in (graph.initializer, graph.input):
        kept = [value for value in values if value.name not in gone]
        del values[:]
        values.extend(kept)


def write_whole(files: dict[Path, bytes]) -> None:
    """Writes files under temporary names and renames them, in order, so that no incomplete file appears."""
    written = []
    try:
        for path, content in files.items():
            descriptor, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
            written.append((name, path))
            with os.fdopen(descriptor, "wb") as file:
                file.write(content)
            # Temporary files are readable only for their owner.
            os.chmod(name, 0o666 & ~current_umask())
        for name, path in written:
            os.replace(name, path)
    finally:
        for name, _ in written:
            if os.path.exists(name):
                os.unlink(name)


def current_umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def refuse_existing(path: Path, overwrite: bool) -> None:
    if not path.parent.is_dir():
        raise Refused(f"{path}: expected the folder {path.parent}, found none")
    if path.is_dir():
        raise Refused(f"{path}: expected a file's name, found a folder")
    if path.exists() and not overwrite:
        raise Refused(f"{path}: already exists (--overwrite replaces it)")


def read_model(path: Path) -> ModelProto:
    try:
        model = onnx.load(path)
    except OSError as error:
        raise Refused(f"{path}: {error.strerror or error}") from error
    except Exception as error:  # protobuf's own error class differs between its versions
        raise Refused(f"{path}: expected an ONNX model, found something else ({first_line(error)})") from error
    if not model.HasField("graph"):
        raise Refused(f"{path}: expected an ONNX model, found no graph in it")
    return model


def first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0]


def main() -> None:
    parser = argparse.ArgumentParser(description="Rewrites the pseudo-3-D windows of an ONNX file as 2-D windows.")
    parser.add_argument("source", type=Path, metavar="IN.onnx")
    parser.add_argument("out", type=Path, metavar="OUT.onnx")
    parser.add_argument("--overwrite", action="store_true", help="replace OUT.onnx")
    given = parser.parse_args()
    try:
        refuse_existing(given.out, given.overwrite)
        model = read_model(given.source)
        try:
            result, count = rewrite(model)
        except Refused as error:
            raise Refused(f"{given.source}: {error}") from error
        except (onnx.checker.ValidationError, onnx.shape_inference.InferenceError) as error:
            raise Refused(f"{given.source}: expected a valid ONNX model: {first_line(error)}") from error
        write_whole({given.out: result.SerializeToString()})
        print(f"{given.out}: {count} windows over three axes rewritten as windows over two")
    except (Refused, OSError) as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
