"""Packs are the same bytes as those of the command."""

import pickle
from pathlib import Path

import pytest

import edgegait

DATA = Path(__file__).parents[2] / "data"


def test_a_cohort_is_the_commands(program, tmp_path):
    path = tmp_path / "made.egp"
    program("cohort", "--people", 3, "--speeds-kmh", "4,5", "--seed", 7, "--dressed", "--out", path)
    pack = edgegait.cohort(people=3, speeds_kmh=[4, 5], seed=7, dressed=True)
    assert bytes(pack) == path.read_bytes() == bytes(edgegait.Pack(path))
    assert [one["name"] for one in pack.subjects] == ["7-F01", "7-M01", "7-F02"]
    assert [one["sex"] for one in pack.subjects] == ["female", "male", "female"]
    assert len(pack) == 6
    assert pack.walks[1]["walk"] == "walk-5kmh"
    assert pack.walks[1]["speed_kmh"] == 5.0
    assert 0.9 < pack.walks[1]["duration_s"] < 1.3
    assert not pack.walks[1]["is_uncut"]
    assert pack.results["bytes"] == len(bytes(pack))


def test_an_import_is_the_commands(program, tmp_path):
    path = tmp_path / "walk.egp"
    source = DATA / "mocap/clips/cmu_amc/s07/07_01.amc"
    program("import", source, "--subject", "anna", "--track", "clip", "--out", path)
    pack = edgegait.import_walks(source, subject="anna", track="clip")
    assert bytes(pack) == path.read_bytes()
    assert pack.walks[0]["is_uncut"]
    assert pack.results["clips"][0]["frames"] > 0
    # A take has all its frames.
    dataset = edgegait.Dataset(pack, views="side", template="silhouettes", raster="rows")
    image, _ = dataset[0]
    assert image.shape[1:] == (50, 30)
    assert image.shape[0] == dataset.rows([0])["frames"][0]


def test_packs_are_pickled_as_their_bytes(tmp_path):
    pack = edgegait.cohort(people=1, speeds_kmh=[5], quick=True)
    again = pickle.loads(pickle.dumps(pack))
    assert bytes(again) == bytes(pack)
    path = tmp_path / "a.egp"
    pack.save(path)
    with pytest.raises(ValueError, match="already exists"):
        pack.save(path)
    pack.save(path, overwrite=True)
    assert bytes(edgegait.Pack(path)) == bytes(pack)
    assert pack._repr_png_().startswith(b"\x89PNG")


def test_what_is_no_pack_is_refused(tmp_path):
    with pytest.raises(edgegait.Error, match='byte 0: expected "EGPK"'):
        edgegait.Pack.from_bytes(b"no pack")
    path = tmp_path / "cut.egp"
    path.write_bytes(bytes(edgegait.cohort(people=1, speeds_kmh=[5], quick=True))[:-1])
    with pytest.raises(edgegait.Error, match=r"cut\.egp"):
        edgegait.Pack(path)
    with pytest.raises(edgegait.Error, match=r"cut\.egp"):
        edgegait.Dataset(path)
    with pytest.raises(FileNotFoundError, match=r"nowhere\.egp"):
        edgegait.Pack(tmp_path / "nowhere.egp")
    with pytest.raises(TypeError):
        edgegait.Pack(3)
    with pytest.raises(TypeError):
        edgegait.Pack.from_bytes("text")


def test_people_who_cannot_be_are_refused():
    with pytest.raises(ValueError, match="expected 3 to 12"):
        edgegait.cohort(speeds_kmh=[40])
    with pytest.raises(ValueError, match="--sex"):
        edgegait.cohort(sex="neither")
    with pytest.raises(ValueError, match="--speed"):
        edgegait.cohort(speed_kmh=5)
    with pytest.raises(TypeError, match="out"):
        edgegait.cohort(out="x.egp")
    with pytest.raises(TypeError, match="expected files"):
        edgegait.import_walks()
    with pytest.raises(FileNotFoundError):
        edgegait.import_walks("nowhere.bvh")
