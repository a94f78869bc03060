"""Tests that the shipped networks give the answers of `edgegait score` with ONNX Runtime and NumPy in Python.

    python networks.py EDGEGAIT MODELS FOLDER

EDGEGAIT is the command, MODELS is the folder of the networks, and FOLDER is empty.
"""

import csv
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
from PIL import Image

# The largest allowed difference of a distance (1 - cosine) in f32.
MOST_APART = 2e-5
# The share of probes whose answer may differ between implementations of 8-bit kernels.
MOST_CHANGED_INT8 = 0.05
# Nine cycles of each person, of more than one take.
SWEEP = ["sweep", "--cycles", "9", "--first-cycle", "1000", "--azimuth-deg", "0,45,90", "--size", "50x30"]


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def embeddings(path, inputs):
    """Returns a model's embeddings `[inputs, numbers, parts]`, computed one input at a time."""
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    name = session.get_inputs()[0].name
    found = np.concatenate([session.run(["embedding"], {name: one[None]})[0] for one in inputs])
    return found.reshape(*found.shape[:2], -1).astype(np.float64)


def nearest(embedding, who, take, view):
    """Returns, for each input, the nearest person among other takes from the same viewpoint, and the distance."""
    unit = embedding / np.linalg.norm(embedding, axis=1, keepdims=True)
    distance = 1 - np.einsum("anp,bnp->abp", unit, unit).mean(2)
    can_be = (view[:, None] == view[None]) & ((take[:, None] != take[None]) | (who[:, None] != who[None]))
    distance[~can_be] = np.inf
    return who[distance.argmin(1)], distance.min(1)


def check(name, graph, found, answers):
    """Compares the command's answers with those found here."""
    people, distances = found
    assert len(answers) == len(people) > 100, f"{name}: {len(answers)} of {len(people)}"
    changed = np.mean([row["answer"] != who for row, who in zip(answers, people)])
    apart = max(abs(float(row["distance"]) - one) for row, one in zip(answers, distances))
    right = np.mean([row["answer"] == row["subject"] for row in answers])
    is_int8 = any(node.op_type == "QuantizeLinear" for node in graph.graph.node)
    print(f"{name}: {len(answers)} probes, rank-1 {right:.3f}, {changed:.4f} answers differ, distances differ by {apart:.1e}")
    if is_int8:
        assert changed <= MOST_CHANGED_INT8, changed
    else:
        assert changed == 0 and apart <= MOST_APART, (changed, apart)
    # The comparison means little if the answers are wrong.
    assert right > 0.5, right


def check_form(name, graph):
    """Checks the documented opset, IR, operators and axes."""
    onnx.checker.check_model(graph, full_check=True)
    assert graph.ir_version == 8, graph.ir_version
    assert [(opset.domain, opset.version) for opset in graph.opset_import] == [("", 17)], graph.opset_import
    assert all(node.domain == "" for node in graph.graph.node)
    assert graph.graph.input[0].type.tensor_type.shape.dim[0].dim_param == "N", name


if __name__ == "__main__":
    program, models = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    os.chdir(sys.argv[3])
    run = lambda *arguments: subprocess.run([program, *arguments], check=True, stdout=subprocess.DEVNULL)
    run(*SWEEP, "--template", "gei", "--out", "geis")
    run(*SWEEP, "--template", "silhouettes", "--format", "casia-b", "--out", "tree")
    score = ["--protocol", "leave-one-take-out", "--no-baselines", "--cache", "none", "--out", "report", "--overwrite"]

    index = table("geis/index.csv")
    who = np.array([row["subject"] for row in index])
    view = np.array([float(row["azimuth_deg"]) for row in index])
    geis = np.load("geis/geis.npy").reshape(-1, 1, 50, 30).astype(np.float32) / 255
    bytes_of_all = 0
    for path in sorted(models.glob("*.onnx")):
        graph = onnx.load(path)
        bytes_of_all += path.stat().st_size
        check_form(path.stem, graph)
        if path.stem in ("side", "spread"):
            continue
        if 'template = "gei"' in path.with_suffix(".toml").read_text():
            run("score", str(path), "geis", *score, "--probes-csv", "answers.csv")
            answers = {(row["subject"], row["variation"], float(row["azimuth_deg"])): row for row in table("answers.csv")}
            ordered = [answers[row["subject"], row["variation"], float(row["azimuth_deg"])] for row in index]
            take = np.array([row["take"] for row in ordered])
            check(path.stem, graph, nearest(embeddings(path, geis), who, take, view), ordered)
        else:
            run("score", str(path), "tree", "--as-stored", *score, "--probes-csv", "answers.csv")
            answers = table("answers.csv")
            sequences = []
            for row in answers:
                folder = Path("tree", row["subject"], row["take"], f"{float(row['azimuth_deg']):03.0f}")
                frames = [np.asarray(Image.open(frame).convert("L")) for frame in sorted(folder.iterdir())]
                sequences.append((np.stack(frames) >= 128).astype(np.float32))
            assert len({len(sequence) for sequence in sequences}) > 1
            keys = [np.array([row[key] for row in answers]) for key in ("subject", "take", "azimuth_deg")]
            check(path.stem, graph, nearest(embeddings(path, sequences), *keys), answers)
    assert bytes_of_all <= 8_000_000, bytes_of_all
