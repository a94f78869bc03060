"""Keyword arguments as flags of the command."""

from __future__ import annotations

import operator
import os
import sys
from typing import TYPE_CHECKING, Any, TypedDict

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


class Drawing(TypedDict, total=False):
    """Which walks of a pack are drawn and how: flags of `edgegait sweep`, which says more of each."""

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
    """How a stream goes through a dataset: see Stream."""

    seed: int
    shuffle: bool
    people_at_once: int
    by_cycle: bool
    fresh: bool
    start: int
    rank: int | None
    world: int | None


def whole(name: str, value: Any, least: int, most: int) -> int:
    """A whole number in a range."""
    try:
        found = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: expected a whole number, found {value!r}") from None
    if not least <= found <= most:
        raise ValueError(f"{name}: expected {least} to {most}, found {found}")
    return found


def program() -> list[str]:
    """How the command is started in a process of its own; nothing where no interpreter is known."""
    return [sys.executable, "-m", "edgegait"] if sys.executable else []


def words(flags: Mapping[str, Any]) -> list[str]:
    """Flags as the command line has them: `{"azimuth_deg": [0, 90]}` is `--azimuth-deg=0,90`.

    What is None or False is left out, and what is True has no value.
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
    """The values of a flag that has one or several."""
    try:
        values = list(value)
    except TypeError:
        values = [value]
    for one in values:
        if isinstance(one, (list, tuple, dict)):
            raise TypeError(f"{name}: expected one value or a list of them, found {value!r}")
    return values
