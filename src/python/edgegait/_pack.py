"""Packs: people, their bodies and their walks in one block of bytes."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import Any

from . import _native
from ._command import Results, command
from ._flags import words
from ._picture import sheet_of_items


class Pack:
    """People, their bodies and their walks, to be drawn. A pack is pickled as its bytes.

    Args:
        path: The file to read.
    """

    #: The results of the command that made the pack, if any: see `edgegait cohort --json`.
    results: Results | None = None

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._native = _native.Pack(os.fspath(path))

    @classmethod
    def from_bytes(cls, data: bytes, name: str = "") -> Pack:
        """Reads a pack from bytes, which are checked; `name` is for messages and results."""
        pack = cls.__new__(cls)
        pack._native = _native.Pack.from_bytes(data, name)
        return pack

    @property
    def subjects(self) -> list[dict[str, Any]]:
        """The people: name, sex, age_years, stature_m, mass_kg; None if unknown."""
        return self._native.subjects

    @property
    def walks(self) -> list[dict[str, Any]]:
        """The walks: subject, walk, cycle, speed_kmh, duration_s, is_uncut (an uncut motion)."""
        return self._native.walks

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes the pack to a file atomically, and creates missing folders."""
        self._native.save(os.fspath(path), overwrite=overwrite)

    def __bytes__(self) -> bytes:
        return bytes(self._native)

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        return repr(self._native)

    def __reduce__(self) -> tuple[Any, ...]:
        return Pack.from_bytes, (bytes(self), self._native.path)

    def _repr_png_(self) -> bytes:
        first = self.walks[0]
        template = "silhouettes" if first["is_uncut"] else "gei"
        drawing = {"views": "side", "template": template, "raster": "rows", "walks": first["walk"]}
        return sheet_of_items(_native.Items.of_sweep(words(drawing), self._native))


def _made(name: str, inputs: tuple[Any, ...], flags: dict[str, Any]) -> Pack:
    """Returns the pack that a subcommand makes."""
    if "out" in flags:
        raise TypeError("out: the pack is returned (Pack.save writes it)")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.egp"
        results = command(name, *inputs, out=path, **flags)
        pack = Pack.from_bytes(path.read_bytes())
    pack.results = results
    return pack


def cohort(**flags: Any) -> Pack:
    """Makes synthetic people from published norms and a seed, by default 26 at ten speeds.

    Keyword arguments are the flags of `edgegait cohort`: `people=100`, `speeds_kmh=[4, 5]`,
    `dressed=True`, `quick=True`, `seed=7`. The `results` of the pack describe the people.
    """
    return _made("cohort", (), flags)


def import_walks(*files: str | os.PathLike[str], **flags: Any) -> Pack:
    """Imports recorded walks (BVH, ASF/AMC, C3D, TRC, glTF; files or folders) as a pack.

    Keyword arguments are the flags of `edgegait import`: `track="clip"`, `subject="anna"`,
    `stature_m=1.68`. The `results` of the pack state how well each take was matched, with warnings.
    """
    if not files:
        raise TypeError("import_walks: expected files or folders, found none")
    return _made("import", files, flags)
