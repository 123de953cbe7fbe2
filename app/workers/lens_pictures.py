"""Small pictures of the lenses of the library: made in the background, kept in the user's cache folder.

Thumbnails are pictures through the lenses, others their sections. A file is named by the content of the lens file and
by the versions of what draws it. Other processes make them: in a thread of this one they would hold the GIL, which the
window needs. Each line that such a process reads is a name of the library, a tab, and the PNG file to be written; each
line of its answer is “ok”, or why there is no picture. It ends with its input.

The process of the thumbnails is `python -m lensbench.app.workers.lens_pictures THREADS`.
"""

import hashlib
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from time import time

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.constraints import with_longer_side
from lensbench.app.bench.exposure import exposed
from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.scenes.scene_file import find_scene
from lensbench.app.session.export import develop
from lensbench.app.session.states import user_folder
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.task import Task, lower_priority, thread_count
from lensbench.lenses.library import catalogue
from lensbench.lenses.picture_file import PictureFileError, read_picture_file

THUMBNAIL = "3"                 # the look of a thumbnail: another one draws all of them again
DAYS = 30                       # that an unused file is kept
PROCESSES = min(4, thread_count())      # for thumbnails. Each loads the library: 150 MB
# Of one thread each: set-up holds the GIL for half of the time of a thumbnail
COMMAND = (sys.executable, "-m", "lensbench.app.workers.lens_pictures", str(max(1, thread_count() // PROCESSES)))

Pixels = NDArray[np.uint8]


def pictures_folder() -> Path:
    """The folder of the pictures of lenses; it may not exist yet."""
    return user_folder("XDG_CACHE_HOME", ".cache") / "thumbnails"


@lru_cache(maxsize=4096)
def file_name(lens: str, look: str = THUMBNAIL) -> str:
    """The file of a picture of a library lens: it changes with the lens file, with lensbench and with the look."""
    content = catalogue.path_of(lens).read_bytes()
    digest = hashlib.sha256(b"\0".join((content, version("lensbench").encode(), look.encode())))
    return f"{digest.hexdigest()[:24]}.png"


class LensPictures:
    """Pictures by the name of the lens. Call all methods from the window's thread.

    folder: None keeps them in a temporary folder, which `stop` removes. wake: called from another thread after a file
    is read and after the last picture; those that are rendered between are found in the frames of a window at rest.
    command: starts a process that calls `answer`. look: all that changes its pictures besides the lens. processes: how
    many of them may work at once.
    """

    def __init__(self, folder: Path | None = None, wake: Callable[[], None] = lambda: None,
                 command: Sequence[str] = COMMAND, look: str = THUMBNAIL, processes: int = PROCESSES):
        self.found: dict[str, Pixels] = {}              # (h, w, 3 or 4), as shown
        self.problems: dict[str, str] = {}
        self._wake, self._command, self._look, self._processes_at_once = wake, command, look, processes
        self._temporary = tempfile.TemporaryDirectory(prefix="lensbench-") if folder is None else None
        self._folder = folder or Path(self._temporary.name if self._temporary else "")
        self._change = threading.Condition()
        self._wanted: tuple[str, ...] = ()
        self._taken: set[str] = set()                   # names that a worker reads or renders
        self._looked: set[str] = set()                  # names whose file was not there
        self._may_render = False
        self._first_rendered = self._stopped = False
        self._tasks: list[Task[None]] = []
        self._processes: list[subprocess.Popen[str]] = []

    @property
    def missing(self) -> int:
        """Number of pictures that are wanted and not there yet."""
        return len({*self._wanted}.difference(self.found, self.problems))

    def want(self, names: Sequence[str], may_render: bool) -> None:
        """Make these pictures, the first first. may_render: the processor is free; files are read at any time."""
        with self._change:
            self._wanted, self._may_render = tuple(names), may_render
            waiting = {*self._wanted}.difference(self.found, self.problems, self._taken)
            self._change.notify_all()
        self._tasks = [task for task in self._tasks if not task.done]
        if waiting:
            self._tasks += [Task("Pictures of lenses", self._work, self._wake)
                            for _ in range(len(self._tasks), self._processes_at_once)]

    def stop(self) -> None:
        """End the work and its processes; returns when they have ended."""
        for task in self._tasks:
            task.cancel()
        with self._change:
            self._wanted, self._stopped = (), True
            self._change.notify_all()
            processes = tuple(self._processes)
        for process in processes:
            process.kill()
        for task in self._tasks:
            task.join()
        if self._temporary is not None:
            self._temporary.cleanup()

    def _is_missing(self, name: str) -> bool:
        return name not in self.found and name not in self.problems

    # The workers' side: each has a process of its own

    def _work(self, task: Task[None]) -> None:
        """Read what is kept, then render what is missing, until nothing is."""
        renderer = _Renderer(self._command, self._started)
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            while not task.cancelled:
                with self._change:
                    missing = [name for name in self._wanted if self._is_missing(name)]
                    free = [name for name in missing if name not in self._taken]
                    if not free:
                        break
                    name = next((name for name in free if name not in self._looked), "")
                    renders = not name
                    if renders and not (self._may_render and (self._first_rendered or len(free) == len(missing))):
                        self._change.wait(0.2)
                        continue
                    name = name or free[0]
                    self._taken.add(name)
                try:
                    if renders:
                        self._render(name, renderer)
                    elif self._read(name):
                        self._wake()                    # not for each that is rendered: a frame takes longer than it
                finally:
                    with self._change:
                        self._taken.discard(name)
                        self._looked.add(name)
                        self._first_rendered = self._first_rendered or renders
                        self._change.notify_all()
            if not task.cancelled and not missing:
                self._remove_unused()
        finally:
            renderer.end()

    def _started(self, process: subprocess.Popen[str]) -> None:
        with self._change:
            self._processes = [running for running in self._processes if running.poll() is None] + [process]
            if self._stopped:
                process.kill()

    def _read(self, name: str) -> bool:
        """Take the picture of a lens from its file, if it is there; a damaged file is removed."""
        path = self._folder / file_name(name, self._look)
        try:
            picture = read_picture_file(path)
            self.found[name] = np.asarray(picture.convert("RGBA" if picture.mode == "RGBA" else "RGB"))
            os.utime(path)
            return True
        except (OSError, PictureFileError):             # none, or a damaged one
            with suppress(OSError):
                path.unlink()
            return False

    def _render(self, name: str, renderer: "_Renderer") -> None:
        """Let the process write the file of a lens."""
        answer = renderer.answer(name, self._folder / file_name(name, self._look))
        if answer != "ok" or not self._read(name):
            self.problems[name] = answer if answer not in ("", "ok") else "no picture: its process has ended"
            renderer.end()

    def _remove_unused(self) -> None:
        """Remove files that nothing has read for DAYS."""
        with suppress(OSError):
            for path in self._folder.glob("*.png"):
                if time() - path.stat().st_mtime > DAYS * 86400.0:
                    path.unlink()


class _Renderer:
    """A process that draws pictures, from the first that it is asked for. started: called with it."""

    def __init__(self, command: Sequence[str], started: Callable[[subprocess.Popen[str]], None]):
        self._command, self._started = command, started
        self._process: subprocess.Popen[str] | None = None

    def answer(self, name: str, path: Path) -> str:
        """Draw a lens into a file: “ok”, or why there is none."""
        try:
            if self._process is None:
                self._process = subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                                 stderr=subprocess.DEVNULL, text=True, encoding="utf-8")
                self._started(self._process)
            assert self._process.stdin is not None and self._process.stdout is not None
            self._process.stdin.write(f"{name}\t{path}\n")
            self._process.stdin.flush()
            return self._process.stdout.readline().strip()
        except OSError as error:
            return error.strerror or str(error)

    def end(self) -> None:
        """Let the process end; another question starts another."""
        process, self._process = self._process, None
        if process is None:
            return
        with suppress(OSError):
            if process.stdin is not None:
                process.stdin.close()
        try:
            process.wait(5.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.stdout is not None:
            process.stdout.close()


# The process


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
    """Write a PNG next to its place and rename it. Unlike an export, it may be lost with the power."""
    from PIL import Image

    Image.fromarray(codes).save(f"{path}.part", "PNG", compress_level=1)
    os.replace(f"{path}.part", path)


LONGER_SIDE = 192               # pixels
SAMPLES = 10


def thumbnail_settings(name: str) -> Settings:
    """A lens at its best before a person, in the d line."""
    plain = Settings(scene="portrait", lens_model="trace", dispersion="off", samples=SAMPLES)
    return with_lens(with_longer_side(plain, LONGER_SIDE), name)


def thumbnail(name: str, pool: Executor, threads: int) -> Pixels:
    """Codes (h, w, 3) of the picture through a library lens."""
    settings = thumbnail_settings(name)
    rendering = lb.Rendering(camera(settings), find_scene(settings.scene), light_passes=1)
    rendering.add(settings.samples, pool, threads=threads)
    return np.round(develop(exposed(settings, rendering.image()), settings) * 255.0).astype(np.uint8)


if __name__ == "__main__":
    n_threads = int(sys.argv[1])
    lower_priority()                            # the rendering threads inherit it
    with ThreadPoolExecutor(n_threads) as threads_of_process:
        answer(lambda name: thumbnail(name, threads_of_process, n_threads))
