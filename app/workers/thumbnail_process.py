"""A second process that renders small pictures through lenses, so that the window never waits for their set-up.

Each line of the input is a name of the library, a tab, and the PNG file to be written; each line of the output is
“ok”, or why there is no picture. The process ends with its input. Its argument is the number of threads.
"""

import os
import sys
from concurrent.futures import Executor, ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import lensbench as lb
from lensbench.app.files.export import develop
from lensbench.app.state.build import camera
from lensbench.app.state.constraints import with_longer_side
from lensbench.app.state.lens_choice import with_lens
from lensbench.app.state.picture.exposure import exposed
from lensbench.app.state.scene_file import find_scene
from lensbench.app.state.settings import Settings
from lensbench.app.workers.threads import lower_priority, thread_count

LONGER_SIDE = 192               # pixels
SAMPLES = 12

Pixels = NDArray[np.uint8]


def thumbnail_settings(name: str) -> Settings:
    """A lens at its best before the still life, in the d line."""
    small = with_longer_side(Settings(lens_model="trace", dispersion="off", samples=SAMPLES), LONGER_SIDE)
    return with_lens(small, name)


def main() -> None:
    """Answer the lines of the input one after the other."""
    threads = int(sys.argv[1]) if len(sys.argv) > 1 else thread_count()
    lower_priority()                            # the rendering threads inherit it
    with ThreadPoolExecutor(threads) as pool:
        for line in sys.stdin:
            name, _, path = line.rstrip("\n").partition("\t")
            try:
                _write(path, thumbnail(name, pool, threads))
                answer = "ok"
            except Exception as error:              # the window shows it in the lens's place
                answer = f"{type(error).__name__}: {error}"
            print(" ".join(answer.split()), flush=True)


def thumbnail(name: str, pool: Executor, threads: int) -> Pixels:
    """Codes (h, w, 3) of the picture through a library lens."""
    settings = thumbnail_settings(name)
    rendering = lb.Rendering(camera(settings), find_scene(settings.scene), light_passes=1)
    rendering.add(settings.samples, pool, threads=threads)
    return np.round(develop(exposed(settings, rendering.image()), settings) * 255.0).astype(np.uint8)


def _write(path: str, codes: Pixels) -> None:
    """Write a PNG beside its place and rename it. Unlike an export, it may be lost with the power."""
    Image.fromarray(codes).save(f"{path}.part", "PNG", compress_level=1)
    os.replace(f"{path}.part", path)


if __name__ == "__main__":
    main()
