"""Small pictures through the lenses of the library: made in the background, kept in the user's cache folder.

A file is named by the content of the lens file and by the versions of what draws it, written beside its place and
renamed. A second process renders while the picture of the window leaves the processor.
"""

import hashlib
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from time import time

import numpy as np
from numpy.typing import NDArray

from lensbench.app.workers.task import Task
from lensbench.lenses import catalogue

VERSION = 2                     # of the look of a thumbnail: another one draws all of them again
DAYS = 30                       # that an unused file is kept
COMMAND = (sys.executable, "-m", "lensbench.app.workers.thumbnail_process")

Pixels = NDArray[np.uint8]


def thumbnail_folder() -> Path:
    """The user's thumbnails: lensbench/thumbnails in $XDG_CACHE_HOME or ~/.cache; it may not exist yet."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lensbench" / "thumbnails"


@lru_cache(maxsize=1024)
def file_name(lens: str) -> str:
    """The file of a library lens: it changes with the lens file, with lensbench and with VERSION."""
    content = catalogue.path_of(lens).read_bytes()
    digest = hashlib.sha256(b"\0".join((content, version("lensbench").encode(), str(VERSION).encode())))
    return f"{digest.hexdigest()[:24]}.png"


class LensThumbnails:
    """Thumbnails by the name of the lens. Call all methods from the window's thread.

    folder: None keeps them in a temporary folder, which `stop` removes.
    """

    def __init__(self, folder: Path | None = None, wake: Callable[[], None] = lambda: None,
                 command: Sequence[str] = COMMAND):
        self.found: dict[str, Pixels] = {}              # (h, w, 3), as shown
        self.problems: dict[str, str] = {}
        self._wake, self._command = wake, command
        self._temporary = tempfile.TemporaryDirectory(prefix="lensbench-") if folder is None else None
        self._folder = folder or Path(self._temporary.name if self._temporary else "")
        self._change = threading.Condition()
        self._wanted: tuple[str, ...] = ()
        self._may_render = False
        self._task: Task[None] | None = None
        self._process: subprocess.Popen[str] | None = None

    @property
    def missing(self) -> int:
        """Number of thumbnails that are wanted and not there yet."""
        return sum(name not in self.found and name not in self.problems for name in self._wanted)

    def want(self, names: Sequence[str], may_render: bool) -> None:
        """Make these thumbnails, the first first. may_render: the processor is free; files are read at any time."""
        with self._change:
            self._wanted, self._may_render = tuple(names), may_render
            self._change.notify_all()
        if self.missing and (self._task is None or self._task.done):
            self._task = Task("Thumbnails", self._work, self._wake)

    def stop(self) -> None:
        """End the work and its process; returns when they have ended."""
        if self._task is not None:
            self._task.cancel()
        with self._change:
            self._wanted = ()
            self._change.notify_all()
        process = self._process
        if process is not None:
            process.kill()
        if self._task is not None:
            self._task.join()
        if self._temporary is not None:
            self._temporary.cleanup()

    # The worker's side

    def _work(self, task: Task[None]) -> None:
        """Read what is kept, then render what is missing, until nothing is."""
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            looked: set[str] = set()                    # names whose file was not there
            while not task.cancelled:
                with self._change:
                    missing = [name for name in self._wanted if name not in self.found and name not in self.problems]
                    may_render = self._may_render
                if not missing:
                    break
                first = next((name for name in missing if name not in looked), None)
                if first is not None:
                    if self._read(first):
                        self._wake()
                    looked.add(first)
                    continue
                if may_render:
                    self._render(missing[0])
                    self._wake()
                    continue
                with self._change:
                    self._change.wait(0.2)
            if not task.cancelled:
                self._remove_unused()
        finally:
            self._end_process()

    def _read(self, name: str) -> bool:
        """Take the picture of a lens from its file, if it is there; a damaged file is removed."""
        from PIL import Image

        try:
            path = self._folder / file_name(name)
            with Image.open(path) as file:
                self.found[name] = np.asarray(file.convert("RGB"))
            os.utime(path)
            return True
        except FileNotFoundError:
            return False
        except (OSError, ValueError, SyntaxError):      # of a damaged PNG
            with suppress(OSError):
                path.unlink()
            return False

    def _render(self, name: str) -> None:
        """Let the process write the file of a lens."""
        path = self._folder / file_name(name)
        try:
            if self._process is None:
                self._process = subprocess.Popen(self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                                 stderr=subprocess.DEVNULL, text=True, encoding="utf-8")
            assert self._process.stdin is not None and self._process.stdout is not None
            self._process.stdin.write(f"{name}\t{path}\n")
            self._process.stdin.flush()
            answer = self._process.stdout.readline().strip()
        except OSError as error:
            answer = error.strerror or str(error)
        if answer != "ok" or not self._read(name):
            self.problems[name] = answer if answer not in ("", "ok") else "no picture: its process has ended"
            self._end_process()

    def _end_process(self) -> None:
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

    def _remove_unused(self) -> None:
        """Remove files that nothing has read for DAYS."""
        with suppress(OSError):
            for path in self._folder.glob("*.png"):
                if time() - path.stat().st_mtime > DAYS * 86400.0:
                    path.unlink()
