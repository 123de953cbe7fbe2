"""A small section of a lens, to scale: its glass and its stop, as a picture that a frame only has to show.

Run as a process, it draws sections for the lens browser; its arguments are the look of these pictures.
"""

import sys
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench import lenses
from lensbench.app.drawing import theme
from lensbench.app.plots.section import elements
from lensbench.app.workers.lens_pictures import answer
from lensbench.app.workers.task import lower_priority

FINER = 3                       # points of the drawing along a pixel
WIDTH, HEIGHT = 0.92, 0.92      # of the picture that the lens fills
OUTSIDE = 1.15                  # of the stop's radius, to which its lines go

Pixels = NDArray[np.uint8]


class SectionLook(NamedTuple):
    """All but the lens that changes the picture of a section: pixels across and down, theme, width of a line."""

    size: tuple[int, int]
    dark: bool
    pixel: float

    @property
    def command(self) -> tuple[str, ...]:
        """Start a process that draws sections of this look."""
        return (sys.executable, "-m", "lensbench.app.panels.section_pictures", *map(str, self.size),
                "dark" if self.dark else "light", repr(self.pixel))


def section_picture(lens: lb.Lens, look: SectionLook) -> Pixels:
    """The section as large as fits, with equal axes, on a transparent ground.

    Args:
        lens: Any lens.
        look: Size (pixels), theme, and width of a line (pixels).
    Returns:
        uint8 (h, w, 4): sRGB and opacity. The axis of the lens lies at half of the height.
    """
    from PIL import Image, ImageDraw

    size, dark, pixel = look
    glass = elements(lens)
    edges = [element.outline[:, 0] for element in glass] or [np.array([0.0, lens.length])]
    begin = min(0.0, *(float(z.min()) for z in edges))
    end = max(lens.length, *(float(z.max()) for z in edges))
    radius = max(surface.semi_diameter for surface in lens.surfaces)
    across, down = FINER * size[0], FINER * size[1]
    scale = min(WIDTH * across / max(end - begin, 1e-9), 0.5 * HEIGHT * down / max(radius, 1e-9))
    middle = np.array([0.5 * across - 0.5 * scale * (begin + end), 0.5 * down])

    def placed(points: np.ndarray) -> list[tuple[float, float]]:
        return [(x, y) for x, y in (points * (scale, -scale) + middle).tolist()]

    colours, line = theme.palette(dark), max(1, round(FINER * pixel))
    image = Image.new("RGBA", (across, down), (*_codes(colours.glass_outline)[:3], 0))
    draw = ImageDraw.Draw(image)
    outlines = [placed(element.outline) for element in glass]
    for element, outline in zip(glass, outlines, strict=True):
        v_d = element.glass.v_d if element.glass.v_d is not None else 60.0
        draw.polygon(outline, fill=_codes(colours.glass(element.glass.n_d, v_d)))
    ink = _codes((*colours.glass_outline[:3], 0.85))
    for outline in outlines:
        draw.line([*outline, *outline[:2]], fill=ink, width=line, joint="curve")
    z, open_radius = lens.vertices[lens.stop_index], lens.stop.semi_diameter
    far = max(OUTSIDE * open_radius, open_radius + 2.0 * FINER / scale)
    for sign in (-1.0, 1.0):
        draw.line(placed(np.array([[z, sign * open_radius], [z, sign * far]])), fill=_codes(colours.text),
                  width=round(1.5 * line))
    return np.asarray(image.resize(size, Image.Resampling.BOX))


def _codes(colour: theme.Colour) -> tuple[int, ...]:
    return tuple(round(255.0 * channel) for channel in colour)


def main() -> None:
    """Answer as `workers.lens_pictures` describes."""
    lower_priority()
    width, height, theme_name, pixel = sys.argv[1:]     # as `SectionLook.command` writes them
    look = SectionLook((int(width), int(height)), theme_name == "dark", float(pixel))
    answer(lambda name: section_picture(lenses.load(name), look))


if __name__ == "__main__":
    main()
