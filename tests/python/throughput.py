"""Measures silhouettes and GEIs a second into NumPy and PyTorch, compared with the Rust sweep of the same settings.

    python throughput.py [--rounds N] [--require SHARE]

Each round measures all consumers once, so that ratios are within one round; the table has medians. With --require,
the run fails if the NumPy consumer, or a batched loader without workers, reaches less than that share of the
sweep's GEIs a second.
"""

import argparse
import statistics
import time

import edgegait

BATCH = 512
#: The settings of `edgegait sweep --raster rows`: 26 people at 5 km/h from 703 viewpoints.
GEIS = {"views": "paper", "raster": "rows"}
#: Twenty variations from ten azimuths, with all frames.
SILHOUETTES = {"azimuth_deg": range(0, 180, 18), "raster": "rows", "template": "silhouettes", "cycles": 20}


def sweep_in_rust(drawing):
    """Returns the items a second of the command, which only hashes them."""
    results = edgegait.command("sweep", digest=True, **drawing)
    return results["geis"] / results["seconds"]


def numpy_consumer(drawing):
    """Returns the items a second of a loop that sums the arrays with NumPy."""
    started, count, total = time.perf_counter(), 0, 0
    for cycle in edgegait.sweep(**drawing):
        count += len(cycle.images)
        total += int(cycle.images.sum())
    assert total > 0
    return count / (time.perf_counter() - started)


def loader(drawing, workers, is_batched=True):
    """Returns the items a second of a DataLoader over all items in order."""
    import torch
    from torch.utils.data import DataLoader

    dataset = edgegait.Dataset(**drawing)
    if not is_batched:
        dataset = OneByOne(dataset)
    started, count = time.perf_counter(), 0
    for images, labels in DataLoader(dataset, batch_size=BATCH, num_workers=workers):
        count += len(labels)
        assert images.dtype == torch.uint8
        if not is_batched and count >= 8 * BATCH:
            break
    return count / (time.perf_counter() - started)


class OneByOne:
    """A dataset without batched access."""

    def __init__(self, dataset):
        self.dataset = dataset

    def __len__(self):
        return len(self.dataset)

    def __getitem__(self, index):
        return self.dataset[index]


def main():
    """Prints the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--require", type=float)
    args = parser.parse_args()
    ways = {"Rust sweep": sweep_in_rust, "NumPy consumer": numpy_consumer}
    required = ["NumPy consumer"]
    try:
        import torch  # noqa: F401
    except ImportError:
        print("PyTorch is not installed: no loaders")
    else:
        ways |= {
            "DataLoader, 0 workers": lambda drawing: loader(drawing, 0),
            "DataLoader, 1 worker": lambda drawing: loader(drawing, 1),
            "DataLoader, 2 workers": lambda drawing: loader(drawing, 2),
            "DataLoader, 0 workers, item by item": lambda drawing: loader(drawing, 0, is_batched=False),
        }
        required.append("DataLoader, 0 workers")
    missed = []
    for what, drawing, frames in [("GEIs", GEIS, 1), ("silhouettes", SILHOUETTES, 32)]:
        rates = {name: [] for name in ways}
        for _ in range(args.rounds):
            for name, way in ways.items():
                rates[name].append(way(drawing) * frames)
        print(f"| {what} a second | median | of the sweep | least to most |\n|---|--:|--:|--:|")
        for name, found in rates.items():
            shares = [mine / rust for mine, rust in zip(found, rates["Rust sweep"], strict=True)]
            share = statistics.median(shares)
            print(
                f"| {name} | {statistics.median(found):,.0f} | {share:.0%} | {min(shares):.0%} to {max(shares):.0%} |"
            )
            if what == "GEIs" and name in required and args.require and share < args.require:
                missed.append(f"{name}: {share:.0%}")
    if missed:
        raise SystemExit(f"error: expected at least {args.require:.0%} of the sweep, found {', '.join(missed)}")


if __name__ == "__main__":
    main()
