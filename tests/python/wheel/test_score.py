"""Scores of callables, and results as tables."""

import json
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import edgegait

TAKES = Path(__file__).parents[2] / "data" / "golden" / "v1-take.egp"
SIDES = {"azimuth_deg": [45, 90], "elevation_deg": [0], "raster": "rows"}


def flat(images):
    return images.reshape(len(images), -1)


def judged(recognizer):
    """Returns the results that do not depend on time or name."""
    return {
        name: value
        for name, value in recognizer.items()
        if name not in ("name", "runtime", "baseline", "p50_us", "p90_us", "p99_us", "latency")
    }


def test_pixels_as_a_callable_are_judged_as_pixels():
    results = edgegait.score([flat, "pixels"], no_baselines=True, conditions="casia-b", **SIDES)
    mine, pixels = sorted(results["recognizers"], key=lambda one: one["name"])
    assert (mine["name"], pixels["name"]) == ("flat", "pixels")
    assert mine["runtime"]["name"] == "python"
    assert judged(mine) == judged(pixels)
    assert 0 < mine["rank1"] < 1


def test_results_are_the_commands_json(program, tmp_path):
    path = tmp_path / "score.json"
    words = ["--azimuth-deg", "45,90", "--elevation-deg", 0, "--raster", "rows", "--out", tmp_path / "report"]
    program("score", "side", "pixels", *words, "--json", path)
    expected = json.loads(path.read_text())
    found = edgegait.score(["side", "pixels"], **SIDES)
    assert found["settings"] == expected["settings"]
    assert [judged(one) for one in found["recognizers"]] == [judged(one) for one in expected["recognizers"]]


def test_a_pack_is_scored_without_a_file(tmp_path):
    pack = edgegait.cohort(people=4, speeds_kmh=[5], seed=9)
    pack.save(tmp_path / "a.egp")
    held = edgegait.score("pixels", pack, no_baselines=True, **SIDES)
    read = edgegait.score("pixels", tmp_path / "a.egp", no_baselines=True, **SIDES)
    assert held["recognizers"][0]["probes"] == 8
    assert judged(held["recognizers"][0]) == judged(read["recognizers"][0])
    assert held["inputs"][0]["sha256"] == read["inputs"][0]["sha256"]


def test_a_callable_is_shown_what_its_contract_asks_for():
    seen = []

    def look(images):
        seen.append((images.shape, images.dtype, images.min(), images.max()))
        return images.mean(axis=2).reshape(len(images), -1)

    look = edgegait.Recognizer(
        look,
        name="look",
        template="silhouettes",
        size="64x44",
        frames=8,
        layout="NTHW",
        input_range="-1..1",
        distance="cosine",
    )
    results = edgegait.score(look, no_baselines=True, subjects=["F01", "M01"], **SIDES)
    assert results["recognizers"][0]["name"] == "look"
    assert {(shape[1:], low, high) for shape, _, low, high in seen} == {((8, 64, 44), -1.0, 1.0)}
    assert {kind for _, kind, _, _ in seen} == {np.dtype(np.float32)}


def test_a_callable_may_be_given_the_viewpoints():
    seen = []

    def look(images, views):
        seen.append((len(images), views.shape, views.dtype))
        # A part for each training viewpoint: the image in the part of its viewpoint, zeros in the other.
        pixels = flat(images)
        is_side = views[:, :1] == 90
        return np.stack([np.where(is_side, pixels, 0), np.where(is_side, 0, pixels)], axis=2)

    trained = {"viewpoints": [[90.0, 0.0], [0.0, 0.0]]}
    flags = {"subjects": ["F01", "M01"], "raster": "rows", "elevation_deg": [0], "no_baselines": True}
    recognizer = edgegait.Recognizer(look, view_input="view", distance="view", training=trained)
    rates = {}
    # Beside the model, pixels would be compared as it is.
    for one in (recognizer, "pixels"):
        results = edgegait.score(one, azimuth_deg=[90, 0], protocol="first-take", **flags)
        rates |= {found["name"]: found["rank1"] for found in results["recognizers"]}
    # Comparing within a viewpoint avoids confusion with people from the other one.
    assert rates["look"] == 1.0 > rates["pixels"]
    assert all(shape == (count, 2) and kind == np.float32 for count, shape, kind in seen)
    with pytest.raises(edgegait.Error, match="not been trained on viewpoint 45,0"):
        edgegait.score(recognizer, azimuth_deg=[45], protocol="cross-view", **flags)
    with pytest.raises(edgegait.Error, match="expected view_input"):
        edgegait.Recognizer(look, distance="view")


