"""The subcommands of `edgegait`, in this process."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from typing import Any

from . import _native
from ._design import Design
from ._flags import program, words

_FOLDED = ("recognizers", "models", "points", "clips")


class Results(dict[str, Any]):
    """The JSON results of a subcommand as a dict, with lists of rows as data frames."""

    def frame(self, key: str | None = None) -> Any:
        """Returns the rows of a list as a pandas DataFrame.

        Args:
            key: The name of a list in the results ("recognizers", "paired"), or of a list in each
                recognizer or model ("by_viewpoint", "probe_sets"), whose name is then the first column.
                "cross_view": rank-1 of each probe set, for each pair of viewpoints. None: the only list
                of recognizers, models, points or clips.

        Raises:
            KeyError: If there is no such list.
            ImportError: If pandas is not installed.
        """
        import pandas  # type: ignore[import-untyped, import-not-found, unused-ignore]

        if key is None:
            key = next((name for name in _FOLDED if isinstance(self.get(name), list)), "")
        if key == "cross_view":
            rows = [row for one in self.get("recognizers", ()) for row in _cross_view(one)]
            if not rows:
                raise KeyError("'cross_view': the protocol compares no viewpoints each with each")
            return pandas.DataFrame(rows)
        if isinstance(self.get(key), list):
            return pandas.DataFrame([_row(one) for one in self[key]])
        rows = []
        for name in _FOLDED:
            for one in self.get(name) or ():
                for row in one.get(key) or ():
                    rows.append({"name": one.get("name"), **_row(row)})
        if not rows:
            lists = [name for name, value in self.items() if isinstance(value, list)]
            for name in _FOLDED:
                for one in (self.get(name) or ())[:1]:
                    lists += [name for name, value in one.items() if isinstance(value, list)]
            raise KeyError(f"{key!r}: expected one of {', '.join(sorted(set(lists)))}")
        return pandas.DataFrame(rows)


def _cross_view(recognizer: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yields rank-1 of each probe set, for each pair of viewpoints."""
    for probes in recognizer["probe_sets"]:
        found = probes.get("cross_view")
        for probe, ranks in zip(found["views"], found["rank1"], strict=True) if found else ():
            for gallery, rank1 in zip(found["views"], ranks, strict=True):
                yield {
                    "name": recognizer["name"],
                    "probes": probes["name"],
                    "probe_view": _label(probe),
                    "gallery_view": _label(gallery),
                    "rank1": rank1,
                }


def _label(view: Any) -> Any:
    """Returns a viewpoint as one value: its azimuth if it is level, else both angles; or a camera's name."""
    if isinstance(view, str):
        return view
    azimuth, elevation = view
    return azimuth if elevation == 0 else (azimuth, elevation)


def _row(value: Any) -> dict[str, Any]:
    """Returns an entry of a list as a row, without nested values."""
    if not isinstance(value, dict):
        return {"value": value}
    return {name: one for name, one in value.items() if not isinstance(one, (list, dict))}


def command(name: str, *inputs: str | os.PathLike[str], **flags: Any) -> Results:
    """Runs a subcommand of `edgegait` quietly, and returns the results that `--json` would write.

    >>> edgegait.command("inspect", "cohort.egp")["bytes"]

    Args:
        name: The subcommand.
        inputs: Its positional arguments (files and names), in order.
        flags: Its flags, with underscores instead of dashes; a list gives several values.

    Raises:
        ValueError: For invalid arguments.
        OSError: If the system refuses to read or write.
        Error: For invalid files.
    """
    return run(name, inputs, flags)


def run(
    name: str,
    inputs: tuple[str | os.PathLike[str], ...],
    flags: dict[str, Any],
    callables: list[tuple[Any, str]] | None = None,
    pack: Any = None,
) -> Results:
    """Runs a subcommand with recognizers and a pack of this process."""
    for taken in ("json", "quiet"):
        if taken in flags:
            raise TypeError(f"{taken}: results are returned, and nothing is printed")
    if flags.get("out") == "-":
        raise ValueError("out: expected a path, found standard output (nothing is printed)")
    named = ["--", *(os.fspath(one) for one in inputs)] if inputs else []
    text = _native.command([name, *words(flags), *named], program(), callables or [], pack)
    return Results(json.loads(text) if text else {})


def generate(design: Design | str | os.PathLike[str], **flags: Any) -> Results:
    """Writes the dataset of a design to disk, as `edgegait generate` does.

    Args:
        design: A Design, the name of a built-in design, or a `.toml` file.
        flags: `out="set"` ["generated"], `format="opengait"`, `shard="1/4"`, `resume=True`.

    Raises:
        ValueError: For a Design that is not in a file, since results state the file.
    """
    if not isinstance(design, Design):
        return command("generate", design, **flags)
    try:
        is_named = Design(design.name).toml == design.toml
    except (OSError, ValueError, _native.Error):
        is_named = False
    if not is_named:
        raise ValueError(f"{design.name}: expected the name of a design or its file (Design.save writes one)")
    return command("generate", design.name, **flags)


def merge(*shards: str | os.PathLike[str], **flags: Any) -> Results:
    """Joins all shards of a dataset, as `edgegait merge` does: `out="set"`."""
    return command("merge", *shards, **flags)
