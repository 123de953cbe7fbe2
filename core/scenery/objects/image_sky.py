"""Surroundings shown by a picture of all directions: an HDRI sky."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from lensbench.kernels.figures import significant
from lensbench.scenery.objects.material import Image
from lensbench.scenery.objects.surroundings import Sky
from lensbench.scenery.values import SceneError, check, triple


@dataclass(frozen=True)
class ImageSky:
    """Sky that a picture of all directions shows, and that lights the scene with the radiance of that picture.

    Parameters
    ----------
    image : Image
        Equirectangular: the top row is the zenith (+y), the middle column looks along −z, and the columns left of it
        towards −x, as `EnvironmentCamera` renders them. Linear radiance.
    turn : float
        Rotation of the sky about +y, radians: a positive angle moves what lies along −z towards −x.
    brightness : float
        Factor on the radiance.

    Raises
    ------
    SceneError
        If a value is out of range, or the picture has a radiance that is negative or not finite.
    """

    image: Image
    turn: float = 0.0
    brightness: float = 1.0
    up: tuple[float, float, float] = field(default=(0.0, 1.0, 0.0), init=False)

    def __post_init__(self):
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
