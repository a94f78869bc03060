"""Images for notebooks."""

import io
from pathlib import Path

import numpy as np
import pytest

import edgegait


def decoded(picture):
    image = pytest.importorskip("PIL.Image")
    return np.asarray(image.open(io.BytesIO(picture._repr_png_())))


def test_an_image_is_shown_as_it_is():
    image = np.arange(12, dtype=np.uint8).reshape(3, 4)
    assert np.array_equal(decoded(edgegait.Picture(image, scale=1)), image)
    assert np.array_equal(decoded(edgegait.Picture(image / 255, scale=1)), image)
    large = decoded(edgegait.Picture(image, scale=2))
    assert large.shape == (6, 8)
    assert (large[:2, :2] == image[0, 0]).all()


def test_several_are_a_sheet():
    images = np.stack([np.full((3, 4), value, np.uint8) for value in (10, 20, 30)])
    sheet = decoded(edgegait.Picture(images, columns=2, scale=1))
    # Two rows of two, with a line around each.
    assert sheet.shape == (2 * 4 + 1, 2 * 5 + 1)
    assert sheet[1, 1] == 10
    assert sheet[1, 6] == 20
    assert sheet[5, 1] == 30
    assert sheet[5, 6] == sheet[0, 0] == 96
    assert decoded(edgegait.Picture(images[None], scale=1)).shape == (5, 16)
    assert decoded(edgegait.Picture(images == 20, scale=1))[1, 6] == 255


def test_whatever_is_long_is_shown_in_part():
    take = Path(__file__).parents[2] / "data" / "golden" / "v1-take.egp"
    # Whole takes, hundreds of images, and sequences of different lengths.
    for source, drawing in [
        (take, {"template": "silhouettes", "views": "side"}),
        (None, {"template": "silhouettes", "views": "side"}),
        (None, {"template": "silhouettes", "views": "side", "fps": 25}),
        (None, {"template": ["gei", "silhouettes"], "azimuth_deg": range(0, 360, 4), "elevation_deg": 0}),
    ]:
        dataset = edgegait.Dataset(source, raster="rows", **drawing)
        assert dataset._repr_png_().startswith(b"\x89PNG")
        assert next(edgegait.sweep(source, raster="rows", **drawing))._repr_png_().startswith(b"\x89PNG")
    assert edgegait.Pack(take)._repr_png_().startswith(b"\x89PNG")


def test_datasets_show_some_of_their_items(tmp_path):
    dataset = edgegait.Dataset(views="side", raster="rows")
    assert dataset._repr_png_().startswith(b"\x89PNG")
    path = tmp_path / "sheet.png"
    edgegait.Picture(dataset.batch(range(8))[0]).save(path)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_misuse_raises():
    for wrong, error in [
        (np.zeros(3, np.uint8), ValueError),
        (np.zeros((2, 0), np.uint8), ValueError),
        (np.zeros((2, 2), int), TypeError),
    ]:
        with pytest.raises(error):
            edgegait.Picture(wrong)
    with pytest.raises(ValueError, match="scale"):
        edgegait.Picture(np.zeros((2, 2), np.uint8), scale=0)
    with pytest.raises(ValueError, match="at most 400"):
        edgegait.Picture(np.zeros((401, 2, 2), np.uint8))


def test_what_is_no_picture_is_refused():
    image = np.zeros((3, 4), np.float32)
    for wrong, kind, text in [
        (lambda: edgegait.Picture(image + 200), ValueError, "divide by 255"),
        (lambda: edgegait.Picture(image, scale=2.5), TypeError, "scale"),
        (lambda: edgegait.Picture(image, columns=0), ValueError, "columns: expected 1 to"),
        (lambda: edgegait.Picture([image, image[1:]]), TypeError, "expected an array of images, found list"),
    ]:
        with pytest.raises(kind, match=text):
            wrong()
    assert repr(edgegait.Picture(image)) == "<Picture: 12 x 9 pixels>"
