"""Datasets whose items are drawn on request."""

from __future__ import annotations

import os
import sys
import tempfile
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _native
from ._design import Design
from ._flags import whole, words
from ._pack import Pack
from ._picture import by_item, sheet_of, sheet_of_items

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._flags import Drawing, Streaming

#: An array of each item, or several by name.
Arrays = Any

#: The maximum of items a core, and of approximate bytes, with this many frames a cycle, that a sweep draws at once.
_ITEMS_AT_ONCE = 1024
_BYTES_AT_ONCE = 1 << 22
_FRAMES = 32

#: Items that `rows` requests in one call.
_ROWS_AT_ONCE = 1 << 14

#: The greatest unsigned numbers of 32 and 64 bits.
_U32 = (1 << 32) - 1
_U64 = (1 << 64) - 1

#: Flags that may name a file, and the extension of that file.
_FILES = {"views": ".csv", "conditions": ".toml"}


class Dataset:
    """A dataset whose items, an image and the number of the person, are drawn on request.

    An item is a gait cycle seen from one viewpoint, like a row of the index of a dataset that `generate`
    or `sweep` would write. Its bytes are the same in any order, worker, shard and batch. A
    `torch.utils.data.DataLoader` accepts a dataset directly. To change the items, wrap a dataset in a class of
    your own, with `__len__` and `__getitem__` (or `__getitems__`), instead of inheriting from it.

    Args:
        source: A Design, whose people are made when they are needed; a Pack; or the path of a pack.
            None: the built-in cohort.
        split: The split, for a design with splits.
        people: The maximum number of people of a design.
        threads: The number of threads that draw a batch [all cores; torchrun processes and DataLoader workers share
            the cores].
        drawing: For a pack, the flags of `edgegait sweep` that choose walks and how they are drawn, by
            default from 703 viewpoints. A design states them itself.
    """

    def __init__(
        self,
        source: Design | Pack | str | os.PathLike[str] | None = None,
        *,
        split: str | None = None,
        people: int | None = None,
        threads: int | None = None,
        **drawing: Unpack[Drawing],
    ) -> None:
        if threads is not None:
            threads = whole("threads", threads, 1, 1024)
        if people is not None:
            people = whole("people", people, 1, _U32)
        files: dict[str, bytes] = {}
        if isinstance(source, Design):
            if drawing:
                raise TypeError(f"{next(iter(drawing))}: a design says how it is drawn (change its TOML)")
            self._items = _native.Items.of_design(source.toml, source.name, split, people)
        else:
            if split is not None or people is not None:
                raise TypeError("split, people: expected a Design (subjects= chooses people of a pack)")
            if source is not None and not isinstance(source, (Pack, str, os.PathLike)):
                raise TypeError(f"expected a Design, a Pack or a path, found {type(source).__name__}")
            if isinstance(source, (str, os.PathLike)) and _is_design(Path(source)):
                raise ValueError(f"{os.fspath(source)}: expected a pack's path (a design is edgegait.Design(...))")
            # The bytes go wherever the dataset is pickled.
            source = source if source is None or isinstance(source, Pack) else Pack(source)
            self._items, files = _swept_items(drawing, source)
        self._state: tuple[Any, ...] = source, split, people, drawing, files
        self.threads = threads
        self._epoch = 0
        #: Bytes of an item, or of a frame, in each array, and whether it has frames.
        self._arrays = {name: (size, has_frames) for name, size, has_frames in self._items.arrays}
        self._len = len(self._items)

    @property
    def classes(self) -> list[str]:
        """The names of the people with the labels 0, 1, ..."""
        return self._items.subjects

    @property
    def labels(self) -> np.ndarray:
        """The label of each item, int64."""
        return self._items.labels()

    @property
    def views(self) -> int:
        """The number of viewpoints of each cycle: this many consecutive items show one cycle."""
        return self._items.views

    def __len__(self) -> int:
        return self._len

    def set_epoch(self, epoch: int) -> None:
        """Sets the epoch of the items: each epoch has other variations of the same walks.

        Call it before each epoch of a `DataLoader`, as for a `DistributedSampler`. Epoch 0, with which a
        dataset begins, is what `generate` or `sweep` would write. Persistent workers keep their epoch.
        """
        self._epoch = whole("epoch", epoch, 0, _U32)

    def __getitem__(self, index: Any) -> tuple[Arrays, int]:
        """Returns the image (or the arrays by name) and the label of one item."""
        if isinstance(index, slice):
            raise TypeError("a dataset has no slices: batch(range(...)) draws several items as one array")
        return self.__getitems__([index])[0]

    def __getitems__(self, indices: Iterable[Any]) -> list[tuple[Arrays, int]]:
        """Returns several items, drawn together."""
        numbers = self._numbers(indices)
        arrays, labels = self._drawn(numbers, self._epoch)
        labels = labels.tolist()
        if isinstance(arrays, dict):
            by_item = [dict(zip(arrays, one, strict=True)) for one in zip(*arrays.values(), strict=True)]
            return list(zip(by_item, labels, strict=True))
        return list(zip(arrays, labels, strict=True))

    def batch(self, indices: Iterable[Any], *, epoch: int | None = None) -> tuple[Arrays, np.ndarray]:
        """Returns several items as one array `[n, ...]` (or arrays by name), and their labels, int64.

        Args:
            indices: Numbers of items, in any order.
            epoch: 0 draws the variations of the dataset, and each further epoch draws others of the same
                walks, which no protocol tests with [the epoch of `set_epoch`, else 0].

        Raises:
            ValueError: If items have different numbers of frames, which do not fit into one array.
        """
        arrays, labels = self._drawn(self._numbers(indices), self._epoch_of(epoch))
        stacked = {name: _stacked(name, one) for name, one in _named(arrays, self._arrays).items()}
        return _only(stacked), labels

    def rows(self, indices: Iterable[Any] | None = None, *, epoch: int | None = None) -> dict[str, list[Any]]:
        """Returns the rows of `index.csv` for items (None: all), by column.

        The columns are subject, walk, cycle, variation, speed_kmh, azimuth_deg, elevation_deg, condition,
        alternative, frames and seed; `pandas.DataFrame` makes a table of them.
        """
        numbers = range(self._len) if indices is None else self._numbers(indices)
        epoch = self._epoch_of(epoch)
        found = self._items.rows([], epoch, 1)
        for first in range(0, len(numbers), _ROWS_AT_ONCE):
            part = self._items.rows(numbers[first : first + _ROWS_AT_ONCE], epoch, self._threads())
            for name, column in part.items():
                found[name] += column
        return found

    def stream(self, batch: int = 128, **how: Unpack[Streaming]) -> Stream:
        """Returns an endless stream of batches: see Stream for the arguments."""
        return _stream_class()(self, batch, **how)

    def _numbers(self, indices: Iterable[Any]) -> list[int]:
        """Converts indices to numbers of items; indices below 0 count from the end."""
        numbers = np.asarray(list(indices) if not isinstance(indices, np.ndarray) else indices)
        if numbers.size == 0:
            return []
        if numbers.dtype == bool:
            raise TypeError("expected numbers of items, found a mask (numpy.flatnonzero makes numbers of it)")
        if numbers.ndim != 1 or numbers.dtype.kind not in "iu":
            raise TypeError(f"expected numbers of items, found {numbers.dtype} of shape {numbers.shape}")
        beyond = (numbers < -self._len) | (numbers >= self._len)
        if beyond.any():
            raise IndexError(f"item {numbers[beyond][0]}: expected one of {self._len}")
        numbers = numbers.astype(np.int64)
        found: list[int] = np.where(numbers < 0, numbers + self._len, numbers).tolist()
        return found

    def _drawn(self, numbers: list[int], epoch: int) -> tuple[Arrays, np.ndarray]:
        """Draws items: one array each, or a list of arrays if the numbers of frames differ."""
        drawn, frames = self._items.draw(numbers, epoch, self._threads())
        arrays = {name: by_item(array, frames) if self._arrays[name][1] else array for name, array in drawn.items()}
        return _only(arrays), self._items.labels(numbers)

    def _epoch_of(self, epoch: int | None) -> int:
        """Returns the requested epoch, or the current one."""
        return self._epoch if epoch is None else whole("epoch", epoch, 0, _U32)

    def _threads(self) -> int:
        """Returns the number of threads that draw; 0 for all cores."""
        return self.threads or _share_of_threads()

    def __iter__(self) -> Iterator[tuple[Arrays, int]]:
        """Yields all items in order, drawn in small batches."""
        for first in range(0, self._len, 64):
            yield from self.__getitems__(range(first, min(first + 64, self._len)))

    def __repr__(self) -> str:
        return f"<Dataset: {self._len} items of {len(self.classes)} people: {', '.join(self._arrays)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        source, split, people, drawing, files = self._state
        if type(self) is not Dataset:
            raise TypeError("a subclass of Dataset cannot be pickled: wrap a Dataset in a class of your own")
        return _dataset, (source, split, people, self.threads, drawing, files, self._epoch)

    def _repr_png_(self) -> bytes:
        return sheet_of_items(self._items, self._threads())


