"""Scores recognizers: ONNX models and Python callables."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from . import _native
from ._command import Results, run
from ._pack import Pack


class Recognizer:
    """A callable for `score`, with its contract.

    Its argument is a NumPy array of float32, `[n, 1, rows, columns]` from 0 to 1 unless the contract states
    otherwise. It returns embeddings `[n, numbers]` or `[n, numbers, parts]`, or a pair of embeddings
    and class scores `[n, classes]`, as arrays or tensors. A PyTorch module gets a tensor on the device
    of its parameters, in evaluation mode and without gradients.

    Args:
        function: The callable; the thread that calls `score` calls it.
        name: The name in results; by default the callable's own name.
        contract: The keys of a model's `.toml` file: `template="silhouettes"`, `size="64x44"`,
            `frames=30`, `layout` ["NTHW" for silhouettes], `framing`, `input_range`, `mean`, `std`, `channels`,
            `distance="cosine"`, `classes`, `training`. With `view_input="view"` the function gets a second
            array, `[n, 2]`: the azimuth and elevation of each input, in degrees.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        *,
        name: str | None = None,
        size: str | tuple[int, int] | None = None,
        **contract: Any,
    ) -> None:
        if not callable(function):
            raise TypeError(f"expected a callable, found {type(function).__name__}")
        if size is not None:
            try:
                rows, columns = map(int, size.split("x") if isinstance(size, str) else size)
            except (TypeError, ValueError):
                raise ValueError(f'size: expected rows and columns as "64x44", found {size!r}') from None
            contract |= {"rows": rows, "columns": columns}
        self.function = function
        self.name = name or getattr(function, "__name__", None) or type(function).__name__
        if contract.get("template") == "silhouettes":
            contract.setdefault("layout", "NTHW")
        self.contract = {"name": self.name, **contract}
        _native.check_contract(json.dumps(self.contract, default=_plain))

    def __call__(self, *inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """Returns the embeddings of images (and their viewpoints), and their scores, if any."""
        answer = _called(self.function, inputs)
        if answer is None:
            raise TypeError(f"{self.name}: expected embeddings, found None (does it return them?)")
        if isinstance(answer, (tuple, list)) and len(answer) == 2:
            embedding, scores = answer
        else:
            embedding, scores = answer, None
        return _floats(embedding), None if scores is None else _floats(scores)


def _called(function: Callable[..., Any], inputs: tuple[np.ndarray, ...]) -> Any:
    """Calls a function, or a module in evaluation mode."""
    if not (hasattr(function, "parameters") and hasattr(function, "eval") and hasattr(function, "modules")):
        return function(*inputs)
    import torch  # type: ignore[import-not-found, unused-ignore]

    module: Any = function
    first = next(iter(module.parameters()), None)
    modes = [(one, one.training) for one in module.modules()]
    module.eval()
    try:
        with torch.inference_mode():
            tensors = [torch.from_numpy(one) for one in inputs]
            return module(*(one if first is None else one.to(first.device) for one in tensors))
    finally:
        for one, was_training in modes:
            one.training = was_training


def _floats(numbers: Any) -> np.ndarray:
    """Converts an array or a tensor to an array of float32."""
    if hasattr(numbers, "detach"):
        numbers = numbers.detach().cpu().float().numpy()
    return np.ascontiguousarray(numbers, dtype=np.float32)


def score(
    models: Any = None,
    data: Pack | str | os.PathLike[str] | None = None,
    **flags: Any,
) -> Results:
    """Scores recognizers on people seen from many viewpoints, as `edgegait score` does.

    Results list models before callables, and baselines in their order among them. Callables get sequences
    of silhouettes one at a time, and images in batches.

    Args:
        models: An ONNX file, the name of a shipped model, "pixels", a Recognizer or any callable, or a
            list of these. None: the shipped linear models.
        data: A Pack, or the path of a pack, a dataset or a tree of silhouettes. None: the built-in
            cohort of 26 people.
        flags: Flags of `edgegait score`, by default with 703 viewpoints: `views="side"`,
            `protocol="casia-b"`, `conditions="each"`, `raster="rows"`, `no_baselines=True`,
            `runtime="ort"`; `out="report"` also writes the report.
    """
    listed = models if isinstance(models, (list, tuple)) else [models]
    names: list[str | os.PathLike[str]] = []
    callables: list[tuple[Any, str]] = []
    for model in listed:
        if model is None:
            continue
        if isinstance(model, (str, os.PathLike)):
            names.append(model)
        elif isinstance(model, Recognizer) or callable(model):
            recognizer = model if isinstance(model, Recognizer) else Recognizer(model)
            callables.append((recognizer, json.dumps(recognizer.contract, default=_plain)))
        else:
            raise TypeError(f"expected a model's path, a Recognizer or a callable, found {type(model).__name__}")
    called = [recognizer.name for recognizer, _ in callables]
    if twice := next((name for at, name in enumerate(called) if name in called[:at]), None):
        raise ValueError(f"two recognizers are called {twice!r}: give one another name (Recognizer(..., name=))")
    pack = None
    if isinstance(data, Pack):
        pack = data._native
    elif data is not None and not isinstance(data, (str, os.PathLike)):
        raise TypeError(
            f"expected a Pack or a path, found {type(data).__name__} "
            "(of a design, generate(..., format='opengait') makes a tree to score)"
        )
    elif data is not None:
        names.append(data)
    with tempfile.TemporaryDirectory() as folder:
        flags.setdefault("out", os.path.join(folder, "report"))
        return run("score", tuple(names), flags, callables, pack)


def _plain(value: Any) -> Any:
    """Converts numbers and lists of NumPy to Python's."""
    if isinstance(value, np.ndarray) or hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Iterable):
        return list(value)
    raise TypeError(f"expected numbers, strings and lists in a contract, found {type(value).__name__}")