def test_classes_decide_where_scores_are_given():
    people = [one["name"] for one in edgegait.cohort(people=26, speeds_kmh=[5]).subjects]

    def known(images):
        scores = np.zeros((len(images), len(people)), np.float32)
        scores[:, 3] = 1
        return flat(images), scores

    results = edgegait.score(edgegait.Recognizer(known, classes=people), no_baselines=True, **SIDES)
    assert results["settings"]["protocol"] == "closed-set"
    # One of 26 people is right.
    assert results["recognizers"][0]["rank1"] == pytest.approx(1 / 26)


def test_lists_of_results_are_data_frames():
    pandas = pytest.importorskip("pandas")
    results = edgegait.score("pixels", **SIDES)
    assert isinstance(results, dict)
    frame = results.frame()
    assert list(frame["name"]) == ["pixels"]
    views = results.frame("by_viewpoint")
    assert isinstance(views, pandas.DataFrame)
    assert list(views["name"]) == ["pixels", "pixels"]
    assert list(views["azimuth_deg"]) == [45, 90]
    with pytest.raises(KeyError, match=r"'nothing': expected one of .*by_viewpoint"):
        results.frame("nothing")
    with pytest.raises(KeyError, match="compares no viewpoints"):
        results.frame("cross_view")
    crossed = edgegait.score("pixels", protocol="casia-b", raster="rows", subjects=["F01", "M02"], no_baselines=True)
    frame = crossed.frame("cross_view")
    assert len(frame) == 3 * 11 * 11
    other = frame[frame.probe_view != frame.gallery_view]
    means = other.groupby("probes").rank1.mean()
    for probes in crossed["recognizers"][0]["probe_sets"]:
        assert means[probes["name"]] == pytest.approx(probes["cross_view"]["mean_percent"] / 100, abs=1e-4)


def test_what_a_callable_raises_is_raised():
    class Own(Exception):
        pass

    def broken(images):
        raise Own("my bug")

    with pytest.raises(Own, match="my bug"):
        edgegait.score(broken, **SIDES)
    for wrong, text in [
        (lambda images: images.sum(), "expected embeddings of"),
        (lambda images: flat(images)[:1], "expected embeddings of"),
        (lambda images: images, "found 4 axes|expected embeddings"),
        (lambda images: (flat(images), images[:, 0]), "expected scores"),
        (lambda images: "text", "could not convert"),
        (lambda images: (flat(images), flat(images)[:, :3]), "scores of the 2 classes of the contract, found 3"),
        (lambda images: None, "found None"),
    ]:
        with pytest.raises((ValueError, TypeError), match=text):
            edgegait.score(edgegait.Recognizer(wrong, name="wrong", classes=["F01", "M02"]), **SIDES)
    # The next score runs.
    assert edgegait.score(flat, no_baselines=True, **SIDES)["recognizers"][0]["rank1"] > 0


def test_numbers_that_are_none_are_counted():
    def holes(images):
        found = flat(images).copy()
        found[::2, 0] = np.nan
        return found

    results = edgegait.score(holes, no_baselines=True, **SIDES)
    assert results["recognizers"][0]["probe_sets"][0]["non_finite"] > 0


