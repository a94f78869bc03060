"""Exports a network of OpenGait's to ONNX, with the contract that EdgeGait reads beside it.

    python export_opengait.py --opengait DIR --config DIR/configs/gaitbase/gaitbase_da_casiab.yaml \
        --checkpoint GaitBase_DA-60000.pt --out gaitbase.onnx

DIR is a checkout of github.com/ShiqiYu/OpenGait; its own model code is imported from there, and none
of it is here. No GPU, no distributed set-up and no data set are needed. GaitBase (OpenGait calls it
Baseline), GaitSet, GaitPart and DeepGaitV2 (2d, p3d) can be exported. What comes out takes
silhouettes `[N, T, 64, 44]`, any number of people and frames, and gives embeddings in parts
`[N, c, p]`, in 2-D operators of ONNX operator set 17. Before it is written, ONNX Runtime computes
the same with it as PyTorch with the original.

The checkout needs torch, torchvision, einops and PyYAML; requirements-opengait.txt has all that this
needs. TensorBoard, tqdm, OpenCV and Matplotlib, which its files import too, are not used by what
runs here, and need not be installed.
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

# What has to be installed: the name in Python, and pip's if it is another.
PACKAGES = {
    "torch": "torch", "torchvision": "torchvision", "einops": "einops", "yaml": "pyyaml",
    "numpy": "numpy", "onnx": "onnx", "onnxscript": "onnxscript", "onnxruntime": "onnxruntime",
}
INSTALL = "pip install -r models/recipe/requirements-opengait.txt"
# OpenGait's files import these on their way, and no network here computes with them.
UNUSED = ("tensorboard", "tqdm", "cv2", "matplotlib")
# Models by their name in a configuration, and the file of opengait/modeling/models that has them.
MODELS = {"Baseline": "baseline", "GaitSet": "gaitset", "GaitPart": "gaitpart", "DeepGaitV2": "deepgaitv2"}
# What OpenGait's files are cut to: 64x64, less 10 columns on each side (`BaseSilCuttingTransform`).
ROWS, COLUMNS = 64, 44
CUTTING = "BaseSilCuttingTransform"
DISTANCES = {"euc": "euclidean", "cos": "cosine"}
OPSET, IR_VERSION = 17, 8
# People and frames with which the exported network is compared with the original. One is the case
# that exporters take for granted.
CHECKED = ((1, 1), (1, 9), (3, 5))
# Most that a number may differ by, as a part of the largest one. Ours: last bits that other kernels
# round otherwise came to 4e-7.
TOLERANCE = 1e-4
NO_CHECKPOINT = "expected a checkpoint that PyTorch saved, found something else, or one that is cut short"
# Keys of a checkpoint that a message names of each kind.
NAMED = 3


missing = [pip for name, pip in PACKAGES.items() if importlib.util.find_spec(name) is None]
if missing:
    sys.exit(f"error: expected the Python packages {', '.join(missing)}, found none of them ({INSTALL})")

# Nothing is written into this folder, nor into the checkout.
sys.dont_write_bytecode = True

import numpy as np  # noqa: E402
import onnx  # noqa: E402
import torch  # noqa: E402
import yaml  # noqa: E402
from onnx import helper, numpy_helper  # noqa: E402

from pseudo3d import Refused, first_line, refuse_existing, rewrite, write_whole  # noqa: E402


class StandIns(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds empty modules in place of packages that are imported but not used."""

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
    """A module with whatever class is asked for."""

    def __getattr__(self, name: str):
        if name.startswith("__"):
            raise AttributeError(name)
        return type(name, (), {})


@contextlib.contextmanager
def checkout_importable(checkout: Path):
    """Within this, the checkout's own modules can be imported, one by one.

    `modeling.models` imports all models there are, and packages that most of them do not need: here
    it is a package that imports nothing.
    """
    source = checkout / "opengait"
    # Installed packages look each other up when they are first imported: now, while they find the truth.
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
    """Silhouettes in, embeddings out."""

    def __init__(self, network):
        super().__init__()
        self.network = network

    def forward(self, sils):
        found = self.network(([sils], None, None, None, None))
        return found["inference_feat"]["embeddings"]


def read_config(path: Path, checkout: Path) -> dict:
    """A configuration, completed as OpenGait does it: by configs/default.yaml, dictionaries in depth."""
    config = read_yaml(path)
    if not isinstance(config.get("model_cfg"), dict):
        raise Refused(f"{path}: expected a configuration of OpenGait's with model_cfg, found none")
    default = checkout / "configs" / "default.yaml"
    return merged(read_yaml(default), config) if default.is_file() else config


def read_yaml(path: Path) -> dict:
    try:
        found = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise Refused(f"{path}: expected YAML: {' '.join(str(error).split())}") from error
    if not isinstance(found, dict):
        raise Refused(f"{path}: expected a configuration of OpenGait's, found {type(found).__name__}")
    return found


