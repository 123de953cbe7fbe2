"""Files that settings and scenes name: their stamps and caches, where they may lie, and textures as linear light.

A scene names files next to it or below; one that the program has written in its own folder names any. The stamp of a
file is a key of caches, which keep the last good content while the file cannot be read.
"""

import math
import os
from collections.abc import Callable, Iterable
from functools import wraps
from io import BytesIO
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import lensbench as lb
from lensbench.core.kernels.byte_cache import buffers, byte_cache, total
from lensbench.core.kernels.numeric import linear
from lensbench.core.text import excerpt
from lensbench.lenses.picture_file import PictureFileError, read_picture_file


def user_folder(variable: str, otherwise: str) -> Path:
    """The user's folder `lensbench` of an XDG variable, or in `otherwise` below the home; it may not exist yet."""
    base = os.environ.get(variable)
    return (Path(base) if base else Path("~").expanduser() / otherwise) / "lensbench"


def own_scenes() -> Path:
    """The resolved folder of the scenes that the program writes around files of the user; it may not exist yet."""
    return (user_folder("XDG_DATA_HOME", ".local/share") / "scenes").resolve()


def asset_path(name: str, folder: Path, what: str, most_bytes: int) -> Path:
    """The path of a file that a scene in `folder` names, called `what`; SceneError if missing, too large, elsewhere."""
    own = folder == own_scenes()
    if Path(name).is_absolute() and not own or "\0" in name:
        raise lb.SceneError(f"{what} {excerpt(name)}: name it relative to the scene file")
    try:
        path = (folder / name).resolve(strict=True)
    except (OSError, RuntimeError) as error:
        raise lb.SceneError(f"{what} {excerpt(name)}: there is no such file") from error
    if not (own or path.is_relative_to(folder)):
        raise lb.SceneError(f"{what} {excerpt(name)} lies outside the folder of the scene: put it next to the file or "
                            "below")
    if not path.is_file():
        raise lb.SceneError(f"{what} {excerpt(name)} is not a file: it is a folder, pipe, device or socket")
    if path.stat().st_size > most_bytes:
        raise lb.SceneError(f"{what} {excerpt(name)} is larger than {most_bytes >> 20} MB")
    return path


MOST_BYTES = 512 << 20                  # of a file
TEXTURE_SIDE = 8192                     # texels: larger pictures are averaged down to this
TEXTURE_TEXELS = 8192 * 4096            # and to as many in all: 400 MB of linear light
MOST_TEXELS = 2 * TEXTURE_TEXELS        # of all textures of a scene and its meshes together: 800 MB
BAND = 64                               # rows that are made linear at once


class Textures:
    """The textures of one scene file: image files in its folder or below, each read once, bounded together."""

    def __init__(self, folder: Path):
        self.folder = folder            # resolved
        self._images: dict[Path, lb.Image] = {}

    def read(self, name: str, decoded: Callable[[Path], lb.Image] = lambda path: image_of(read_picture_file(path))
             ) -> lb.Image:
        """The image, linear and upright, as `image_of`; SceneError where it cannot be read or is too much.

        decoded: the image of a file; PictureFileError.
        """
        path = asset_path(name, self.folder, "texture", MOST_BYTES)
        if path not in self._images:
            try:
                self._images[path] = decoded(path)
            except PictureFileError as error:
                raise lb.SceneError(f"texture {excerpt(name)}: {error}") from error
            self.check()
        return self._images[path]

    def check(self, of_meshes: Iterable[lb.Image] = ()) -> None:
        """SceneError where these images and those of the meshes have too many texels together."""
        if sum(image.width * image.height for image in (*self._images.values(), *of_meshes)) > MOST_TEXELS:
            raise lb.SceneError(f"the textures of the scene have more than {MOST_TEXELS // 1_000_000} million texels "
                                "together: make them smaller")


def image_of(picture: Any, most_texels: int = TEXTURE_TEXELS) -> lb.Image:
    """A picture of Pillow as linear light, averaged down to TEXTURE_SIDE and most_texels; PictureFileError if tiny."""
    from PIL import Image as Picture

    width, height = picture.size
    if min(width, height) < 2:
        raise PictureFileError("it is smaller than 2 × 2 pixels")
    shrink = min(TEXTURE_SIDE / max(width, height), math.sqrt(most_texels / (width * height)), 1.0)
    columns, rows = (max(2, math.floor(length * shrink)) for length in picture.size)
    deep = picture.mode.startswith("I")
    deepest = 65535 if deep else 255
    curve = np.asarray(linear(np.arange(deepest + 1) / deepest), np.float32)
    data = BytesIO()                    # gives its bytes without a copy
    for first in range(0, rows, BAND):
        last = min(first + BAND, rows)
        top, bottom = first * height / rows, last * height / rows
        rows_of_picture = picture.crop((0, math.floor(top), width, math.ceil(bottom)))
        light = curve[np.clip(np.atleast_3d(rows_of_picture if deep else rows_of_picture.convert("RGB")), 0, deepest)]
        if (columns, rows) != picture.size:
            box = (0.0, top - math.floor(top), float(width), bottom - math.floor(top))
            light = np.stack([np.asarray(Picture.fromarray(light[..., c]).resize(
                (columns, last - first), Picture.Resampling.BOX, box)) for c in range(light.shape[2])], -1)
        data.write(np.ascontiguousarray(np.broadcast_to(light, (*light.shape[:2], 3)), np.float32).data)
    return lb.Image(columns, rows, data.getvalue())


MOST_KEPT = 1 << 30     # bytes
Stamp = tuple[int, int]
Content = TypeVar("Content")


def file_stamp(path: str | Path) -> Stamp:
    """Time of the last change (ns) and size (bytes); (0, 0) where there is no such file, as for a library name."""
    if "." not in (name := str(path)) and os.sep not in name:       # asked for many times a frame
        return 0, 0
    try:
        status = Path(path).stat()
    except (OSError, ValueError):               # no name that a file may have
        return 0, 0
    return status.st_mtime_ns, status.st_size


def keeps_last_good(size: int) -> Callable[[Callable[[str, Any], Content]], Callable[[str, Any], Content]]:
    """Decorator of load(name, stamp), which reads the file `name`: it is read once for each stamp.

    size: stamps kept, and names whose last content is, as long as they hold MOST_KEPT bytes at most. If a file that has
    been read cannot be read after a change, such as one that is half written, the content read last is returned. A file
    that has never been read raises what `load` raises.
    """
    def decorate(load: Callable[[str, Any], Content]) -> Callable[[str, Any], Content]:
        good: dict[str, tuple[Content, dict[int, int]]] = {}         # with its buffers
        bad: dict[str, Any] = {}                # stamps that could not be read
        cached = byte_cache(MOST_KEPT, size)(load)

        @wraps(load)
        def loaded(name: str, stamp: Any) -> Content:
            if name in good and bad.get(name) == stamp:
                return good[name][0]
            try:
                content = cached(name, stamp)
            except (ValueError, OSError):
                if name not in good:
                    raise
                bad[name] = stamp
                return good[name][0]
            known = good.pop(name, None)
            if known is not None and known[0] is content:
                good[name] = known              # the newest name is last
                return content
            for last in list(good)[-1:]:        # its content may have grown by cached properties
                good[last] = good[last][0], buffers(good[last][0])
            good[name] = content, buffers(content)
            while len(good) > 1 and (len(good) > size or total(kept for _, kept in good.values()) > MOST_KEPT):
                forgotten = next(iter(good))
                del good[forgotten]
                bad.pop(forgotten, None)
            return content

        return loaded

    return decorate
