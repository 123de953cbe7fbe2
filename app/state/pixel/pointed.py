"""What the mouse points at in one panel, for all panels to show: a pixel, a ray, surfaces of the lens.

A panel that is drawn later in a frame, or in the next frame, reads it here. It is no part of the settings.
"""

from dataclasses import dataclass, field

import numpy as np

Place = tuple[float, float]


@dataclass(frozen=True, eq=False)
class PointedRay:
    """One ray that a point of a plot belongs to.

    path (n, 3): mm, lens frame, from before the lens to the film, or to the surface that ends it. surface: the index of
    that surface, −1 for a ray that passes. end: where it ends, or comes from, in words. target (3,): the point of the
    scene that it comes from, mm in the world, or None; raster: where the picture shows that point, pixels, or None.
    """

    path: np.ndarray
    surface: int
    end: str
    target: np.ndarray | None = None
    raster: Place | None = None


@dataclass
class Pointed:
    """The pixel, the ray and the surfaces under the mouse.

    hover: raster point under the mouse in the picture. pinned: a kept pixel, as parts of the picture's width and
    height, so that it survives another size of the picture. ray, surfaces: what all panels show in this frame; the
    surfaces are indices into the lens, empty for none. A panel whose ray or surfaces lie under the mouse sets them for
    the next frame, by `point_at_ray` and `point_at_surfaces`.
    """

    hover: Place | None = None
    pinned: Place | None = None
    ray: PointedRay | None = None
    surfaces: tuple[int, ...] = ()
    _next_ray: PointedRay | None = field(default=None, repr=False)
    _next_surfaces: tuple[int, ...] = field(default=(), repr=False)

    def advance(self) -> None:
        """Begin a frame: show what the panels of the frame before have found under the mouse."""
        self.ray, self.surfaces = self._next_ray, self._next_surfaces
        self._next_ray, self._next_surfaces = None, ()

    def point_at_ray(self, ray: PointedRay) -> None:
        """A point that this ray belongs to lies under the mouse."""
        self._next_ray = ray

    def point_at_surfaces(self, surfaces: tuple[int, ...]) -> None:
        """These surfaces lie under the mouse."""
        self._next_surfaces = surfaces

    def pixel(self, pixels_x: int, pixels_y: int) -> Place | None:
        """The middle of the pixel whose rays are shown, in raster pixels: the pinned one, else that under the mouse."""
        at = self.hover if self.pinned is None else (self.pinned[0] * pixels_x, self.pinned[1] * pixels_y)
        if at is None:
            return None
        column, row = (min(max(int(place), 0), count - 1)
                       for place, count in zip(at, (pixels_x, pixels_y), strict=True))
        return column + 0.5, row + 0.5

    def toggle_pin(self, part: Place) -> None:
        """Pin the pixel at these parts of width and height, or unpin the one that is pinned."""
        self.pinned = part if self.pinned is None else None