def test_misuse_raises(tmp_path):
    for wrong, text in [
        ({"models": 3}, "expected a model's path"),
        ({"models": "nobody"}, "nobody"),
        ({"models": "pixels", "protocol": "own"}, 'no protocol "own"'),
        ({"models": "pixels", "bogus": 1}, "unexpected argument '--bogus'"),
        ({"models": "pixels", "json": "x"}, "json: results are returned"),
        ({"models": [flat, flat]}, "two recognizers are called 'flat'.*name="),
        ({"models": "pixels", "data": edgegait.Design("casia-b-like")}, "makes a tree to score"),
        ({"models": "pixels", "data": tmp_path / "nowhere.egp"}, "nowhere.egp"),
        ({"models": [TAKES, "pixels"], "data": edgegait.Pack(TAKES)}, "expected one source of walks"),
    ]:
        with pytest.raises((ValueError, TypeError, OSError, edgegait.Error), match=text):
            edgegait.score(**wrong)
    for wrong, text in [
        ({"size": "big"}, "64x44"),
        ({"size": "3x3"}, "3"),
        ({"colour": 3}, "unknown field `colour`.*name`"),
        ({"layout": "NTHW"}, "layout"),
    ]:
        with pytest.raises((ValueError, edgegait.Error), match=text) as raised:
            edgegait.score(edgegait.Recognizer(flat, **wrong), **SIDES)
        assert "line 1" not in str(raised.value)
    assert edgegait.Recognizer(flat, size=(64, 44)).contract["columns"] == 44
    assert edgegait.Recognizer(flat, template="silhouettes").contract["layout"] == "NTHW"
    with pytest.raises(TypeError, match="expected a callable"):
        edgegait.Recognizer(3)


def test_other_subcommands_run_quietly(tmp_path, capfd):
    results = edgegait.generate("casia-b-like", people=2, out=tmp_path / "set")
    assert results["people"] == 4
    shards = [tmp_path / "one", tmp_path / "two"]
    for number, shard in enumerate(shards, 1):
        edgegait.generate("casia-b-like", people=2, out=shard, shard=f"{number}/2")
    edgegait.merge(*(shard / "test" for shard in shards), out=tmp_path / "whole")
    whole, once = (path.read_bytes() for path in [tmp_path / "whole/geis.npy", tmp_path / "set/test/geis.npy"])
    assert whole == once
    design = edgegait.Design.from_toml(edgegait.Design("casia-b-like").toml)
    with pytest.raises(ValueError, match=r"design\.toml: expected the name of a design or its file"):
        edgegait.generate(design, out=tmp_path / "third")
    saved = design.save(tmp_path / "own.toml")
    edgegait.generate(saved, people=2, out=tmp_path / "third")
    assert (tmp_path / "third/test/geis.npy").read_bytes() == once
    with pytest.raises(FileExistsError):
        design.save(tmp_path / "own.toml")
    with pytest.raises(ValueError, match="--bogus"):
        edgegait.command("inspect", "a.egp", bogus=True)
    with pytest.raises(ValueError, match="out: expected a path"):
        edgegait.command("contract", "side", out="-")
    assert capfd.readouterr() == ("", "")


def test_models_are_measured_in_processes_of_their_own(program):
    measured = edgegait.command("bench", "side", max_seconds=1)
    assert measured["models"][0]["name"] == "side"
    assert "side" in program("bench", "side", "--max-seconds", 1)


def test_an_error_in_one_thread_leaves_the_others_alone():
    def slow(images):
        time.sleep(0.002)
        return flat(images)

    def wrong(images):
        raise RuntimeError("mine")

    with ThreadPoolExecutor() as pool:
        right = pool.submit(edgegait.score, slow, no_baselines=True, views="side", raster="rows", conditions="casia-b")
        for _ in range(20):
            with pytest.raises(RuntimeError, match="mine"):
                edgegait.score(wrong, no_baselines=True, **SIDES)
        assert not right.done() or right.exception() is None
        assert right.result()["recognizers"][0]["rank1"] > 0
