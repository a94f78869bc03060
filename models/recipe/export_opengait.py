"""Exports a network of OpenGait to ONNX, with the contract that EdgeGait reads.

    python export_opengait.py --opengait DIR --config DIR/configs/gaitbase/gaitbase_da_casiab.yaml \
        --checkpoint GaitBase_DA-60000.pt --out gaitbase.onnx

DIR is a checkout of github.com/ShiqiYu/OpenGait. Its model code is imported from there; this file
contains none of it. No GPU, distributed set-up or dataset is needed. GaitBase (Baseline in
OpenGait), GaitSet, GaitPart and DeepGaitV2 (2d, p3d) can be exported. The exported model takes
silhouettes `[N, T, 64, 44]`, for any number of people and frames, and gives embeddings in parts
`[N, c, p]`, in 2-D operators of ONNX operator set 17. Before it is written, its outputs in ONNX
Runtime are compared with those of the original in PyTorch.

requirements-opengait.txt lists all packages that this needs, including those of the checkout (torch,
torchvision, einops and PyYAML). TensorBoard, tqdm, OpenCV and Matplotlib, which the checkout also
imports, are not used here and need not be installed.
"""

from __future__ import annotations

import argparse
import contextlib
import copy
import hashlib
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import io
import json
import logging
import pickle
import re
import subprocess
import sys
import types
import warnings
from pathlib import Path

# The packages that must be installed: the name in Python, and pip's name.
PACKAGES = {
    "torch": "torch", "torchvision": "torchvision", "einops": "einops", "yaml": "pyyaml",
    "numpy": "numpy", "onnx": "onnx", "onnxscript": "onnxscript", "onnxruntime": "onnxruntime",
}
INSTALL = "pip install -r models/recipe/requirements-opengait.txt"
# OpenGait's files import these packages, but the networks do not use them.
UNUSED = ("tensorboard", "tqdm", "cv2", "matplotlib")
# The models by their name in a configuration, with their file in opengait/modeling/models.
MODELS = {"Baseline": "baseline", "GaitSet": "gaitset", "GaitPart": "gaitpart", "DeepGaitV2": "deepgaitv2"}
# The size of OpenGait's inputs: 64x64, less 10 columns on each side (`BaseSilCuttingTransform`).
ROWS, COLUMNS = 64, 44
CUTTING = "BaseSilCuttingTransform"
DISTANCES = {"euc": "euclidean", "cos": "cosine"}
OPSET, IR_VERSION = 17, 8
# The numbers of people and frames for which the exported network is compared with the original.
# Exporters tend to fix sizes of 1.
CHECKED = ((1, 1), (1, 9), (3, 5))
# The largest allowed difference, relative to the largest value. Our choice: different rounding in
# other kernels amounted to 4e-7.
TOLERANCE = 1e-4
NO_CHECKPOINT = "expected a checkpoint that PyTorch saved, found another or a truncated file"
# The number of keys of each kind that a message names.
NAMED = 3


missing = [pip for name, pip in PACKAGES.items() if importlib.util.find_spec(name) is None]
if missing:
    sys.exit(f"error: expected the Python packages {', '.join(missing)}, but they are not installed ({INSTALL})")

# Write no bytecode into this folder or the checkout.
sys.dont_write_bytecode = True

import numpy as np  # noqa: E402
import onnx  # noqa: E402
import torch  # noqa: E402
import yaml  # noqa: E402
from onnx import helper, numpy_helper  # noqa: E402

from pseudo3d import Refused, first_line, refuse_existing, rewrite, write_whole  # noqa: E402


