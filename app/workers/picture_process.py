"""What a process answers that draws small pictures of lenses, so that the window never waits for them.

Each line of its input is a name of the library, a tab, and the PNG file to be written; each line of its output is “ok”,
or why there is no picture. The process ends with its input.
"""

import os
import sys
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Pixels = NDArray[np.uint8]


def answer(picture: Callable[[str], Pixels]) -> None:
    """Answer the lines of the input one after the other. picture: of a lens by its name, (h, w, 3 or 4)."""
    for line in sys.stdin:
        name, _, path = line.rstrip("\n").partition("\t")
        try:
            _write(path, picture(name))
            outcome = "ok"
        except Exception as error:              # the window shows it in the lens's place
            outcome = f"{type(error).__name__}: {error}"
        print(" ".join(outcome.split()), flush=True)


def _write(path: str, codes: Pixels) -> None:
    """Write a PNG beside its place and rename it. Unlike an export, it may be lost with the power."""
    Image.fromarray(codes).save(f"{path}.part", "PNG", compress_level=1)
    os.replace(f"{path}.part", path)
