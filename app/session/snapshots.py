"""The shelf of snapshots: pictures that were kept with their settings, one PNG each; and cards.

A snapshot's name is that of its file; the newest comes first. Any such PNG can be opened by `lensbench view` and
dropped on the window. A card is one PNG with the picture, the section of its lens to scale, and the settings in words.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lensbench.app.bench.build import design
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.plots.section import elements
from lensbench.app.session.export import ExportError, read_settings, replacing, save_picture
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance, format_f_number, format_time
from lensbench.core.text import fixed, significant
from lensbench.lenses.picture_file import PictureFileError, read_picture_file

LONGEST_NAME = 60               # characters
THUMBNAIL = 288                 # pixels of the longer side
FORBIDDEN = r'[\x00-\x1f/\\:*?"<>|]'


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A kept picture: its file, settings, and thumbnail uint8 (h, w, 3)."""

    path: Path
    settings: Settings
    thumbnail: NDArray[np.uint8]

    @property
    def name(self) -> str:
        """Shown under the thumbnail."""
        return self.path.stem

    def codes(self) -> NDArray[np.float32]:
        """The picture (h, w, 3) as codes of the screen from 0 to 1; ExportError if the file is gone."""
        return _codes(self.path).astype(np.float32) / np.float32(255.0)


class SnapshotShelf:
    """The snapshots of one folder, the newest first. say: receives a sentence for each file that cannot be read."""

    def __init__(self, folder: Path, say: Callable[[str], object] = lambda text: None):
        self.folder, self._say = folder, say
        self.snapshots: list[Snapshot] = []

    def load(self) -> None:
        """Read the folder."""
        snapshots: list[Snapshot] = []
        try:
            paths = sorted((path for path in self.folder.glob("*.png") if path.is_file()),
                           key=lambda path: path.stat().st_mtime, reverse=True)
        except OSError:
            paths = []
        for path in paths:
            try:
                snapshots.append(read_snapshot(path))
            except (ValueError, OSError) as error:
                self._say(f"The snapshot {path.stem} cannot be read: {error}")
        self.snapshots = snapshots

    def keep(self, image: NDArray[np.float32], settings: Settings, name: str) -> Snapshot:
        """Add a linear picture (h, w, 3) with its settings; ExportError if it cannot be written."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ExportError(f"{self.folder}: {error.strerror}: the snapshot was not kept") from error
        path = self._free(name)
        save_picture(path, image, settings)
        snapshot = read_snapshot(path)
        self.snapshots.insert(0, snapshot)
        return snapshot

    def rename(self, snapshot: Snapshot, name: str) -> Snapshot:
        """The snapshot under another name; ExportError if it cannot be written."""
        if cleaned(name) == snapshot.name:
            return snapshot
        path = self._free(name)
        try:
            snapshot.path.rename(path)
        except OSError as error:
            raise ExportError(f"{snapshot.path}: {error.strerror}: the snapshot keeps its name") from error
        renamed = Snapshot(path, snapshot.settings, snapshot.thumbnail)
        self.snapshots[self.snapshots.index(snapshot)] = renamed
        return renamed

    def remove(self, snapshot: Snapshot) -> None:
        """Delete a snapshot and its file; ExportError if that cannot be."""
        try:
            snapshot.path.unlink(missing_ok=True)
        except OSError as error:
            raise ExportError(f"{snapshot.path}: {error.strerror}: the snapshot was not deleted") from error
        self.snapshots.remove(snapshot)

    def _free(self, name: str) -> Path:
        """A path for this name, with a number behind it if the name is taken."""
        stem, number = cleaned(name), 1
        path = self.folder / f"{stem}.png"
        while path.exists():
            number += 1
            path = self.folder / f"{stem} {number}.png"
        return path


def cleaned(name: str) -> str:
    """A name that every file system takes; f/2 has another slash in it, which looks the same."""
    kept = " ".join(re.sub(FORBIDDEN, " ", name.replace("f/", "f⁄")).split()).strip(". ")
    return kept[:LONGEST_NAME].strip(". ") or "snapshot"


def read_snapshot(path: Path) -> Snapshot:
    """A PNG or PPM picture with its settings; ExportError where it cannot be read or has none."""
    from PIL import Image

    settings = read_settings(path)
    picture = Image.fromarray(_codes(path))
    picture.thumbnail((THUMBNAIL, THUMBNAIL))
    return Snapshot(path, settings, np.asarray(picture))


def _codes(path: Path) -> NDArray[np.uint8]:
    try:
        return np.asarray(read_picture_file(path).convert("RGB"))
    except PictureFileError as error:
        raise ExportError(f"{path}: {error}") from error


# Cards

WIDTH = 1600                    # pixels of the card
FOOT, MARGIN = 300, 40
COLOURS = {True: ((28, 28, 28), (242, 242, 242), (150, 150, 150), (169, 188, 203), (70, 96, 120)),
           False: ((232, 232, 232), (12, 12, 12), (90, 90, 90), (91, 115, 134), (168, 192, 216))}


def write_card(path: Path, codes: NDArray[np.float32], settings: Settings, title: str, dark: bool) -> None:
    """Write the card of a picture (h, w, 3) of screen codes from 0 to 1; ExportError if it cannot be written."""
    from PIL import Image, ImageDraw

    ground, strong, dim, outline, glass = COLOURS[dark]
    picture = Image.fromarray(np.rint(255.0 * np.clip(codes, 0.0, 1.0)).astype(np.uint8))
    inner = WIDTH - 2 * MARGIN
    picture = picture.resize((inner, round(inner * picture.height / picture.width)), Image.Resampling.LANCZOS)
    card = Image.new("RGB", (WIDTH, picture.height + FOOT + 2 * MARGIN), ground)
    card.paste(picture, (MARGIN, MARGIN))
    draw, top = ImageDraw.Draw(card), picture.height + 2 * MARGIN
    draw.text((MARGIN, top), title, strong, label_font(38))
    for i, line in enumerate(words(settings)):
        draw.text((MARGIN, top + 62 + 36 * i), line, dim, label_font(27))
    if settings.has_lens:
        box = (WIDTH - MARGIN - 560, top, WIDTH - MARGIN, top + FOOT - MARGIN)
        _section(card, settings, box, (outline, glass, dim))
    with replacing(path) as temporary:
        card.save(temporary, "PNG")


def words(settings: Settings) -> list[str]:
    """The settings that a photographer writes next to a picture, in lines."""
    got = readings(settings)
    f_number = settings.f_number or got.f_number
    lines = []
    if settings.has_lens:
        lens = design(settings)
        lines.append(" · ".join(filter(None, (lens.name, lens.maker, lens.designer))))
    exposure = [format_f_number(f_number)] if f_number else []
    exposure.append(format_time(settings.shutter))
    exposure.append(f"ISO {fixed(settings.iso, 0)}")
    lines.append(" · ".join(exposure))
    setup = [f"focused at {format_distance(settings.focus_distance)}"] if settings.focuses else []
    setup.append(f"film {significant(settings.film.width, 4)} × {significant(settings.film.height, 4)} mm")
    if got.efl is not None:
        setup.insert(0, f"{fixed(got.efl, 1)} mm")
    return [*lines, " · ".join(setup)]


def _section(card, settings: Settings, box: tuple[int, int, int, int], inks: tuple) -> None:
    """The elements of the lens, as large as fits into the box, and the axis."""
    from PIL import Image, ImageDraw

    outline, glass, axis = inks
    glasses = elements(design(settings))
    if not glasses:
        return
    fine = 3
    width, height = (box[2] - box[0]) * fine, (box[3] - box[1]) * fine
    points = np.concatenate([element.outline for element in glasses])
    (z0, _), (z1, tall) = points.min(axis=0), np.abs(points).max(axis=0)
    z1 = float(points[:, 0].max())
    scale = 0.94 * min(width / max(z1 - z0, 1e-9), 0.5 * height / max(tall, 1e-9))
    image = Image.new("RGB", (width, height), card.getpixel((1, 1)))
    draw = ImageDraw.Draw(image)
    left, middle = width - scale * (z1 - z0) - 0.02 * width, 0.5 * height
    draw.line([(left - 0.03 * width, middle), (width, middle)], axis, fine)
    for element in glasses:
        path = [(left + scale * (z - z0), middle - scale * y) for z, y in element.outline.tolist()]
        draw.polygon(path, glass)
        draw.line([*path, path[0]], outline, 2 * fine, "curve")
    card.paste(image.resize((box[2] - box[0], box[3] - box[1]), Image.Resampling.LANCZOS), box[:2])


def label_font(size: float):
    """The font of cards and sheets, of a height in pixels."""
    from importlib.util import find_spec

    from PIL import ImageFont

    package = find_spec("imgui_bundle")         # its fonts, without its library
    if package is None or package.origin is None:
        return ImageFont.load_default(size)
    return ImageFont.truetype(str(Path(package.origin).parent / "assets/fonts/Roboto/Roboto-Regular.ttf"), size)
