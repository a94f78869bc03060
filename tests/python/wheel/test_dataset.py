"""Datasets give the bytes of the command, in any process and order."""

import multiprocessing
import os
import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import edgegait

DESIGN = """
seed = 5
conditions = "casia-b"
[population]
dressed = "per-take"
[walks]
speeds_kmh = {{ uniform = [4, 6], walks = 2 }}
takes = 2
[views]
azimuth_deg = {{ uniform = [0, 360] }}
elevation_deg = [0, 15]
count = 3
[images]
template = {template}
joints = {joints}
size = "64x44"
raster = "rows"
{more}
[splits]
train = "0..3"
test = "10..12"
"""


def design(template='"gei"', joints="false", more=""):
    return edgegait.Design.from_toml(DESIGN.format(template=template, joints=joints, more=more))


@pytest.mark.parametrize("split", ["train", "test"])
def test_a_design_is_what_generate_stores(program, table, tmp_path, split):
    made = design()
    made.save(tmp_path / "design.toml")
    program("generate", tmp_path / "design.toml", "--out", tmp_path / "set")
    stored = np.load(tmp_path / "set" / split / "geis.npy")
    dataset = edgegait.Dataset(made, split=split)
    images, labels = dataset.batch(range(len(dataset)))
    assert np.array_equal(images, stored)
    index = table(tmp_path / "set" / split / "index.csv")
    assert [dataset.classes[label] for label in labels] == index["subject"]
    assert np.array_equal(labels, dataset.labels)
    rows = dataset.rows()
    assert list(rows) == list(index)
    for name, column in rows.items():
        kind = type(column[0])
        assert column == [kind(value) for value in index[name]], name


def test_sequences_and_joints_are_what_generate_stores(program, tmp_path):
    made = design('["silhouettes", "gei", "mhi"]', "true", "fps = 25")
    made.save(tmp_path / "design.toml")
    program("generate", tmp_path / "design.toml", "--out", tmp_path / "set")
    folder = tmp_path / "set" / "train"
    stored = {name: np.load(folder / f"{name}.npy") for name in ["silhouettes", "geis", "mhi", "joints", "keypoints"]}
    dataset = edgegait.Dataset(made, split="train")
    frames = dataset.rows()["frames"]
    ends = np.cumsum(frames)
    assert len(set(frames)) > 1
    for at, (arrays, _) in enumerate(dataset):
        assert list(arrays) == list(stored)
        part = slice(ends[at] - frames[at], ends[at])
        for name in ["silhouettes", "joints", "keypoints"]:
            assert np.array_equal(arrays[name], stored[name][part], equal_nan=True), name
        for name in ["geis", "mhi"]:
            assert np.array_equal(arrays[name], stored[name][at]), name
    with pytest.raises(ValueError, match="equally many frames"):
        dataset.batch(range(len(dataset)))
    # Items of one cycle have the same number of frames.
    arrays, _ = dataset.batch([0, 1])
    assert arrays["silhouettes"].shape == (2, frames[0], 64, 44)
    assert arrays["joints"].dtype == np.float32


def test_a_sweep_is_what_the_command_stores(program, table, tmp_path):
    drawing = {
        "conditions": "casia-b",
        "template": ["gei", "frequency"],
        "raster": "rows",
        "cycles": 2,
        "subjects": ["F01", "M03"],
    }
    words = [
        "--conditions",
        "casia-b",
        "--template",
        "gei,frequency",
        "--raster",
        "rows",
        "--cycles",
        2,
        "--subjects",
        "F01,M03",
    ]
    angles = ["--azimuth-deg", "0,90", "--elevation-deg=-10,0,30"]
    program("sweep", *words, *angles, "--out", tmp_path / "set")
    stored = {name: np.load(tmp_path / "set" / f"{name}.npy") for name in ["geis", "frequency"]}
    index = table(tmp_path / "set" / "index.csv")
    cycles = list(edgegait.sweep(azimuth_deg=[0, 90], elevation_deg=[-10, 0, 30], **drawing))
    assert len(cycles) == 2 * 3 * 2
    for name, array in stored.items():
        assert np.array_equal(np.concatenate([cycle.arrays[name] for cycle in cycles]), array)
    for name in ["subject", "condition", "variation", "alternative", "elevation_deg"]:
        found = [value for cycle in cycles for value in cycle.rows[name]]
        assert found == [type(found[0])(value) for value in index[name]]
    assert cycles[0].images.shape == (6, 50, 30)
    assert cycles[0].subject == "F01"
    assert cycles[0]._repr_png_().startswith(b"\x89PNG")


