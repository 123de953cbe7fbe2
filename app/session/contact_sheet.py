"""Contact sheets: pictures of several lenses in one framing, or snapshots, with captions, in one file.

A `.png` or `.jpg` shows them in a grid, a `.gif` or `.webp` one after the other.
"""

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lensbench import lenses
from lensbench.app.bench.build import design
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.exposure import exposed
from lensbench.app.bench.lens_choice import APERTURE, FILM, with_lens
from lensbench.app.session.export import ExportError, develop, replacing
from lensbench.app.session.picture_render import render
from lensbench.app.session.snapshots import Snapshot, label_font, words
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_f_number
from lensbench.core.text import fixed, significant
from lensbench.lenses.library import search

if TYPE_CHECKING:
    from PIL import Image

GRIDS, MOVING = (".png", ".jpg", ".jpeg"), (".gif", ".webp")
SUFFIXES = (*GRIDS, *MOVING)
COUNTS = ("one two three four five six seven eight nine ten eleven twelve").split()
NEAR = 0.06                     # by which a focal length may differ from the one that is engraved
MOST = 48                       # pictures of one sheet
LONGEST = 600.0                 # s: GIF counts to 655
WIDEST = 12_000                 # pixels of a sheet, across or down
GROUND, STRONG, DIM = (28, 28, 28), (242, 242, 242), (150, 150, 150)
SECONDS = 1.2                   # that each picture of a moving sheet is shown


@dataclass(frozen=True, eq=False)
class Cell:
    """One picture with its caption. codes: uint8 (h, w, 3), as the screen shows them."""

    codes: NDArray[np.uint8]
    title: str
    caption: str

    @classmethod
    def of(cls, snapshot: Snapshot) -> "Cell":
        """A snapshot as it was kept; ExportError if its file is gone."""
        codes = np.rint(255.0 * snapshot.codes()).astype(np.uint8)
        return cls(codes, snapshot.name, " · ".join(words(snapshot.settings)[-2:]))


def found_lenses(text: str, count: int = 6) -> tuple[list[str], int]:
    """Names of the lenses of the library that a text describes, and how many of them it asks for, else `count`.

    Such a text is “six 50 mm lenses”; primes and the most relevant come first. ValueError where no lens matches.
    """
    match = re.fullmatch(rf"\s*((?:{'|'.join(COUNTS)})\b|\d+(?=\s+\d))?\s*(.*?)(\s+lens(es)?)?\s*", text.lower())
    assert match is not None
    count = count if match[1] is None else COUNTS.index(match[1]) + 1 if match[1] in COUNTS else int(match[1])
    cards, words = lenses.describe(), match[2]
    if (length := re.search(r"\b(\d{1,4}) ?mm\b", words)) is not None:        # not of a number in a note or a range
        nominal, words = float(length[1]), words.replace(length[0], "")
        cards = search.filtered(cards, focal=((1.0 - NEAR) * nominal, (1.0 + NEAR) * nominal))
    title = "" if length is None else f"{length[1]} mm"
    ranked = sorted(search.searched(cards, words), key=lambda card: (card.zooms, title not in card.title))
    names = [card.name for card in ranked][:MOST]
    if not count:
        raise ValueError(f"“{text}” asks for no lens: ask for one at least")
    if not names:
        raise ValueError(f"no lens of the library matches “{match[2]}”: type a focal length, a maker or a kind, such "
                         "as six 50 mm lenses")
    return names, min(count, len(names))


def rendered_cells(settings: Settings, names: Sequence[str], progress: Callable[[float], object] = lambda part: None,
                   cancelled: Callable[[], bool] = lambda: False, threads: int | None = None,
                   ) -> Iterator[Cell | str]:
    """The picture of each lens on the film of the settings, framed as they are, at their f-number where it has that.

    Instead of one that cannot be rendered: a sentence that states why. Ends early when cancelled.
    """
    for i, name in enumerate(names):
        def part(share: float, done: int = i) -> None:
            progress((done + share) / len(names))

        try:
            taken = with_lens(settings, name, (FILM, APERTURE))
            outcome = render(taken, part, cancelled, threads)
            if outcome is None:
                return
            codes = np.rint(255.0 * develop(exposed(taken, outcome[0]), taken)).astype(np.uint8)
            yield Cell(codes, design(taken).name, _caption(taken))
        except (ValueError, OSError) as error:
            yield f"{name}: {error}"


