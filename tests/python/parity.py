"""Makes the small networks for tests of `edgegait parity`: tests/data/parity.

    edgegait sweep --azimuth-deg 0,45,90,135,180 --elevation-deg 0,30 --cycles 8 --raster rows --out geis
    python parity.py geis/geis.npy tests/data/parity

`float.onnx` has random weights. `int8.onnx` is the same network, quantised statically with ONNX
Runtime's tools. In `wrong_scale.onnx` the scale of the convolution's weights is 1.5 times as large.
Made with onnx 1.23.2 and onnxruntime 1.31.1.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper
from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static


def network():
    """Returns a network of a convolution with 4 kernels, ReLU, and a linear map to 8 numbers."""
    random = np.random.default_rng(5)

    def weights(name, *shape):
        scale = 1 / np.sqrt(np.prod(shape[1:]))
        return numpy_helper.from_array((random.normal(size=shape) * scale).astype(np.float32), name)

    nodes = [
        helper.make_node("Conv", ["gei", "kernels"], ["c"], kernel_shape=[7, 5], strides=[6, 6]),
        helper.make_node("Relu", ["c"], ["r"]),
        helper.make_node("Flatten", ["r"], ["flat"]),
        helper.make_node("Gemm", ["flat", "weights"], ["embedding"], transB=1),
    ]
    graph = helper.make_graph(
        nodes,
        "small",
        [helper.make_tensor_value_info("gei", TensorProto.FLOAT, ["N", 1, 50, 30])],
        [helper.make_tensor_value_info("embedding", TensorProto.FLOAT, ["N", 8])],
        [weights("kernels", 4, 1, 7, 5), weights("weights", 8, 160)],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(model, full_check=True)
    return model


class Calibration(CalibrationDataReader):
    def __init__(self, geis):
        self.rest = iter(geis)

    def get_next(self):
        gei = next(self.rest, None)
        return None if gei is None else {"gei": gei[None, None].astype(np.float32) / 255}


def main(geis, folder):
    geis = np.load(geis)[::7]
    with tempfile.TemporaryDirectory() as place:
        plain, quantized = Path(place, "float.onnx"), Path(place, "int8.onnx")
        onnx.save(network(), plain)
        quantize_static(
            plain,
            quantized,
            Calibration(geis),
            quant_format=QuantFormat.QDQ,
            activation_type=QuantType.QUInt8,
            weight_type=QuantType.QInt8,
        )
        Path(folder, "float.onnx").write_bytes(plain.read_bytes())
        Path(folder, "int8.onnx").write_bytes(quantized.read_bytes())
        model = onnx.load(quantized)
    (scale,) = [one for one in model.graph.initializer if one.name == "kernels_scale"]
    wrong = numpy_helper.to_array(scale) * np.float32(1.5)
    scale.CopyFrom(numpy_helper.from_array(wrong, scale.name))
    onnx.save(model, Path(folder, "wrong_scale.onnx"))


if __name__ == "__main__":
    main(*sys.argv[1:])