def _is_design(path: Path) -> bool:
    """Returns whether a path looks like a design's name or file."""
    return path.suffix == ".toml" or (not path.suffix and not path.exists())


def _swept_items(drawing: Drawing, source: Pack | None) -> tuple[_native.Items, dict[str, bytes]]:
    """Returns the items of a sweep, and the contents of files that flags name, to be pickled with a dataset."""
    files = {}
    for flag, ending in _FILES.items():
        named: Any = drawing.get(flag)
        if isinstance(named, (str, os.PathLike)) and os.fspath(named).endswith(ending) and Path(named).is_file():
            files[flag] = Path(named).read_bytes()
    return _native.Items.of_sweep(words(drawing), None if source is None else source._native), files


def _dataset(
    source: Any,
    split: Any,
    people: Any,
    threads: Any,
    drawing: dict[str, Any],
    files: dict[str, bytes],
    epoch: int,
) -> Dataset:
    """Restores a pickled dataset, with the original files that its flags name."""
    with tempfile.TemporaryDirectory() as folder:
        there = dict(drawing)
        for flag, contents in files.items():
            there[flag] = os.path.join(folder, os.path.basename(os.fspath(drawing[flag])))
            Path(there[flag]).write_bytes(contents)
        dataset = Dataset(source, split=split, people=people, threads=threads, **there)
    dataset._state = source, split, people, drawing, files
    dataset._epoch = epoch
    return dataset