def test_an_item_is_the_same_in_any_order_batch_and_number_of_threads():
    dataset = edgegait.Dataset(design(), split="train")
    images, labels = dataset.batch(range(len(dataset)))
    order = np.random.default_rng(1).permutation(len(dataset))
    shuffled, shuffled_labels = dataset.batch(order)
    assert np.array_equal(shuffled, images[order])
    assert np.array_equal(shuffled_labels, labels[order])
    one = edgegait.Dataset(design(), split="train", threads=1)
    for at in order[:10]:
        image, label = one[int(at)]
        assert np.array_equal(image, images[at])
        assert label == labels[at]
    assert np.array_equal(dataset[-1][0], images[-1])
    assert np.array_equal(dataset[np.int64(3)][0], images[3])
    twice, _ = dataset.batch([4, 4])
    assert np.array_equal(twice[0], twice[1])
    fewer = edgegait.Dataset(design(), split="train", people=2)
    assert len(fewer) * 3 == len(dataset) * 2
    assert np.array_equal(fewer.batch(range(len(fewer)))[0], images[: len(fewer)])


def test_a_batch_owns_its_memory_and_is_not_copied():
    dataset = edgegait.Dataset(views="side", raster="rows")
    images, labels = dataset.batch(range(8))
    assert images.flags.c_contiguous
    assert images.flags.writeable
    assert images.dtype == np.uint8
    assert labels.dtype == np.int64
    before = images[1].copy()
    images[0] = 0
    assert np.array_equal(images[1], before)
    assert np.array_equal(dataset[1][0], before)
    pairs = dataset.__getitems__([0, 1])
    assert pairs[0][0].base is not None
    assert isinstance(pairs[0][1], int)


def test_further_epochs_have_other_variations_of_the_same_people():
    dataset = edgegait.Dataset(design(), split="train")
    first = [dataset.batch(range(12), epoch=epoch)[0] for epoch in range(3)]
    assert not np.array_equal(first[0], first[1])
    assert not np.array_equal(first[1], first[2])
    rows = [dataset.rows(range(12), epoch=epoch) for epoch in range(3)]
    assert rows[0]["subject"] == rows[1]["subject"] == rows[2]["subject"]
    # Two takes of eight variations each; commands know variations below 1,001,000.
    assert max(rows[0]["variation"]) < 16
    assert {value - 2**20 for value in rows[1]["variation"]} == set(rows[0]["variation"])
    assert {value - 2**20 - 16 for value in rows[2]["variation"]} == set(rows[0]["variation"])
    with pytest.raises(ValueError, match="no variations left for pass"):
        dataset.batch([0], epoch=2**31)
    pack = edgegait.Dataset(views="side", raster="rows", subjects="F01")
    far = pack.rows([0], epoch=1)
    assert far["variation"] == [2**20]
    # Variations that the command can name are the same.
    named = edgegait.Dataset(views="side", raster="rows", subjects="F01", first_cycle=1000, cycles=2)
    assert named.rows()["variation"] == [1000, 1001]


