"""The view of the section: millimetres to pixels, fitted, panned and zoomed."""

from dataclasses import dataclass, replace
from math import floor, log10

from imgui_bundle import ImVec2

MARGIN = 1.16               # of the tallest part, above and below
LEFT, RIGHT = 0.16, 0.16    # of the width, kept for the rays that come in and for the names beside the film
MOST_NAMES = 0.3            # of the width, at most, that these names get
ZOOM_STEP = 1.15
MIN_SCALE, MAX_SCALE = 1e-3, 1e5


@dataclass(frozen=True)
class View:
    """Pixels per mm, and where the first vertex lies in the panel (pixels from its upper left corner)."""

    scale: float
    x: float
    y: float

    def to_screen(self, corner: ImVec2, z: float, y: float) -> ImVec2:
        """A point (z, y) of the lens frame on the screen; corner: of the panel."""
        return ImVec2(corner.x + self.x + z * self.scale, corner.y + self.y - y * self.scale)

    def to_lens(self, corner: ImVec2, point: ImVec2) -> tuple[float, float]:
        """The inverse: (z, y) in mm."""
        return (point.x - corner.x - self.x) / self.scale, (corner.y + self.y - point.y) / self.scale

    def moved(self, dx: float, dy: float) -> "View":
        """Panned by pixels."""
        return replace(self, x=self.x + dx, y=self.y + dy)

    def zoomed(self, steps: float, x: float, y: float) -> "View":
        """Zoomed about the point at x, y (pixels in the panel)."""
        scale = min(max(self.scale * ZOOM_STEP**steps, MIN_SCALE), MAX_SCALE)
        factor = scale / self.scale
        return View(scale, x + factor * (self.x - x), y + factor * (self.y - y))


def fitted(width: float, height: float, z0: float, z1: float, half_height: float, label: float,
           names: float = 0.0) -> View:
    """All from z0 to z1 and ±half_height in a panel of this size.

    label: pixels below that the row of signs needs. names: pixels that the names behind z1 need.
    """
    width, height = max(width, 1.0), max(height - label, 1.0)
    length = max(z1 - z0, 1e-6)
    right = max(RIGHT * width, min(names, MOST_NAMES * width))
    scale = min(((1.0 - LEFT) * width - right) / length, height / (2.0 * MARGIN * max(half_height, 1e-6)))
    scale = min(max(scale, MIN_SCALE), MAX_SCALE)
    spare = width - length * scale
    # Spare room goes to the incoming rays for the most part
    return View(scale, min(0.6 * spare, spare - right) - z0 * scale, 0.5 * height + 0.15 * label)


def round_length(most: float) -> float:
    """The longest of 1, 2, 5 × 10ⁿ that is no longer than this."""
    decade = 10.0 ** floor(log10(most))
    return next(step * decade for step in (5.0, 2.0, 1.0) if step * decade <= most * (1.0 + 1e-9))