def _only(arrays: dict[str, Any]) -> Any:
    """Returns the only array, or several by name."""
    return next(iter(arrays.values())) if len(arrays) == 1 else arrays


def _named(arrays: Any, names: Iterable[str]) -> dict[str, Any]:
    """Returns arrays by name, also if there is only one."""
    return arrays if isinstance(arrays, dict) else {next(iter(names)): arrays}


def _stacked(name: str, array: np.ndarray | list[np.ndarray]) -> np.ndarray:
    """Returns one array, or raises if items have different numbers of frames."""
    if isinstance(array, list):
        frames = sorted({len(one) for one in array})
        raise ValueError(
            f"{name}: expected items of equally many frames, found {frames[0]} to {frames[-1]} "
            "(frames_per_cycle= instead of fps=, or dataset[i] one by one)"
        )
    return array


def _share_of_threads() -> int:
    """Returns the number of threads that draw: 0 for all cores, or a share of them with several processes."""
    worker, local = _worker(), os.environ.get("LOCAL_WORLD_SIZE", "1")
    processes = (1 if worker is None else int(worker.num_workers)) * (int(local) if local.isdecimal() else 1)
    if processes <= 1:
        return 0
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, cores // processes)


def _worker() -> Any:
    """Returns PyTorch's information about this process, if it is a worker of a DataLoader."""
    torch = sys.modules.get("torch.utils.data")
    return None if torch is None else torch.get_worker_info()


def _rank() -> tuple[int, int]:
    """Returns the rank of this process and the number of ranks, from torch.distributed or its launcher."""
    torch = sys.modules.get("torch.distributed")
    if torch is not None and torch.is_available() and torch.is_initialized():
        return torch.get_rank(), torch.get_world_size()
    rank, world = os.environ.get("RANK"), os.environ.get("WORLD_SIZE")
    if rank is None or world is None:
        return 0, 1
    if not (rank.isdecimal() and world.isdecimal() and int(rank) < int(world)):
        raise ValueError(f"RANK={rank}, WORLD_SIZE={world}: expected a rank below the number of readers")
    return int(rank), int(world)


