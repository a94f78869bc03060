"""Tests reading datasets in Python: trees and arrays with pickle and NumPy alone, and the guide's code blocks.

    python datasets.py FOLDER GUIDE.md

FOLDER has the files that .ci/run makes: `tree` (--format opengait), `arrays/train` and `arrays/test` (the same
design as folders, silhouettes and GEIs at 64x64), `npz/test.npz` and `sets/test` (one design as npz and as
a folder), and the files that the guide's blocks read.
"""

import csv
import hashlib
import json
import os
import pickle
import re
import sys
from pathlib import Path

import numpy as np


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def sequences_of(root, partition, part):
    """Lists sequences by OpenGait's rules, reimplemented from opengait/data/dataset.py of commit 0efafd4: the
    partition's labels that are on disk, their types and views in the order of their names, and all files of
    each view, which must be pickles of one length that are not empty."""
    on_disk = os.listdir(root)
    found = []
    for label in [label for label in partition[part] if label in on_disk]:
        for kind in sorted(os.listdir(root / label)):
            for view in sorted(os.listdir(root / label / kind)):
                folder = root / label / kind / view
                paths = sorted(folder / name for name in os.listdir(folder))
                assert paths, f"{folder}: no files"
                modalities = []
                for path in paths:
                    assert path.suffix == ".pkl", path
                    with open(path, "rb") as file:
                        modalities.append(pickle.load(file))
                assert all(len(one) == len(modalities[0]) > 0 for one in modalities), folder
                found.append((label, kind, view, modalities[0]))
    return found


def cut(frames):
    """Applies BaseSilCuttingTransform: cuts ten columns for every 64 off each side, and scales to 0..1."""
    columns = int(frames.shape[-1] // 64) * 10
    kept = frames[..., columns:-columns] if columns else frames
    return kept / 255.0


def check_tree(root, arrays):
    with open(root / "partition.json") as file:
        partition = json.load(file)
    assert sorted(partition) == ["TEST_SET", "TRAIN_SET"]
    assert not set(partition["TRAIN_SET"]) & set(partition["TEST_SET"])
    listed = {row["path"]: row for row in table(root / "sequences.csv")}
    count = 0
    for part, folder in (("TRAIN_SET", "train"), ("TEST_SET", "test")):
        rows = table(arrays / folder / "index.csv")
        silhouettes = np.load(arrays / folder / "silhouettes.npy", mmap_mode="r")
        assert silhouettes.dtype == np.uint8 and silhouettes.shape[1:] == (64, 64)
        ends = np.cumsum([int(row["frames"]) for row in rows])
        assert ends[-1] == len(silhouettes)
        drawn = {}
        for row, end in zip(rows, ends):
            azimuth = float(row["azimuth_deg"])
            # A take has eight variations of a walk, and its name includes the condition.
            take = f"{row['walk']}-{row['condition']}-{int(row['variation']) // 8 + 1:02}"
            key = (row["subject"], take, f"{azimuth:03.0f}")
            drawn.setdefault(key, []).append(silhouettes[end - int(row["frames"]) : end])
        found = sequences_of(root, partition, part)
        assert {(label, kind, view) for label, kind, view, _ in found} == set(drawn)
        for label, kind, view, frames in found:
            assert frames.dtype == np.uint8 and frames.shape[1:] == (64, 64)
            assert np.array_equal(frames, np.concatenate(drawn[label, kind, view]))
            path = f"{label}/{kind}/{view}/{view}.pkl"
            row = listed.pop(path)
            assert int(row["frames"]) == len(frames)
            assert row["sha256"] == hashlib.sha256((root / path).read_bytes()).hexdigest()
            inputs = cut(frames)
            assert inputs.shape[1:] == (64, 44) and inputs.min() == 0 and inputs.max() == 1
            # Heads and feet reach the first and last row, so only the margins are cut.
            assert frames[:, 0].any() and frames[:, -1].any()
            count += 1
    assert not listed, f"no files of {sorted(listed)[:3]}"
    print(f"{root.name}: {count} sequences, as OpenGait reads them")


def check_npz(path, folder):
    numbers = {"cycle": "<u4", "variation": "<u4", "frames": "<u4", "seed": "<u8"}
    numbers |= {name: "<f8" for name in ("speed_kmh", "azimuth_deg", "elevation_deg")}
    rows = table(folder / "index.csv")
    with np.load(path, allow_pickle=False) as found:
        for file in folder.glob("*.npy"):
            assert np.array_equal(found[file.stem], np.load(file)), file
        for column in rows[0]:
            array = found[column]
            assert array.shape == (len(rows),), column
            if column in numbers:
                assert array.dtype.str == numbers[column], column
                assert array.tolist() == [float(row[column]) for row in rows], column
            else:
                assert array.dtype.kind == "U", column
                assert array.tolist() == [row[column] for row in rows], column
        assert json.loads(found["manifest.json"])["format"] == "npz"
    print(f"{path.name}: {len(rows)} rows, as numpy.load reads them")


def run_guide(page):
    """Runs the page's Python blocks in order, in the folder where its commands were run."""
    blocks = re.findall(r"^```python\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) >= 3, len(blocks)
    names = {"geis": np.zeros((4, 64, 44), np.uint8), "people": list("aabb"), "angles": [0, 90] * 2, "walks": ["nm-01"] * 4}
    for block in blocks:
        exec(compile(block, str(page), "exec"), names)
    frames, sequences = names["frames"], names["sequences"]
    assert [len(one) for one in sequences] == frames.tolist()
    print(f"{page.name}: {len(blocks)} blocks of Python run")
    return names


if __name__ == "__main__":
    folder, page = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    check_tree(folder / "tree", folder / "arrays")
    check_npz(folder / "npz/test.npz", folder / "sets/test")
    os.chdir(folder)
    names = run_guide(page)
    assert min(names["rates"].values()) > 0.5 and names["rates"]["nm-05"] > 0.8, names["rates"]
    print(names["rates"])
