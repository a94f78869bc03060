"""Writes a trained network as ONNX with its contract, and GEINet also with 8-bit weights and activations.

    python export.py DATASET --network geinet --weights geinet.pt --out models

The graphs have opset 17, IR 8, standard operators and a batch axis `N` (and an axis `T` of silhouettes). Before
anything is written, the outputs of ONNX Runtime must agree with PyTorch's.
"""

import argparse
import json
import tempfile
import warnings
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import torch

from data import People
from networks import COLUMNS, NETWORKS, ROWS

# The largest allowed difference from PyTorch, relative to the largest value of an embedding.
MOST_APART = 1e-4
# The number of GEIs that calibrate the range of activations.
CALIBRATION = 512


def graph_of(network, pictures):
    """Returns the ONNX model of a network, after comparing its outputs for `pictures` with PyTorch's."""
    name = network.takes
    axes = {name: {0: "N"} if name == "gei" else {0: "N", 1: "T"}, "embedding": {0: "N"}}
    network = network.to(memory_format=torch.contiguous_format).eval()
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = str(Path(folder) / "network.onnx")
        torch.onnx.export(
            network, (pictures[:2],), path, input_names=[name], output_names=["embedding"],
            dynamic_axes=axes, opset_version=17, dynamo=False,
        )
        model = onnx.load(path)
    model.ir_version = 8
    model.producer_version = torch.__version__.split("+")[0]
    onnx.checker.check_model(model, full_check=True)
    with torch.no_grad():
        expected = network(pictures).numpy()
    apart = float(np.abs(answers(model, pictures.numpy()) - expected).max() / np.abs(expected).max())
    if not apart < MOST_APART:
        raise SystemExit(f"ONNX Runtime and PyTorch differ by {apart:.1e} of the largest value, expected less than {MOST_APART}")
    return model, apart


def answers(model, pictures):
    """Returns the outputs of ONNX Runtime for images."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(model.SerializeToString(), options, providers=["CPUExecutionProvider"])
    found = [session.run(None, {session.get_inputs()[0].name: pictures[at : at + 64]})[0] for at in range(0, len(pictures), 64)]
    return np.concatenate(found)


def quantized(model, geis):
    """Returns the model with 8-bit weights, scaled by channel, and 8-bit activations (QDQ), calibrated with `geis`.

    Weights use 7 bits, so that sums of two products fit the 16 bits in which processors without VNNI add them.
    """
    from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static
    from onnxruntime.quantization.shape_inference import quant_pre_process

    if len(geis) == 0:
        raise SystemExit("no GEIs to calibrate with: expected at least one (generate the dataset from people.toml)")

    class Geis(CalibrationDataReader):
        def __init__(self):
            self.left = iter([geis[at : at + 1] for at in range(len(geis))])

        def get_next(self):
            gei = next(self.left, None)
            return None if gei is None else {model.graph.input[0].name: gei}

    with tempfile.TemporaryDirectory() as folder:
        paths = [str(Path(folder) / name) for name in ("float.onnx", "prepared.onnx", "int8.onnx")]
        onnx.save(model, paths[0])
        quant_pre_process(paths[0], paths[1])
        quantize_static(
            paths[1], paths[2], Geis(), quant_format=QuantFormat.QDQ, per_channel=True, reduce_range=True,
            activation_type=QuantType.QUInt8, weight_type=QuantType.QInt8,
        )
        found = onnx.load(paths[2])
    found.ir_version = 8
    # The preparation lists domains that the graph does not use.
    plain = [opset for opset in found.opset_import if opset.domain == ""]
    del found.opset_import[:]
    found.opset_import.extend(plain)
    onnx.checker.check_model(found, full_check=True)
    return found


def contract(name, network, people, description):
    """Returns the contract of a model as TOML, with every key."""
    is_gei = network.takes == "gei"
    text = lambda value: json.dumps(value, ensure_ascii=False)
    return "\n".join(
        [
            f'name = "{name}"\ninput_range = "0..1"\nrows = {ROWS}\ncolumns = {COLUMNS}',
            f'layout = "{"NCHW" if is_gei else "NTHW"}"\nframing = "height"\ntemplate = "{network.takes}"',
            'distance = "cosine"\nclasses = []\n\n[outputs]\nembedding = "embedding"\n\n[training]',
            f"description = {text(description)}\nviewpoints = []",
            f"subjects = {text(people.names)}\nwalks = []\ncycles = []\nvariations = []",
            f"seed = {people.manifest['seed']}\n",
        ]
    )


def export(people, name, network, out, description):
    """Writes a network's files and returns the difference from PyTorch."""
    every = max(1, len(people) // CALIBRATION)
    chosen = np.arange(0, len(people), every)[:CALIBRATION]
    if network.takes == "gei":
        pictures = people.geis[chosen].float() / 255
    else:
        chosen = chosen[:: max(1, len(chosen) // 64)]
        pictures = people.silhouettes(chosen)
    model, apart = graph_of(network, pictures[:64])
    written = {name: (model, description)}
    if name == "geinet":
        note = f"{description}; 8-bit weights by channel and 8-bit activations, calibrated on {len(chosen)} of these GEIs, every {every}th"
        written[f"{name}-int8"] = (quantized(model, pictures.numpy()), note)
    out = Path(out)
    for stem, (model, about) in written.items():
        for suffix, content in ((".onnx", model.SerializeToString()), (".toml", contract(stem, network, people, about).encode())):
            partial = out / f"{stem}{suffix}.partial"
            partial.write_bytes(content)
            partial.replace(out / f"{stem}{suffix}")
    return apart


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset", help="the folder of the dataset that the network was trained on")
    parser.add_argument("--network", required=True, choices=NETWORKS)
    parser.add_argument("--weights", required=True, help="the weights that train.py wrote")
    parser.add_argument("--out", default=".", help="folder for the model and its contract")
    arguments = parser.parse_args()
    people = People(arguments.dataset)
    network = NETWORKS[arguments.network]()
    weights = torch.load(arguments.weights, weights_only=True)
    try:
        network.load_state_dict(weights)
    except RuntimeError as error:
        raise SystemExit(f"{arguments.weights}: expected weights of {arguments.network}: {error}") from None
    description = f"{len(people.names)} people of {arguments.dataset}"
    apart = export(people, arguments.network, network, arguments.out, description)
    print(f"{arguments.network}: ONNX Runtime and PyTorch differ by {apart:.1e} of the largest value")


if __name__ == "__main__":
    main()
