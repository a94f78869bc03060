"""Endless streams: their items and their readers."""

import itertools
import pickle
from pathlib import Path

import numpy as np
import pytest

import edgegait

TAKE = Path(__file__).parents[2] / "data" / "golden" / "v1-take.egp"
MASK = 2**64 - 1


def mixed(z):
    """Returns the next number of splitmix64 (Steele, Lea & Flood)."""
    z = (z + 0x9E3779B97F4A7C15) & MASK
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
    return z ^ (z >> 31)


def permuted(number, count, key):
    """Permutes a number with a Feistel network of six rounds, repeated until the result is below `count`."""
    half = max(1, ((count - 1).bit_length() + 1) // 2)
    while True:
        left, right = number >> half, number & ((1 << half) - 1)
        for turn in range(6):
            left, right = right, left ^ (mixed(right ^ mixed((key + turn) & MASK)) & ((1 << half) - 1))
        number = left << half | right
        if number < count:
            return number


def place(at, seed, people, items, at_once):
    """Returns epoch and item of a draw in the order that the guide defines, reimplemented."""
    epoch, at = divmod(at, people * items)
    key = mixed(seed ^ mixed(epoch))
    block, at = divmod(at, min(at_once, people) * items)
    present = min(at_once, people - block * at_once)
    at = permuted(at, present * items, mixed(key ^ mixed(block + 1)))
    return epoch, permuted(block * at_once + at // items, people, key) * items + at % items


@pytest.fixture(scope="module")
def dataset():
    design = """
    seed = 3
    [population]
    people = "0..7"
    [walks]
    speeds_kmh = [5]
    [views]
    azimuth_deg = [0, 45, 90]
    elevation_deg = [0]
    [images]
    raster = "rows"
    """
    return edgegait.Dataset(edgegait.Design.from_toml(design))


def test_the_order_is_that_of_the_guide(dataset):
    stream = dataset.stream(batch=10, seed=9, people_at_once=3)
    found = [place for number in range(20) for place in stream.places(number)]
    assert found == [place(at, 9, 7, 3, 3) for at in range(200)]
    assert stream.places(0) != dataset.stream(batch=10, seed=8, people_at_once=3).places(0)


def test_viewpoints_of_a_cycle_can_stay_together(dataset):
    stream = dataset.stream(batch=6, seed=9, by_cycle=True)
    places = [place for number in range(7) for place in stream.places(number)]
    assert sorted(item for _, item in places[:21]) == list(range(21))
    for at in range(0, 42, 3):
        (epoch, first), second, third = places[at : at + 3]
        assert first % 3 == 0
        assert [second, third] == [(epoch, first + 1), (epoch, first + 2)]
    assert [(epoch, item // 3) for epoch, item in places[::3]] == [place(at, 9, 7, 1, 256) for at in range(14)]


def test_each_epoch_has_each_item_once(dataset):
    stream = dataset.stream(batch=4)
    places = [place for number in range(21) for place in stream.places(number)]
    for epoch in range(4):
        assert sorted(item for found, item in places if found == epoch) == list(range(21))
    plain = dataset.stream(batch=4, shuffle=False)
    assert plain.places(5) == [(0, 20), (1, 0), (1, 1), (1, 2)]


def test_a_batch_is_of_its_places(dataset):
    stream = dataset.stream(batch=8)
    # Items 16 to 23: two epochs.
    images, labels = stream[2]
    assert images.shape == (8, 50, 30)
    epochs = {epoch for epoch, _ in stream.places(2)}
    assert epochs == {0, 1}
    for image, label, (epoch, item) in zip(images, labels, stream.places(2), strict=True):
        alone, expected = dataset.batch([item], epoch=epoch)
        assert np.array_equal(image, alone[0])
        assert label == expected[0] == item // 3
    same = dataset.stream(batch=8, fresh=False)
    for image, (_, item) in zip(same[2][0], same.places(2), strict=True):
        assert np.array_equal(image, dataset[item][0])


def test_readers_share_batches_and_a_stream_goes_on_where_it_stopped(dataset, monkeypatch):
    def first(stream, count):
        return [images.tobytes() for images, _ in itertools.islice(stream, count)]

    alone = first(dataset.stream(batch=5), 6)
    shared = [first(dataset.stream(batch=5, rank=rank, world=2), 3) for rank in range(2)]
    assert [shared[at % 2][at // 2] for at in range(6)] == alone
    assert first(dataset.stream(batch=5, start=4), 2) == alone[4:]
    assert first(pickle.loads(pickle.dumps(dataset.stream(batch=5, start=4))), 2) == alone[4:]
    monkeypatch.setenv("RANK", "1")
    monkeypatch.setenv("WORLD_SIZE", "2")
    assert first(dataset.stream(batch=5), 3) == shared[1]
    # The rank is taken when the stream is made, not from its worker's environment.
    packed = pickle.dumps(dataset.stream(batch=5))
    monkeypatch.delenv("RANK")
    monkeypatch.delenv("WORLD_SIZE")
    assert first(pickle.loads(packed), 3) == shared[1]
    monkeypatch.setenv("RANK", "2")
    monkeypatch.setenv("WORLD_SIZE", "2")
    with pytest.raises(ValueError, match="expected a rank below"):
        dataset.stream()


def test_whole_takes_are_the_same_in_each_epoch():
    takes = edgegait.Dataset(TAKE, views="side", template="silhouettes", raster="rows")
    stream = takes.stream(batch=2)
    assert stream.places(0) == [(0, 0), (1, 0)]
    sequences, _ = stream[0]
    assert len(sequences[0]) > 1
    assert np.array_equal(sequences[0], sequences[1])


def test_misuse_raises(dataset):
    for wrong, text in [
        ({"batch": 0}, "batch: expected 1 to"),
        ({"batch": 10**9}, "at most 1431655 of these items at once"),
        ({"seed": -1}, "seed"),
        ({"seed": 2**64}, "seed: expected 0 to 18446744073709551615"),
        ({"start": 2**64}, "start"),
        ({"people_at_once": 0}, "people_at_once"),
        ({"rank": 2, "world": 2}, "rank: expected 0 to 1"),
        ({"rank": 1}, "both or none"),
    ]:
        with pytest.raises(ValueError, match=text):
            dataset.stream(**wrong)
    for wrong in [{"batch": "many"}, {"start": 1.5}]:
        with pytest.raises(TypeError, match="expected a whole number"):
            dataset.stream(**wrong)
    assert dataset.stream(batch=np.int64(3), seed=np.uint8(4)).places(0) == dataset.stream(batch=3, seed=4).places(0)
    with pytest.raises(IndexError, match="no end before"):
        dataset.stream(batch=3)[2**63]
    assert isinstance(dataset.stream(), edgegait.Stream)
    with pytest.raises(TypeError, match="never ends"):
        len(edgegait.Stream(dataset))
    with pytest.raises(IndexError):
        dataset.stream()[-1]
    with pytest.raises(TypeError, match="batch number: expected a whole number"):
        dataset.stream()["a"]
    with pytest.raises(TypeError, match="expected a Dataset, found Pack"):
        edgegait.Stream(edgegait.Pack(TAKE))
    with pytest.raises(TypeError):
        dataset.stream(size=3)
