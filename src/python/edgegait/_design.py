"""Designs: of what a training set is made."""

from __future__ import annotations

import os
from pathlib import Path

from . import _native


class Design:
    """Who walks, how, under which conditions and seen from where, in about twenty lines of TOML.

    Args:
        name: A design that is built in ("casia-b-like", "domain-random"), or a `.toml` file.

    Its text is `toml`; `Design.from_toml(design.toml.replace('count = 8', 'count = 2'))` is another one.
    """

    def __init__(self, name: str | os.PathLike[str]) -> None:
        self.name = os.fspath(name)
        self.toml = _native.design_text(self.name)

    @classmethod
    def from_toml(cls, toml: str, name: str = "design.toml") -> Design:
        """A design from its text; `name` is for messages. Checked when a dataset is made of it."""
        design = cls.__new__(cls)
        design.name, design.toml = name, toml
        return design

    def save(self, path: str | os.PathLike[str]) -> Design:
        """Writes the text into a file that is not there yet; the design that this file is."""
        with Path(path).open("x", encoding="utf-8") as file:
            file.write(self.toml)
        return Design(path)

    def __repr__(self) -> str:
        return f"<Design {self.name}>"
