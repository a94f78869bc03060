"""Designs, which specify training sets."""

from __future__ import annotations

import os
from pathlib import Path

from . import _native


class Design:
    """The people, walks, conditions and viewpoints of a training set, in about twenty lines of TOML.

    Args:
        name: A built-in design ("casia-b-like", "domain-random"), or a `.toml` file.

    Its text is `toml`; `Design.from_toml(design.toml.replace('count = 8', 'count = 2'))` makes a variant.
    """

    def __init__(self, name: str | os.PathLike[str]) -> None:
        self.name = os.fspath(name)
        self.toml = _native.design_text(self.name)

    @classmethod
    def from_toml(cls, toml: str, name: str = "design.toml") -> Design:
        """Makes a design from its text, which a Dataset checks later; `name` is for messages."""
        design = cls.__new__(cls)
        design.name, design.toml = name, toml
        return design

    def save(self, path: str | os.PathLike[str]) -> Design:
        """Writes the text to a new file, and returns the design of that file."""
        with Path(path).open("x", encoding="utf-8") as file:
            file.write(self.toml)
        return Design(path)

    def __repr__(self) -> str:
        return f"<Design {self.name}>"
