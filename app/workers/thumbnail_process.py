"""A process that renders small pictures through lenses; its argument is the number of threads.

What a process answers that draws small pictures of lenses, so that the window never waits for them.

Each line of its input is a name of the library, a tab, and the PNG file to be written; each line of its output is “ok”,
or why there is no picture. The process ends with its input.
"""

import os
import sys
from collections.abc import Callable
from concurrent.futures import Executor, ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.constraints import with_longer_side
from lensbench.app.bench.exposure import exposed
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.scenes.scene_file import find_scene
from lensbench.app.session.export import develop
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.task import lower_priority, thread_count

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


LONGER_SIDE = 192               # pixels
SAMPLES = 12


def thumbnail_settings(name: str) -> Settings:
    """A lens at its best before the still life, in the d line."""
    small = with_longer_side(Settings(lens_model="trace", dispersion="off", samples=SAMPLES), LONGER_SIDE)
    return with_lens(small, name)


def main() -> None:
    """Answer as `picture_process` describes."""
    threads = int(sys.argv[1]) if len(sys.argv) > 1 else thread_count()
    lower_priority()                            # the rendering threads inherit it
    with ThreadPoolExecutor(threads) as pool:
        answer(lambda name: thumbnail(name, pool, threads))


def thumbnail(name: str, pool: Executor, threads: int) -> Pixels:
    """Codes (h, w, 3) of the picture through a library lens."""
    settings = thumbnail_settings(name)
    rendering = lb.Rendering(camera(settings), find_scene(settings.scene), light_passes=1)
    rendering.add(settings.samples, pool, threads=threads)
    return np.round(develop(exposed(settings, rendering.image()), settings) * 255.0).astype(np.uint8)


if __name__ == "__main__":
    main()
