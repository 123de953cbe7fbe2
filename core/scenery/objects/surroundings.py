"""Surroundings of the shapes of a scene: floor, sun and sky, of three colours or shown by a picture."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from lensbench.core.scenery.objects.material import Image
from lensbench.core.scenery.values import SceneError, Triple, check, triple
from lensbench.core.text import significant


@dataclass(frozen=True)
class Floor:
    """Endless plane, visible from above, checkered or with an image that repeats.

    Args:
        height: Distance along `normal` from the world's origin, mm.
        tile: Edge of a tile, mm.
        light, dark: (r, g, b). Linear albedo of the tiles, in [0, 1].
        gloss: 0: matte. In (0, 1]: a clear coat, as in `Material`.
        normal: (x, y, z). Upward direction, of any length, world frame.
        turn: Rotation of the tiles about the normal, radians.
        offset: (a, b). Shift of the tiles, in tiles.
        image: Instead of the two colours: repeated, `tile` mm wide, its rows upright for a camera that looks along −z.
    Raises:
        SceneError: If a value is out of range.
    """

    height: float = -250.0
    tile: float = 100.0
    light: Triple = (0.75, 0.75, 0.75)
    dark: Triple = (0.08, 0.08, 0.08)
    gloss: float = 0.0
    normal: Triple = (0.0, 1.0, 0.0)
    turn: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)
    image: Image | None = None

    def __post_init__(self) -> None:
        check(self, ("tile",))
        if not 0.0 <= self.gloss <= 1.0:
            raise SceneError(f"gloss {significant(self.gloss)}: it must lie between 0 and 1")
        if not np.any(self.normal):
            raise SceneError("the normal of a floor cannot be zero")
        if min(*self.light, *self.dark) < 0.0 or max(*self.light, *self.dark) > 1.0:
            raise SceneError("the colours of a floor must lie between 0 and 1")


@dataclass(frozen=True)
class Sun:
    """Distant disk of uniform radiance.

    Args:
        direction: (x, y, z). Direction towards the sun, of any length, world frame.
        colour: (r, g, b). Irradiance on a surface that faces it, divided by π.
        angular_radius: Radians, at most 1.
    Raises:
        SceneError: If a value is out of range.
    """

    direction: Triple
    colour: Triple = (2.0, 1.9, 1.7)
    angular_radius: float = math.radians(0.27)

    def __post_init__(self) -> None:
        check(self, ("angular_radius",))
        if not np.any(self.direction):
            raise SceneError("the direction of the sun cannot be zero")
        if self.angular_radius > 1.0:
            raise SceneError(f"angular radius of the sun {significant(self.angular_radius)}: at most 1 radian")
        if min(self.colour) < 0.0:
            raise SceneError(f"colour {self.colour}: no component can be negative")


@dataclass(frozen=True)
class Sky:
    """Sky whose radiance varies linearly with the sine of the elevation.

    Args:
        zenith, horizon, ground: (r, g, b). Radiance overhead, at the horizon, and everywhere below the horizon.
        up: (x, y, z). Direction of the zenith, of any length, world frame.
    Raises:
        SceneError: If a value is out of range.
    """

    zenith: Triple = (0.25, 0.45, 0.9)
    horizon: Triple = (0.8, 0.85, 0.9)
    ground: Triple = (0.3, 0.28, 0.25)
    up: Triple = (0.0, 1.0, 0.0)

    def __post_init__(self) -> None:
        check(self)
        if min(*self.zenith, *self.horizon, *self.ground) < 0.0:
            raise SceneError("the colours of a sky cannot be negative")
        if not np.any(self.up):
            raise SceneError("the up direction of a sky cannot be zero")


@dataclass(frozen=True)
class ImageSky:
    """Sky that a picture of all directions shows, and that lights the scene with the radiance of that picture.

    Args:
        image: Equirectangular: the top row is the zenith (+y), the middle column looks along −z, and the columns left
            of it towards −x, as `EnvironmentCamera` renders them. Linear radiance.
        turn: Rotation of the sky about +y, radians: a positive angle moves what lies along −z towards −x.
        brightness: Factor on the radiance.
    Raises:
        SceneError: If a value is out of range, or the picture has a radiance that is negative or not finite.
    """

    image: Image
    turn: float = 0.0
    brightness: float = 1.0
    up: tuple[float, float, float] = field(default=(0.0, 1.0, 0.0), init=False)

    def __post_init__(self) -> None:
        check(self)
        if self.brightness < 0.0:
            raise SceneError(f"brightness {significant(self.brightness)} of a sky: it cannot be negative")
        values = self.image.values
        if not (np.isfinite(values).all() and values.min() >= 0.0):
            raise SceneError("the picture of a sky has values that are negative or not finite")

    @cached_property
    def gradient(self) -> Sky:
        """The nearest sky of three colours, for pictures without shadows.

        The radiance below the horizon is the mean of the picture there; zenith and horizon are least squares over the
        solid angle above, none negative.
        """
        means = self.image.values.mean(1, dtype=np.float64) * self.brightness
        height = len(means)
        edges = np.cos(math.pi * np.arange(height + 1) / height)
        weights, sines = edges[:-1] - edges[1:], (edges[:-1] + edges[1:]) / 2.0
        above = sines > 0.0
        ground = np.average(means[~above], 0, weights[~above])
        roots = np.sqrt(weights[above])[:, None]
        basis = np.column_stack([1.0 - sines[above], sines[above]])
        horizon, zenith = np.linalg.lstsq(basis * roots, means[above] * roots, rcond=None)[0]
        return Sky(triple(np.maximum(zenith, 0.0)), triple(np.maximum(horizon, 0.0)), triple(ground))