def test_an_epoch_can_be_set_for_samplers_of_ones_own():
    dataset = edgegait.Dataset(design(), split="train", people=1)
    dataset.set_epoch(2)
    assert np.array_equal(dataset[5][0], dataset.batch([5], epoch=2)[0][0])
    assert dataset.rows([5]) == dataset.rows([5], epoch=2) != dataset.rows([5], epoch=0)
    again = pickle.loads(pickle.dumps(dataset))
    assert np.array_equal(again[5][0], dataset[5][0])
    assert np.array_equal(dataset.stream(batch=3, shuffle=False)[0][0], dataset.batch(range(3), epoch=0)[0])
    dataset.set_epoch(0)
    assert not np.array_equal(dataset[5][0], again[5][0])
    with pytest.raises(ValueError, match="epoch: expected"):
        dataset.set_epoch(-1)


def test_nobody_of_a_design_that_is_built_in_is_of_the_built_in_cohort():
    cohort = edgegait.cohort(people=26, speeds_kmh=[5]).subjects
    for name in ["casia-b-like", "domain-random"]:
        names = edgegait.Dataset(edgegait.Design(name), split="train", people=26).classes
        assert not {one["name"] for one in cohort} & set(names)


def _drawn(dataset):
    return dataset.batch(range(len(dataset)))[0].tobytes()


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_other_processes_draw_the_same(method):
    dataset = edgegait.Dataset(design(), split="train", people=1)
    expected = _drawn(dataset)
    again = pickle.loads(pickle.dumps(dataset))
    assert _drawn(again) == expected
    # Threads were started in this process before it forks.
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map_async(_drawn, [dataset, dataset]).get(timeout=60) == [expected, expected]
    pack = edgegait.Dataset(edgegait.cohort(people=1, speeds_kmh=[5], quick=True), views="side", raster="rows")
    with multiprocessing.get_context(method).Pool(1) as pool:
        assert pool.apply_async(_drawn, [pack]).get(timeout=60) == _drawn(pack)


def test_files_that_flags_name_go_with_a_pickle(tmp_path):
    views, conditions = tmp_path / "mine.csv", tmp_path / "some.toml"
    views.write_text("azimuth_deg,elevation_deg\n10,0\n200,30\n")
    conditions.write_text('[[conditions]]\nname = "hats"\nconfounders = { hat = 1 }\n')
    dataset = edgegait.Dataset(views=views, conditions=conditions, raster="rows", subjects="F01")
    expected, rows = _drawn(dataset), dataset.rows()
    assert rows["azimuth_deg"] == [10, 200]
    assert rows["condition"] == ["hats", "hats"]
    packed = pickle.dumps(dataset)
    views.write_text("azimuth_deg,elevation_deg\n90,0\n")
    conditions.unlink()
    again = pickle.loads(packed)
    assert again.rows() == rows
    assert _drawn(again) == expected
    assert _drawn(pickle.loads(pickle.dumps(again))) == expected


