"""Which line of the film is open when a point falls on it: what the way back asks of a rolling shutter."""

from collections.abc import Callable

import numpy as np

from lensbench.cameras.protocol import DifferentiableCamera
from lensbench.imaging.film import Film

Project = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Raster points (n, 2) → where n things fall as the camera stands when the lines of these are open, and whether."""

ROUNDS = 40


def film_middle(film: Film, n: int) -> np.ndarray:
    """The raster point of the film's middle, n times."""
    return np.tile([film.pixels_x / 2.0, film.pixels_y / 2.0], (n, 1))


def project_onto_open_rows(camera: DifferentiableCamera, project: Project, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Raster points (n, 2) of n things, each on the line that is open when it falls there; which are on the film."""
    raster, visible = project(film_middle(camera.film, n))
    if camera.moves and camera.readout > 0.0:
        raster, visible = _rolled(camera, project, raster)
    with np.errstate(invalid="ignore"):
        inside = ((raster >= 0.0) & (raster <= [camera.film.pixels_x, camera.film.pixels_y])).all(1)
    return raster, visible & inside


def _rolled(camera: DifferentiableCamera, project: Project, raster: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By the secant rule along the readout, each thing on its own."""
    axis = 0 if camera.readout_direction in ("left", "right") else 1
    before, place = film_middle(camera.film, len(raster)), raster.copy()
    off = raster[:, axis] - before[:, axis]
    for _ in range(ROUNDS):
        raster, visible = project(place)
        now = raster[:, axis] - place[:, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            step = -now * (place[:, axis] - before[:, axis]) / (now - off)
        step = np.where(np.isfinite(step), step, now)
        before, off, place = place, now, place.copy()
        place[:, axis] += step
        if not (np.abs(step) > 1e-11).any():
            break
    raster, visible = project(place)
    with np.errstate(invalid="ignore"):                 # a panorama that turns fast may miss a point, or see it twice
        return raster, visible & (np.abs(raster[:, axis] - place[:, axis]) < 1e-6)