def merged(below: dict, above: dict) -> dict:
    result = dict(below)
    for key, value in above.items():
        inner = isinstance(value, dict) and isinstance(below.get(key), dict)
        result[key] = merged(below[key], value) if inner else value
    return result


def refuse_unsupported(path: Path, config: dict) -> str:
    """The distance by which a configuration's embeddings are compared, if the network can be exported."""
    model = config["model_cfg"].get("model")
    if not isinstance(model, str) or model not in MODELS:
        raise Refused(f"{path}: expected the model {', '.join(MODELS)}, found {model}")
    backbone = config["model_cfg"].get("Backbone")
    if isinstance(backbone, dict) and backbone.get("mode") == "3d":
        raise Refused(
            f"{path}: expected DeepGaitV2 of the mode 2d or p3d, found 3d: its 3x3x3 convolutions are no 2-D ones, "
            "and the embedded runtime has no others"
        )
    evaluator = config.get("evaluator_cfg")
    evaluator = evaluator if isinstance(evaluator, dict) else {}
    transforms = evaluator.get("transform") or [{"type": CUTTING}]
    if transforms != [{"type": CUTTING}]:
        found = json.dumps(transforms, default=str)
        raise Refused(f"{path}: expected silhouettes as {CUTTING} alone gives them (evaluator_cfg: transform), found {found}")
    metric = evaluator.get("metric", "euc")
    if not isinstance(metric, str) or metric not in DISTANCES:
        raise Refused(f"{path}: evaluator_cfg: expected the metric {' or '.join(DISTANCES)}, found {metric}")
    return DISTANCES[metric]


def build(path: Path, config: dict, seed: int = 0):
    """The network of a configuration, with random weights."""
    model = config["model_cfg"]["model"]
    module = importlib.import_module(f"modeling.models.{MODELS[model]}")
    kind = getattr(module, model)
    # Its own `__init__` asks for CUDA, loaders and a process group.
    network = kind.__new__(kind)
    torch.nn.Module.__init__(network)
    torch.manual_seed(seed)
    try:
        network.build_network(copy.deepcopy(config["model_cfg"]))
    except ModuleNotFoundError:
        raise
    except Exception as error:
        raise Refused(f"{path}: OpenGait cannot build {model} of this model_cfg: {kind_of(error)}") from error
    convolutions = (torch.nn.Conv1d, torch.nn.Conv2d, torch.nn.Conv3d)
    first = next((part for part in network.modules() if isinstance(part, convolutions)), None)
    if first is not None and first.in_channels != 1:
        raise Refused(f"{path}: expected a network of silhouettes, which are 1 channel, found {first.in_channels} channels")
    return network.eval()


def kind_of(error: BaseException) -> str:
    """An error of others' code in one line; KeyError's own text is but the key."""
    kind = type(error).__name__
    return f"{kind}: {first_line(error)}" if str(error) else kind


def randomise(network, seed: int) -> None:
    """Random weights, and batch normalisation as training might leave it: not the identity."""
    torch.manual_seed(seed)
    network.init_parameters()
    for part in network.modules():
        if isinstance(part, torch.nn.modules.batchnorm._BatchNorm):
            part.running_mean.normal_(0.0, 0.2)
            part.running_var.uniform_(0.5, 2.0)
            part.weight.data.uniform_(0.5, 1.5)
            part.bias.data.normal_(0.0, 0.2)


