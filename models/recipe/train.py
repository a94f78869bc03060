"""Trains one network on a dataset of silhouettes and writes its weights.

    python train.py DATASET --network gei-small --out gei-small.pt

It uses one thread, so that the same machine, packages and seed give the same weights, and several networks can be
trained in parallel.
"""

import argparse
import math
import time

import torch
from torch.nn import functional as F

from data import People
from networks import NETWORKS

# People in a batch, sequences of each, passes over the data, largest learning rate, frames in a set.
RECIPE = {
    "gei-small": {"people": 32, "each": 4, "passes": 40, "rate": 2e-3},
    "geinet": {"people": 32, "each": 4, "passes": 45, "rate": 2e-3},
    "gaitset-small": {"people": 16, "each": 4, "passes": 20, "rate": 2e-3, "frames": 8},
}
# Cosines are multiplied by this before the softmax.
SCALE = 16.0
WEIGHT_DECAY = 5e-4


def moved(pictures, random):
    """Returns randomly varied images, `[n, channels, rows, columns]`.

    Half of them are mirrored. The standard deviations are 2 degrees (rotation), 3 % (scale) and about half a pixel (shift).
    """
    n, _, rows, columns = pictures.shape
    is_mirrored = torch.rand(n, generator=random) < 0.5
    pictures = torch.where(is_mirrored[:, None, None, None], pictures.flip(3), pictures)
    angle = torch.randn(n, generator=random) * math.radians(2)
    scale = 1 + 0.03 * torch.randn(n, 2, generator=random)
    shift = torch.randn(n, 2, generator=random) * torch.tensor([0.04, 0.02])
    maps = torch.zeros(n, 2, 3)
    maps[:, 0, 0], maps[:, 1, 1] = scale[:, 0], scale[:, 1]
    maps[:, 0, 1], maps[:, 1, 0] = angle * rows / columns, -angle * columns / rows
    maps[:, :, 2] = shift
    grid = F.affine_grid(maps, list(pictures.shape), align_corners=False)
    return F.grid_sample(pictures, grid, align_corners=False)


class Batches:
    """Samples people, sequences of each, and frames of these."""

    def __init__(self, people, network, recipe, seed):
        self.people, self.recipe = people, recipe
        self.random = torch.Generator().manual_seed(seed)
        self.takes_geis = network.takes == "gei"
        self.size = recipe["people"] * recipe["each"]
        self.count = max(1, len(people) // self.size * recipe["passes"])

    def draw(self):
        """Returns images and the numbers of their people."""
        chosen = torch.randperm(len(self.people.names), generator=self.random)[: self.recipe["people"]]
        sequences = []
        for person in chosen.tolist():
            own = self.people.sequences_of[person]
            sequences.append(own[torch.randint(len(own), (self.recipe["each"],), generator=self.random)])
        sequences = torch.cat(sequences)
        if self.takes_geis:
            pictures = self.people.geis[sequences].float() / 255
        else:
            order = torch.rand(len(sequences), self.people.frames, generator=self.random).argsort(1)
            pictures = self.people.silhouettes(sequences, order[:, : self.recipe["frames"]])
        return moved(pictures, self.random), self.people.who[sequences]


def train(people, name, seed, passes=None, say=print):
    """Returns a network trained to distinguish `people`: cross-entropy of the cosines to one vector for each person."""
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    torch.manual_seed(seed)
    recipe = dict(RECIPE[name])
    recipe["passes"] = passes or recipe["passes"]
    recipe["people"] = min(recipe["people"], len(people.names))
    network = NETWORKS[name]().to(memory_format=torch.channels_last)
    vectors = torch.nn.Parameter(torch.randn(network.numbers, len(people.names)) / 16)
    batches = Batches(people, network, recipe, seed)
    learnt = [*network.parameters(), vectors]
    optimizer = torch.optim.AdamW(learnt, lr=recipe["rate"], weight_decay=WEIGHT_DECAY)
    schedule = torch.optim.lr_scheduler.OneCycleLR(
        optimizer, recipe["rate"], total_steps=batches.count, pct_start=0.1
    )
    network.train()
    started, told, loss_sum, summed = time.monotonic(), 0.0, 0.0, 0
    for step in range(1, batches.count + 1):
        pictures, who = batches.draw()
        embedding = network(pictures)
        cosines = F.normalize(embedding, dim=1) @ F.normalize(vectors, dim=0)
        loss = F.cross_entropy(SCALE * cosines, who)
        if not torch.isfinite(loss):
            raise SystemExit(f"{name}: step {step}: the loss is {loss.item()} (lower the learning rate)")
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
        loss_sum, summed = loss_sum + loss.item(), summed + 1
        seconds = time.monotonic() - started
        if seconds - told > 30 or step == batches.count:
            left = seconds / step * (batches.count - step)
            say(f"{name}: step {step} of {batches.count}, loss {loss_sum / summed:.3f}, {left:.0f} s left", flush=True)
            told, loss_sum, summed = seconds, 0.0, 0
    return network.eval()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset", help="a folder that `edgegait generate people.toml` wrote")
    parser.add_argument("--network", required=True, choices=NETWORKS)
    parser.add_argument("--out", required=True, help="file of weights")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--passes", type=int, help="passes over the data, instead of the recipe's")
    arguments = parser.parse_args()
    people = People(arguments.dataset)
    network = train(people, arguments.network, arguments.seed, arguments.passes)
    torch.save(network.state_dict(), arguments.out)


if __name__ == "__main__":
    main()
