"""Tests of the installed package: `python -m pytest tests/python/wheel`.

EDGEGAIT_PROGRAM names the command whose files are compared; by default, it is the package's.
"""

import csv
import os
import subprocess
import sys

import pytest


@pytest.fixture
def program():
    """Runs the command with these arguments, and fails if it fails."""
    named = os.environ.get("EDGEGAIT_PROGRAM")
    start = [named] if named else [sys.executable, "-m", "edgegait"]

    def run(*words):
        done = subprocess.run([*start, *map(str, words)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture
def table():
    """Reads a CSV file by column."""

    def read(path):
        with open(path, newline="") as file:
            rows = list(csv.DictReader(file))
        return {name: [row[name] for row in rows] for name in rows[0]}

    return read