class StandIns(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Provides empty modules in place of packages that are imported but not used."""

    def __init__(self, names: list[str]):
        self.names = names

    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in self.names or name == "torch.utils.tensorboard" and "tensorboard" in self.names:
            return importlib.machinery.ModuleSpec(name, self, is_package=True)
        return None

    def create_module(self, spec):
        return StandIn(spec.name)

    def exec_module(self, module):
        pass


class StandIn(types.ModuleType):
    """A module that has an empty class of any name."""

    def __getattr__(self, name: str):
        if name.startswith("__"):
            raise AttributeError(name)
        return type(name, (), {})


@contextlib.contextmanager
def checkout_importable(checkout: Path):
    """Makes the checkout's modules importable, one by one.

    The checkout's `modeling.models` imports all models, and packages that most of them do not need.
    It is replaced with a package that imports nothing.
    """
    source = checkout / "opengait"
    # Installed packages check for each other when first imported, so import them before the stand-ins exist.
    import torchvision.ops  # noqa: F401

    stand_ins = StandIns([name for name in UNUSED if importlib.util.find_spec(name) is None])
    sys.meta_path.insert(0, stand_ins)
    sys.path.insert(0, str(source))
    for name in ("modeling", "modeling.models"):
        package = types.ModuleType(name)
        package.__path__ = [str(source.joinpath(*name.split(".")))]
        sys.modules[name] = package
    try:
        yield
    except ModuleNotFoundError as error:
        raise Refused(f"{checkout}: its code needs the Python package {error.name!r} (pip install {error.name})") from error
    finally:
        sys.meta_path.remove(stand_ins)
        for name in [name for name, module in sys.modules.items() if isinstance(module, StandIn)]:
            del sys.modules[name]


class Embedding(torch.nn.Module):
    """A network that takes silhouettes and returns embeddings."""

    def __init__(self, network):
        super().__init__()
        self.network = network

    def forward(self, sils):
        found = self.network(([sils], None, None, None, None))
        return found["inference_feat"]["embeddings"]


def read_config(path: Path, checkout: Path) -> dict:
    """Reads a configuration and completes it as OpenGait does: recursively from configs/default.yaml."""
    config = read_yaml(path)
    if not isinstance(config.get("model_cfg"), dict):
        raise Refused(f"{path}: expected a configuration of OpenGait with model_cfg, found none")
    default = checkout / "configs" / "default.yaml"
    return merged(read_yaml(default), config) if default.is_file() else config


def read_yaml(path: Path) -> dict:
    try:
        found = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise Refused(f"{path}: expected YAML: {' '.join(str(error).split())}") from error
    if not isinstance(found, dict):
        raise Refused(f"{path}: expected a configuration of OpenGait, found {type(found).__name__}")
    return found


def merged(below: dict, above: dict) -> dict:
    result = dict(below)
    for key, value in above.items():
        inner = isinstance(value, dict) and isinstance(below.get(key), dict)
        result[key] = merged(below[key], value) if inner else value
    return result


def refuse_unsupported(path: Path, config: dict) -> str:
    """Returns the distance between a configuration's embeddings, if the network can be exported."""
    model = config["model_cfg"].get("model")
    if not isinstance(model, str) or model not in MODELS:
        raise Refused(f"{path}: expected the model {', '.join(MODELS)}, found {model}")
    backbone = config["model_cfg"].get("Backbone")
    if isinstance(backbone, dict) and backbone.get("mode") == "3d":
        raise Refused(
            f"{path}: expected DeepGaitV2 in mode 2d or p3d, found 3d: its 3x3x3 convolutions have no 2-D equivalent, "
            "and the embedded runtime has only 2-D ones"
        )
    evaluator = config.get("evaluator_cfg")
    evaluator = evaluator if isinstance(evaluator, dict) else {}
    transforms = evaluator.get("transform") or [{"type": CUTTING}]
    if transforms != [{"type": CUTTING}]:
        found = json.dumps(transforms, default=str)
        raise Refused(f"{path}: expected {CUTTING} as the only transform (evaluator_cfg: transform), found {found}")
    metric = evaluator.get("metric", "euc")
    if not isinstance(metric, str) or metric not in DISTANCES:
        raise Refused(f"{path}: evaluator_cfg: expected the metric {' or '.join(DISTANCES)}, found {metric}")
    return DISTANCES[metric]


def build(path: Path, config: dict, seed: int = 0):
    """Builds the network of a configuration, with random weights."""
    model = config["model_cfg"]["model"]
    module = importlib.import_module(f"modeling.models.{MODELS[model]}")
    kind = getattr(module, model)
    # Skip its own `__init__`, which needs CUDA, loaders and a process group.
    network = kind.__new__(kind)
    torch.nn.Module.__init__(network)
    torch.manual_seed(seed)
    try:
        network.build_network(copy.deepcopy(config["model_cfg"]))
    except ModuleNotFoundError:
        raise
    except Exception as error:
        raise Refused(f"{path}: OpenGait cannot build {model} from this model_cfg: {kind_of(error)}") from error
    convolutions = (torch.nn.Conv1d, torch.nn.Conv2d, torch.nn.Conv3d)
    first = next((part for part in network.modules() if isinstance(part, convolutions)), None)
    if first is not None and first.in_channels != 1:
        raise Refused(f"{path}: expected a network for silhouettes, which have 1 channel, found {first.in_channels} channels")
    return network.eval()


def kind_of(error: BaseException) -> str:
    """Describes an error of other code in one line, with its type, as the text of a KeyError is only the key."""
    kind = type(error).__name__
    return f"{kind}: {first_line(error)}" if str(error) else kind


def randomise(network, seed: int) -> None:
    """Sets random weights, and batch normalisation that is not the identity, as after training."""
    torch.manual_seed(seed)
    network.init_parameters()
    for part in network.modules():
        if isinstance(part, torch.nn.modules.batchnorm._BatchNorm):
            part.running_mean.normal_(0.0, 0.2)
            part.running_var.uniform_(0.5, 2.0)
            part.weight.data.uniform_(0.5, 1.5)
            part.bias.data.normal_(0.0, 0.2)


def read_checkpoint(path: Path) -> tuple[dict, str]:
    """Returns the tensors by name, and the file's SHA-256."""
    content = path.read_bytes()
    try:
        found = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        # The error names what PyTorch would have to run.
        more = re.search(r"GLOBAL (\S+)", str(error))
        if more is None:
            raise Refused(f"{path}: {NO_CHECKPOINT}") from error
        raise Refused(
            f"{path}: expected tensors and plain values, found {more[1]}, and loading that could run code "
            '(if you trust it: torch.save({"model": torch.load(FILE, weights_only=False)["model"]}, OTHER))'
        ) from error
    except Exception as error:  # unpickling can raise anything
        raise Refused(f"{path}: {NO_CHECKPOINT}") from error
    tensors = found.get("model") if isinstance(found, dict) else None
    if not isinstance(tensors, dict) or not all(isinstance(tensor, torch.Tensor) for tensor in tensors.values()):
        keys = f"the keys {', '.join(map(str, list(found)[:NAMED]))} ..." if isinstance(found, dict) else type(found).__name__
        raise Refused(f'{path}: expected a checkpoint of OpenGait with weights under "model", found {keys}')
    return tensors, hashlib.sha256(content).hexdigest()


def differences(network, tensors: dict) -> list[str]:
    """Returns the differences between tensors and a network's weights; empty if they fit."""
    own = {name: list(tensor.shape) for name, tensor in network.state_dict().items()}
    given = {name: list(tensor.shape) for name, tensor in tensors.items()}
    other = [f"{name}: expected {own[name]}, found {given[name]}" for name in own if name in given and own[name] != given[name]]
    kinds = {
        "missing": [name for name in own if name not in given],
        "unexpected": [name for name in given if name not in own],
        "of other shapes": other,
    }
    return [
        f"{len(names)} {kind} ({', '.join(names[:NAMED])}{' ...' if len(names) > NAMED else ''})"
        for kind, names in kinds.items() if names
    ]


def load(network, tensors: dict, path: Path, config_path: Path, checkout: Path) -> None:
    """Loads the weights into the network, all or none."""
    found = differences(network, tensors)
    if found:
        fitting = fitting_configs(tensors, checkout)
        others = f"; it fits {', '.join(fitting)}" if fitting else "; it fits no configuration of the checkout that can be exported"
        raise Refused(f"{path}: expected the weights of {config_path.name}, found keys that differ: {', '.join(found)}{others}")
    network.load_state_dict(tensors, strict=True)


def fitting_configs(tensors: dict, checkout: Path) -> list[str]:
    """Returns the checkout's configurations whose networks fit these weights."""
    fitting = []
    for path in sorted((checkout / "configs").rglob("*.yaml")):
        # Skip configurations that cannot be read or exported.
        with contextlib.suppress(Refused, OSError):
            config = read_config(path, checkout)
            refuse_unsupported(path, config)
            # Build shapes only, without values.
            with torch.device("meta"):
                network = build(path, config)
            if not differences(network, tensors):
                fitting.append(path.relative_to(checkout).as_posix())
    return fitting


class MaxPoolOfRows(torch.nn.Module):
    """A MaxPool1d as a 2-D one over single rows, as PyTorch's export of MaxPool1d fixes the number of frames."""

    def __init__(self, pool):
        super().__init__()
        self.pool = pool

    def forward(self, x):
        kernel, stride, padding, dilation = (
            number if isinstance(number, int) else number[0]
            for number in (self.pool.kernel_size, self.pool.stride, self.pool.padding, self.pool.dilation)
        )
        return torch.nn.functional.max_pool2d(
            x.unsqueeze(-2), (1, kernel), (1, stride), (0, padding), (1, dilation), self.pool.ceil_mode
        ).squeeze(-2)


def export(network) -> onnx.ModelProto:
    """Exports a network to ONNX with 2-D operators."""
    network = copy.deepcopy(network)
    for part in list(network.modules()):
        for name, child in list(part.named_children()):
            if isinstance(child, torch.nn.MaxPool1d):
                setattr(part, name, MaxPoolOfRows(child))
    dims = {0: torch.export.Dim("N"), 1: torch.export.Dim("T")}
    example = torch.rand(2, 7, ROWS, COLUMNS)
    # Export the program first: torch.onnx.export would silently fix sizes that it cannot keep dynamic.
    program = torch.export.export(Embedding(network), (example,), dynamic_shapes=(dims,))
    program = torch.onnx.export(
        program, input_names=["sils"], output_names=["embedding"], dynamo=True, opset_version=18, verbose=False,
    )
    model, _ = rewrite(older(program.model_proto))
    return model


def older(model: onnx.ModelProto) -> onnx.ModelProto:
    """Converts a model from operator set 18, the oldest that the exporter writes, to set 17.

    In set 17, axes of reductions other than sums are attributes, and the outputs of Split define
    its number of parts. Parts of shapes are taken with Gather, which more readers support. The
    checker and the comparison with PyTorch find other differences between the sets. The exporter's
    own names and paths are removed.
    """
    graph = model.graph
    constants = {tensor.name: tensor for tensor in graph.initializer}
    nodes = []
    for node in graph.node:
        del node.metadata_props[:]
        node.doc_string = ""
        attributes = {item.name: helper.get_attribute_value(item) for item in node.attribute}
        if node.op_type.startswith("Reduce") and node.op_type != "ReduceSum" and len(node.input) == 2:
            attributes.pop("noop_with_empty_axes", None)
            attributes["axes"] = numpy_helper.to_array(constants[node.input[1]]).tolist()
            nodes.append(helper.make_node(node.op_type, node.input[:1], node.output, node.name, **attributes))
        elif node.op_type == "Split":
            attributes.pop("num_outputs", None)
            nodes.append(helper.make_node("Split", node.input, node.output, node.name, **attributes))
        elif node.op_type == "Shape" and attributes:
            places = np.arange(attributes["start"], attributes["end"], dtype=np.int64)
            whole, which = f"{node.output[0]}/whole", f"{node.output[0]}/which"
            graph.initializer.append(numpy_helper.from_array(places, which))
            nodes.append(helper.make_node("Shape", node.input, [whole], f"{node.name}/whole"))
            nodes.append(helper.make_node("Gather", [whole, which], node.output, node.name))
        else:
            nodes.append(node)
    read = {name for node in nodes for name in node.input}
    kept = [tensor for tensor in graph.initializer if tensor.name in read]
    fresh = helper.make_graph(nodes, "opengait", graph.input, graph.output, kept)
    for value in (*fresh.input, *fresh.output, *fresh.initializer):
        del value.metadata_props[:]
        value.doc_string = ""
    free = [size.dim_param for size in fresh.input[0].type.tensor_type.shape.dim]
    for value in (*fresh.input, *fresh.output):
        for size in value.type.tensor_type.shape.dim:
            if size.dim_param:
                size.dim_param = "NT"[free.index(size.dim_param)]
    result = helper.make_model(fresh, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION)
    result.producer_name = "edgegait export_opengait"
    return result


def check(model: onnx.ModelProto, network) -> float:
    """Returns the largest difference from PyTorch, relative to the largest value; rejects too large a difference."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3
    session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
    random = torch.Generator().manual_seed(1)
    worst = 0.0
    for people, frames in CHECKED:
        sils = torch.rand(people, frames, ROWS, COLUMNS, generator=random)
        with torch.no_grad():
            expected = Embedding(network)(sils).numpy()
        found = session.run(["embedding"], {"sils": sils.numpy()})[0]
        if found.shape != expected.shape or not np.isfinite(found).all():
            raise Refused(f"the exported network: expected finite numbers {list(expected.shape)}, found {list(found.shape)} or others")
        worst = max(worst, float(np.abs(found - expected).max() / np.abs(expected).max()))
    if not worst <= TOLERANCE:
        raise Refused(f"the exported network: expected PyTorch's outputs within {TOLERANCE}, found a difference of {worst:.1e}")
    return worst


def contract(distance: str, description: str) -> str:
    """Returns the model's contract as TOML, in which JSON strings are valid."""
    return f"""template = "silhouettes"
layout = "NTHW"
rows = {ROWS}
columns = {COLUMNS}
framing = "height"
input_range = "0..1"
distance = "{distance}"

[outputs]
embedding = "embedding"

[training]
description = {json.dumps(description, ensure_ascii=False)}
"""


def commit_of(checkout: Path) -> str | None:
    """Returns the checkout's git commit, if it is a repository."""
    command = ["git", "-C", str(checkout), "rev-parse", "--show-toplevel", "HEAD"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=30)
    except (OSError, subprocess.TimeoutExpired):
        return None
    lines = done.stdout.splitlines()
    # The commit of a repository around the folder does not count.
    is_own = done.returncode == 0 and len(lines) == 2 and Path(lines[0]).resolve() == checkout.resolve()
    return lines[1] if is_own else None


def described(config_path: Path, config: dict, checkout: Path, weights: str) -> str:
    path = config_path.resolve()
    within = path.is_relative_to(checkout.resolve())
    name = path.relative_to(checkout.resolve()).as_posix() if within else path.name
    commit = commit_of(checkout)
    source = f"OpenGait {commit}" if commit else "OpenGait"
    return f"{config['model_cfg']['model']} of {source}, {name}; {weights}"


def run(given: argparse.Namespace) -> None:
    checkout = given.opengait
    if not (checkout / "opengait" / "modeling" / "base_model.py").is_file():
        raise Refused(f"{checkout}: expected a checkout of OpenGait, found no opengait/modeling/base_model.py in it")
    beside = given.out.with_suffix(".toml")
    for path in (given.out, beside):
        refuse_existing(path, given.overwrite)
    config = read_config(given.config, checkout)
    distance = refuse_unsupported(given.config, config)
    with checkout_importable(checkout):
        network = build(given.config, config, given.random_weights or 0)
        if given.checkpoint:
            tensors, digest = read_checkpoint(given.checkpoint)
            load(network, tensors, given.checkpoint, given.config, checkout)
            data = (config.get("data_cfg") or {}).get("dataset_name", "unknown data")
            weights = f"checkpoint {given.checkpoint.name}, SHA-256 {digest}; trained on {data}, says the configuration"
        else:
            randomise(network, given.random_weights)
            weights = f"random weights, seed {given.random_weights}: for latencies only, its answers mean nothing"
    try:
        model = export(network)
        worst = check(model, network)
    except Refused:
        raise
    except Exception as error:
        raise Refused(f"{given.config}: PyTorch could not export it: {kind_of(error)}") from error
    text = contract(distance, described(given.config, config, checkout, weights))
    # The contract comes first, as a model without it would get wrong inputs.
    write_whole({beside: text.encode("utf-8"), given.out: model.SerializeToString()})
    parameters = sum(part.numel() for part in network.parameters())
    shape = [size.dim_param or size.dim_value for size in model.graph.output[0].type.tensor_type.shape.dim]
    print(
        f"{given.out}: {config['model_cfg']['model']}, {parameters / 1e6:.1f} M parameters, sils [N, T, {ROWS}, {COLUMNS}] "
        f"to embedding [{', '.join(map(str, shape))}]; differs from PyTorch by {worst:.1e} of the largest value"
    )
    print(f"{beside}: its contract")


def seed(text: str) -> int:
    """Parses a seed for PyTorch."""
    number = int(text)
    if not 0 <= number < 2**63:
        raise ValueError(text)
    return number


def main() -> None:
    parser = argparse.ArgumentParser(description="Exports a network of OpenGait to ONNX, with its contract.")
    parser.add_argument("--opengait", type=Path, required=True, metavar="DIR", help="a checkout of OpenGait")
    parser.add_argument("--config", type=Path, required=True, metavar="FILE.yaml", help="one of its configurations")
    weights = parser.add_mutually_exclusive_group(required=True)
    weights.add_argument("--checkpoint", type=Path, metavar="FILE.pt", help="a checkpoint of its training")
    weights.add_argument("--random-weights", type=seed, metavar="SEED", help="random weights with this seed, to measure latencies only")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE.onnx", help="the model to write, with its contract FILE.toml")
    parser.add_argument("--overwrite", action="store_true", help="replace FILE.onnx and FILE.toml")
    given = parser.parse_args()
    if given.out.suffix != ".onnx":
        parser.error(f"--out: expected a name that ends in .onnx, found {given.out}")
    warnings.simplefilter("ignore")
    logging.disable(logging.WARNING)
    try:
        run(given)
    except Refused as error:
        sys.exit(f"error: {error}")
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        sys.exit(f"error: {where}{error.strerror or error}")


if __name__ == "__main__":
    main()