def test_processes_share_the_cores(monkeypatch):
    from edgegait import _dataset

    cores = len(os.sched_getaffinity(0))
    assert _dataset._share_of_threads() == 0
    monkeypatch.setenv("LOCAL_WORLD_SIZE", "2")
    assert _dataset._share_of_threads() == max(1, cores // 2)
    monkeypatch.setattr(_dataset, "_worker", lambda: SimpleNamespace(id=0, num_workers=cores))
    assert _dataset._share_of_threads() == 1


def test_misuse_raises():
    dataset = edgegait.Dataset(views="side", raster="rows")
    with pytest.raises(TypeError, match="no slices: batch"):
        dataset[0:3]
    with pytest.raises(TypeError, match="flatnonzero"):
        dataset.batch(np.ones(26, bool))
    for name in ["casia-b-like", "mine.toml"]:
        with pytest.raises(ValueError, match=r"a design is edgegait\.Design"):
            edgegait.Dataset(name)
    for wrong in ["a", 1.5, None, [0], (0, 1)]:
        with pytest.raises((TypeError, ValueError)):
            dataset[wrong]
    for beyond in [26, -27, 2**40, -(2**62)]:
        with pytest.raises(IndexError, match="expected one of 26"):
            dataset[beyond]
    with pytest.raises(IndexError):
        dataset.rows([99])
    # Items of 1,500 bytes that exceed 2 GiB.
    with pytest.raises(ValueError, match="at most 1431655 of these items at once, found 1431656"):
        dataset.batch(np.zeros(1_431_656, np.int64))
    for wrong in [-1, 2**32]:
        with pytest.raises(ValueError, match="epoch: expected 0 to 4294967295"):
            dataset.batch([0], epoch=wrong)
        with pytest.raises(ValueError, match="epoch"):
            dataset.rows([0], epoch=wrong)
    images, labels = dataset.batch([])
    assert len(images) == len(labels) == 0
    sequences = edgegait.Dataset(views="side", raster="rows", template="silhouettes")
    assert sequences.batch([])[0].shape == (0, 1, 50, 30)
    assert sequences.__getitems__([]) == []
    # Narrow integer types are accepted as indices.
    large = edgegait.Dataset(views="paper", raster="rows")
    assert np.array_equal(large.batch(np.array([1, 2], np.uint8))[0], large.batch([1, 2])[0])
    assert np.array_equal(large[np.int8(-1)][0], large[len(large) - 1][0])
    for wrong, text in [
        ({"raster": "crayons"}, "possible values: skia"),
        ({"views": "everywhere"}, 'expected "paper", "side"'),
        ({"subjects": "nobody"}, "nobody"),
        ({"lens": "ortho", "distance_m": 3}, "--distance-m"),
        ({"template": "gei", "raster": "columns"}, "raster columns"),
        ({"colour": "blue"}, "unexpected argument '--colour'"),
        ({"out": "here"}, "nothing is stored here"),
        ({"shard": "1/2"}, "nothing is stored here"),
        ({"conditions": "bad-weather"}, "no set of conditions"),
        ({"azimuth_deg": [1, [2]]}, "expected one value or a list"),
        ({"threads": 0}, "threads: expected 1 to 1024"),
        ({"threads": 2.5}, "threads: expected a whole number, found 2.5"),
        ({"whole_recordings": True}, "--whole-recordings: expected a tree"),
        ({"named_views": True}, "--named-views: expected a tree"),
    ]:
        with pytest.raises((ValueError, TypeError), match=text):
            edgegait.Dataset(**wrong)
    for wrong in [3, b"bytes", ["a.egp"]]:
        with pytest.raises(TypeError, match="expected a Design, a Pack or a path"):
            edgegait.Dataset(wrong)
    with pytest.raises(OSError, match="expected a regular file, found a folder"):
        edgegait.Dataset(".")


def test_designs_that_cannot_be_are_refused():
    with pytest.raises(ValueError, match='no design "casia": expected casia-b-like, domain-random'):
        edgegait.Design("casia")
    with pytest.raises(FileNotFoundError):
        edgegait.Design("nowhere.toml")
    with pytest.raises(edgegait.Error, match=r"design\.toml:2: unknown field `colour`"):
        edgegait.Dataset(edgegait.Design.from_toml('seed = 1\ncolour = "blue"\n'))
    with pytest.raises(ValueError, match="no split is named, expected one of"):
        edgegait.Dataset(edgegait.Design("casia-b-like"))
    with pytest.raises(ValueError, match='no split "valid"'):
        edgegait.Dataset(edgegait.Design("casia-b-like"), split="valid")
    with pytest.raises(TypeError, match="raster: a design says"):
        edgegait.Dataset(edgegait.Design("casia-b-like"), split="train", raster="rows")
    with pytest.raises(TypeError, match="expected a Design"):
        edgegait.Dataset(split="train")
    with pytest.raises(ValueError, match="people: expected 1 to"):
        edgegait.Dataset(edgegait.Design("casia-b-like"), split="train", people=-1)
