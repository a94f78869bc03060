"""Pictures that notebooks show."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import _native
from ._flags import whole

#: Most images of a contact sheet.
_MOST = 400


class Picture:
    """An image, or a contact sheet of several, that a notebook displays.

    Args:
        images: An array or tensor of bytes (0 to 255) or floats (0 to 1): `[rows, columns]`, or several,
            `[n, rows, columns]`, with any number of axes in front.
        columns: Images in a row of the sheet; by default `t` for `[n, t, rows, columns]`.
        scale: Side of an image's pixel in the picture, in pixels.
    """

    def __init__(self, images: Any, *, columns: int | None = None, scale: int = 3) -> None:
        if hasattr(images, "detach"):
            images = images.detach().cpu().numpy()
        try:
            found = np.asarray(images)
        except ValueError:
            raise TypeError(f"expected an array of images, found {type(images).__name__}") from None
        if found.ndim < 2 or 0 in found.shape:
            raise ValueError(f"expected an image [rows, columns] or several, found an array of {found.shape}")
        if found.dtype.kind == "f":
            if np.nanmax(found) > 1:
                raise ValueError(f"expected floats from 0 to 1, found {np.nanmax(found)} (divide by 255?)")
            found = np.clip(np.nan_to_num(found) * 255, 0, 255).round()
        elif found.dtype.kind not in "ub":
            raise TypeError(f"expected bytes from 0 to 255 or floats from 0 to 1, found {found.dtype}")
        elif found.dtype == bool:
            found = found * np.uint8(255)
        scale = whole("scale", scale, 1, 64)
        if columns is not None:
            columns = whole("columns", columns, 1, _MOST)
        if columns is None and found.ndim >= 4:
            columns = found.shape[-3]
        found = found.astype(np.uint8).reshape(-1, *found.shape[-2:])
        if len(found) > _MOST:
            raise ValueError(f"expected at most {_MOST} images, found {len(found)}")
        self._sheet = _sheet(found, columns, scale)

    def __repr__(self) -> str:
        rows, columns = self._sheet.shape
        return f"<Picture: {columns} x {rows} pixels>"

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the picture to a PNG file."""
        Path(path).write_bytes(self._repr_png_())

    def _repr_png_(self) -> bytes:
        return _native.png(self._sheet)


def by_item(array: np.ndarray, frames: Sequence[int]) -> np.ndarray | list[np.ndarray]:
    """Splits frames by item: one array if all items have the same number, else a list."""
    if not frames:
        return array[:, None]
    if len(set(frames)) == 1:
        return array.reshape(len(frames), frames[0], *array.shape[1:])
    return np.split(array, np.cumsum(frames)[:-1])


def sheet_of(images: np.ndarray | list[np.ndarray]) -> bytes:
    """Returns a PNG of images, or of sequences, with a row of the first frames each."""
    if isinstance(images, np.ndarray) and images.ndim == 3:
        return Picture(images)._repr_png_()
    frames = min(16, *(len(one) for one in images), 16)
    return Picture(np.stack([one[:frames] for one in images[:24]]))._repr_png_()


def sheet_of_items(items: _native.Items, threads: int = 0) -> bytes:
    """Returns a PNG of up to 40 items, evenly chosen; `threads` draw them, 0 for all cores."""
    step = max(1, len(items) // 40)
    drawn, frames = items.draw(list(range(0, min(len(items), 40 * step), step)), 0, threads)
    name, _, has_frames = items.arrays[0]
    return sheet_of(by_item(drawn[name], frames) if has_frames else drawn[name])


def _sheet(images: np.ndarray, columns: int | None, scale: int) -> np.ndarray:
    """Arranges images side by side, with grey lines between them."""
    count, height, width = images.shape
    columns = columns or min(count, max(1, 960 // (width * scale)))
    rows = -(-count // columns)
    sheet = np.full((rows * (height + 1) + 1, columns * (width + 1) + 1), 96, np.uint8)
    for at, image in enumerate(images):
        top, left = at // columns * (height + 1) + 1, at % columns * (width + 1) + 1
        sheet[top : top + height, left : left + width] = image
    if count == 1:
        sheet = images[0]
    return np.ascontiguousarray(sheet.repeat(scale, 0).repeat(scale, 1))
