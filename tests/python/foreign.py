"""Tests models that other tools export, with and without a contract.

    python foreign.py edgegait FOLDER [LIBRARY]

Each model is made with onnx.helper, or with PyTorch or skl2onnx if these are installed, and tried with one command,
which must give a rank-1, or an error that states what to do. LIBRARY is that of ONNX Runtime. JUnit XML of
`edgegait gate` is read with Python's parser.
"""

import json
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

FLOAT, UINT8, DOUBLE, INT64 = TensorProto.FLOAT, TensorProto.UINT8, TensorProto.DOUBLE, TensorProto.INT64


def saved(path, nodes, inputs, outputs, weights=()):
    value = helper.make_tensor_value_info
    graph = helper.make_graph(nodes, "g", [value(*one) for one in inputs], [value(*one) for one in outputs], list(weights))
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(model, full_check=True)
    onnx.save(model, path)


def matrix(name, rows, columns, kind=np.float32):
    random = np.random.default_rng(7)
    return numpy_helper.from_array((random.normal(size=(rows, columns)) / np.sqrt(rows)).astype(kind), name)


def flat(path, shape, numbers, element=FLOAT, outputs=None, batch="N"):
    """Writes a model that multiplies all pixels by a matrix."""
    kind = np.float64 if element == DOUBLE else np.float32
    nodes, source = [], "picture"
    if element == UINT8:
        nodes.append(helper.make_node("Cast", ["picture"], ["numbers"], to=FLOAT))
        source = "numbers"
    nodes += [helper.make_node("Flatten", [source], ["flat"]), helper.make_node("MatMul", ["flat", "w"], ["features"])]
    outputs = outputs or [("features", DOUBLE if element == DOUBLE else FLOAT, [batch, 16])]
    saved(path, nodes, [("picture", element, [batch, *shape])], outputs, [matrix("w", numbers, 16, kind)])


def sequence(path, parts=False):
    """Writes a model that averages a matrix product of 64x44 pixels over frames; `[n, c, p]` with parts."""
    shape = numpy_helper.from_array(np.array([0, 0, 2816], np.int64), "shape")
    nodes = [
        helper.make_node("Reshape", ["silhouettes", "shape"], ["flat"]),
        helper.make_node("MatMul", ["flat", "w"], ["each"]),
        helper.make_node("ReduceMean", ["each"], ["mean"], axes=[1], keepdims=0),
    ]
    output = ("mean", FLOAT, ["N", 16])
    weights = [matrix("w", 2816, 16), shape]
    if parts:
        weights.append(numpy_helper.from_array(np.array([0, 4, 4], np.int64), "parts"))
        nodes.append(helper.make_node("Reshape", ["mean", "parts"], ["in parts"]))
        output = ("in parts", FLOAT, ["N", 4, 4])
    saved(path, nodes, [("silhouettes", FLOAT, ["N", "T", 64, 44])], [output], weights)


def two_inputs(path):
    nodes = [
        helper.make_node("Flatten", ["picture"], ["flat"]),
        helper.make_node("MatMul", ["flat", "w"], ["m"]),
        helper.make_node("Mul", ["m", "scale"], ["features"]),
    ]
    inputs = [("picture", FLOAT, ["N", 1, 64, 44]), ("scale", FLOAT, ["N", 1])]
    saved(path, nodes, inputs, [("features", FLOAT, ["N", 16])], [matrix("w", 2816, 16)])


class Tried:
    """Runs the command in a folder."""

    def __init__(self, edgegait, folder, library):
        self.edgegait, self.folder, self.library = edgegait, folder, library

    def run(self, *arguments):
        done = subprocess.run([self.edgegait, *arguments], cwd=self.folder, capture_output=True, text=True)
        return done.returncode, done.stdout, done.stderr

    def runtime(self):
        return ["--runtime", "ort", "--ort-lib", self.library] if self.library else []

    def scored(self, name, *flags):
        """Returns rank-1 from the side and the warnings, or `None` and the error."""
        out = ["--views", "side", "--no-baselines", "--out", "report", "--overwrite", "--json", "score.json", "--quiet"]
        code, _, error = self.run("score", name, *out, *flags)
        if code != 0:
            assert code == 1, (name, code, error)
            return None, error.strip()
        results = json.loads((self.folder / "score.json").read_text())
        return results["recognizers"][0]["rank1"], " ".join(results["warnings"])


def expect(found, name, words):
    for word in words:
        assert word in found, f"{name}: expected {word!r} in {found!r}"


