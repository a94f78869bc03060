"""The command `edgegait`."""

from __future__ import annotations

import sys

from . import _native
from ._flags import program


def main() -> None:
    """Runs the command with the arguments of the process."""
    sys.exit(_native.main(["edgegait", *sys.argv[1:]], program()))