def _caption(settings: Settings) -> str:
    lens = readings(settings)
    f_number = settings.f_number or lens.f_number
    return " · ".join(([f"{fixed(lens.efl, 1)} mm"] if lens.efl else []) + ([format_f_number(f_number)] if f_number
                                                                             else []))


def checked_sheet(path: Path, count: int = 1, seconds: float = SECONDS) -> Path:
    """The path of a sheet; ExportError for another suffix, no pictures or more than MOST, or too long a time each."""
    if not 1 <= count <= MOST:
        raise ExportError(f"{path}: {count} pictures: 1 to {MOST} make a sheet")
    if not 0.01 <= seconds <= LONGEST:
        raise ExportError(f"{path}: {significant(seconds)} s: a picture is shown for 0.01 to {significant(LONGEST)} s")
    if path.suffix.lower() not in SUFFIXES:
        raise ExportError(f"{path}: a sheet is written as {' '.join(GRIDS)}, pictures one after the other as "
                          f"{' '.join(MOVING)}")
    return path


def write_sheet(path: Path, cells: Sequence[Cell], seconds: float = SECONDS) -> None:
    """Write the pictures as one file, by its suffix in a grid or one after the other, each for so many seconds.

    ExportError: for no pictures, more than MOST, another suffix, or a file that cannot be written.
    """
    suffix = checked_sheet(path, len(cells), seconds).suffix.lower()
    with replacing(path) as temporary:
        if suffix in MOVING:
            first, *others = _frames(cells)
            options = {"quality": 90} if suffix == ".webp" else {}
            first.save(temporary, suffix[1:].upper(), save_all=True, append_images=others, loop=0,
                       duration=round(1000.0 * seconds), **options)
        else:
            _grid(cells).save(temporary, "PNG" if suffix == ".png" else "JPEG", quality=92)


def _frames(cells: Sequence[Cell]) -> "list[Image.Image]":
    """Each picture with its caption below, all of the size of the first."""
    size = cells[0].codes.shape[1], cells[0].codes.shape[0]
    return [_labelled(cell, size) for cell in cells]


def _grid(cells: Sequence[Cell]) -> "Image.Image":
    """The pictures in rows, with as many columns as make the sheet a little wider than high."""
    from PIL import Image

    h, w = cells[0].codes.shape[:2]
    columns = max(1, min(len(cells), round(math.sqrt(2.2 * len(cells) * h / w))))
    rows, gap = -(-len(cells) // columns), max(w // 32, 4)
    shrunk = min(1.0, WIDEST / (columns * (w + gap) + gap), WIDEST / (rows * (1.25 * h + gap) + gap))
    size = max(round(w * shrunk), 16), max(round(h * shrunk), 16)
    frames = [_labelled(cell, size) for cell in cells]
    width, height = frames[0].size
    sheet = Image.new("RGB", (columns * (width + gap) + gap, rows * (height + gap) + gap), GROUND)
    for i, frame in enumerate(frames):
        sheet.paste(frame, (gap + i % columns * (width + gap), gap + i // columns * (height + gap)))
    return sheet


def _labelled(cell: Cell, size: tuple[int, int]) -> "Image.Image":
    """A picture, as large as fits into the size (w, h), with two lines of text below."""
    from PIL import Image, ImageDraw

    width, height = size
    points = max(width // 26, 9)
    picture = Image.fromarray(cell.codes)
    scale = min(width / picture.width, height / picture.height)
    picture = picture.resize((max(1, round(scale * picture.width)), max(1, round(scale * picture.height))),
                             Image.Resampling.LANCZOS)
    frame = Image.new("RGB", (width, height + round(2.9 * points)), GROUND)
    frame.paste(picture, ((width - picture.width) // 2, (height - picture.height) // 2))
    draw, y = ImageDraw.Draw(frame), height + 0.3 * points
    for text, colour, high in ((cell.title, STRONG, points), (cell.caption, DIM, 0.85 * points)):
        font = label_font(high)
        while font.getlength(text) > width and len(text) > 2:
            text = text[:-2].rstrip(" …") + "…"
        draw.text((0, y), text, colour, font)
        y += 1.3 * points
    return frame