def read_checkpoint(path: Path) -> tuple[dict, str]:
    """The tensors by name, and the file's SHA-256."""
    content = path.read_bytes()
    try:
        found = torch.load(io.BytesIO(content), map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        # So PyTorch names what it would have to run.
        more = re.search(r"GLOBAL (\S+)", str(error))
        if more is None:
            raise Refused(f"{path}: {NO_CHECKPOINT}") from error
        raise Refused(
            f"{path}: expected tensors and plain values, found {more[1]}, and loading that could run code "
            '(where you trust it: torch.save({"model": torch.load(FILE, weights_only=False)["model"]}, OTHER))'
        ) from error
    except Exception as error:  # whatever unpickling runs into
        raise Refused(f"{path}: {NO_CHECKPOINT}") from error
    tensors = found.get("model") if isinstance(found, dict) else None
    if not isinstance(tensors, dict) or not all(isinstance(tensor, torch.Tensor) for tensor in tensors.values()):
        keys = f"the keys {', '.join(map(str, list(found)[:NAMED]))} ..." if isinstance(found, dict) else type(found).__name__
        raise Refused(f'{path}: expected a checkpoint of OpenGait\'s with weights under "model", found {keys}')
    return tensors, hashlib.sha256(content).hexdigest()


def differences(network, tensors: dict) -> list[str]:
    """What keeps tensors from being a network's weights: nothing if they fit."""
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
    """Gives the weights to the network, all or none."""
    found = differences(network, tensors)
    if found:
        fitting = fitting_configs(tensors, checkout)
        others = f"; it fits {', '.join(fitting)}" if fitting else "; it fits no configuration of the checkout that can be exported"
        raise Refused(f"{path}: expected the weights of {config_path.name}, found of its keys {', '.join(found)}{others}")
    network.load_state_dict(tensors, strict=True)


def fitting_configs(tensors: dict, checkout: Path) -> list[str]:
    """Configurations of the checkout whose networks have these weights."""
    fitting = []
    for path in sorted((checkout / "configs").rglob("*.yaml")):
        # Those that cannot be read or exported fit nothing.
        with contextlib.suppress(Refused, OSError):
            config = read_config(path, checkout)
            refuse_unsupported(path, config)
            # Shapes alone, without numbers.
            with torch.device("meta"):
                network = build(path, config)
            if not differences(network, tensors):
                fitting.append(path.relative_to(checkout).as_posix())
    return fitting


class MaxPoolOfRows(torch.nn.Module):
    """A MaxPool1d as a 2-D one of single rows: PyTorch's export fixes the frames of the other."""

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
    """A network as ONNX, in 2-D operators."""
    network = copy.deepcopy(network)
    for part in list(network.modules()):
        for name, child in list(part.named_children()):
            if isinstance(child, torch.nn.MaxPool1d):
                setattr(part, name, MaxPoolOfRows(child))
    dims = {0: torch.export.Dim("N"), 1: torch.export.Dim("T")}
    example = torch.rand(2, 7, ROWS, COLUMNS)
    # By itself torch.onnx.export would fix, without a word, what it cannot keep free.
    program = torch.export.export(Embedding(network), (example,), dynamic_shapes=(dims,))
    program = torch.onnx.export(
        program, input_names=["sils"], output_names=["embedding"], dynamo=True, opset_version=18, verbose=False,
    )
    model, _ = rewrite(older(program.model_proto))
    return model


def older(model: onnx.ModelProto) -> onnx.ModelProto:
    """A model of operator set 18, the oldest that the exporter writes, in set 17.

    Where the sets differ in operators that occur here: axes of reductions (but sums) are attributes in 17, parts
    of Split are counted by its outputs, and parts of shapes are taken here by Gather, which more
    readers follow. What else the sets differ in, the checker and the comparison with PyTorch find.
    Names of the exporter's own steps and paths are left out.
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
    """The largest difference to PyTorch, as a part of the largest number; too large a one is refused."""
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
            raise Refused(f"the exported network: expected numbers {list(expected.shape)}, found {list(found.shape)} or no numbers")
        worst = max(worst, float(np.abs(found - expected).max() / np.abs(expected).max()))
    if not worst <= TOLERANCE:
        raise Refused(f"the exported network: expected what PyTorch computes within {TOLERANCE}, found a difference of {worst:.1e}")
    return worst


def contract(distance: str, description: str) -> str:
    """The contract beside the model, as TOML. JSON's strings are TOML's."""
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
    """The checkout's commit, if it is one of git's."""
    command = ["git", "-C", str(checkout), "rev-parse", "--show-toplevel", "HEAD"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=30)
    except (OSError, subprocess.TimeoutExpired):
        return None
    lines = done.stdout.splitlines()
    # A folder within another repository has nothing to do with that one's commit.
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
    # The contract first: a model without its own would be fed wrongly.
    write_whole({beside: text.encode("utf-8"), given.out: model.SerializeToString()})
    parameters = sum(part.numel() for part in network.parameters())
    shape = [size.dim_param or size.dim_value for size in model.graph.output[0].type.tensor_type.shape.dim]
    print(
        f"{given.out}: {config['model_cfg']['model']}, {parameters / 1e6:.1f} M parameters, sils [N, T, {ROWS}, {COLUMNS}] "
        f"to embedding [{', '.join(map(str, shape))}]; differs from PyTorch by {worst:.1e} of the largest number"
    )
    print(f"{beside}: its contract")


def seed(text: str) -> int:
    """A number that PyTorch takes as a seed."""
    number = int(text)
    if not 0 <= number < 2**63:
        raise ValueError(text)
    return number


def main() -> None:
    parser = argparse.ArgumentParser(description="Exports a network of OpenGait's to ONNX, with its contract.")
    parser.add_argument("--opengait", type=Path, required=True, metavar="DIR", help="a checkout of OpenGait")
    parser.add_argument("--config", type=Path, required=True, metavar="FILE.yaml", help="one of its configurations")
    weights = parser.add_mutually_exclusive_group(required=True)
    weights.add_argument("--checkpoint", type=Path, metavar="FILE.pt", help="what its training saved")
    weights.add_argument("--random-weights", type=seed, metavar="SEED", help="no training: for latencies only")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE.onnx", help="the model; FILE.toml becomes its contract")
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
