"""Reads datasets of `edgegait generate` for PyTorch."""

import csv
import json
from pathlib import Path

import numpy as np
import torch

from networks import COLUMNS, ROWS


def opened(path):
    """Opens an array of 50x30 images."""
    if not path.exists():
        raise SystemExit(f"{path}: not found (generate the dataset from people.toml)")
    pictures = np.load(path, mmap_mode="r")
    if pictures.dtype != np.uint8 or pictures.shape[-2:] != (ROWS, COLUMNS):
        raise SystemExit(
            f"{path}: expected bytes of {ROWS}x{COLUMNS} images, found {pictures.dtype} of {pictures.shape} "
            "(generate the dataset from people.toml)"
        )
    return pictures


class People:
    """The GEIs of a dataset and 32 silhouettes of each gait cycle, with the number of the person."""

    def __init__(self, folder):
        folder = Path(folder)
        manifest = json.loads((folder / "manifest.json").read_text())
        #: The dataset's manifest, which states design, seed and version.
        self.manifest = manifest
        silhouettes = opened(folder / "silhouettes.npy")
        #: The GEI of each sequence, `[sequences, 1, 50, 30]` bytes.
        self.geis = torch.from_numpy(np.array(opened(folder / "geis.npy"))).reshape(-1, 1, ROWS, COLUMNS)
        with open(folder / "index.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        #: The names of the people, in the order of their numbers.
        self.names = sorted({row["subject"] for row in rows})
        numbers = {name: number for number, name in enumerate(self.names)}
        #: The number of the person in each sequence, `[sequences]`.
        self.who = torch.tensor([numbers[row["subject"]] for row in rows])
        silhouettes = silhouettes.reshape(len(rows), -1, ROWS, COLUMNS)
        self.frames = silhouettes.shape[1]
        # One bit a pixel: 115 MB for 19,200 sequences.
        self.bits = np.concatenate(
            [np.packbits(silhouettes[at : at + 256] > 127, axis=-1) for at in range(0, len(rows), 256)]
        )
        self.sequences_of = [torch.nonzero(self.who == person).flatten() for person in range(len(self.names))]

    def __len__(self):
        return len(self.who)

    def silhouettes(self, sequences, frames=None):
        """Returns silhouettes of these sequences, `[n, frames, 50, 30]`, 0 or 1; `frames` selects frames of each by index."""
        bits = self.bits[np.asarray(sequences)]
        if frames is not None:
            bits = np.take_along_axis(bits, np.asarray(frames)[:, :, None, None], axis=1)
        return torch.from_numpy(np.unpackbits(bits, axis=-1, count=COLUMNS)).float()
