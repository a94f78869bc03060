"""Keyword arguments as flags of the command."""

from __future__ import annotations

import operator
import os
import sys
from typing import TYPE_CHECKING, Any, TypedDict

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


class Drawing(TypedDict, total=False):
    """The flags of `edgegait sweep` that choose walks and how they are drawn; its `--help` explains them."""

    subjects: str | Sequence[str]
    walks: str | Sequence[str]
    cycles: int
    first_cycle: int
    conditions: str | os.PathLike[str]
    confound: str | Sequence[str]
    views: str | os.PathLike[str]
    azimuth_deg: float | Sequence[float]
    elevation_deg: float | Sequence[float]
    template: str | Sequence[str]
    size: str
    raster: str
    framing: str
    lens: str
    distance_m: float
    fov_deg: float
    camera: str
    aim_m: Sequence[float]
    jitter: str
    frames_per_cycle: int
    fps: float
    joints: bool
    seed: int


class Streaming(TypedDict, total=False):
    """The arguments of Stream."""

    seed: int
    shuffle: bool
    people_at_once: int
    by_cycle: bool
    fresh: bool
    start: int
    rank: int | None
    world: int | None


def whole(name: str, value: Any, least: int, most: int) -> int:
    """Checks that a value is a whole number in a range, and returns it as an int."""
    try:
        found = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: expected a whole number, found {value!r}") from None
    if not least <= found <= most:
        raise ValueError(f"{name}: expected {least} to {most}, found {found}")
    return found


def program() -> list[str]:
    """Returns the words that start the command in a process of its own; none without a known interpreter."""
    return [sys.executable, "-m", "edgegait"] if sys.executable else []


def words(flags: Mapping[str, Any]) -> list[str]:
    """Converts flags to words of the command line: `{"azimuth_deg": [0, 90]}` to `--azimuth-deg=0,90`.

    None and False are left out, and True has no value.
    """
    found = []
    for name, value in flags.items():
        flag = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            found.append(flag)
        elif isinstance(value, (str, os.PathLike)):
            found.append(f"{flag}={os.fspath(value)}")
        else:
            found.append(f"{flag}={','.join(map(str, _listed(name, value)))}")
    return found


def _listed(name: str, value: Any) -> list[Any]:
    """Returns the values of a flag as a list."""
    try:
        values = list(value)
    except TypeError:
        values = [value]
    for one in values:
        if isinstance(one, (list, tuple, dict)):
            raise TypeError(f"{name}: expected one value or a list of them, found {value!r}")
    return values