class Stream:
    """An endless stream of batches of a dataset: `(images, labels)`, arrays of `[batch, ...]` and int64.

    Each epoch has every item once, shuffled, with variations of the walks that earlier epochs did not have.
    The bytes of batch number b do not depend on its reader. Readers share batches: rank r of w reads the
    batches r, r + w, ..., and its DataLoader's workers share those, so that their order does not depend on
    the number of workers. Uncut motions have no variations: they are the same in each epoch. Import torch
    before passing a stream to `DataLoader(stream, batch_size=None)`.

    Args:
        dataset: The dataset.
        batch: Items in a batch.
        seed: Seed of the order.
        shuffle: Whether items are shuffled; else they come in order.
        people_at_once: Number of people of a design that are made together and whose items are shuffled
            together; an epoch goes through all people in groups of this size.
        by_cycle: Whether the viewpoints of a cycle stay together, instead of being shuffled too: a cycle
            is posed once for them, so that streams of many viewpoints are several times as fast.
        fresh: Whether each epoch has variations of its own; else all epochs have the same items.
        start: The number of the first batch, to continue an earlier training run.
        rank, world: The number of this reader, and the number of readers [from torch.distributed, or from
            the environment's RANK and WORLD_SIZE; else the only reader].
    """

    def __init__(
        self,
        dataset: Dataset,
        batch: int = 128,
        *,
        seed: int = 1,
        shuffle: bool = True,
        people_at_once: int = 256,
        by_cycle: bool = False,
        fresh: bool = True,
        start: int = 0,
        rank: int | None = None,
        world: int | None = None,
    ) -> None:
        if not isinstance(dataset, Dataset):
            raise TypeError(f"expected a Dataset, found {type(dataset).__name__}")
        if len(dataset) == 0:
            raise ValueError("expected a dataset with items, found none")
        if (rank is None) != (world is None):
            raise ValueError("rank, world: expected both or none")
        self.dataset, self.shuffle, self.by_cycle, self.fresh = dataset, shuffle, by_cycle, fresh
        self.batch = whole("batch", batch, 1, _U64)
        dataset._items.check_at_once(self.batch)
        self.seed = whole("seed", seed, 0, _U64)
        self.people_at_once = whole("people_at_once", people_at_once, 1, _U32)
        self.start = whole("start", start, 0, _U64)
        # Determined here, as a spawned worker has no process group.
        if rank is None or world is None:
            self.reader = _rank()
        else:
            world = whole("world", world, 1, _U32)
            self.reader = whole("rank", rank, 0, world - 1), world

    def __iter__(self) -> Iterator[tuple[Arrays, np.ndarray]]:
        """Yields the batches of this reader."""
        rank, world = self.reader
        worker = _worker()
        number, workers = (0, 1) if worker is None else (worker.id, worker.num_workers)
        at = self.start + rank + world * number
        while True:
            yield self[at]
            at += world * workers

    def __getitem__(self, number: int) -> tuple[Arrays, np.ndarray]:
        """Returns the batch with a number, of any reader."""
        try:
            number = whole("batch number", number, 0, _U64 // self.batch - 1)
        except ValueError as error:
            raise IndexError(f"{error} (a stream has no end before 2^64 items)") from None
        places = self.places(number)
        parts = []
        first = 0
        for last in range(1, len(places) + 1):
            if last == len(places) or places[last][0] != places[first][0]:
                epoch = places[first][0] if self.fresh else 0
                numbers = [item for _, item in places[first:last]]
                parts.append(self.dataset.batch(numbers, epoch=epoch))
                first = last
        if len(parts) == 1:
            return parts[0]
        arrays = [_named(part, self.dataset._arrays) for part, _ in parts]
        joined = {name: np.concatenate([part[name] for part in arrays]) for name in arrays[0]}
        return _only(joined), np.concatenate([labels for _, labels in parts])

    def places(self, number: int) -> list[tuple[int, int]]:
        """Returns the epoch and the item of each place in the batch with a number."""
        first = number * self.batch
        if not self.shuffle:
            return [divmod(at, len(self.dataset)) for at in range(first, first + self.batch)]
        return self.dataset._items.order(
            self.seed, first, self.batch, people_at_once=self.people_at_once, by_cycle=self.by_cycle
        )

    def __repr__(self) -> str:
        rank, world = self.reader
        return f"<Stream: batches of {self.batch} of {self.dataset!r}, reader {rank} of {world}>"

    def __len__(self) -> int:
        raise TypeError("a stream never ends (import torch before dataset.stream() to give it to a DataLoader)")

    def __reduce__(self) -> tuple[Any, ...]:
        how = {name: value for name, value in vars(self).items() if name not in ("dataset", "batch", "reader")}
        how |= dict(zip(("rank", "world"), self.reader, strict=True))
        return _stream, (self.dataset, self.batch, how)


def _stream(dataset: Dataset, batch: int, how: dict[str, Any]) -> Stream:
    """Restores a pickled stream."""
    return dataset.stream(batch, **how)


def _stream_class() -> type[Stream]:
    """Returns Stream, or with PyTorch imported, a subclass that is also an IterableDataset."""
    global _TORCH_STREAM
    torch = sys.modules.get("torch.utils.data")
    if torch is None:
        return Stream
    if _TORCH_STREAM is None:
        _TORCH_STREAM = type("Stream", (Stream, torch.IterableDataset), {"__module__": __name__})
    return _TORCH_STREAM


_TORCH_STREAM: type[Stream] | None = None


@dataclass(frozen=True, repr=False)
class Swept:
    """One gait cycle (or uncut motion) from all viewpoints.

    Attributes:
        arrays: Arrays by name ("geis", "silhouettes", "joints"), with one entry for each viewpoint.
    """

    arrays: dict[str, np.ndarray]
    _dataset: Dataset
    _numbers: range

    @cached_property
    def rows(self) -> dict[str, list[Any]]:
        """The rows of `index.csv`, by column."""
        return self._dataset.rows(self._numbers, epoch=0)

    @property
    def images(self) -> np.ndarray:
        """The first of the arrays, `[viewpoints, ...]`."""
        return next(iter(self.arrays.values()))

    @property
    def subject(self) -> str:
        """The name of the subject."""
        return str(self.rows["subject"][0])

    def __repr__(self) -> str:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in self.arrays.items())
        return f"<Swept: {self.subject}, {self.rows['walk'][0]}: {shapes}>"

    def _repr_png_(self) -> bytes:
        return sheet_of(self.images[:60])


