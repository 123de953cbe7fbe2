"""The figures of one pixel: what it shows, how far off that is, how blurred, and how much light arrives."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lensbench.app.state.build import setup
from lensbench.app.state.geometry.blur import Blur
from lensbench.app.state.geometry.exit_pupil import region
from lensbench.app.state.pixel.beam import beam
from lensbench.app.state.pixel.lens_rays import film_place
from lensbench.app.state.pixel.pointed import Place
from lensbench.app.state.pixel.spot import spot
from lensbench.app.state.settings import Settings
from lensbench.app.state.view_camera import seen_from


@dataclass(frozen=True, eq=False)
class PixelReadings:
    """Figures of a raster point; None where a figure has no meaning.

    film: the film point (mm), as the lens forms its image;
    of a panorama, which has no film, None. thing: what the pixel shows; "sky", or "" without light.
    ahead, along: its distance (mm) along the axis from where the focus is measured, and along the ray. diameter: of
    its circle of confusion on the film (mm); pixels: the same in pixels; traced: by rays of the real lens, not by the
    formula of an ideal one; no_blur: why there is none. light: of the axis without vignetting, as a part; open: the
    exit-pupil region against that of the axis, by area.
    """

    raster: Place
    film: Place | None
    thing: str
    ahead: float
    along: float
    diameter: float | None
    pixels: float | None
    traced: bool
    no_blur: str
    light: float
    open: float | None


def pixel_readings(settings: Settings, raster: Place) -> PixelReadings:
    """The figures of a raster point; ValueError or OSError where there is no camera."""
    seen, pitch = beam(settings, raster), settings.film.pitch
    diameter, traced, why = None, False, ""
    if not len(seen.origins):
        why = "no light reaches this pixel"
    elif settings.has_lens and settings.follows_lens:
        try:
            diameter, traced = spot(settings, raster).diameter, True
        except ValueError as error:
            why = str(error)
    else:
        blur = Blur.of(settings)
        if blur.blurs:
            diameter = pitch * blur.pixels(seen.ahead, (raster[0] / settings.film.pixels_x,
                                                        raster[1] / settings.film.pixels_y))
        else:
            why = "this camera has no plane in focus"
    film = None if settings.kind.panorama else film_place(settings, raster)
    return PixelReadings(raster, film, _named(seen.thing, seen.along), seen.ahead, seen.along, diameter,
                         None if diameter is None else diameter / pitch, traced, why, seen.light,
                         _open(settings, raster))


def _named(thing: str, along: float) -> str:
    return "" if math.isnan(along) else "sky" if math.isinf(along) else thing


def _open(settings: Settings, raster: Place) -> float | None:
    """Area of the region of a film point against that of the axis."""
    if not (settings.has_lens and settings.follows_lens):
        return None
    built, at = seen_from(settings, raster)
    axis = region(built.lens, setup(settings).film_distance, 0.0).area
    here = region(built.lens, built.film_distance, math.hypot(*at), math.atan2(at[1], at[0])).area
    return here / axis if axis > 0.0 else None


def colour_of(image: NDArray[np.float32] | None, raster: Place) -> tuple[float, float, float] | None:
    """Red, green and blue of a pixel of a picture (h, w, 3); None outside it or without one."""
    if image is None or not (0 <= raster[1] < image.shape[0] and 0 <= raster[0] < image.shape[1]):
        return None
    red, green, blue = (float(value) for value in image[int(raster[1]), int(raster[0])])
    return red, green, blue
