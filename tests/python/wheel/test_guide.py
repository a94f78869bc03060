"""The code blocks of the guide's page run one after another in one session."""

import importlib.util
import os
import re
from pathlib import Path

import pytest

import edgegait

GUIDE = Path(__file__).parents[3] / "src/guide/python.md"


def test_the_blocks_of_the_guide_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", GUIDE.read_text(), re.DOTALL)
    assert len(blocks) == 4
    # 800 steps take a minute; some of them show that it runs.
    names = {"STEPS": int(os.environ.get("EDGEGAIT_STEPS", "3"))}
    left_out = 0
    for block in blocks:
        if "import torch" in block or ", torch" in block:
            if importlib.util.find_spec("torch") is None:
                left_out += 1
                continue
            pytest.importorskip("pandas")
        exec(compile(block, str(GUIDE), "exec"), names)
    printed = capsys.readouterr().out
    print(printed)
    assert printed.count("(3, 50, 30)") == 20
    assert names["image"].shape == (50, 30)
    assert names["images"].shape == ((64, 50, 30) if left_out else (128, 50, 30))
    assert names["rows"]["azimuth_deg"][0] <= 180
    assert {"pixels", "mean_silhouette"} < {one["name"] for one in names["results"]["recognizers"]}


def test_docstrings_say_what_is_there():
    for name in edgegait.__all__:
        assert getattr(edgegait, name).__doc__, name