def sweep(
    source: Pack | str | os.PathLike[str] | None = None,
    *,
    threads: int | None = None,
    **drawing: Unpack[Drawing],
) -> Iterator[Swept]:
    """Yields the gait cycles of a pack from all viewpoints, as `edgegait sweep` stores them.

    >>> for cycle in edgegait.sweep(views="paper", raster="rows"):
    ...     cycle.images.shape
    (703, 50, 30)

    Args:
        source: A Pack, or its path. None: the built-in cohort.
        threads: Threads that draw [all cores].
        drawing: Flags of `edgegait sweep`: `views="side"`, `template=["gei", "silhouettes"]`,
            `conditions="each"`, `joints=True`.
    """
    return swept(Dataset(source, threads=threads, **drawing))


def swept(dataset: Dataset) -> Iterator[Swept]:
    """Yields the cycles of a dataset, drawn in groups on all cores: two groups are drawn while one is used."""
    views = dataset.views
    of_one = views * sum(size * (_FRAMES if has_frames else 1) for size, has_frames in dataset._arrays.values())
    cycles = len(dataset) // views
    items = _ITEMS_AT_ONCE * (dataset.threads or os.cpu_count() or 1)
    at_once = max(1, min(items // max(1, views), _BYTES_AT_ONCE // max(1, of_one)))
    groups = [range(first, min(first + at_once, cycles)) for first in range(0, cycles, at_once)]

    def drawn(cycles: range) -> dict[str, Any]:
        arrays, _ = dataset._drawn(list(range(cycles.start * views, cycles.stop * views)), 0)
        return _named(arrays, dataset._arrays)

    with ThreadPoolExecutor(max_workers=2) as threads:
        ahead = deque(threads.submit(drawn, group) for group in groups[:2])
        for number, group in enumerate(groups):
            arrays = ahead.popleft().result()
            ahead.extend(threads.submit(drawn, later) for later in groups[number + 2 : number + 3])
            for cycle in group:
                at = (cycle - group.start) * views
                part = {name: _stacked(name, _part(one, slice(at, at + views))) for name, one in arrays.items()}
                yield Swept(part, dataset, range(cycle * views, (cycle + 1) * views))


def _part(array: np.ndarray | list[np.ndarray], part: slice) -> np.ndarray | list[np.ndarray]:
    """Returns a part of arrays by item: one array if its items have the same number of frames."""
    found = array[part]
    if isinstance(found, list) and len({len(one) for one in found}) == 1:
        return np.stack(found)
    return found
