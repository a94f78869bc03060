"""The architectures of the shipped networks.

Each takes images of 50 rows and 30 columns, from 0 (background) to 1 (figure), and returns embeddings `[n, numbers]`,
which are compared by the angle between them.
"""

import torch
from torch import nn

ROWS, COLUMNS = 50, 30


def block(channels_in, channels, side=3, stride=1, padding=None):
    """Returns a convolution without bias, batch normalisation and ReLU."""
    padding = side // 2 if padding is None else padding
    return nn.Sequential(
        nn.Conv2d(channels_in, channels, side, stride, padding, bias=False),
        nn.BatchNorm2d(channels),
        nn.ReLU(),
    )


class GeiSmall(nn.Module):
    """Four 3x3 convolutions over a GEI and a linear map, with at most 50 thousand parameters.

    `[n, 1, 50, 30]` to `[n, 64]`. Each of six horizontal strips is pooled to the sum of its maximum and its mean
    for each channel (horizontal pooling: Fu et al., AAAI 2019).
    """

    takes = "gei"
    numbers = 64

    def __init__(self):
        super().__init__()
        self.features = nn.Sequential(
            block(1, 16),
            nn.MaxPool2d(2),
            block(16, 32),
            nn.MaxPool2d(2),
            block(32, 32),
            block(32, 48),
            nn.MaxPool2d(2),
        )
        self.embed = nn.Linear(48 * 6, self.numbers)

    def forward(self, geis):
        maps = self.features(geis)
        return self.embed((maps.amax(3) + maps.mean(3)).flatten(1))


class GeiNet(nn.Module):
    """GEINet (Shiraga et al., ICB 2016) at 50x30, with batch normalisation in place of local response normalisation.

    `[n, 1, 50, 30]` to `[n, 256]`: 18 convolutions of 7x7, max pooling of 2x2, 45 convolutions of 5x5, max pooling of
    3x3 with stride 2, and a fully connected layer of 256 units in place of 1,024, with batch normalisation.
    """

    takes = "gei"
    numbers = 256

    def __init__(self):
        super().__init__()
        self.features = nn.Sequential(
            block(1, 18, 7, padding=0),
            nn.MaxPool2d(2),
            block(18, 45, 5, padding=0),
            nn.MaxPool2d(3, 2),
        )
        self.embed = nn.Linear(45 * 8 * 3, self.numbers)
        self.neck = nn.BatchNorm1d(self.numbers)

    def forward(self, geis):
        return self.neck(self.embed(self.features(geis).flatten(1)))


class GaitSetSmall(nn.Module):
    """A small GaitSet (Chao et al., AAAI 2019): a set of any number of silhouettes, in any order.

    `[n, t, 50, 30]` to `[n, 128]`. Three convolutions act on each silhouette, the first of 5x5 with stride 2. Maximum
    plus mean over the set follow the second and the third. A fourth convolution on the former is the global path.
    Both paths are pooled in one, two and three horizontal strips. A linear map with batch normalisation follows.
    """

    takes = "silhouettes"
    numbers = 128
    strips = (1, 2, 3)

    def __init__(self):
        super().__init__()
        self.early = nn.Sequential(block(1, 16, 5, stride=2), block(16, 32), nn.MaxPool2d(2))
        self.late = block(32, 64)
        self.over_all = block(32, 64)
        self.embed = nn.Linear(64 * 2 * sum(self.strips), self.numbers)
        self.neck = nn.BatchNorm1d(self.numbers)

    def forward(self, silhouettes):
        n, t = silhouettes.shape[0], silhouettes.shape[1]
        early = self.early(silhouettes.reshape(-1, 1, ROWS, COLUMNS))
        late = self.late(early)
        set_early = over_set(early.reshape(n, t, 32, 12, 7))
        set_late = over_set(late.reshape(n, t, 64, 12, 7))
        pooled = []
        for maps in (set_late, self.over_all(set_early) + set_late):
            for count in self.strips:
                strips = maps.reshape(n, 64, count, 12 // count * 7)
                pooled.append(strips.amax(3) + strips.mean(3))
        return self.neck(self.embed(torch.cat(pooled, 2).flatten(1)))


def over_set(maps):
    """Pools a set of maps `[n, t, ...]`: maximum plus mean."""
    return maps.amax(1) + maps.mean(1)


NETWORKS = {"gei-small": GeiSmall, "geinet": GeiNet, "gaitset-small": GaitSetSmall}
