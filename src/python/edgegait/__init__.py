"""Human gait silhouettes from compressed motion, for training and testing gait recognizers.

>>> import edgegait
>>> dataset = edgegait.Dataset(edgegait.Design("casia-b-like"), split="train", people=10)
>>> image, label = dataset[0]
>>> image.shape
(64, 44)

Images are NumPy arrays of bytes, 0 to 255, with row 0 at the top. Keyword arguments are the flags of the
command `edgegait`, with underscores instead of dashes; messages name them as flags.
"""

from . import _native
from ._command import Results, command, generate, merge
from ._dataset import Dataset, Stream, Swept, sweep
from ._design import Design
from ._native import Error
from ._pack import Pack, cohort, import_walks
from ._picture import Picture
from ._score import Recognizer, score

__version__ = _native.__version__

__all__ = [
    "Dataset",
    "Design",
    "Error",
    "Pack",
    "Picture",
    "Recognizer",
    "Results",
    "Stream",
    "Swept",
    "cohort",
    "command",
    "generate",
    "import_walks",
    "merge",
    "score",
    "sweep",
]
