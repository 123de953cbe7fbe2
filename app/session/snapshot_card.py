"""A card of a snapshot: one PNG with the picture, the section of its lens to scale, and the settings in words."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lensbench.app.bench.build import design
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.plots.section import elements
from lensbench.app.session.export import replacing
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance, format_f_number, format_time
from lensbench.core.text import fixed, significant

WIDTH = 1600                    # pixels of the card
FOOT, MARGIN = 300, 40
COLOURS = {True: ((28, 28, 28), (242, 242, 242), (150, 150, 150), (169, 188, 203), (70, 96, 120)),
           False: ((232, 232, 232), (12, 12, 12), (90, 90, 90), (91, 115, 134), (168, 192, 216))}


def write_card(path: Path, codes: NDArray[np.float32], settings: Settings, title: str, dark: bool) -> None:
    """Write the card; ExportError if that cannot be. codes: (h, w, 3), 0 to 1."""
    from PIL import Image, ImageDraw

    ground, strong, dim, outline, glass = COLOURS[dark]
    picture = Image.fromarray(np.rint(255.0 * np.clip(codes, 0.0, 1.0)).astype(np.uint8))
    inner = WIDTH - 2 * MARGIN
    picture = picture.resize((inner, round(inner * picture.height / picture.width)), Image.Resampling.LANCZOS)
    card = Image.new("RGB", (WIDTH, picture.height + FOOT + 2 * MARGIN), ground)
    card.paste(picture, (MARGIN, MARGIN))
    draw, top = ImageDraw.Draw(card), picture.height + 2 * MARGIN
    draw.text((MARGIN, top), title, strong, _font(38))
    for i, line in enumerate(words(settings)):
        draw.text((MARGIN, top + 62 + 36 * i), line, dim, _font(27))
    if settings.has_lens:
        box = (WIDTH - MARGIN - 560, top, WIDTH - MARGIN, top + FOOT - MARGIN)
        _section(card, settings, box, (outline, glass, dim))
    with replacing(path) as part:
        card.save(part, "PNG")


def words(settings: Settings) -> list[str]:
    """The settings that a photographer writes beside a picture, in lines."""
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
    place = [f"focused at {format_distance(settings.focus_distance)}"] if settings.focuses else []
    place.append(f"film {significant(settings.film.width, 4)} × {significant(settings.film.height, 4)} mm")
    if got.efl is not None:
        place.insert(0, f"{fixed(got.efl, 1)} mm")
    return [*lines, " · ".join(place)]


def _section(card, settings: Settings, box: tuple[int, int, int, int], inks: tuple) -> None:
    """The elements of the lens, as large as fits into the box, and the axis."""
    from PIL import Image, ImageDraw

    outline, glass, axis = inks
    found = elements(design(settings))
    if not found:
        return
    fine = 3
    width, height = (box[2] - box[0]) * fine, (box[3] - box[1]) * fine
    points = np.concatenate([element.outline for element in found])
    (z0, _), (z1, tall) = points.min(axis=0), np.abs(points).max(axis=0)
    z1 = float(points[:, 0].max())
    scale = 0.94 * min(width / max(z1 - z0, 1e-9), 0.5 * height / max(tall, 1e-9))
    image = Image.new("RGB", (width, height), card.getpixel((1, 1)))
    draw = ImageDraw.Draw(image)
    left, middle = width - scale * (z1 - z0) - 0.02 * width, 0.5 * height
    draw.line([(left - 0.03 * width, middle), (width, middle)], axis, fine)
    for element in found:
        path = [(left + scale * (z - z0), middle - scale * y) for z, y in element.outline.tolist()]
        draw.polygon(path, glass)
        draw.line([*path, path[0]], outline, 2 * fine, "curve")
    card.paste(image.resize((box[2] - box[0], box[3] - box[1]), Image.Resampling.LANCZOS), box[:2])


def _font(size: int):
    from importlib.util import find_spec

    from PIL import ImageFont

    found = find_spec("imgui_bundle")           # its fonts, without its library
    if found is None or found.origin is None:
        return ImageFont.load_default(size)
    return ImageFont.truetype(str(Path(found.origin).parent / "assets/fonts/Roboto/Roboto-Regular.ttf"), size)