def main():
    edgegait, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    library = sys.argv[3] if len(sys.argv) > 3 else None
    tried = Tried(edgegait, folder, library)
    lines = []

    def number(name, words, *flags, commands=1):
        rank1, said = tried.scored(name, *flags)
        assert rank1 is not None, f"{name}: {said}"
        expect(said, name, words)
        lines.append(f"{name}: rank-1 {100 * rank1:.1f} % after {commands} command(s)")

    def refusal(name, words, *flags):
        rank1, said = tried.scored(name, *flags)
        assert rank1 is None, f"{name}: {rank1}"
        expect(said, name, words)
        lines.append(f"{name}: refused: {said.removeprefix('error: ')}")

    flat(folder / "usual.onnx", [1, 64, 44], 2816)
    number("usual.onnx", ["read as GEIs of 64x44 (NCHW)"])
    sequence(folder / "sequence.onnx")
    number("sequence.onnx", ["silhouettes of 64x44 (NTHW)"])
    sequence(folder / "parts.onnx", parts=True)
    number("parts.onnx", ["silhouettes of 64x44 (NTHW)"])
    flat(folder / "odd names.onnx", [1, 50, 30], 1500, outputs=[("features", FLOAT, ["banana", 16])], batch="banana")
    number("odd names.onnx", ["GEIs of 50x30"])
    flat(folder / "one.onnx", [1, 64, 64], 4096, batch=1)
    number("one.onnx", ["GEIs of 64x64"])
    flat(folder / "bytes.onnx", [1, 64, 44], 2816, element=UINT8)
    number("bytes.onnx", ["input range 0..255"])
    flat(folder / "colour.onnx", [3, 64, 44], 3 * 2816)
    number("colour.onnx", ["in 3 equal channels"])
    (folder / "colour.toml").write_text("rows = 64\ncolumns = 44\nchannels = 3\nmean = [0.485, 0.456, 0.406]\nstd = [0.229, 0.224, 0.225]\n")
    number("colour.onnx", [])
    flat(folder / "wide.onnx", [1, 128, 88], 128 * 88)
    refusal("wide.onnx", ["[N, 1, 128, 88]", "50x30, 64x44, 64x64"])
    two_inputs(folder / "two.onnx")
    refusal("two.onnx", ['"scale" f32 [N, 1]', "takes images only"])
    flat(folder / "eight.onnx", [1, 64, 44], 2816, batch=8)
    refusal("eight.onnx", ["batch axis", "dynamic_axes"])
    flat(folder / "double.onnx", [2816], 2816, element=DOUBLE)
    refusal("double.onnx", ["f64", "--runtime ort"])
    if library:
        number("double.onnx", ["(ND)"], *tried.runtime())

    sklearn(tried, lines, number, refusal)
    pytorch(folder, number)

    # `contract` writes every key, including the guessed ones, so that nothing is guessed afterwards.
    code, _, error = tried.run("contract", "usual.onnx")
    assert code == 0, error
    number("usual.onnx", [], commands=2)
    _, said = tried.scored("usual.onnx")
    assert "no .toml lies beside it" not in said, said
    code, said, error = tried.run("check", "usual.onnx", *(["--ort-lib", library] if library else []))
    assert code in (0, 4) and "embeddings of 16 numbers" in said, (said, error)
    if library:
        assert "onnxruntime" in said and "differ by" in said, said
    junit(tried)
    print("\n".join(lines))


def sklearn(tried, lines, number, refusal):
    """Tries linear discriminants of scikit-learn, whose classes are people by name."""
    try:
        from skl2onnx import to_onnx
        from sklearn.discriminant_analysis import LinearDiscriminantAnalysis
    except ImportError:
        print("without skl2onnx: classifiers are not tried")
        return
    folder = tried.folder
    code, _, error = tried.run("sweep", "--views", "side", "--cycles", "4", "--out", "geis")
    assert code == 0, error
    geis = np.load(folder / "geis" / "geis.npy").reshape(-1, 1500).astype(np.float32) / 255
    with open(folder / "geis" / "index.csv") as index:
        names = next(index).strip().split(",")
        people = [line.split(",")[names.index("subject")] for line in index]
    classifier = LinearDiscriminantAnalysis().fit(geis, people)
    for name, options in (("maps.onnx", None), ("classes.onnx", {"zipmap": False})):
        model = to_onnx(classifier, geis[:1], options=options, target_opset={"": 17, "ai.onnx.ml": 3})
        (folder / name).write_bytes(model.SerializeToString())
    refusal("maps.onnx", ["zipmap"], *tried.runtime())
    if tried.library:
        number("classes.onnx", ["classes as people"], *tried.runtime())
    refusal("classes.onnx", ["ai.onnx.ml", "--runtime ort"])


def pytorch(folder, number):
    """Tries a convolution from PyTorch's exporter."""
    try:
        import torch
    except ImportError:
        print("without PyTorch: its exporter is not tried")
        return
    torch.manual_seed(3)
    network = torch.nn.Sequential(
        torch.nn.Conv2d(1, 8, 5, 2), torch.nn.ReLU(), torch.nn.AvgPool2d(5), torch.nn.Flatten(), torch.nn.Linear(288, 32)
    )
    axes = {"x": {0: "batch"}, "y": {0: "batch"}}
    picture = torch.zeros(2, 1, 64, 64)
    torch.onnx.export(network.eval(), picture, folder / "torch.onnx", input_names=["x"], output_names=["y"], dynamic_axes=axes, opset_version=17, dynamo=False)
    number("torch.onnx", ["GEIs of 64x64"])


def junit(tried):
    """Checks that another program can read a missed and a kept limit."""
    limits = "".join(
        f"[[limit]]\nfigure = 'recognizers[{name}].rank1'\nname = '{title}'\n{bound}\n"
        for name, title, bound in (("usual", 'a < b & "c"', "at_least = 1.1"), ("usual", "holds", "at_least = 0"))
    )
    (tried.folder / "limits.toml").write_text(limits)
    tried.scored("usual.onnx")
    code, said, error = tried.run("gate", "limits.toml", "score.json", "--junit", "gate.xml", "--overwrite")
    assert code == 4, (code, said, error)
    suites = ElementTree.parse(tried.folder / "gate.xml").getroot()
    cases = suites.findall("./testsuite/testcase")
    assert suites.get("failures") == "1" and len(cases) == 2, suites.attrib
    assert cases[0].get("name") == 'a < b & "c": at least 1.1', cases[0].attrib
    assert cases[0].find("failure") is not None and cases[1].find("failure") is None


if __name__ == "__main__":
    main()
