"""The shipped networks: what each takes, and what it makes of it.

Each takes pictures of 50 rows and 30 columns from 0 (background) to 1 (figure), and gives an embedding, `[n,
numbers]`. Embeddings are compared by the angle between them.
"""

import torch
from torch import nn

ROWS, COLUMNS = 50, 30


def block(channels_in, channels, side=3, stride=1, padding=None):
    """A convolution without bias, batch normalisation, and what is above 0."""
    padding = side // 2 if padding is None else padding
    return nn.Sequential(
        nn.Conv2d(channels_in, channels, side, stride, padding, bias=False),
        nn.BatchNorm2d(channels),
        nn.ReLU(),
    )


class GeiSmall(nn.Module):
    """Four plain 3x3 convolutions over a GEI, and one linear map: at most 50 thousand parameters.

    `[n, 1, 50, 30]` to `[n, 64]`. Each of six strips of rows keeps its greatest and its mean value
    a channel (horizontal pooling: Fu et al., AAAI 2019).
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

    `[n, 1, 50, 30]` to `[n, 256]`: 18 convolutions of 7x7, the greatest of 2x2, 45 convolutions of 5x5,
    the greatest of 3x3 at every second, and a fully connected layer of 256 in place of 1,024, normalised over a batch.
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

    `[n, t, 50, 30]` to `[n, 128]`. Three convolutions on each silhouette, the first of 5x5 at every second pixel;
    greatest plus mean value over the set after the second and the third; a fourth convolution on the former, the
    global path; of both paths one, two and three strips of rows; one linear map of all, normalised over a batch.
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
    """What a set of maps `[n, t, ...]` has in common: the greatest value and the mean, added."""
    return maps.amax(1) + maps.mean(1)


NETWORKS = {"gei-small": GeiSmall, "geinet": GeiNet, "gaitset-small": GaitSetSmall}
