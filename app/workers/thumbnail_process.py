"""A process that renders small pictures through lenses; its argument is the number of threads."""

import sys
from concurrent.futures import Executor, ThreadPoolExecutor

import numpy as np

import lensbench as lb
from lensbench.app.files.export import develop
from lensbench.app.state.camera_kinds import camera
from lensbench.app.state.constraints import with_longer_side
from lensbench.app.state.lens_choice import with_lens
from lensbench.app.state.picture.exposure import exposed
from lensbench.app.state.scene_file import find_scene
from lensbench.app.state.settings import Settings
from lensbench.app.workers.picture_process import Pixels, answer
from lensbench.app.workers.threads import lower_priority, thread_count

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
