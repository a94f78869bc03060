"""PyTorch: loaders, samplers, workers and modules (.ci/full runs these; without PyTorch they are skipped)."""

import gc
import itertools
import os

import numpy as np
import pytest

torch = pytest.importorskip("torch")
data = pytest.importorskip("torch.utils.data")

import edgegait  # noqa: E402


@pytest.fixture(scope="module")
def dataset():
    design = edgegait.Design("casia-b-like")
    return edgegait.Dataset(design, split="train", people=3)


def images_of(loader):
    return torch.cat([images for images, _ in loader])


@pytest.mark.parametrize("workers", [0, 1, 2])
@pytest.mark.parametrize("context", ["fork", "spawn"])
def test_a_loader_takes_a_dataset_as_it_is(dataset, workers, context):
    if workers == 0 and context == "spawn":
        pytest.skip("no process is started")
    expected, labels = dataset.batch(range(len(dataset)))
    how = {"multiprocessing_context": context} if workers else {}
    loader = data.DataLoader(dataset, batch_size=32, num_workers=workers, **how)
    found = list(loader)
    assert np.array_equal(torch.cat([images for images, _ in found]), expected)
    assert np.array_equal(torch.cat([labels for _, labels in found]), labels)
    assert found[0][0].dtype == torch.uint8
    assert found[0][1].dtype == torch.int64


def test_shuffled_loaders_have_each_item_once(dataset):
    expected, _ = dataset.batch(range(len(dataset)))
    loader = data.DataLoader(dataset, batch_size=32, shuffle=True, generator=torch.Generator().manual_seed(3))
    found = sorted(image.numpy().tobytes() for image in images_of(loader))
    assert found == sorted(image.tobytes() for image in expected)


def test_a_distributed_sampler_shares_items(dataset):
    expected, _ = dataset.batch(range(len(dataset)))
    shares = []
    for rank in range(2):
        sampler = data.DistributedSampler(dataset, num_replicas=2, rank=rank, shuffle=False)
        shares.append(images_of(data.DataLoader(dataset, batch_size=16, sampler=sampler)))
    assert np.array_equal(torch.stack(shares, 1).flatten(0, 1), expected)


@pytest.mark.parametrize("workers", [0, 1, 2, 3])
def test_a_stream_is_the_same_with_any_number_of_workers(dataset, workers):
    stream = dataset.stream(batch=16, seed=4)
    assert isinstance(stream, data.IterableDataset)
    assert isinstance(stream, edgegait.Stream)
    loader = data.DataLoader(stream, batch_size=None, num_workers=workers)
    found = list(itertools.islice(loader, 7))
    for number, (images, labels) in enumerate(found):
        expected, people = stream[number]
        assert np.array_equal(images, expected)
        assert np.array_equal(labels, people)


def test_ranks_and_workers_share_a_stream(dataset):
    shares = []
    for rank in range(2):
        stream = dataset.stream(batch=16, rank=rank, world=2)
        loader = data.DataLoader(stream, batch_size=None, num_workers=2)
        shares.append(list(itertools.islice(loader, 4)))
    for number in range(8):
        assert np.array_equal(shares[number % 2][number // 2][0], dataset.stream(batch=16)[number][0])


def test_the_process_group_says_which_rank_reads(dataset, monkeypatch):
    monkeypatch.setattr(torch.distributed, "is_initialized", lambda: True)
    monkeypatch.setattr(torch.distributed, "get_rank", lambda: 1)
    monkeypatch.setattr(torch.distributed, "get_world_size", lambda: 3)
    stream = dataset.stream(batch=16)
    # Spawned workers have no process group.
    loader = data.DataLoader(stream, batch_size=None, num_workers=1, multiprocessing_context="spawn")
    for number, (images, _) in zip([1, 4], loader, strict=False):
        assert np.array_equal(images, stream[number][0])


def test_an_abandoned_loader_leaves_nothing_behind(dataset):
    batches = iter(data.DataLoader(dataset.stream(batch=16), batch_size=None, num_workers=2))
    next(batches)
    workers = [worker.pid for worker in batches._workers]
    assert len(workers) == 2
    del batches
    gc.collect()
    for pid in workers:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
    assert len(dataset.batch(range(8))[0]) == 8


def test_modules_are_scored_in_evaluation_mode_and_left_as_they_were():
    class Net(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.drop = torch.nn.Dropout(0.5)
            self.frozen = torch.nn.BatchNorm1d(4).eval()
            self.modes = set()

        def forward(self, images):
            self.modes.add((self.training, torch.is_inference_mode_enabled(), type(images)))
            return self.drop(images.flatten(1))

    net = Net()
    results = edgegait.score([net, "pixels"], views="side", raster="rows", no_baselines=True)
    assert net.training
    assert net.drop.training
    assert not net.frozen.training
    assert net.modes == {(False, True, torch.Tensor)}
    mine, pixels = results["recognizers"][1], results["recognizers"][0]
    assert mine["name"] == "Net"
    assert mine["rank1"] == pixels["rank1"]
    # Embeddings in parts, as of OpenGait's models.
    parts = edgegait.Recognizer(lambda images: torch.from_numpy(images).reshape(len(images), 50, 30), name="parts")
    assert edgegait.score(parts, views="side", raster="rows", no_baselines=True)["recognizers"][0]["rank1"] == 1


def test_tensors_are_pictures(dataset):
    images, _ = dataset.batch(range(4))
    assert edgegait.Picture(torch.from_numpy(images))._repr_png_() == edgegait.Picture(images)._repr_png_()
