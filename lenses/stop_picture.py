"""Picture files for the stop: the part of the light that passes, as linear light; and their place beside a lens file.

White passes all light, black and clear parts pass none. A lens file names its picture by a path relative to its own
folder, and reads none outside it.
"""

import os
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

import numpy as np

from lensbench.core.kernels.numeric import linear, srgb
from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.stop_image import StopImage, StopImageError
from lensbench.core.text import excerpt
from lensbench.lenses.file_error import replacing
from lensbench.lenses.picture_file import PictureFileError, read_picture_file

SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp", ".bmp")
MOST_PIXELS = 4096 * 4096               # of the file; known from its header
SHARES = np.array([0.2126, 0.7152, 0.0722])     # of red, green and blue in the luminance (Rec. 709)
MOST_NAMES = 1000                       # tried beside a lens file


def read_picture(path: str | os.PathLike[str]) -> StopImage:
    """The picture of a file, with its path; StopImageError where it cannot be read, or passes no light."""
    say = partial("picture in the stop {}: {}".format, excerpt(Path(path).name))
    try:
        light = transmission(read_picture_file(path, MOST_PIXELS))
    except PictureFileError as error:
        raise StopImageError(say(str(error))) from error
    try:
        return replace(StopImage.of(light), file=str(Path(path).resolve()))
    except StopImageError as error:
        raise StopImageError(say(str(error))) from error


def transmission(picture: Any) -> np.ndarray:
    """Luminance of a picture of PIL, linear, times its opacity: white passes all light, black and clear pass none.

    (h, w) from 0 to 1, the top row first.
    """
    if picture.mode.startswith("I"):                    # 16 bits
        return np.asarray(linear(np.clip(np.asarray(picture) / 65535.0, 0.0, 1.0)), float)
    curve = np.asarray(linear(np.arange(256) / 255.0), float)
    red, green, blue, opacity = (np.asarray(band) for band in picture.convert("RGBA").split())
    light = sum(share * curve[band] for share, band in zip(SHARES, (red, green, blue), strict=True))
    passed: np.ndarray = np.minimum(light, 1.0) * (opacity / 255.0)
    return passed


def picture_beside(folder: Path | None, name: object) -> StopImage:
    """The picture that a lens file in a folder names; None: of a text without a file.

    StopImageError for a name that is no relative path within the folder, and as `read_picture`.
    """
    if not isinstance(name, str) or not name or "\0" in name:
        raise StopImageError('image must be the path of a picture next to the lens file: "heart.png"')
    said = f"picture in the stop {excerpt(name)}"
    if folder is None:
        raise StopImageError(f"{said}: this lens has no file, in whose folder it could be")
    if PurePosixPath(name).is_absolute() or PureWindowsPath(name).anchor or ".." in PureWindowsPath(name).parts:
        raise StopImageError(f"{said}: it must lie in the folder of the lens file, or below: give its path from there")
    file = folder / PureWindowsPath(name).as_posix()
    if file.suffix.lower() not in SUFFIXES:
        raise StopImageError(f"{said}: pictures are {', '.join(SUFFIXES)}")
    if not file.resolve().is_relative_to(folder.resolve()):
        raise StopImageError(f"{said}: it is a link out of the folder of the lens file")
    return replace(read_picture(file), name=PureWindowsPath(name).as_posix())


def with_picture_beside(lens: Lens, path: Path) -> tuple[Lens, list[Finding]]:
    """The lens with its picture in the folder of a lens file, written there where it is not; and a note of that.

    The file of the picture is copied as it is; a picture without one, or whose file has changed, is written as a PNG
    of 16 bits. LensFileError where it cannot be written.
    """
    image = lens.stop_image
    if image is None:
        return lens, []
    preferred = Path(image.name or Path(image.file).name or f"{path.stem}-stop.png")
    if not (path.parent / preferred).parent.is_dir():
        preferred = Path(preferred.name)
    source = Path(image.file) if image.file and _is(Path(image.file), image) else None
    if source is None:
        preferred = preferred.with_suffix(".png")
    for k in range(1, MOST_NAMES):
        name = preferred if k == 1 else preferred.with_name(f"{preferred.stem}-{k}{preferred.suffix}")
        target = path.parent / name
        if _is(target, image):
            return replace(lens, stop_image=replace(image, name=name.as_posix())), []
        if not target.exists():
            break
    with replacing(target, "the picture in the stop ") as temporary:
        if source is not None:
            shutil.copyfile(source, temporary)
            said = f"the picture in the stop was copied next to it, as {excerpt(name.as_posix())}"
        else:
            _write(image, temporary)
            said = (f"the picture in the stop was written next to it, as {excerpt(name.as_posix())}: "
                    f"{image.side} × {image.side} pixels of 16 bits")
    return replace(lens, stop_image=replace(image, name=name.as_posix())), [note(Kind.BESIDE, said)]


def _is(file: Path, image: StopImage) -> bool:
    """Whether a file holds this picture, but for the rounding of 16 bits."""
    try:
        stored = read_picture(file)
    except (StopImageError, OSError):
        return False
    return stored.side == image.side and bool(np.abs(stored.grid - image.grid).max() < 2e-5)


def _write(image: StopImage, file: Path) -> None:
    """Write the texels as a grey PNG of 16 bits."""
    from PIL import Image as Picture

    codes = np.round(65535.0 * srgb(image.grid.astype(float))).astype(np.uint16)
    Picture.fromarray(codes).save(file, format="PNG")
